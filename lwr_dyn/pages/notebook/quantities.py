"""What can be plotted of runs, by name: each is described as a figure, which `lwr_dyn.plot` draws."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.model.dh import JointKind
from lwr_dyn.pages.figures.responses import response_figures
from lwr_dyn.pages.plotting.run_figures import path_figure, tip_error_figure, torque_figure
from lwr_dyn.pages.replay.figures import Curve, Figure, Level, Panel, Series, SeriesName
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun

Runs = Sequence[ReplayedRun]
MILLI = 1e3


def tip_error(runs: Runs) -> tuple[Figure, ...]:
    """Distance of the flange from where it should be [mm]."""
    return (tip_error_figure(runs),)


def energy(runs: Runs) -> tuple[Figure, ...]:
    """Kinetic and potential energy [J]."""
    panel = Panel("", "energy", "J", tuple(Curve(one.caption, Series(i, "energy")) for i, one in enumerate(runs)))
    return (Figure("energy", "Energy", "", "time", "s", (panel,), over_time=True),)


def torque(runs: Runs) -> tuple[Figure, ...]:
    """Applied torques [N m, N], with the limits that are known."""
    return (torque_figure(runs),)


def friction(runs: Runs) -> tuple[Figure, ...]:
    """Torques of friction [N m, N]."""
    return (_of_joints(runs, "friction", ("N m", "N"), "Friction"),)


def position(runs: Runs) -> tuple[Figure, ...]:
    """Joint positions and their references [rad, m]."""
    return (_of_joints(runs, "q", ("rad", "m"), "Positions", "q_ref"),)


def velocity(runs: Runs) -> tuple[Figure, ...]:
    """Joint speeds and their references [rad/s, m/s]."""
    return (_of_joints(runs, "dq", ("rad/s", "m/s"), "Speeds", "dq_ref", "velocity"),)


def position_error(runs: Runs) -> tuple[Figure, ...]:
    """Errors of the joint positions, reference minus actual [mrad, mm]."""
    return (_of_joints(runs, "position error", ("mrad", "mm"), "Position errors", scale=MILLI),)


def velocity_error(runs: Runs) -> tuple[Figure, ...]:
    """Errors of the joint speeds [mrad/s, mm/s]."""
    return (_of_joints(runs, "velocity error", ("mrad/s", "mm/s"), "Speed errors", scale=MILLI),)


def path(runs: Runs) -> tuple[Figure, ...]:
    """The path of the flange [m] in the coordinate plane in which it is widest, with its reference."""
    return (path_figure(runs),)


def overview(runs: Runs) -> tuple[Figure, ...]:
    """The tip error [mm], then the torques joint by joint [N m, N]."""
    (tip,), (torques,) = tip_error(runs), torque(runs)
    named = tuple(replace(panel, title="tip error") for panel in tip.panels)
    return (replace(torques, id="overview", title="Tip error and torques", panels=(*named, *torques.panels)),)


QUANTITIES: Mapping[str, Callable[[Runs], tuple[Figure, ...]]] = {
    "overview": overview,
    "tip error": tip_error,
    "path": path,
    "torque": torque,
    "position error": position_error,
    "velocity error": velocity_error,
    "position": position,
    "velocity": velocity,
    "friction": friction,
    "energy": energy,
    "response": response_figures,
}
"""Name -> the figures of runs, side by side."""


def quantity_named(name: str) -> str:
    """The quantity of a name, in which "-" and "_" count as spaces; raises `UnknownNameError`, which lists all.

    >>> quantity_named("Tip-Error")
    'tip error'
    """
    plain = " ".join(str(name).lower().replace("-", " ").replace("_", " ").split())
    if plain not in QUANTITIES:
        raise UnknownNameError("quantity", str(name), QUANTITIES)
    return plain


def _of_joints(
    runs: Runs,
    quantity: SeriesName,
    units: tuple[str, str],
    title: str,
    reference: SeriesName | None = None,
    limits: str = "",
    scale: float = 1.0,
) -> Figure:
    """One panel a joint; `units` of a joint that turns and of one that slides."""
    panels = []
    for j, joint in enumerate(runs[0].arm.joints()):
        wanted = () if reference is None else (Curve("reference", Series(0, reference, j, scale)),)
        curves = tuple(Curve(one.caption, Series(i, quantity, j, scale)) for i, one in enumerate(runs))
        limit, unit = getattr(joint.limits, limits, None), units[joint.kind is not JointKind.REVOLUTE]
        levels = () if limit is None else (Level("limit", limit), Level("limit", -limit))
        note = "" if not limits else f"limit {limit:g} {unit}" if limit is not None else "limit not known"
        panels.append(Panel(joint.name, quantity, unit, (*wanted, *curves), levels, note))
    name = quantity.replace(" ", "-")
    return Figure(name, title, "", "time", "s", tuple(panels), over_time=True, columns=2)
