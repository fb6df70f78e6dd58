"""Figures of runs: errors, torques and limits, the flange's path, a wall's force, an observer, responses; by name.

Each takes the runs that are shown together, and the places of those that it draws (all of them if not given). Titles
and ids are general; `dataclasses.replace` gives those of a document. `QUANTITIES` names what `lwr_dyn.plot` draws.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Literal

import numpy as np

from lwr_dyn.control.laws.observer import CollisionThreshold
from lwr_dyn.control.protocol import label_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError, UnknownNameError
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.run import Run
from lwr_dyn.pages.figures.figure import GREY, Curve, Figure, Level, Panel, Series, SeriesName
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from lwr_dyn.simulation.step_and_chirp import HALF_POWER, FrequencyResponse, StepResponse, responses_of
from lwr_dyn.simulation.walls_and_pushes import Wall

Runs = Sequence[ReplayedRun]

MILLI = 1e3

_PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}

_REFERENCE: tuple[SeriesName, ...] = ("reference x", "reference y", "reference z")

_FLANGE: tuple[SeriesName, ...] = ("flange x", "flange y", "flange z")


def error_figure(
    runs: Runs,
    chosen: Sequence[int] | None = None,
    quantity: Literal["position error", "velocity error"] = "position error",
) -> Figure:
    """Joint errors q_ref - q [mrad, mm] or dq_ref - dq [mrad/s, mm/s] over time: run by run a panel per joint."""
    per = "/s" if quantity == "velocity error" else ""
    panels = []
    for i in _places(runs, chosen):
        for j, joint in enumerate(runs[i].arm.joints()):
            unit = f"mrad{per}" if joint.kind is JointKind.REVOLUTE else f"mm{per}"
            panels.append(Panel(joint.name, quantity, unit, (Curve(runs[i].caption, Series(i, quantity, j, MILLI)),)))
    title = f"{quantity.capitalize()}s of the joints"
    return Figure(quantity.replace(" ", "-"), title, "", "time", "s", tuple(panels), over_time=True, columns=4)


def tip_error_figure(runs: Runs, chosen: Sequence[int] | None = None) -> Figure:
    """Distance of the flange from where it should be [mm] over time, a curve per run."""
    curves = tuple(Curve(runs[i].caption, Series(i, "tip error", scale=MILLI)) for i in _places(runs, chosen))
    panel = Panel("", "tip error", "mm", curves)
    return Figure("tip-error", "Tip error", "", "time", "s", (panel,), over_time=True)


def torque_figure(runs: Runs, chosen: Sequence[int] | None = None) -> Figure:
    """Applied torques [N m, N] of all runs over time, one panel per joint, with the limits that are known."""
    return joints_figure(runs, "torque", ("N m", "N"), "Torques and their limits", limit="effort", chosen=chosen)


def joints_figure(
    runs: Runs,
    quantity: SeriesName,
    units: tuple[str, str],
    title: str,
    *,
    reference: SeriesName | None = None,
    limit: str = "",
    scale: float = 1.0,
    chosen: Sequence[int] | None = None,
) -> Figure:
    """A quantity of the joints over time, one panel per joint.

    Parameters
    ----------
    runs, chosen
        See this module.
    units : (str, str)
        Of a joint that turns and of one that slides.
    reference : SeriesName, optional
        Drawn of the first run.
    limit : str, optional
        The field of `JointLimits` that is drawn at either side of zero, or said to be unknown.
    """
    places = _places(runs, chosen)
    panels = []
    for j, joint in enumerate(max((runs[i].arm for i in places), key=lambda arm: arm.n).joints()):
        wanted = () if reference is None else (Curve("reference", Series(0, reference, j, scale)),)
        curves = (Curve(runs[i].caption, Series(i, quantity, j, scale)) for i in places if runs[i].arm.n > j)
        unit, most = units[joint.kind is not JointKind.REVOLUTE], getattr(joint.limits, limit, None)
        levels = () if most is None else (Level("limit", most), Level("limit", -most))
        note = "" if not limit else "limit not known" if most is None else f"limit {most:g} {unit}"
        panels.append(Panel(joint.name, quantity, unit, (*wanted, *curves), levels, note))
    name = quantity.replace(" ", "-")
    return Figure(name, title, "", "time", "s", tuple(panels), over_time=True, columns=2)


def path_figure(runs: Runs, chosen: Sequence[int] | None = None, plane: str | None = None) -> Figure:
    """The path of the flange in a plane of the base [m], with its reference.

    Parameters
    ----------
    runs, chosen
        See this module.
    plane : {"xy", "xz", "yz"}, optional
        The one in which the first reference is widest, if not given.

    Raises
    ------
    OptionError
        A plane of another name.
    """
    if plane is not None and plane not in _PLANES:
        raise OptionError("plane", repr(plane), ", ".join(_PLANES))
    places = _places(runs, chosen)
    drawn = plane or widest_plane(runs[places[0]].reference_path)
    a, b = _PLANES[drawn]
    first = {runs[i].run.q_ref.tobytes(): i for i in reversed(places)}
    references = tuple(_reference(runs[i], i, a, b) for i in sorted(first.values(), key=places.index))
    paths = tuple(Curve(runs[i].caption, Series(i, _FLANGE[b]), Series(i, _FLANGE[a])) for i in places)
    panel = Panel("", drawn[1], "m", (*references, *paths))
    return Figure("path", "Path of the flange", "", drawn[0], "m", (panel,), equal_aspect=True)


def _reference(one: ReplayedRun, run: int, a: int, b: int) -> Curve:
    """The task's own points where the run file has them."""
    if "reference_trace" in one.run.meta:
        points = one.reference_path
        return Curve("reference", points[:, b], points[:, a], dashed=True, colour=GREY)
    return Curve("reference", Series(run, _REFERENCE[b]), Series(run, _REFERENCE[a]), dashed=True)


