"""`ReplayedRun`: a run with its arm, label and place in the palette; every picture starts from it."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.protocol import LAMBDA, UNNAMED
from lwr_dyn.foundation.arrays import Array, real_array
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.kinematics import forward
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run, run_used
from lwr_dyn.pages.replay.look import RUN_COLOURS, run_colour
from lwr_dyn.simulation.audit import audit_words
from lwr_dyn.simulation.metrics import stop_contacts

PLACES = {"inverse-dynamics": 0, "pd-gravity": 1, "pid": 2}
"""The places in the palette that belong to controllers; the fourth belongs to all others."""

PLAIN = "as modelled"
"""What is said of a plant that is the controller's model."""


@dataclass(frozen=True, slots=True, eq=False)
class ReplayedRun:
    """A run with its arm, label and place in the palette, and the flange pose T_{0,flange}, actual and desired."""

    run: Run
    arm: Arm
    label: str
    place: int  # in the palette, of `run_places`
    pose: Array  # (k, 4, 4) [m], actual
    pose_ref: Array  # (k, 4, 4) [m], desired

    @property
    def colour(self) -> str:
        """Its colour in the light scheme; pages write the token `--run1` to `--run5` of its place."""
        return run_colour(self.place)

    @property
    def caption(self) -> str:
        """The label for a figure: with the stops that joints met, as they are part of what is drawn."""
        return "; ".join(text for text in (self.label, stop_contacts(self.run, self.arm).sentence()) if text)

    @property
    def caveat(self) -> str:
        """What must be known before its numbers; empty where nothing must."""
        return self.arm.caveat(run_used(self.run))

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
    """Runs with their arms, labels and places in the palette.

    Parameters
    ----------
    runs : sequence of Run
    arms : Arm or sequence of Arm
        One for all, or one per run.
    labels : sequence of str, optional
        One per run; if not given the controller's, with what differs where it repeats.

    Raises
    ------
    OptionError
        No run, or not one arm and one label per run.
    ShapeError
        A run that is empty, not finite, or has other joints than its arm.
    """
    arm_of = [arms] * len(runs) if isinstance(arms, Arm) else list(arms)
    if isinstance(labels, str):
        raise OptionError("labels", repr(labels), "a list of names, one per run")
    names = _labels(runs) if labels is None else [str(label) for label in labels]
    if not runs:
        raise OptionError("runs", "none", "one or more")
    for option, values in (("arms", arm_of), ("labels", names)):
        if len(values) != len(runs):
            raise OptionError(option, f"{len(values)} for {len(runs)} runs", "one per run")
    places = run_places([run_name(run) for run in runs])
    return tuple(_replayed(*row) for row in zip(runs, arm_of, names, places, strict=True))


def pose_as_run(arm: Arm, q: ArrayLike) -> Run:
    """A pose q (n,) [rad or m] as a run of one sample, which is what a stage draws."""
    at, nothing, zero = np.asarray(q, dtype=np.float64)[None], np.zeros((1, arm.n)), np.zeros(1)
    return Run(zero, at, nothing, at, nothing, nothing, nothing, nothing, zero, {})


def run_name(run: Run) -> tuple[str, str, str]:
    """What gives a run its colour, as its file has it: the controller; its plant and payload; its label."""
    controller, known = run.meta.get("controller"), facts(run)
    name = controller.get("name") if isinstance(controller, Mapping) else controller
    more = [known[key] for key in ("plant", "payload") if known.get(key, PLAIN) != PLAIN]
    return str(name), ", ".join(more), known.get("controller", "")


def run_places(names: Sequence[tuple[str, str, str]]) -> tuple[int, ...]:
    """The places in the palette of the runs of one picture, by their names (`run_name`), whatever their order.

    A run has the place of its controller, alone and beside others. Where several of one picture want a place, the one
    of the shortest label and then of the plain plant has it; each other one gets the first place that stays free. From
    the fifth run on: 4, grey.

    >>> run_places([("pid", "", ""), ("mine", "", ""), ("pid", "3 kg", ""), ("pd-gravity", "", "")])
    (2, 3, 0, 1)
    """
    order = sorted(range(len(names)), key=lambda i: (len(names[i][2]), names[i][2], names[i][1], names[i][0], i))
    having: dict[int, int] = {}
    for i in order:
        having.setdefault(PLACES.get(names[i][0], len(PLACES)), i)
    free = (place for place in range(len(RUN_COLOURS)) if place not in having)
    place_of = {i: place for place, i in having.items()}
    place_of |= dict(zip((i for i in order if i not in place_of), free, strict=False))
    return tuple(place_of.get(i, len(RUN_COLOURS)) for i in range(len(names)))


