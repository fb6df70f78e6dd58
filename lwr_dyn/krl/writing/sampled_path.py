"""A path that an arm has taken or shall take, as samples: from a run, a motion, or a table of poses or axes.

A path of poses is followed on one branch of the inverse kinematics all along, inside the limits.
"""

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.foundation.files import ends_in, read_text
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.kinematics.six_joints.spherical_wrist import all_branches
from lwr_dyn.krl.motion.pose_paths import NEAR
from lwr_dyn.krl.robot.kuka_pose import rotation_of_abc, status, turn
from lwr_dyn.krl.running.controller import HOME_DEG
from lwr_dyn.krl.running.values import AXIS_NAMES, POSE_NAMES
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion, Run
from lwr_dyn.trajectory.pose_path import slerp

WHOLE = 2.0 * np.pi
NEAR_ZERO = np.radians(0.01)
"""[rad] The sign of an axis this near to zero, which Turn holds, may be lost where a pose is rounded."""
TAUGHT = 1e-4
"""[rad] A solution this near to the axes is theirs."""
TOUCH = 1e-9
"""[rad] Rounding allowed at a limit."""


def followed(arm: Arm, T: Array, s: int | None, t: int | None, source: str) -> Array:
    """The axes (k, n) [rad] of flange poses T (k, 4, 4) [m] on the branch that begins nearest to mastering.

    With Status `s` and Turn `t` where they are given. Raises `OptionError` with what stops the best branch.
    """
    branches = all_branches(arm, T)
    home = np.array(arm.mastering) if arm.mastering else np.radians(HOME_DEG)
    found: list[tuple[bool, float, int, Array]] = []
    faults: list[tuple[float, str]] = []
    for b in range(branches.q.shape[1]):
        q, fault = _along(arm, branches.q[:, b], float(branches.reach_excess[:, b].max()), home)
        if q is not None:
            S, here = status(arm, q[0]), turn(q[0])
            if (S if s is None else s & 7) != S or here != (here if t is None else t & 63):
                q, fault = None, (1.0, f"it begins with S {S} T {here}")
        if q is None:
            faults.append(fault)
        else:
            least = float(branches.clearance[:, b, 2].min())
            found.append((least < NEAR, float(np.abs(q[0] - home).max()), b, q))
    if not found:
        raise OptionError(source, f"no branch follows it: {max(faults)[1]}", "a path inside reach and limits")
    return min(found, key=lambda x: x[:3])[3]


def _along(arm: Arm, q: Array, excess: float, home: Array) -> tuple[Array | None, tuple[float, str]]:
    """One branch without jumps, each axis in its range; or None, how far it came (0 to 1), and why it ends."""
    if excess > 0.0:
        return None, (0.0, f"out of reach by {1e3 * excess:.4g} mm")
    q = np.unwrap(q, axis=0)
    step = np.abs(np.diff(q, axis=0)).max(axis=1)
    jump = int(np.argmax(step > 0.5 * np.pi))
    if step[jump] > 0.5 * np.pi:
        return None, (jump / len(q), f"an axis turns by {np.degrees(step[jump]):.4g} deg at sample {jump + 2}")
    q = q + WHOLE * np.round((home - q[0]) / WHOLE)
    for i in range(arm.n):
        over = np.maximum(q[:, i] - arm.upper[i], arm.lower[i] - q[:, i])
        low, up = arm.lower[i] - TOUCH, arm.upper[i] + TOUCH
        turns = [k for k in (0, -1, 1) if ((turned := q[:, i] + WHOLE * k) <= up).all() and (turned >= low).all()]
        if not turns:
            return None, (0.5, f"{arm.joint_names[i]} leaves its range by {np.degrees(over.max()):.4g} deg")
        q[:, i] += WHOLE * turns[0]
    return q, (1.0, "")