def widest_plane(points: Array) -> str:
    """The coordinate plane that drops the axis in which points (m, 3) spread least.

    >>> widest_plane(np.array([[0.0, 0.0, 0.0], [0.1, 1.0, 2.0]]))
    'yz'
    """
    dropped = int(np.argmin(np.ptp(points, axis=0)))
    return ("yz", "xz", "xy")[dropped]


def register_figure(run: int, joint: int) -> Figure:
    """Position, velocity, and torques of motor and friction of a 0-based joint of run `run` over time."""

    def curve(label: str, quantity: SeriesName) -> Curve:
        return Curve(label, Series(run, quantity, joint))

    panels = (
        Panel("position", "position", "rad", (curve("q", "q"),)),
        Panel("velocity", "velocity", "rad/s", (curve("dq", "dq"),)),
        Panel("torque", "torque", "N m", (curve("motor", "torque"), curve("friction", "friction"))),
    )
    return Figure("register", f"Register of joint {joint + 1}", "", "time", "s", panels, over_time=True)


def _places(runs: Runs, chosen: Sequence[int] | None) -> Sequence[int]:
    return range(len(runs)) if chosen is None else chosen


def pressing_and_drag(run: Run, wall: Wall) -> tuple[Array, Array]:
    """The force along the wall's normal (k,) and the size of that along the wall (k,) [N]; raises `ShapeError`."""
    force = wall.forces(run.q, run.dq)
    pressing = force @ wall.normal
    return pressing, np.linalg.norm(force - pressing[:, None] * wall.normal, axis=1)


def contact_figure(runs: Run | Sequence[Run], wall: Wall, labels: Sequence[str] | None = None) -> Figure:
    """A figure that `lwr_dyn.pages.plotting.plots.save_figure` writes.

    Parameters
    ----------
    runs : Run or sequence of Run
        Of the wall's arm.
    wall : Wall
    labels : sequence of str, optional
        One a run; the names of their controllers if not given.

    Raises
    ------
    OptionError
        No run, or another number of labels.
    ShapeError
        A run of an arm with another number of joints.
    """
    several = [runs] if isinstance(runs, Run) else list(runs)
    names = [_label(run) for run in several] if labels is None else list(labels)
    if not several or len(names) != len(several):
        raise OptionError("labels", f"{len(names)} for {len(several)} runs", "one for each run, at least one run")
    forces = [pressing_and_drag(run, wall) for run in several]
    panels = []
    for which, title in enumerate(("Into the wall", "Along the wall")):
        rows = enumerate(zip(names, several, forces, strict=True))
        curves = (Curve(name, both[which], x=run.t, colour=place) for place, (name, run, both) in rows)
        panels.append(Panel(title, "force", "N", tuple(curves)))
    return Figure("contact", "Force of the wall on the tip", "", "time", "s", tuple(panels))


def _label(run: Run) -> str:
    controller = run.meta.get("controller", {})
    return str(controller.get("label", "run")) if run.setup is None else label_of(run.setup.controller)


def observer_figure(run: Run, joints: Sequence[int] | None = None) -> Figure:
    """Estimate, levels and true external torque [N m] over time [s], a panel a joint; `joints` are 0-based.

    Raises `MissingDataError` for a run without an observer, such as a continuous one.
    """
    own = run.meta.get("controller", {}).get("parameters", {}).get("observer")
    if own is None or "external_torque" not in run.signals or run.t.size < 2:
        raise MissingDataError("the run", "signals of a momentum observer", "its figure (a law as LAW+observer)")
    inertia = None if own["inertia"] is None else np.array(own["inertia"])
    threshold = CollisionThreshold(np.array(own["bias"]), inertia, own["noise"], own["cutoff_hz"])
    level = threshold.level(np.array(own["gain"]), float(run.t[1] - run.t[0]))
    estimate, true, panels = run.signals["external_torque"], run.signals.get("tau_external"), []
    for j in range(run.n) if joints is None else joints:
        curves = [Curve("estimate", estimate[:, j], run.t, colour=0)]
        if true is not None:
            curves.insert(0, Curve("true", true[:, j], run.t, dashed=True, colour=GREY))
        ends = (Level("level", float(level[j])), Level("level", -float(level[j])))
        panels.append(Panel(f"joint_{j + 1}", "external torque", "N m", tuple(curves), ends))
    title = "External torque by the momentum observer"
    return Figure("external-torque", title, "", "time", "s", tuple(panels), over_time=True, columns=2)


