"""Figures of runs: errors, torques against their limits, the path of the flange, one joint's register.

Each takes the runs that are shown together, and the places of those that it draws (all of them if not given). Titles
and ids are general; `dataclasses.replace` gives those of a document.
"""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.dh import JointKind
from lwr_dyn.pages.replay.figures import GREY, Curve, Figure, Level, Panel, Series, SeriesName
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun

_PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
_REFERENCE: tuple[SeriesName, ...] = ("reference x", "reference y", "reference z")
_FLANGE: tuple[SeriesName, ...] = ("flange x", "flange y", "flange z")


def error_figure(
    runs: Sequence[ReplayedRun],
    chosen: Sequence[int] | None = None,
    quantity: Literal["position error", "velocity error"] = "position error",
) -> Figure:
    """Joint errors q_ref - q [mrad, mm] or dq_ref - dq [mrad/s, mm/s] over time: run by run a panel per joint."""
    per = "/s" if quantity == "velocity error" else ""
    panels = []
    for i in _places(runs, chosen):
        for j, joint in enumerate(runs[i].arm.joints()):
            unit = f"mrad{per}" if joint.kind is JointKind.REVOLUTE else f"mm{per}"
            curve = Curve(runs[i].caption, Series(i, quantity, j, 1e3))
            panels.append(Panel(joint.name, quantity, unit, (curve,)))
    title = f"{quantity.capitalize()}s of the joints"
    return Figure(quantity.replace(" ", "-"), title, "", "time", "s", tuple(panels), over_time=True, columns=4)


def tip_error_figure(runs: Sequence[ReplayedRun], chosen: Sequence[int] | None = None) -> Figure:
    """Distance of the flange from where it should be [mm] over time, a curve per run."""
    curves = tuple(Curve(runs[i].caption, Series(i, "tip error", scale=1e3)) for i in _places(runs, chosen))
    panel = Panel("", "tip error", "mm", curves)
    return Figure("tip-error", "Tip error", "", "time", "s", (panel,), over_time=True)


def torque_figure(runs: Sequence[ReplayedRun], chosen: Sequence[int] | None = None) -> Figure:
    """Applied torques [N m, N] of all runs over time, one panel per joint, with the limits that are known."""
    places = _places(runs, chosen)
    arm = max((runs[i].arm for i in places), key=lambda a: a.n)
    panels = []
    for j, joint in enumerate(arm.joints()):
        limit, unit = joint.limits.effort, "N m" if joint.kind is JointKind.REVOLUTE else "N"
        curves = tuple(Curve(runs[i].caption, Series(i, "torque", j)) for i in places if runs[i].arm.n > j)
        levels = () if limit is None else (Level("limit", limit), Level("limit", -limit))
        note = "limit not known" if limit is None else f"limit {limit:g} {unit}"
        panels.append(Panel(joint.name, "torque", unit, curves, levels, note))
    title = "Torques and their limits"
    return Figure("torque", title, "", "time", "s", tuple(panels), over_time=True, columns=2)


def path_figure(runs: Sequence[ReplayedRun], chosen: Sequence[int] | None = None, plane: str | None = None) -> Figure:
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
    rows: tuple[tuple[str, str, dict[str, SeriesName]], ...] = (
        ("position", "rad", {"q": "q"}),
        ("velocity", "rad/s", {"dq": "dq"}),
        ("torque", "N m", {"motor": "torque", "friction": "friction"}),
    )
    panels = tuple(
        Panel(name, name, unit, tuple(Curve(label, Series(run, quantity, joint)) for label, quantity in curves.items()))
        for name, unit, curves in rows
    )
    return Figure("register", f"Register of joint {joint + 1}", "", "time", "s", panels, over_time=True)


def _places(runs: Sequence[ReplayedRun], chosen: Sequence[int] | None) -> Sequence[int]:
    return range(len(runs)) if chosen is None else chosen