def taught_axes(arm: Arm, flange: Array, q: Array, clear: float) -> Array | None:
    """The solution (n,) [rad] of a rounded pose (4, 4) [m] that is nearest to q (n,).

    None where Status and Turn would not select it for sure: nearer than `clear` [rad] to the wrist singularity, or an
    axis at zero.
    """
    branches = all_branches(arm, flange[None])
    solutions = branches.q[0] + WHOLE * np.round((q - branches.q[0]) / WHOLE)
    away = np.nan_to_num(np.abs(solutions - q).max(axis=-1), nan=np.inf)
    best = int(np.argmin(away))
    if away[best] > TAUGHT or branches.clearance[0, best, 2] < clear or np.abs(q).min() < NEAR_ZERO:
        return None
    return np.asarray(solutions[best])


SAME = 1e-9
"""[rad] Samples nearer than this in all axes are one."""
BETWEEN_M, BETWEEN_RAD = 0.002, np.radians(0.5)
"""[m], [rad] Between two rows of poses the path is straight; it is sampled at most this far apart."""
SAGITTA_M, SAGITTA_RAD = 5e-6, 1e-4
"""[m], [rad] Between two samples of a motion its path bends so much at most, if `MOST_BETWEEN` samples more do."""
MOST_BETWEEN = 32
PAUSE = 0.05
"""[s] An arm that stands so long waits."""
MOST = 200_000
"""Most samples of a path."""
NEEDED = "a .csv with X, Y, Z, A, B, C [mm, deg], A1 to A6 [deg] or q1 to q6 [rad], or a run, .npz"
_JOINTS = tuple(f"q{i}" for i in range(1, 7))
_TIME = ("t", "time")


@dataclass(frozen=True, slots=True, eq=False)
class SampledPath:
    """k samples of a path: axes q (k, n) [rad], poses T (k, 4, 4) [m] of the tool in the world."""

    arm: Arm
    q: Array
    T: Array
    tool: Array
    """(4, 4) [m] The tool in the flange."""
    t: Array | None
    """(k,) [s] The times; None where there are none."""
    source: str
    pauses: Mapping[int, float] = field(default_factory=dict)
    """Sample -> how long the arm stands there [s]."""

    def __post_init__(self) -> None:
        freeze_arrays(self, "q", "T", "tool")

    @property
    def duration(self) -> float | None:
        """[s] With the pause at the end."""
        return None if self.t is None else float(self.t[-1] - self.t[0]) + self.pauses.get(len(self.q) - 1, 0.0)


def path_of_motion(motion: Run | Motion, arm: Arm, tool: Array | None = None, source: str = "motion") -> SampledPath:
    """The path of a `Run` or `Motion`; samples at rest count once.

    Raises `OptionError` where the motion is another arm's, or nothing moves.
    """
    if isinstance(motion, Run):
        _refuse_other_arm(motion, arm, source)
    _refuse_joints(motion.q.shape[1], arm, source)
    flange = np.eye(4) if tool is None else tool
    t, q = _refined(arm, motion, flange)
    return _of_axes(arm, q, t, flange, source)


def _refuse_joints(count: int, arm: Arm, source: str) -> None:
    if count != arm.n:
        raise OptionError(source, f"{count} joints", f"the {arm.n} of {arm.name}")


def _refuse_other_arm(run: Run, arm: Arm, source: str) -> None:
    """Raises `OptionError` where the run names another robot, or another file of the same name."""
    name, file, digest = (run.meta.get(key) for key in ("robot", "file", "digest"))
    if name not in (None, arm.name):
        raise OptionError(source, f"a run of {name}", f"a run of {arm.name}, or --robot {file or name}")
    if file and digest and digest != arm.digest:
        raise OptionError(source, f"a run of another {name}: {file}", "the robot's file as it was in the run")


