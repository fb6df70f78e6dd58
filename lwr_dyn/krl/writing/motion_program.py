"""A sampled path -> a program of PTP, LIN and CIRC that follows it within a tolerance, with its `.dat`.

A point between two motions is passed by the largest approximation that cuts the corner little enough. Between two paths
in space ($APO.CDIS = d) the corner is cut by a parabola, at most d sin(turn / 2) / 2 from it, and the orientation is at
most a quarter of what both turn within d away; between two PTP ($APO.CPTP) a quarter of what both still go is missed.
Passing between the two kinds, and to or from a block, is left out: they stop there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.motion.motion_segments import tool_pose
from lwr_dyn.krl.motion.pose_paths import PosePath
from lwr_dyn.krl.project.program import Program, program_of
from lwr_dyn.krl.robot.kuka_pose import frame_matrix, pose_of_matrix, rotation_angle, status, turn
from lwr_dyn.krl.writing import point_program
from lwr_dyn.krl.writing.path_fit import BLOCKS, CLEAR, FittedMotion
from lwr_dyn.krl.writing.sampled_path import SampledPath, taught_axes

SMALLEST = 1e-5
"""[m] A smaller $APO.CDIS is none."""
USED = 0.9
"""Share of an axis' rated speed that a path in space uses at most."""


@dataclass(frozen=True, slots=True)
class Approximation:
    """C_DIS with $APO.CDIS [mm], or C_PTP with $APO.CPTP [%]."""

    keyword: str
    value: float


def approximations(
    samples: SampledPath, motions: Sequence[FittedMotion], tolerance: tuple[float, float], share: float = 1.0
) -> tuple[Approximation | None, ...]:
    """At the end of each motion, for corners cut by `tolerance` [m, rad] at most; `share` of each; none at the end."""
    found = [_at_corner(samples, a, b, tolerance, share) for a, b in pairwise(motions)]
    return (*found, None)


def _at_corner(
    samples: SampledPath, a: FittedMotion, b: FittedMotion, tolerance: tuple[float, float], share: float
) -> Approximation | None:
    if a.knots or b.knots or a.last in samples.pauses or (a.kind == "PTP") != (b.kind == "PTP"):
        return None
    if a.kind == "PTP":
        percent = np.floor(200.0 * share * _ptp_share(samples, a, b, tolerance))
        return Approximation("C_PTP", float(percent)) if percent >= 1.0 else None
    distance = share * _distance(a.path(samples), b.path(samples), tolerance)
    return Approximation("C_DIS", _rounded_down(1e3 * distance, 2)) if distance >= SMALLEST else None


def _distance(a: PosePath, b: PosePath, tolerance: tuple[float, float]) -> float:
    """The largest $APO.CDIS [m] for which both position and orientation stay near the corner."""
    if min(a.length, b.length) < 2.0 * SMALLEST:
        return 0.0
    before, after = (a.segment.at(np.array([a.segment.length])), b.segment.at(np.array([0.0])))
    cut = float(np.linalg.norm(after.dp[0] - before.dp[0])) / 4.0
    ends = (a.orientation.at(np.array([a.segment.length])), b.orientation.at(np.array([0.0])))
    turn = float(np.linalg.norm(ends[1].rate[0] - ends[0].rate[0])) / 4.0
    # on arcs the chord of d leaves the path too: d^2 / (8 r)
    bend = float(np.linalg.norm(before.ddp[0]) + np.linalg.norm(after.ddp[0])) / 8.0
    d = 0.5 * min(a.length, b.length)
    d = min(d, tolerance[1] / turn) if turn > 0.0 else d
    return float(min(d, _root(bend, cut, tolerance[0])))


def _root(square: float, linear: float, most: float) -> float:
    """The d at which square d^2 + linear d = most; infinite without both."""
    if square == linear == 0.0:
        return np.inf
    return 2.0 * most / (linear + float(np.sqrt(linear**2 + 4.0 * square * most)))


def _ptp_share(samples: SampledPath, a: FittedMotion, b: FittedMotion, tolerance: tuple[float, float]) -> float:
    """The share of both motions, at most half, that may be blended."""
    q = samples.q
    miss = (q[b.last] - 2.0 * q[b.first] + q[a.first]) / 4.0
    T = tool_pose(samples.arm, np.stack([q[b.first], q[b.first] + 1e-3 * miss]), samples.tool)
    position = float(np.linalg.norm(T[1, :3, 3] - T[0, :3, 3])) / 1e-3
    orientation = float(rotation_angle(T[1, :3, :3], T[0, :3, :3])) / 1e-3
    bounds = [most / found for most, found in zip(tolerance, (position, orientation), strict=True) if found > 0.0]
    return min([0.5, *bounds])


