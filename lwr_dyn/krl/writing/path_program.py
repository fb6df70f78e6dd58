"""Writes a sampled path as a program, runs the program, and keeps what stays within the tolerance.

In place of many short motions a SPLINE block with as few SPL, and from pause to pause a PTP_SPLINE block with as few
SPTP, as keep the tool within the tolerance. The curve is the one that `krl run` plans (cubic, through its points);
KUKA's own is not published, so between the points a controller's path may be another one.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.diagnostics import ExecutionError
from lwr_dyn.krl.motion.motion_segments import tool_pose
from lwr_dyn.krl.motion.pose_paths import PosePath
from lwr_dyn.krl.motion.splines import SplinePoint, spline_pieces
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import ProgramError, ProgramRun, run_program
from lwr_dyn.krl.writing import path_fit
from lwr_dyn.krl.writing.motion_program import PathProgram, approximations, speeds_of
from lwr_dyn.krl.writing.path_fit import BLOCKS, KINDS, USUAL, FittedMotion, PathDeviation, Tolerance
from lwr_dyn.krl.writing.point_program import NAMES, is_name
from lwr_dyn.krl.writing.sampled_path import SampledPath

FEWEST = 3
"""Motions that a block replaces."""
LONG = 5.0
"""A motion so many times as long as the middle one stays as it is."""
ROUNDS, STEPS = 16, 6
MOST = 3000
"""Points of a block."""


def with_splines(
    samples: SampledPath, motions: Sequence[FittedMotion], tolerance: tuple[float, float], wherever: bool = False
) -> tuple[FittedMotion, ...]:
    """The motions with SPL blocks for runs of LIN and CIRC that need more points; `wherever` it is possible at all."""
    out: list[FittedMotion] = []
    for group in _groups(samples, motions, wherever):
        points = sum(2 if motion.kind == "CIRC" else 1 for motion in group)
        knots = None
        if group[0].kind != "PTP" and (wherever or len(group) >= FEWEST):
            knots = _knots(samples, group[0].first, group[-1].last, tolerance, MOST if wherever else points - 1)
        out += group if knots is None else [FittedMotion("SPL", group[0].first, group[-1].last, None, knots)]
    return tuple(out)


def _groups(samples: SampledPath, motions: Sequence[FittedMotion], wherever: bool) -> Iterator[list[FittedMotion]]:
    """Runs of short LIN and CIRC without a pause; every other motion alone."""
    lengths = [0.0 if motion.kind == "PTP" else motion.path(samples).length for motion in motions]
    long = np.inf if wherever else LONG * float(np.median([x for x in lengths if x > 0.0] or [0.0]))
    group: list[FittedMotion] = []
    for motion, length in zip(motions, lengths, strict=True):
        short = motion.kind != "PTP" and length <= long
        if group and (not short or motion.first in samples.pauses):
            yield group
            group = []
        if short:
            group.append(motion)
        else:
            yield [motion]
    if group:
        yield group


def _knots(
    samples: SampledPath, first: int, last: int, tolerance: tuple[float, float], most: int
) -> tuple[int, ...] | None:
    """The samples at which the points of a SPLINE block stand; None where it would take more than `most`."""
    if last - first < 2:
        return None
    places = samples.T[first : last + 1, :3, 3]
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1)))

    def passed(knots: Sequence[int]) -> Array | None:
        path = _curve(samples, [first + k for k in knots])
        return None if path is None else path_fit.poses_at(path[0], _nearest(path, way, knots, places))

    return _refined_knots(samples, first, way, passed, tolerance, most)


def _refined_knots(
    samples: SampledPath,
    first: int,
    way: Array,
    passed: Callable[[Sequence[int]], Array | None],
    tolerance: tuple[float, float],
    most: int,
) -> tuple[int, ...] | None:
    """Knots, more where the poses (k, 4, 4) that a curve has passed are off; `way` (k,) grows from sample to sample."""
    last = len(way) - 1
    knots = sorted({0, last, *([_half(way, 0, last)] if last > 1 else ())})
    for _ in range(ROUNDS):
        T = passed(knots) if len(knots) - 1 <= most else None
        if T is None:
            return None
        good = path_fit.within(T, samples.T[first : first + last + 1], tolerance)
        bad = [(a, b) for a, b in pairwise(knots) if not good[a : b + 1].all() and b > a + 1]
        if not bad:
            return tuple(first + k for k in knots[1:]) if good.all() else None
        knots = sorted({*knots, *(_half(way, a, b) for a, b in bad)})
    return None


def _half(way: Array, a: int, b: int) -> int:
    """The sample half the way between two."""
    return min(max(int(np.searchsorted(way, 0.5 * (way[a] + way[b]))), a + 1), b - 1)


def _curve(samples: SampledPath, knots: Sequence[int]) -> tuple[PosePath, Array] | None:
    """The path through samples and the lengths at which it passes them."""
    points = [SplinePoint("SPL", samples.T[k]) for k in knots[1:]]
    try:
        pieces = list(spline_pieces(samples.T[knots[0]], points))
    except ExecutionError:
        return None
    if len(pieces) != 1 or len(pieces[0].motions) != len(points):
        return None
    return pieces[0].path, np.append(0.0, pieces[0].ends)


def _nearest(path: tuple[PosePath, Array], way: Array, knots: Sequence[int], places: Array) -> Array:
    """The lengths (k,) at which the curve is nearest to the places (k, 3), by Newton's steps from their share."""
    curve, marks = path

    def at(s: Array) -> tuple[Array, Array]:
        found = curve.segment.at(s)
        return found.p, found.dp

    return _stepped(at, places, np.interp(way, way[list(knots)], marks), marks[-1])