def _refined(arm: Arm, motion: Run | Motion, tool: Array) -> tuple[Array, Array]:
    """Times and axes with samples between those of the motion, by its speeds, where its path is curved."""
    t, q = motion.t, motion.q
    if len(t) < 3:
        return t, q
    T = flange_pose(arm.chain, q) @ tool
    bend = np.linalg.norm(np.diff(T[:, :3, 3], 2, axis=0), axis=1) / (8.0 * SAGITTA_M)
    turn = np.linalg.norm(np.diff(T[:, :3, :3], 2, axis=0), axis=(1, 2)) / (8.0 * SAGITTA_RAD)
    each = np.sqrt(np.maximum(bend, turn))
    counts = np.ceil(np.maximum(np.append(each, each[-1]), np.append(each[0], each))).astype(int)
    counts = np.clip(counts, 1, MOST_BETWEEN)
    if counts.sum() > MOST:
        return t, q
    parts = [np.linspace(t[k], t[k + 1], n, endpoint=False) for k, n in enumerate(counts)]
    times = np.append(np.concatenate(parts), t[-1])
    return times, np.asarray(CubicHermiteSpline(t, q, motion.dq)(times))


def read_sampled_path(path: str | Path, arm: Arm, tool: Array | None = None, base: Array | None = None) -> SampledPath:
    """The path of a run file (.npz), or of a table (.csv) of poses of the tool in the base, or of axes.

    Raises `FileAccessError`, or `OptionError` for poses that no branch of the arm follows.
    """
    flange, world = np.eye(4) if tool is None else tool, np.eye(4) if base is None else base
    if ends_in(path, ".npz"):
        return path_of_motion(Run.load(path), arm, flange, Path(path).name)
    if ends_in(path, ".src") or ends_in(path, ".dat"):
        raise FileAccessError(str(path), "a program, no path", NEEDED)
    columns = _columns(path)
    t = next((columns[name] for name in _TIME if name in columns), None)
    if t is not None and (np.diff(t) <= 0.0).any():
        raise FileAccessError(str(path), "times that do not grow", "a time later than the row before in each row")
    for names, factor in ((AXIS_NAMES, np.pi / 180.0), (_JOINTS, 1.0)):
        if all(name in columns for name in names):
            _refuse_joints(len(names), arm, Path(path).name)
            q = np.stack([columns[name] for name in names], axis=1) * factor
            return _of_axes(arm, *_axes_between(q, t, str(path)), flange, Path(path).name)
    missing = [name for name in POSE_NAMES if name not in columns]
    if missing:
        raise FileAccessError(str(path), f"no column {', '.join(missing)}", NEEDED)
    poses, times = _between(_poses(columns, world), t, str(path))
    wanted = [None if name not in columns else int(columns[name][0]) for name in ("S", "T")]
    q = followed(arm, poses @ np.linalg.inv(flange), wanted[0], wanted[1], Path(path).name)
    return SampledPath(arm, q, poses, flange, times, Path(path).name)


def _of_axes(arm: Arm, q: Array, t: Array | None, tool: Array, source: str) -> SampledPath:
    outside = np.maximum(q - arm.upper, arm.lower - q)
    k, i = np.unravel_index(int(np.argmax(outside)), outside.shape)
    if outside[k, i] > SAME:
        place = f"{arm.joint_names[int(i)]} outside its range by {np.degrees(outside[k, i]):.4g} deg in sample {k + 1}"
        raise OptionError(source, place, "axes inside their limits")
    moved = np.concatenate([[True], np.abs(np.diff(q, axis=0)).max(axis=1) > SAME])
    if moved.sum() < 2:
        raise OptionError(source, "nothing moves", "a motion")
    if moved.sum() > MOST:
        raise OptionError(source, f"{int(moved.sum())} samples", f"at most {MOST}")
    kept = np.array(q[moved])
    T = flange_pose(arm.chain, kept) @ tool
    if t is None:
        return SampledPath(arm, kept, T, tool, None, source)
    last = np.append(np.flatnonzero(moved)[1:], len(q)) - 1
    stood = t[last] - t[moved]
    pauses = {int(k): float(stood[k]) for k in np.flatnonzero(stood >= PAUSE)}
    return SampledPath(arm, kept, T, tool, np.array(t[moved]), source, pauses)