def _rounded_down(x: float, digits: int = 3) -> float:
    unit = 10.0 ** (np.floor(np.log10(x)) + 1 - digits)
    return float(np.round(np.floor(x / unit + 1e-9) * unit, 9))


DECIMALS_MM, DECIMALS_DEG = 4, 5
"""Of written points: a REAL of the controller has seven digits."""
START = "XSTART"


@dataclass(frozen=True, slots=True, eq=False)
class ProgramSpeeds:
    """$VEL_AXIS [%], and of each motion $VEL.CP [m/s] (0 for a PTP); $VEL.ORI1 [deg/s] where a turn needs less."""

    percent: int
    cp: tuple[float, ...]
    orientation: float | None = None

    def slower(self, factor: float) -> ProgramSpeeds:
        """All of them by a factor."""
        orientation = None if self.orientation is None else self.orientation * factor
        return ProgramSpeeds(max(int(self.percent * factor), 1), tuple(v * factor for v in self.cp), orientation)


@dataclass(frozen=True, slots=True, eq=False)
class PathProgram:
    """What is written: the motions with their speeds and approximations, tool and base as X, Y, Z, A, B, C."""

    name: str
    samples: SampledPath
    motions: tuple[FittedMotion, ...]
    speeds: ProgramSpeeds
    approximations: tuple[Approximation | None, ...]
    base: Array = field(default_factory=lambda: np.eye(4))
    """(4, 4) [m]"""

    def counts(self) -> dict[str, int]:
        """Motions of each kind that occurs; of SPL and SPTP those in all blocks."""
        kinds = [motion.kind for motion in self.motions for _ in motion.knots or (motion.last,)]
        return {kind: kinds.count(kind) for kind in dict.fromkeys(kinds)}

    @property
    def passed(self) -> int:
        """Points that are passed without a stop."""
        inside = sum(len(motion.knots) - 1 for motion in self.motions if motion.knots)
        return inside + sum(approximation is not None for approximation in self.approximations)

    def program(self, tool: int | None = None, base: int | None = None) -> Program:
        """As files; tool and base by their numbers in `$config.dat` where these are given."""
        moves, points = self._moves()
        of = (("TOOL", self.samples.tool, tool), ("BASE", self.base, base))
        at, world = (point_program.frame_set(name, rounded(T), number) for name, T, number in of)
        source = point_program.program_file(self.name, at, world, self.speeds.percent, self._first_speed, moves)
        start = point_program.axes_declared(START, self.samples.arm, _axes_deg(self.samples.q[0]))
        return program_of(source, point_program.data_file(self.name, [start, *points]))

    @property
    def _first_speed(self) -> float:
        return _rounded_down(next((v for v in self.speeds.cp if v > 0.0), 0.25))

    def _moves(self) -> tuple[list[s.Statement], list[s.Statement]]:
        moves: list[s.Statement] = [s.Move("PTP", e.Name(START)), *self._wait(0)]
        points: list[s.Statement] = []
        if self.speeds.orientation is not None:
            moves.insert(0, point_program.component_set("$VEL.ORI1", _rounded_down(self.speeds.orientation)))
        set_: dict[str, float] = {"$VEL.CP": self._first_speed}
        for i, motion in enumerate(self.motions):
            approximation = self.approximations[i]
            moves += self._settings(set_, self.speeds.cp[i], approximation)
            ends = motion.knots or (motion.last,)
            names = [f"P{len(points) + k}" for k in range(1, len(ends) + 1)]
            via = None
            if motion.via is not None:
                via = e.Name(names[0].replace("P", "V"))
                points.append(self._point(via.name, motion.via, axes=False))
            points += [self._point(name, k, axes="PTP" in motion.kind) for name, k in zip(names, ends, strict=True)]
            blends = () if approximation is None else (approximation.keyword,)
            block = [s.Move(motion.kind, e.Name(name), auxiliary=via, blends=blends) for name in names]
            moves += [s.SplineBlock(BLOCKS[motion.kind]), *block, s.EndSpline()] if motion.knots else block
            moves += self._wait(motion.last)
        return moves, points

    def _wait(self, sample: int) -> list[s.Statement]:
        seconds = self.samples.pauses.get(sample, 0.0)
        return [s.Wait("SEC", e.Real(round(seconds, 3)))] if seconds else []

    def _settings(self, set_: dict[str, float], cp: float, approximation: Approximation | None) -> list[s.Statement]:
        """The assignments that change something before a motion."""
        wanted = {"$VEL.CP": _rounded_down(cp)} if cp > 0.0 else {}
        if approximation is not None:
            wanted["$APO.CDIS" if approximation.keyword == "C_DIS" else "$APO.CPTP"] = approximation.value
        changed = {name: value for name, value in wanted.items() if set_.get(name) != value}
        set_.update(changed)
        return [point_program.component_set(name, value) for name, value in changed.items()]

    def motion_at(self, line: int) -> int:
        """The index of the motion or block in or before a line (from 1) of the `.src`; -1 before all of them."""
        open_, count = False, -2  # the first is the way to the start
        for x in (each.statement for each in self.program().source.lines[:line]):
            count += isinstance(x, s.SplineBlock) or (isinstance(x, s.Move) and not open_)
            open_ = isinstance(x, s.SplineBlock) or (open_ and not isinstance(x, s.EndSpline))
        return count

    def _point(self, name: str, sample: int, axes: bool) -> s.Statement:
        """A point: its pose with S and T, or its axes for a PTP to where a pose does not determine them."""
        arm, q = self.samples.arm, self.samples.q[sample]
        pose = rounded(np.linalg.inv(self.base) @ self.samples.T[sample])
        flange = self.base @ frame_matrix(pose) @ np.linalg.inv(self.samples.tool)
        solved = taught_axes(arm, flange, q, CLEAR)
        if axes and solved is None:
            return point_program.axes_declared(name, arm, _axes_deg(q))
        at = q if solved is None else solved
        return point_program.pose_declared(name, pose, status(arm, at), turn(at))


