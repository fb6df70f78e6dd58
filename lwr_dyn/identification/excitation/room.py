"""Whether an arm has room for a motion at all: what no pose meets is said before a search begins.

A motion is a row of poses, so a limit that no pose meets is met by no motion. Poses are drawn inside the position
limits; where none of them meets all, the best of them are moved by a small search of their own. What is asked of a
pose: its distances, less what is kept, and the torques that hold it at rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FaultError, OptionError
from lwr_dyn.identification.excitation.motion_limits import Clearance, MotionLimits, TorqueUse
from lwr_dyn.kinematics.forward import joint_axes

POSES, MOVED = 2000, 3
"""Drawn poses, and how many of the best are moved further where none of them meets all."""
PER_SHARE = 0.1
"""[m] As which a share of a torque limit counts beside distances."""
ENOUGH = 1e-9
"""[m] By which a pose may miss what is asked: rounding."""


class ExcitationError(FaultError, ValueError):
    """No motion is inside the limits and clear, or none was found."""


@dataclass(frozen=True, slots=True, eq=False)
class Demands:
    """What is asked of a pose: room (k, m) at q (k, n), below 0 where it is not met, and the name of each column."""

    clearance: Clearance
    torques: TorqueUse

    @property
    def names(self) -> tuple[str, ...]:
        """Pairs that keep a distance, then joints with a torque limit."""
        joints = zip(self.clearance.arm.joint_names, self._known, strict=True)
        return (*self.clearance.names, *(name for name, known in joints if known))

    @property
    def _known(self) -> Array:
        return np.isfinite(self.torques.limit)

    def of(self, q: Array) -> Array:
        """Distances less what is kept [m], then 1 - |g| / limit times `PER_SHARE`."""
        zero = np.zeros_like(q)
        share = np.abs(self.torques.dynamics.inverse_dynamics(q, zero, zero) / self.torques.limit)[:, self._known]
        return np.hstack([self.clearance.of(q), PER_SHARE * (1.0 - share)])

    def gradient(self, q: Array) -> Array:
        """Its derivative by q, (k, m, n)."""
        zero, known = np.zeros_like(q), self._known
        tau = np.asarray(self.torques.dynamics.inverse_dynamics(q, zero, zero))
        by_q = np.asarray(self.torques.dynamics.inverse_dynamics_derivatives(q, zero, zero).by_q)
        slope = -PER_SHARE * (np.sign(tau) / self.torques.limit)[:, known, None] * by_q[:, known]
        return np.concatenate([self.clearance.with_gradient(q)[1], slope], axis=1)

    def shortfall(self, column: int, room: float, when: str) -> str:
        """What a column lacks `when`, in words, with the names of both that are too near."""
        name = self.names[column]
        if column < len(self.clearance.names):
            kept = float(self.clearance.keeps[column])
            apart = room + kept
            are = f"are {when} {apart:.3g} m apart" if apart >= 0.0 else f"overlap {when} by {-apart:.3g} m"
            return f"{name} {are}; {kept:.3g} m is to be kept"
        return f"{name} needs {when} {1.0 - room / PER_SHARE:.3g} times the torque that it may use, at rest"


def drawn_poses(limits: MotionLimits, count: int = POSES) -> Array:
    """(count, n) poses inside the position limits, always the same ones."""
    return np.random.default_rng(0).uniform(limits.lower, limits.upper, (count, len(limits.lower)))


def widest_distances(clearance: Clearance, limits: MotionLimits) -> Array:
    """(m,) The largest distance of each pair in the drawn poses, less what is kept [m]."""
    return np.asarray(clearance.of(drawn_poses(limits)).max(axis=0, initial=-np.inf))


def check_room(clearance: Clearance, limits: MotionLimits, torques: TorqueUse) -> None:
    """Raise where no pose meets what is asked.

    Raises
    ------
    ExcitationError
        A pair that is too near in all poses, or a joint that cannot hold the arm in any; then, what the pose that
        comes nearest to meeting all lacks.
    """
    asked = Demands(clearance, torques)
    q = drawn_poses(limits)
    room = asked.of(q)
    if not room.size or room.min(axis=1).max() >= 0.0:
        return
    where = f"excitation of {clearance.arm.name}"
    for column in (k for k in np.argsort(room.max(axis=0)).tolist() if room[:, k].max() < 0.0):
        best = moved_pose(asked, q[[int(np.argmax(room[:, column]))]], limits, [column])
        value = float(asked.of(best)[0, column])
        if value < -ENOUGH:
            words = asked.shortfall(column, value, "at best")
            raise ExcitationError(where, words, _cure(asked, column))
    order = np.argsort(room.min(axis=1))[::-1][:MOVED]
    ends = np.concatenate([moved_pose(asked, q[[k]], limits, [*range(room.shape[1])]) for k in order])
    lacks = asked.of(ends)
    best_end = lacks[int(np.argmax(lacks.min(axis=1)))]
    if best_end.min() < -ENOUGH:
        column = int(np.argmin(best_end))
        words = asked.shortfall(column, float(best_end[column]), "in the best pose for all at once")
        raise ExcitationError(where, words, _cure(asked, column))


def moved_pose(asked: Demands, q: Array, limits: MotionLimits, columns: Sequence[int]) -> Array:
    """The pose (1, n) to which q (1, n) is moved so that the least room in some `columns` is largest."""

    def room(x: Array) -> Array:
        return np.asarray(asked.of(x[None, :-1])[0, columns] - x[-1])

    def slope(x: Array) -> Array:
        out = asked.gradient(x[None, :-1])[0, columns]
        return np.hstack([out, np.full((len(out), 1), -1.0)])

    solve: Any = minimize  # its stubs know no value with its gradient
    start = np.append(q[0], asked.of(q)[0, columns].min())
    falling = np.append(np.zeros(q.shape[1]), -1.0)
    end = solve(
        lambda x: (-x[-1], falling), start, method="SLSQP", jac=True, options={"maxiter": 100, "ftol": 1e-10},
        bounds=[*zip(limits.lower, limits.upper, strict=True), (None, None)],
        constraints={"type": "ineq", "fun": room, "jac": slope},
    )  # fmt: skip
    found: Array = np.clip(end.x[:-1], limits.lower, limits.upper)[None]
    return found if asked.of(found)[0, columns].min() > start[-1] else q


def _cure(asked: Demands, column: int) -> str:
    if column >= len(asked.clearance.names):
        return "a larger share of the torque limits (--torque-share), a smaller payload"
    low = column < len(asked.clearance.low)
    return "less to keep (--keep)" + (", a lower floor (--floor)" if low else ", a thinner column (--column)")


def check_column(clearance: Clearance, column: float | None) -> None:
    """Raise `OptionError` where a `column` [m] that was asked for holds the whole arm inside in most poses."""
    if column and len(links_inside(clearance)) == len(clearance.capsules) - 1:
        raise OptionError("column", column, "a radius in m that does not hold the whole arm inside")


def links_inside(clearance: Clearance) -> tuple[str, ...]:
    """Links that are not held against the column: those beside it, and those inside it in most poses."""
    if not _has_column(clearance):
        return ()
    held = {b for a, b in clearance.pairs if a == 0}
    return tuple(
        clearance.arm.chain.links[start].link for b, (start, _) in enumerate(clearance.capsules) if b and b not in held
    )


def column_words(clearance: Clearance) -> str:
    """How thick the column is, to which height it reaches, and what is not held against it; empty without one."""
    if not _has_column(clearance):
        return ""
    arm, radius = clearance.arm, clearance.radii[0]
    top = float(joint_axes(arm.chain, np.zeros((1, arm.n))).p[0, 0, 2])
    inside = links_inside(clearance)
    but = f"; its distance to {', '.join(inside)} is not checked (beside it, or inside in most poses)" if inside else ""
    return f"column of radius {radius:.3g} m up to {arm.joint_names[0]} at {top:.3g} m, its top round{but}"


def near_words(clearance: Clearance) -> str:
    """Pairs that keep less than is asked, as they are never far apart; empty where none does.

    >>> import lwr_dyn
    >>> from lwr_dyn.identification.excitation.motion_limits import clearance_of
    >>> near_words(clearance_of(lwr_dyn.load("lwr4plus")))
    ''
    """
    names = dict(zip(clearance.pairs, clearance.names[len(clearance.low) :], strict=True))
    return "; ".join(
        f"{names[pair]} are never far apart: they keep {keep:.2g} m, not {clearance.kept:g} m"
        for pair, keep in clearance.near.items()
    )


def _has_column(clearance: Clearance) -> bool:
    return bool(clearance.capsules) and clearance.capsules[0] == (0, clearance.arm.n + 1)