def response_figure(runs: Runs) -> Figure:
    """Steps [share of the step] or frequency responses [dB, deg] of runs.

    Raises `OptionError` for runs of other tasks, or of both.
    """
    found: Any = [responses_of(one.run, one.arm) for one in runs]
    kinds = {type(response) for each in found for response in each}
    if len(kinds) != 1 or not all(found):
        raise OptionError("runs", "not all of the task step, or not all of the task chirp", "runs of one of them")
    is_step, panels = kinds == {StepResponse}, list[Panel]()
    for joint in (response.joint for response in found[0]):
        mine = [(one, r) for one, each in zip(runs, found, strict=True) for r in each if r.joint == joint]
        panels += [_step_panel(joint, mine)] if is_step else _chirp_panels(joint, mine)
    if is_step:
        return Figure("response", "Responses to a step", "", "time from the step", "ms", tuple(panels), columns=2)
    return Figure("response", "Frequency responses", "", "frequency", "Hz", tuple(panels), columns=2)


def _step_panel(joint: int, mine: Sequence[tuple[ReplayedRun, StepResponse]]) -> Panel:
    curves = tuple(Curve(one.caption, r.y, MILLI * r.t, colour=one.place) for one, r in mine)
    first = mine[0][1]
    note = f"rise {MILLI * first.rise:.3g} ms, overshoot {100.0 * first.overshoot:.2g} %" if len(mine) == 1 else ""
    return Panel(f"joint {joint}", "share of the step", "", curves, (Level("asked for", 1.0),), note)


def _chirp_panels(joint: int, mine: Sequence[tuple[ReplayedRun, FrequencyResponse]]) -> list[Panel]:
    size = tuple(Curve(one.caption, 20.0 * np.log10(np.abs(r.H)), r.f, colour=one.place) for one, r in mine)
    angle = tuple(Curve(one.caption, np.degrees(np.unwrap(np.angle(r.H))), r.f, colour=one.place) for one, r in mine)
    first = mine[0][1]
    reached = "beyond the sweep" if np.isnan(first.bandwidth) else f"{first.bandwidth:.3g} Hz"
    note = f"bandwidth {reached}" if len(mine) == 1 else ""
    level = Level("bandwidth", float(20.0 * np.log10(HALF_POWER)))
    return [
        Panel(f"joint {joint}, magnitude in dB", "magnitude", "dB", size, (level,), note),
        Panel(f"joint {joint}, phase in deg", "phase", "deg", angle),
    ]


def energy_figure(runs: Runs) -> Figure:
    """Kinetic and potential energy [J]."""
    panel = Panel("", "energy", "J", tuple(Curve(one.caption, Series(i, "energy")) for i, one in enumerate(runs)))
    return Figure("energy", "Energy", "", "time", "s", (panel,), over_time=True)


def overview_figure(runs: Runs) -> Figure:
    """The tip error [mm], then the torques joint by joint [N m, N]."""
    torques = torque_figure(runs)
    named = (replace(panel, title="tip error") for panel in tip_error_figure(runs).panels)
    return replace(torques, id="overview", title="Tip error and torques", panels=(*named, *torques.panels))


QUANTITIES: Mapping[str, Callable[[Runs], Figure]] = {
    "overview": overview_figure,
    "tip error": tip_error_figure,
    "path": path_figure,
    "torque": torque_figure,
    "position error": partial(
        joints_figure, quantity="position error", units=("mrad", "mm"), title="Position errors", scale=MILLI
    ),
    "velocity error": partial(
        joints_figure, quantity="velocity error", units=("mrad/s", "mm/s"), title="Speed errors", scale=MILLI
    ),
    "position": partial(joints_figure, quantity="q", units=("rad", "m"), title="Positions", reference="q_ref"),
    "velocity": partial(
        joints_figure, quantity="dq", units=("rad/s", "m/s"), title="Speeds", reference="dq_ref", limit="velocity"
    ),
    "friction": partial(joints_figure, quantity="friction", units=("N m", "N"), title="Friction"),
    "energy": energy_figure,
    "response": response_figure,
}
"""Name -> the figure of runs."""


def quantity_named(name: str) -> str:
    """The quantity of a name, in which "-" and "_" count as spaces; raises `UnknownNameError`, which lists all.

    >>> quantity_named("Tip-Error")
    'tip error'
    """
    plain = " ".join(str(name).lower().replace("-", " ").replace("_", " ").split())
    if plain not in QUANTITIES:
        raise UnknownNameError("quantity", str(name), QUANTITIES)
    return plain