def speeds_of(
    samples: SampledPath, motions: Sequence[FittedMotion], cp: float | None, percent: int | None
) -> ProgramSpeeds:
    """Speeds for a program: those given, else the largest of the samples' times; slower where an axis needs it.

    `cp` [m/s] and `percent` of the axes' rated speeds. Without times and without `cp` it is 0.25 m/s, without `percent`
    100 %.
    """
    arm = samples.arm
    way = np.linalg.norm(np.diff(samples.T[:, :3, 3], axis=0), axis=1)
    if cp is None:
        cp = 0.25 if samples.t is None else float(np.max(way / np.diff(samples.t)))
    cp = float(np.clip(cp, 1e-3, 10.0))
    step = np.abs(np.diff(samples.q, axis=0)) / arm.velocity
    if percent is None:
        used = 1.0 if samples.t is None else float(np.max(step / np.diff(samples.t)[:, None]))
        percent = int(np.clip(np.ceil(100.0 * used), 1, 100))
    found, turns = [], []
    for motion in motions:
        if "PTP" in motion.kind or motion.knots:
            # the speed of a block is planned under the axes' bounds
            found.append(0.0 if "PTP" in motion.kind else cp)
            continue
        part = slice(motion.first, motion.last)
        length = motion.path(samples).length
        # the axes' time for a piece at their rated speeds bounds the speed on it
        moving = way[part] > 1e-9
        bound = float(np.min(way[part][moving] / np.maximum(step[part][moving].max(axis=1), 1e-12), initial=np.inf))
        found.append(float(np.clip(min(cp, USED * bound), 1e-3, 10.0)))
        if length < 1e-6:
            turns.append(USED * motion.path(samples).angle / max(float(step[part].max(axis=1).sum()), 1e-12))
    slowest = min((np.degrees(x) for x in turns), default=np.inf)
    return ProgramSpeeds(percent, tuple(found), float(slowest) if slowest < 200.0 else None)


def rounded(T: Array) -> tuple[float, ...]:
    """X, Y, Z, A, B, C of a pose (4, 4), as they are written."""
    p = pose_of_matrix(T)
    mm = (round(x, DECIMALS_MM) + 0.0 for x in (p.x_mm, p.y_mm, p.z_mm))
    return (*mm, *(round(x, DECIMALS_DEG) + 0.0 for x in (p.a_deg, p.b_deg, p.c_deg)))


def _axes_deg(q: Array) -> list[float]:
    return [round(float(x), DECIMALS_DEG) + 0.0 for x in np.degrees(q)]
