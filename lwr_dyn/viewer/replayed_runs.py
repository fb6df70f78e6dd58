"""`ReplayedRun`: a run with its arm, label and colour; every picture of this package starts from it."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array, real_array
from lwr_dyn.errors import OptionError, ShapeError
from lwr_dyn.kinematics import forward
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.audit import audit_words
from lwr_dyn.simulation.stop_contacts import stop_contacts

RUN_COLOURS = ("#e8590c", "#1c7ed6", "#2b8a3e", "#9c36b5", "#c2255c", "#0c8599")
"""One per run; the first three are distinguishable with a colour deficiency."""


@dataclass(frozen=True, slots=True, eq=False)
class ReplayedRun:
    """A run with its arm, label and colour, and the flange pose T_{0,flange}, actual and desired."""

    run: Run
    arm: Arm
    label: str
    colour: str
    pose: Array  # (k, 4, 4) [m], actual
    pose_ref: Array  # (k, 4, 4) [m], desired

    @property
    def caption(self) -> str:
        """The label for a figure: with the stops that joints met, as they are part of what is drawn."""
        return "; ".join(text for text in (self.label, stop_contacts(self.run, self.arm).sentence()) if text)

    @property
    def tip_error(self) -> Array:
        """Distance between desired and actual flange position, (k,) [m]."""
        return np.asarray(np.linalg.norm(self.pose_ref[:, :3, 3] - self.pose[:, :3, 3], axis=1))

    @property
    def reference_path(self) -> Array:
        """Points of the desired path, (m, 3) [m]: the one stored in the run if any, else that of `pose_ref`."""
        stored = self.run.meta.get("reference_trace")
        if stored is None:
            return np.asarray(self.pose_ref[:, :3, 3])
        points = real_array("reference_trace", stored)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ShapeError("reference_trace", f"shape {points.shape}", "(m, 3), points in the base frame in m")
        return points


def replayed_runs(
    runs: Sequence[Run], arms: Arm | Sequence[Arm], labels: Sequence[str] | None = None
) -> tuple[ReplayedRun, ...]:
    """Runs with their arms, labels and colours.

    Parameters
    ----------
    runs : sequence of Run
    arms : Arm or sequence of Arm
        One for all, or one per run.
    labels : sequence of str, optional
        One per run; the controller's name if not given, numbered where names repeat.

    Raises
    ------
    OptionError
        No run, or not one arm and one label per run.
    ShapeError
        A run that is empty, not finite, or has other joints than its arm.
    """
    arm_of = [arms] * len(runs) if isinstance(arms, Arm) else list(arms)
    names = _labels(runs) if labels is None else [str(label) for label in labels]
    if not runs:
        raise OptionError("runs", "none", "one or more")
    for option, values in (("arms", arm_of), ("labels", names)):
        if len(values) != len(runs):
            raise OptionError(option, f"{len(values)} for {len(runs)} runs", "one per run")
    colours = [RUN_COLOURS[i % len(RUN_COLOURS)] for i in range(len(runs))]
    return tuple(_replayed(*row) for row in zip(runs, arm_of, names, colours, strict=True))


def _replayed(run: Run, arm: Arm, label: str, colour: str) -> ReplayedRun:
    if run.t.ndim != 1 or run.t.size == 0:
        raise ShapeError(f"t of {label}", f"shape {run.t.shape}", "(k,) with at least one time")
    if not (np.diff(run.t) > 0.0).all():
        raise ShapeError(f"t of {label}", "times that do not grow", "strictly growing times")
    shape = (run.t.size, arm.n)
    for name in ("q", "dq", "q_ref", "dq_ref", "tau_applied"):
        array = real_array(f"{name} of {label}", getattr(run, name))
        if array.shape != shape:
            raise ShapeError(f"{name} of {label}", f"shape {array.shape}", f"{shape} for {arm.name}")
    pose, pose_ref = (forward.forward_kinematics(arm.chain, q) for q in (run.q, run.q_ref))
    return ReplayedRun(run, arm, label, colour, pose, pose_ref)


def _labels(runs: Sequence[Run]) -> list[str]:
    plain = [facts(run).get("controller", "run") for run in runs]
    return [name if plain.count(name) == 1 else f"{name} {plain[: i + 1].count(name)}" for i, name in enumerate(plain)]


def facts(run: Run) -> dict[str, str]:
    """Facts about a run for a page or a line, if known: robot, reading, mount, tool, controller, task, ... audit.

    Raises `OptionError` for a record that is not as `simulate` writes it.
    """
    try:
        return _facts(run)
    except (AttributeError, KeyError, TypeError, ValueError):
        raise OptionError("run", "a record of another form", "a run made by simulate") from None


def _facts(run: Run) -> dict[str, str]:
    meta, note = run.meta, run.meta.get("note") or {}
    given = meta.get("loaded_with") or {}
    values = {"robot": meta.get("robot"), "reading": meta.get("reading")}
    values |= {what: _shortly(given[what]) for what in ("mount", "tool") if what in given}
    values["controller"] = _controller(meta)
    values["task"] = note.get("task", meta.get("task"))
    carrier = "tool centre point" if "tool" in given else "flange"
    values["payload"] = _payload(meta.get("payload"), bool(note.get("payload_known")), carrier)
    values["plant"] = note.get("plant", meta.get("plant"))
    values["audit"] = audit_words(run.audit)
    return {key: value for key, value in values.items() if isinstance(value, str) and value}


def _controller(meta: Mapping[str, Any]) -> Any:
    """The controller's label; its name in runs that have no label."""
    controller = meta.get("controller")
    return controller.get("label", controller.get("name")) if isinstance(controller, Mapping) else controller


def _shortly(fields: Mapping[str, Any]) -> str:
    """A mount or a tool in words: its place and its mass."""
    words = ("on", "xyz", "rpy", "rpy_deg", "pose", "mass")
    return json.dumps({key: fields[key] for key in words if key in fields}).strip("{}").replace('"', "")


def _payload(load: Any, known: bool, carrier: str) -> str | None:
    """A load in words: its mass, where it is fixed, and whether the controller knows of it."""
    if not isinstance(load, Mapping):
        return None
    com = load.get("com", (0.0, 0.0, 0.0))
    place = f"({', '.join(f'{x:g}' for x in com)}) m from the {carrier}" if any(com) else f"the {carrier}"
    return f"{load.get('mass', 0.0):g} kg at {place}{', known to the controller' if known else ''}"
