"""Emitted inverse kinematics in C against Python: many poses, singular ones among them."""

from __future__ import annotations

import ctypes
import tempfile
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.foundation.tables import aligned
from lwr_dyn.model.arm import Arm

POSES, INTERVALS = 20_000, 500
ARMS = ("lwr4plus", "wam7", "kr30ha")
CLOSE, SAME, TOUCH = 1e-12, 1e-9, 1e-6
"""Poses of the branches [m and dimensionless]; angles beside Python's [rad], more where singular; intervals [rad] where
a joint touches its limit: as the root of rounding."""


def emitted_closed_form() -> tuple[str, bool, str]:
    """Emitted closed-form IK of 3 arms in C: poses of all branches, arm angles, intervals, beside Python's."""
    rows, good = [], True
    for name in ARMS:
        arm = lwr_dyn.load(name)
        for kind, q in (("random", _random(arm)), ("multiples of 45 deg", _singular(arm))):
            with tempfile.TemporaryDirectory() as folder:
                row, holds = _compared(arm, q, Path(folder), kind == "random")
            rows.append((name, kind, *row))
            good = good and holds
    head = ("arm", "positions", "branches", "FK - T", "beside Python [rad]", "intervals", "of another length")
    return f"{len(rows)} sets of {POSES} poses", good, aligned(rows, head)


def _random(arm: Arm) -> np.ndarray:
    rng = np.random.default_rng(1)
    return rng.uniform(np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi), (POSES, arm.n))


def _singular(arm: Arm) -> np.ndarray:
    step = np.pi / 4.0
    return np.clip(np.round(_random(arm) / step) * step, arm.lower, arm.upper)


def _compared(arm: Arm, q: np.ndarray, folder: Path, is_random: bool) -> tuple[tuple[str, ...], bool]:
    from lwr_dyn.codegen.emit.closed_form import NAME
    from lwr_dyn.codegen.emit.emission import emitted_arm
    from lwr_dyn.kinematics.solution import wrap
    from tests.codegen.emit.shared_library import SharedLibrary
    from tests.codegen.emit.test_closed_form import expected_branches

    library = SharedLibrary(emitted_arm(arm, [NAME]), folder)
    T = np.ascontiguousarray(lwr_dyn.forward_kinematics(arm, q))
    psi = np.random.default_rng(2).uniform(-np.pi, np.pi, len(T))
    out = np.zeros((len(T), 8, arm.n))
    for k in range(len(T)):
        library.call(NAME, T[k], *([float(psi[k])] if arm.n == 7 else []), out[k])
    expected, _ = expected_branches(arm, T, psi)
    there = ~np.isnan(out[..., 0])
    same = bool((there == ~np.isnan(expected[..., 0])).all())
    poses = lwr_dyn.forward_kinematics(arm, out[there])
    error = float(np.abs(poses - np.broadcast_to(T[:, None], (*there.shape, 4, 4))[there]).max())
    apart = float(np.abs(wrap(out - expected))[there].max())
    count, other = _intervals(library, T[:INTERVALS]) if arm.n == 7 else (0, 0)
    row = (str(int(there.sum())), f"{error:.1e}", f"{apart:.1e}", str(count), str(other))
    return row, same and error < CLOSE and other == 0 and (apart < SAME or not is_random)


def _intervals(library: object, T: np.ndarray) -> tuple[int, int]:
    """How many intervals, and on how many branches their length is not that of Python's.

    At singular poses an interval of one point, where a joint touches its limit, may be found by one of both alone.
    """
    from lwr_dyn.codegen.emit.closed_form import NAME
    from lwr_dyn.kinematics.arm_geometry import srs_geometry
    from lwr_dyn.kinematics.solution import BRANCHES, joint_ranges
    from lwr_dyn.kinematics.srs_margins import intervals_at_level, margin_problem

    arm, count, other = library.arm, 0, 0  # type: ignore[attr-defined]
    geometry, ranges = srs_geometry(arm.chain), joint_ranges(arm)
    assert geometry is not None
    for pose in T:
        pairs, counts = np.zeros((8, 16, 2)), np.zeros(8, dtype=np.intc)
        library.call(f"{NAME}_intervals", pose, 0.0, pairs, counts, kind=ctypes.c_double)  # type: ignore[attr-defined]
        wanted = intervals_at_level(margin_problem(geometry, ranges, np.broadcast_to(pose, (8, 4, 4)), BRANCHES), 0.0)
        for b in range(8):
            these = np.array(wanted.of(b)).reshape(-1, 2)
            count += len(these)
            other += abs(_length(these) - _length(pairs[b, : counts[b]])) > TOUCH
    return count, other


def _length(intervals: np.ndarray) -> float:
    return float((intervals[:, 1] - intervals[:, 0]).sum())
