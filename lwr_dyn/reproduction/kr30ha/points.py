"""The report's points recomputed: its own simplified solution digit by digit, what is right beside it, misses in mm.

The report drives a planar two-link arm (995 and 820 mm) to Point 1, Point 2 and home, after taking the shoulder's
offset off x; the true arm is solved for the flange with A = B = C = 0, as in the report's own program, and from
mastering on with the least axis travel.

The KR 30 HA report's movement on the true arm: mastering, Point 1, Point 2, mastering, two seconds of rest at each.

The program (Appendix B) names four PTP moves with WAIT SEC 2 after each. Axes move together by quintics. Speeds are
not printed; assumed is at most half the rated speed of an axis, which it would reach in half a second or more.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.six_joints.spherical_wrist import require_wrist_arm
from lwr_dyn.kinematics.solution import joint_distance, nearest_solution
from lwr_dyn.kinematics.solution_rows import Solution
from lwr_dyn.krl.robot.kuka_pose import KukaPose, pose_of_matrix, status, turn
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.printed_number import agrees
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.papers import printed_tables
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.trajectory.references.joint_moves import JointReference, point_to_point

POINTS = ("point_1", "point_2", "home")


@dataclass(frozen=True, slots=True)
class PointCell:
    """One printed number and what the report's own formula gives: deg, or the bare D."""

    point: str
    name: str
    printed: str
    value: float
    erratum: str
    """Named where the digits differ; empty where they agree."""

    @property
    def reproduced(self) -> bool:
        """To the printed digits."""
        return agrees(self.printed, self.value)

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        shown = {"point": self.point, "cell": self.name, "printed": self.printed, "value": self.value}
        return shown | {"reproduced": self.reproduced, "erratum": self.erratum or None}


@dataclass(frozen=True, slots=True, eq=False)
class RightPoint:
    """The true arm at a point: the flange there with A = B = C = 0 (home: mastering), lengths [mm]."""

    name: str
    target: KukaPose
    q: Array
    """(6,) A1 to A6 [rad], least travel from the point before."""
    travel_deg: float
    """Sum of |dA_i| from the point before."""
    inside_limits: int
    """How many solutions are inside the limits, and how many there are in all."""
    solutions: int
    wrist_mm: Array
    """Where the wrist centre then stands, (3,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Miss:
    """The paper's angles (Table 5) put into the true arm, wrist straight: its position, and by how much it misses."""

    name: str
    reading: str
    """How theta became A: "A = -theta", or "A = theta" (home stands in KUKA's axes)."""
    q: Array
    wrist_mm: Array
    flange_mm: Array
    wrist_miss_mm: float
    flange_miss_mm: float


@dataclass(frozen=True, slots=True, eq=False)
class PaperPoints:
    """Everything about the three points."""

    cells: tuple[PointCell, ...]
    right: tuple[RightPoint, ...]
    misses: tuple[Miss, ...]

    @property
    def holds(self) -> bool:
        """Every printed digit is reproduced or explained by an erratum."""
        return all(cell.reproduced or cell.erratum for cell in self.cells)


def paper_points() -> PaperPoints:
    """Solve the report's points its way and the right way."""
    tables = printed_tables("kr30ha")
    arm = arm_from_paper(open_paper("kr30ha", "kuka"))
    cells = tuple(cell for name in POINTS for cell in _cells(name, tables))
    return PaperPoints(cells, right_points(arm, tables), point_misses(arm, tables))


def point_misses(arm: Arm, tables: Mapping[str, Any]) -> tuple[Miss, ...]:
    """Table 5's angles put through an arm, point by point."""
    out = []
    for name in POINTS:
        sign, reading = (1.0, "A = theta") if name == "home" else (-1.0, "A = -theta")
        q = np.zeros(6)
        q[:3] = sign * np.radians([float(text) for text in tables["table_5"][name]])
        places = wrist_centre_mm(arm, q), 1e3 * flange_pose(arm.chain, q)[:3, 3]
        distances = (float(np.linalg.norm(place - np.array(tables[name]["xyz"]))) for place in places)
        out.append(Miss(name, reading, q + 0.0, *places, *distances))
    return tuple(out)


def simplified_solution(point: Mapping[str, Any], geometry: Mapping[str, Any]) -> dict[str, float]:
    """The report's formulas for D, theta_1, theta_3, alpha, phi and both theta_2 [deg], at full precision."""
    d1, d2, a2, a3 = (float(geometry[name][0]) for name in ("d1", "d2", "a2", "a3"))
    x, y, z = (float(v) for v in point["xyz"])
    ahead, height = math.hypot(x - d2, y), z - d1
    D = (ahead**2 + height**2 - a2**2 - a3**2) / (2.0 * a2 * a3)
    theta_3 = int(point["elbow"]) * math.acos(D)
    alpha, phi = math.atan2(height, ahead), math.asin(a3 * math.sin(theta_3) / math.hypot(ahead, height))
    angles = {"theta_1": math.atan2(y, x - d2), "theta_3": theta_3, "alpha": alpha, "phi": phi}
    angles |= {"theta_2 (first)": alpha + phi, "theta_2 (second)": alpha - phi}  # printed in this order
    return {"D": D} | {name: math.degrees(angle) for name, angle in angles.items()}


def _cells(name: str, tables: Mapping[str, Any]) -> list[PointCell]:
    point = tables[name]
    values, both = simplified_solution(point, tables["geometry"]), ("theta_2 (first)", "theta_2 (second)")
    chosen = ("theta_1", both[name != "home"], "theta_3")
    rows = [(cell, cell, f"{name}.{cell}[0]", point[cell][0]) for cell in values if cell in point]
    rows += [(cell, cell, f"{name}.theta_2[{k}]", point["theta_2"][k]) for k, cell in enumerate(both)]
    rows += [
        (cell, f"{cell.split(' ')[0]} (Table 5)", f"table_5.{name}[{k}]", tables["table_5"][name][k])
        for k, cell in enumerate(chosen)
    ]
    return [
        PointCell(name, shown, text, values[cell], _erratum(f"results.{at}", text, values[cell]))
        for cell, shown, at, text in rows
    ]