def _stepped(at: Callable[[Array], tuple[Array, Array]], wanted: Array, s: Array, end: float) -> Array:
    """Newton's steps along a curve, from `s` (k,) up to `end`, towards what is wanted (k, n)."""
    for _ in range(STEPS):
        found, slope = at(s)
        step = np.sum((wanted - found) * slope, axis=1) / np.maximum(np.sum(slope * slope, axis=1), 1e-12)
        s = np.clip(s + step, 0.0, end)
    return np.asarray(s)


def axis_splines(samples: SampledPath, tolerance: tuple[float, float]) -> tuple[FittedMotion, ...]:
    """A block for each way between two pauses; raises `OptionError` where one would have too many points."""
    marks = sorted({0, *samples.pauses, len(samples.q) - 1})
    found = []
    for first, last in pairwise(marks):
        knots = _axis_knots(samples, first, last, tolerance)
        if knots is None:
            raise OptionError(samples.source, "a path too rough for SPTP", "a smooth path, or a larger tolerance")
        found.append(FittedMotion("SPTP", first, last, None, knots))
    return tuple(found)


def _axis_knots(samples: SampledPath, first: int, last: int, tolerance: tuple[float, float]) -> tuple[int, ...] | None:
    q = samples.q[first : last + 1]
    way = _along(samples, q)

    def passed(knots: Sequence[int]) -> Array:
        return tool_pose(samples.arm, _nearest_axes(samples, q, way, knots), samples.tool)

    return _refined_knots(samples, first, way, passed, tolerance, MOST - 1)


def _along(samples: SampledPath, q: Array) -> Array:
    """The time (k,) [s] that the axes need to each sample at their rated speeds, as the parameter of a block has it."""
    return np.append(0.0, np.cumsum((np.abs(np.diff(q, axis=0)) / samples.arm.velocity).max(axis=1)))


def _nearest_axes(samples: SampledPath, q: Array, way: Array, knots: Sequence[int]) -> Array:
    """The places (k, n) of the block's curve that are nearest to axes q (k, n)."""
    points = q[list(knots)]
    marks = _along(samples, points)
    curve = CubicSpline(marks, points, bc_type="natural")
    start = np.interp(way, way[list(knots)], marks)
    return np.asarray(curve(_stepped(lambda s: (curve(s), curve(s, 1)), q, start, marks[-1])))


FITTED, CUT, LEFT = 0.55, 0.4, 0.9
"""Shares of the tolerance: of the fit where corners are cut, of the cut itself, of the fit where they are not."""
SPLINED = (0.8, 0.4, 0.15)
"""Shares of the tolerance for SPL and SPTP at the samples, until its curve keeps it between them too."""
SHARES = (1.0, 0.5, 0.25, 0.1, 0.0)
"""Of the approximations that the corners allow; the first at which the run stays within the tolerance is taken."""
IMPOSSIBLE = frozenset({"out-of-reach", "outside-limits", "singularity", "wrist-flip"})
"""Faults of a path in space, which the same way by PTP does not have."""
MOST_PTP = 100
"""Places where a path in space is given up."""
SLOWER, SLOWEST = 0.8, 0.05


