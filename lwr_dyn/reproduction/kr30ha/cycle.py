"""The KR 30 HA report's movement on the true arm: mastering, Point 1, Point 2, mastering, two seconds of rest at each.

The program (Appendix B) names four PTP moves with WAIT SEC 2 after each. Axes move together by quintics. Speeds are
not printed; assumed is at most half the rated speed of an axis, which it would reach in half a second or more.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.control.controllers import make_controller
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.kr30ha.points import RightPoint
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.trajectory.references.joint_moves import JointReference, point_to_point

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