def _replayed(run: Run, arm: Arm, label: str, place: int) -> ReplayedRun:
    if run.t.ndim != 1 or run.t.size == 0:
        raise ShapeError(f"t of {label}", f"shape {run.t.shape}", "(k,) with at least one time")
    if not (np.diff(run.t) > 0.0).all():
        raise ShapeError(f"t of {label}", "times that do not grow", "strictly growing times")
    shape = (run.t.size, arm.n)
    for name in ("q", "dq", "q_ref", "dq_ref", "tau_applied"):
        array = real_array(f"{name} of {label}", getattr(run, name))
        if array.shape != shape:
            raise ShapeError(f"{name} of {label}", f"shape {array.shape}", f"{shape} for {arm.name}")
    pose, pose_ref = (forward.flange_pose(arm.chain, q) for q in (run.q, run.q_ref))
    return ReplayedRun(run, arm, label, place, pose, pose_ref)


def _labels(runs: Sequence[Run]) -> list[str]:
    """The controller, of several robots after the robot; where it repeats with plant and payload, then a number."""
    names, robots = (
        [facts(run).get(key, other) for run in runs] for key, other in (("controller", "run"), ("robot", ""))
    )
    if len(set(robots)) > 1:
        names = [f"{robot}: {name}" for robot, name in zip(robots, names, strict=True)]
    more = [run_name(run)[1] for run in runs]
    full = [f"{n}, {m}" if m and names.count(n) > 1 else n for n, m in zip(names, more, strict=True)]
    return [name if full.count(name) == 1 else f"{name} {full[: i + 1].count(name)}" for i, name in enumerate(full)]


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
    controller, carrier = meta.get("controller"), "tool centre point" if "tool" in given else "flange"
    if isinstance(controller, Mapping):  # its name in runs that have no label
        controller = controller.get("label", controller.get("name"))
    if isinstance(controller, str):  # runs of 0.2 have Python's word for a lambda
        controller = controller.replace(LAMBDA, UNNAMED)
    values = {
        "robot": meta.get("robot"),
        "reading": meta.get("reading"),
        **{what: _shortly(given[what]) for what in ("mount", "tool") if what in given},
        "controller": controller,
        "task": note.get("task", meta.get("task")),
        "payload": _payload(meta.get("payload"), bool(note.get("payload_known")), carrier),
        "plant": note.get("plant", meta.get("plant")),
        "audit": audit_words(run.audit),
    }
    return {key: value for key, value in values.items() if isinstance(value, str) and value}


def _shortly(fields: Mapping[str, Any]) -> str:
    """A mount or a tool in words, with units: "ceiling, at (0, 0, 2.5) m", "at (0, 0, 0.1) m, 0.5 kg"."""
    forms = {"on": "{}", "xyz": "at {} m", "rpy": "rpy {} rad", "rpy_deg": "rpy {} deg", "pose": "pose {}"}
    forms |= {"mass": "{} kg"}
    shown = ((form, json.dumps(fields[key])) for key, form in forms.items() if key in fields)
    return ", ".join(form.format(value.strip('"').replace("[", "(").replace("]", ")")) for form, value in shown)


def _payload(load: Any, known: bool, carrier: str) -> str | None:
    """A load in words: its mass, where it is fixed, and whether the controller knows of it."""
    if not isinstance(load, Mapping):
        return None
    com = load.get("com", (0.0, 0.0, 0.0))
    place = f"({', '.join(f'{x:g}' for x in com)}) m from the {carrier}" if any(com) else f"the {carrier}"
    return f"{load.get('mass', 0.0):g} kg at {place}{', known to the controller' if known else ''}"