def _erratum(at: str, text: str, value: float) -> str:
    """The erratum that reads a printed cell as what the report's own formula gives; empty where the digits agree."""
    if agrees(text, value):
        return ""
    patches = ((e.id, patch) for e in open_paper("kr30ha", "kuka").errata for patch in e.of_results())
    return next((name for name, patch in patches if patch.at == at and agrees(patch.read, value)), "")


def right_points(arm: Arm, printed: Mapping[str, Any] | None = None) -> tuple[RightPoint, ...]:
    """Mastering -> Point 1 -> Point 2 -> mastering for the flange, each by the least axis travel from where it is."""
    mastering = np.array(arm.mastering)
    q_before, out = mastering, []
    tables = printed_tables("kr30ha") if printed is None else printed
    for name in POINTS:
        if name == "home":
            pose = flange_pose(arm.chain, mastering)
            target = pose_of_matrix(pose)
            result = inverse_kinematics(arm, pose)
            q, travel = mastering, float(np.abs(mastering - q_before).sum())
        else:
            x, y, z = (float(v) for v in tables[name]["xyz"])
            target = KukaPose(x, y, z, 0.0, 0.0, 0.0)
            result = inverse_kinematics(arm, target.matrix())
            best: Solution = nearest_solution(result.solutions, q_before)
            q, travel = best.q, joint_distance(best, q_before)
        stated = replace(target, s=status(arm, q), t=turn(q))
        count = len(result.solutions), len(result.solutions) + len(result.outside)
        out.append(RightPoint(name, stated, q, math.degrees(travel), *count, wrist_centre_mm(arm, q)))
        q_before = q
    return tuple(out)


def wrist_centre_mm(arm: Arm, q: Array) -> Array:
    """The wrist centre in the base at q (6,) [rad], (3,) [mm]; ungated."""
    flange = flange_pose(arm.chain, q)
    return np.asarray(1e3 * (flange[:3, 3] + flange[:3, :3] @ require_wrist_arm(arm).wrist_in_flange))


WAIT = 2.0
"""[s] WAIT SEC 2 of Appendix B."""

ROADS = ("pinocchio", "newton-euler")
"""Both compute the torque at each waypoint."""

SPEED_SHARE = 0.5
"""Assumed: largest axis speed over the rated one."""

RISE = 0.5
"""[s] Assumed: the shortest time in which an axis reaches its rated speed."""

PEAK_SPEED, PEAK_ACCELERATION = 15.0 / 8.0, 10.0 / 3.0**0.5
"""Of a quintic from rest to rest over a way d in a time T: largest speed over d/T, largest acceleration over d/T^2."""


@dataclass(frozen=True, slots=True, eq=False)
class Waypoint:
    """The arm at rest at one of the points: the torque that holds it by either road, and where the run put it."""

    name: str
    holding: dict[str, Array]
    """Engine -> g(q) (6,) [N m]."""
    missed_mm: float
    """Flange of the run less the target, at the end of the wait."""


@dataclass(frozen=True, slots=True, eq=False)
class Cycle:
    """The motion cycle and its simulated result."""

    reference: JointReference
    run: Run
    waypoints: tuple[Waypoint, ...]

    @property
    def peak_torque(self) -> Array:
        """Largest |tau| of every axis over the run, (6,) [N m]."""
        return np.asarray(np.abs(self.run.tau_applied).max(axis=0))

    @property
    def peak_speed(self) -> Array:
        """Largest |dq| of every axis over the run, (6,) [rad/s]."""
        return np.asarray(np.abs(self.run.dq).max(axis=0))


def cycle_reference(arm: Arm, points: Sequence[RightPoint]) -> tuple[JointReference, Array]:
    """The movement, and the times (one per point) [s] at which its wait is over."""
    rows, durations = [np.array(arm.mastering)], []
    for point in points:
        way = np.abs(point.q - rows[-1])
        longest = float((way / arm.velocity).max())
        durations += [max(PEAK_SPEED * longest / SPEED_SHARE, (PEAK_ACCELERATION * longest * RISE) ** 0.5), WAIT]
        rows += [point.q, point.q]
    return point_to_point(arm, np.array(rows), durations), np.cumsum(durations)[1::2]


def cycle(arm: Arm, points: Sequence[RightPoint]) -> Cycle:
    """The movement under inverse dynamics; torque limits are not known, so none are kept."""
    reference, ends = cycle_reference(arm, points)
    controller = make_controller("inverse-dynamics", arm)
    assumed = {name: {"value": x, "kind": "assumed"} for name, x in (("speed_share", SPEED_SHARE), ("rise", RISE))}
    about = {"task": "mastering, Point 1, Point 2, mastering", **assumed}
    run = simulate(arm, controller, reference, meta=about)
    roads = {engine: dynamics_of(arm, engine) for engine in ROADS}
    waypoints = []
    for point, end in zip(points, ends, strict=True):
        flange = flange_pose(arm.chain, run.q[int(np.searchsorted(run.t, end - 1e-9))])
        missed = float(1e3 * np.linalg.norm(flange[:3, 3] - point.target.matrix()[:3, 3]))
        holding = {name: road.gravity_vector(point.q) for name, road in roads.items()}
        waypoints.append(Waypoint(point.name, holding, missed))
    return Cycle(reference, run, tuple(waypoints))