@dataclass(frozen=True, slots=True)
class WritingOptions:
    """How a path becomes a program; speeds that are None come from the samples' times."""

    name: str = "Motion1"
    tolerance: Tolerance = field(default_factory=Tolerance)
    kinds: tuple[str, ...] = USUAL
    speed: float | None = None
    """[m/s]"""
    percent: int | None = None
    """Of the axes' rated speeds, for PTP."""
    approximate: bool = True

    def __post_init__(self) -> None:
        if not is_name(self.name):
            raise OptionError("name", repr(self.name), NAMES)
        if not self.kinds or not set(self.kinds) <= set(KINDS):
            raise OptionError("kinds", ",".join(self.kinds) or "none", f"some of {', '.join(KINDS)}")
        if "SPTP" in self.kinds and len(self.kinds) > 1:
            raise OptionError("kinds", ",".join(self.kinds), "SPTP alone, or some of the others")


@dataclass(frozen=True, slots=True, eq=False)
class WrittenPath:
    """The program, its run on the model, and how far the run's path is from the samples."""

    written: PathProgram
    run: ProgramRun
    deviation: PathDeviation
    tolerance: Tolerance

    @property
    def holds(self) -> bool:
        """Whether the run stays within the tolerance."""
        return self.deviation.holds(self.tolerance)


def write_path(
    samples: SampledPath, options: WritingOptions, base: Array | None = None, machine: MachineData | None = None
) -> WrittenPath:
    """A program that follows the samples, tried on the model.

    Raises `ProgramError` where it cannot run even slowly, with the line that stops it.
    """
    frame, written = np.eye(4) if base is None else base, None
    for splined, share in _attempts(options):
        program, run = _possible(partial(_candidate, samples, options, frame, splined, share), machine)
        deviation = path_fit.path_deviation(samples, program.motions, run, options.tolerance)
        written = WrittenPath(program, run, deviation, options.tolerance)
        if written.holds:
            break
    assert written is not None
    return written


def _attempts(options: WritingOptions) -> list[tuple[float, float]]:
    """Shares of the tolerance for SPL (0: no block), and of the approximations that the corners allow."""
    shares = SHARES if options.approximate else (0.0,)
    with_blocks = [(splined, shares[0]) for splined in SPLINED] if set(options.kinds) & set(BLOCKS) else []
    return with_blocks + ([(0.0, share) for share in shares] if set(options.kinds) - set(BLOCKS) else [])


def _possible(
    candidate: Callable[[Sequence[tuple[int, int]]], PathProgram], machine: MachineData | None
) -> tuple[PathProgram, ProgramRun]:
    """A candidate that runs: where a path in space cannot be gone, by PTP."""
    only_ptp: list[tuple[int, int]] = []
    while True:
        program = candidate(only_ptp)
        try:
            return _slow_enough(program, machine)
        except ProgramError as fault:
            found = re.search(r":(\d+):", fault.position)
            index = program.motion_at(int(found[1])) if found else -1
            motion = program.motions[index] if index >= 0 else None
            if fault.code not in IMPOSSIBLE or motion is None or motion.kind == "PTP" or len(only_ptp) >= MOST_PTP:
                raise
            only_ptp.append((motion.first, motion.last))


def _candidate(
    samples: SampledPath, options: WritingOptions, base: Array, splined: float, share: float,
    only_ptp: Sequence[tuple[int, int]],
) -> PathProgram:  # fmt: skip
    tolerance = options.tolerance
    kinds = tuple(kind for kind in options.kinds if kind not in BLOCKS) or ("LIN", "CIRC")
    if "SPTP" in options.kinds:
        motions = axis_splines(samples, tolerance.times(splined))
    else:
        motions = path_fit.fitted_motions(samples, tolerance.times(FITTED if share else LEFT), kinds, only_ptp)
    if splined and "SPL" in options.kinds:
        motions = with_splines(samples, motions, tolerance.times(splined), wherever=set(options.kinds) == {"SPL"})
    speeds = speeds_of(samples, motions, options.speed, options.percent)
    blends = approximations(samples, motions, tolerance.times(CUT), share)
    return PathProgram(options.name, samples, motions, speeds, blends, base)


def _slow_enough(candidate: PathProgram, machine: MachineData | None) -> tuple[PathProgram, ProgramRun]:
    """The program, slower where an axis would be over its speed, and its run."""
    factor = 1.0
    while True:
        program = candidate if factor == 1.0 else replace(candidate, speeds=candidate.speeds.slower(factor))
        try:
            run = run_program(program.program(), candidate.samples.arm, machine)
            if factor < SLOWEST or not any(d.code == "axis-speed" for d in run.diagnostics):
                return program, run
        except ProgramError as error:
            if error.code != "axis-speed" or factor < SLOWEST:
                raise
        factor *= SLOWER