def _axes_between(q: Array, t: Array | None, path: str) -> tuple[Array, Array | None]:
    """The rows of axes with samples between them: from row to row the axes move in proportion."""
    steps = np.maximum(np.ceil(np.abs(np.diff(q, axis=0)).max(axis=1) / BETWEEN_RAD), 1.0)
    if steps.sum() > MOST:
        raise FileAccessError(path, "a path that is too long", f"at most {MOST} samples, 0.5 deg apart")
    at = np.append(np.concatenate([k + np.arange(n) / n for k, n in enumerate(steps)]), len(q) - 1.0)
    rows = np.arange(len(q))
    between = np.stack([np.interp(at, rows, axis) for axis in q.T], axis=1)
    return between, None if t is None else np.interp(at, rows, t)


def _columns(path: str | Path) -> Mapping[str, Array]:
    """The columns by name without their unit in brackets; raises `FileAccessError`."""
    rows = [row for row in csv.reader(io.StringIO(read_text(path, NEEDED, "utf-8-sig"))) if any(map(str.strip, row))]
    if len(rows) < 3:
        raise FileAccessError(str(path), f"{max(len(rows) - 1, 0)} rows of numbers", "a line of names and two rows")
    names = [re.sub(r"\s*[\[(].*", "", name.strip()) for name in rows[0]]
    if len(set(names)) < len(names):
        raise FileAccessError(str(path), "a column that is there twice", NEEDED)
    return dict(zip(names, np.array(_numbers(path, rows[1:], len(names))).T, strict=True))


def _numbers(path: str | Path, rows: Sequence[Sequence[str]], count: int) -> list[list[float]]:
    out = []
    for i, row in enumerate(rows, 2):
        try:
            values = [float(x) for x in row]
        except ValueError:
            values = []
        if len(values) != count or not np.isfinite(values).all():
            raise FileAccessError(str(path), f"row {i} is {','.join(row)[:60]!r}", f"{count} finite numbers")
        out.append(values)
    return out


def _poses(columns: Mapping[str, Array], base: Array) -> Array:
    rows = np.stack([columns[name] for name in POSE_NAMES], axis=1)
    T = np.zeros((len(rows), 4, 4))
    T[:, 3, 3], T[:, :3, 3] = 1.0, rows[:, :3] / 1e3
    T[:, :3, :3] = [rotation_of_abc(tuple(abc)) for abc in rows[:, 3:]]
    return np.asarray(base @ T)


def _between(T: Array, t: Array | None, path: str) -> tuple[Array, Array | None]:
    """The poses with samples between them, along lines and shortest turns; rows that repeat count once."""
    poses, times = [T[:1]], [np.zeros(0) if t is None else t[:1]]
    for k in range(1, len(T)):
        try:
            turn = slerp(T[k - 1, :3, :3], T[k, :3, :3], 1.0)
        except OptionError:
            allowed = "less than 180 deg between two rows"
            raise FileAccessError(path, f"half a turn between rows {k + 1} and {k + 2}", allowed) from None
        way = T[k, :3, 3] - T[k - 1, :3, 3]
        if np.linalg.norm(way) < SAME and turn.rate < SAME:
            continue
        steps = int(np.ceil(max(np.linalg.norm(way) / BETWEEN_M, turn.rate / BETWEEN_RAD, 1.0)))
        if steps > MOST or sum(map(len, poses)) > MOST:
            raise FileAccessError(
                path, "a path that is too long", f"at most {MOST} samples, {1e3 * BETWEEN_M:g} mm apart"
            )
        u = np.arange(1, steps + 1) / steps
        part = np.tile(np.eye(4), (steps, 1, 1))
        part[:, :3, :3], part[:, :3, 3] = turn.at(u).R, T[k - 1, :3, 3] + u[:, None] * way
        poses.append(part)
        if t is not None:
            times.append(t[k - 1] + u * (t[k] - t[k - 1]))
    if len(poses) == 1:
        raise FileAccessError(path, "nothing moves", "two rows that differ")
    return np.concatenate(poses), None if t is None else np.concatenate(times)
