"""A sampled path -> a program of PTP, LIN and CIRC that follows it within a tolerance, with its `.dat`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.project.program import Program, program_of
from lwr_dyn.krl.robot.kuka_pose import frame_matrix, pose_of_matrix, status, turn
from lwr_dyn.krl.writing.branches import taught_axes
from lwr_dyn.krl.writing.corners import Approximation
from lwr_dyn.krl.writing.path_fit import BLOCKS, CLEAR, FittedMotion
from lwr_dyn.krl.writing.program_lines import (
    axes_declared,
    component_set,
    data_file,
    frame_set,
    pose_declared,
    program_file,
)
from lwr_dyn.krl.writing.sampled_path import SampledPath

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
        frames = (frame_set("TOOL", rounded(self.samples.tool), tool), frame_set("BASE", rounded(self.base), base))
        source = program_file(self.name, *frames, self.speeds.percent, _digits(self._first_speed), moves)
        start = axes_declared(START, self.samples.arm, _axes_deg(self.samples.q[0]))
        return program_of(source, data_file(self.name, [start, *points]))

    @property
    def _first_speed(self) -> float:
        return next((v for v in self.speeds.cp if v > 0.0), 0.25)

    def _moves(self) -> tuple[list[s.Statement], list[s.Statement]]:
        moves: list[s.Statement] = [s.Move("PTP", e.Name(START)), *self._wait(0)]
        points: list[s.Statement] = []
        if self.speeds.orientation is not None:
            moves.insert(0, component_set("$VEL.ORI1", _digits(self.speeds.orientation)))
        set_: dict[str, float] = {"$VEL.CP": _digits(self._first_speed)}
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
        wanted = {"$VEL.CP": _digits(cp)} if cp > 0.0 else {}
        if approximation is not None:
            wanted["$APO.CDIS" if approximation.keyword == "C_DIS" else "$APO.CPTP"] = approximation.value
        changed = {name: value for name, value in wanted.items() if set_.get(name) != value}
        set_.update(changed)
        return [component_set(name, value) for name, value in changed.items()]

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
            return axes_declared(name, arm, _axes_deg(q))
        at = q if solved is None else solved
        return pose_declared(name, pose, status(arm, at), turn(at))


def with_slower(program: PathProgram, factor: float) -> PathProgram:
    """The same motions, slower."""
    return replace(program, speeds=program.speeds.slower(factor))


def speeds_of(
    samples: SampledPath, motions: Sequence[FittedMotion], cp: float | None, percent: int | None, share: float
) -> ProgramSpeeds:
    """Speeds for a program: those given, else the largest of the samples' times; slower where an axis needs it.

    `cp` [m/s] and `percent` of the axes' rated speeds; `share` of an axis' rated speed is used at most by a path in
    space. Without times and without `cp` it is 0.25 m/s, without `percent` 100 %.
    """
    arm = samples.arm
    way = np.linalg.norm(np.diff(samples.T[:, :3, 3], axis=0), axis=1)
    if cp is None:
        cp = 0.25 if samples.t is None else float(np.max(way / np.diff(samples.t)))
    if not 1e-3 <= cp <= 10.0:
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
        found.append(float(np.clip(min(cp, share * bound), 1e-3, 10.0)))
        if length < 1e-6:
            turns.append(share * motion.path(samples).angle / max(float(step[part].max(axis=1).sum()), 1e-12))
    slowest = min((np.degrees(x) for x in turns), default=np.inf)
    return ProgramSpeeds(percent, tuple(found), float(slowest) if slowest < 200.0 else None)


def rounded(T: Array) -> tuple[float, ...]:
    """X, Y, Z, A, B, C of a pose (4, 4), as they are written."""
    p = pose_of_matrix(T)
    mm = (round(x, DECIMALS_MM) + 0.0 for x in (p.x_mm, p.y_mm, p.z_mm))
    return (*mm, *(round(x, DECIMALS_DEG) + 0.0 for x in (p.a_deg, p.b_deg, p.c_deg)))


def _axes_deg(q: Array) -> list[float]:
    return [round(float(x), DECIMALS_DEG) + 0.0 for x in np.degrees(q)]


def _digits(x: float) -> float:
    """Three digits, rounded down."""
    unit = 10.0 ** (np.floor(np.log10(x)) - 2)
    return float(np.round(np.floor(x / unit + 1e-9) * unit, 9))
