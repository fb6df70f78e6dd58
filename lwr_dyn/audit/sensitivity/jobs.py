"""Tasks of the papers as jobs: a reference for the joints, the laws that follow it, what the paper says of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import OptionError, UnknownNameError
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference
from lwr_dyn.trajectory.references.ist import ist_reference
from lwr_dyn.trajectory.references.lspb_move import lspb_move
from lwr_dyn.trajectory.references.point_to_point import point_to_point

PD, INVERSE = "PD + gravity", "inverse dynamics"
NO_GRAVITY = f"{INVERSE} without g"
WAM_START = (0.0, -2.0, 0.0, 1.6, 0.0, 0.0, 0.0)
WAM_TRAVEL, WAM_DURATION, WAM_BLEND = 0.5, 7.0, 1.0
POINTS_MM = ((91.0, -1139.0, 1392.0), (91.0, -1117.0, 1447.0))
"""KR 30 HA report, Table 1: the two points, flange with A = B = C = 0."""
LEG = 4.0
"""[s] of each leg between points; the report gives no times."""
JOINT_LEG = 2.0
MIDDLE = 0.1
"""A move of the joints goes this share of their ranges, about the middle."""


@dataclass(frozen=True, slots=True)
class Law:
    """A controller by name, with the options of its factory."""

    name: str
    controller: str
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Said:
    """A conclusion of a paper about the joints with the largest errors under a law."""

    text: str
    law: str
    joints: tuple[int, ...]
    figure: str
    """Field of `ErrorFigures` whose size ranks the joints."""


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """What is simulated for every pair of readings."""

    name: str
    about: str
    reference: Reference
    laws: tuple[Law, ...]
    said: tuple[Said, ...] = ()
    substeps: int = 1


PAPER_LAWS = (
    Law(PD, "pd-gravity"),
    Law(INVERSE, "inverse-dynamics", {"feedforward": False}),
    Law(NO_GRAVITY, "inverse-dynamics", {"feedforward": False, "gravity": False}),
)
"""The laws as the LWR 4+ paper writes them: omega_n = 50 rad/s, xi = 1, no feed-forward of ddq; and without g, as its
Table VIII comes out."""
LARGEST_ERRORS = tuple(
    Said(f"joints 2 and 4 have the highest errors under {law}", law, (1, 3), figure)
    for law, figure in ((PD, "max"), (INVERSE, "mean_abs"), (NO_GRAVITY, "mean_abs"))
)
"""Below Tables VII ("the highest maximum errors") and VIII ("higher position errors")."""


def ist(arm: Arm) -> Job:
    """The letters IST in 14 s, smooth timing, arm angle of the largest margin."""
    about = "the letters IST in 14 s, smooth timing, arm angle of the largest margin from the limits"
    said = LARGEST_ERRORS if arm.name == "lwr4plus" else ()
    return Job("ist", about, ist_reference(arm, "smooth"), PAPER_LAWS, said)


def lspb(arm: Arm) -> Job:
    """The WAM paper's move of all joints at once: 0.5 rad in 7 s on an LSPB, from its start."""
    if arm.n != len(WAM_START):
        raise OptionError("task lspb", f"{arm.n} joints", f"an arm of {len(WAM_START)} joints")
    start = np.array(WAM_START)
    move = lspb_move(arm, start, start + WAM_TRAVEL, duration=WAM_DURATION, blend=WAM_BLEND)
    pd = Law(f"{PD}, the maker's gains", "pd-gravity", {"own_gains": True}) if arm.gains is not None else PAPER_LAWS[0]
    about = "all joints by 0.5 rad in 7 s on an LSPB with 1 s of blend, gravity compensated, friction of the file"
    return Job("lspb", about, move, (pd, Law(INVERSE, "inverse-dynamics")), substeps=2)


def two_points(arm: Arm) -> Job:
    """The KR 30 HA report's cycle: mastering position, point 1, point 2, and back, each leg a quintic of 4 s."""
    if not arm.mastering:
        raise OptionError("task two-points", f"{arm.name} has no mastering position", "an arm whose file gives one")
    home = np.array(arm.mastering)
    way = [home]
    for point in POINTS_MM:
        way.append(_nearest(arm, _pose(point), way[-1]))
    about = f"mastering position, two points of the report, and back; each leg a quintic of {LEG:g} s (assumed)"
    move = point_to_point(arm, np.array([*way, home]), [LEG] * len(way))
    return Job("two-points", about, move, _usual_laws())


def joint_move(arm: Arm) -> Job:
    """Every joint there and back about the middle of its range, for arms that no paper gives a task."""
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    middle, half = (lower + upper) / 2, MIDDLE * (upper - lower) / 2
    about = f"every joint over {MIDDLE:.0%} of its range about the middle and back, quintics of {JOINT_LEG:g} s"
    move = point_to_point(arm, np.array([middle - half, middle + half, middle - half]), [JOINT_LEG, JOINT_LEG])
    return Job("joint-move", about, move, _usual_laws())


def _usual_laws() -> tuple[Law, ...]:
    return (Law(PD, "pd-gravity"), Law(INVERSE, "inverse-dynamics"))


JOBS: dict[str, Callable[[Arm], Job]] = {"ist": ist, "lspb": lspb, "two-points": two_points, "joint-move": joint_move}
OF_ROBOT = {"lwr4plus": "ist", "wam7": "lspb", "kr30ha": "two-points"}
"""Robot -> the task that its paper sets it."""


def job_of(arm: Arm, name: str | None = None) -> Job:
    """A job by name, or the one that the arm's paper sets it, else a joint move.

    Raises
    ------
    UnknownNameError
        No job of that name.
    OptionError, PathLimitError, MissingDataError
        The arm cannot do it.
    """
    chosen = name or OF_ROBOT.get(arm.name, "joint-move")
    if chosen not in JOBS:
        raise UnknownNameError("task", chosen, JOBS)
    return JOBS[chosen](arm)


def _pose(point_mm: tuple[float, ...]) -> Array:
    T = np.eye(4)
    T[:3, 3] = np.array(point_mm) / 1e3
    return T


def _nearest(arm: Arm, T: Array, q: Array) -> Array:
    """The solution nearest to the joints before; raises `OptionError` when there is none."""
    found = inverse_kinematics(arm, T).solutions
    if not found:
        raise OptionError("task two-points", f"{arm.name} does not reach {T[:3, 3].round(3)}", "an arm that does")
    return min((s.q for s in found), key=lambda s: float(np.abs(s - q).max()))
