"""Writes a sampled path as a program, runs the program, and keeps what stays within the tolerance."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import ProgramRun
from lwr_dyn.krl.running.run import ProgramError, run_program
from lwr_dyn.krl.writing.axis_spline_fit import axis_splines
from lwr_dyn.krl.writing.corners import approximations
from lwr_dyn.krl.writing.motion_program import PathProgram, speeds_of, with_slower
from lwr_dyn.krl.writing.path_fit import BLOCKS, KINDS, USUAL, Tolerance, fitted_motions
from lwr_dyn.krl.writing.program_lines import NAMES, is_name
from lwr_dyn.krl.writing.round_trip import PathDeviation, path_deviation
from lwr_dyn.krl.writing.sampled_path import SampledPath
from lwr_dyn.krl.writing.spline_fit import with_splines

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
USED = 0.9
"""Share of an axis' rated speed that a path in space uses at most."""


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
        deviation = path_deviation(samples, program.motions, run, options.tolerance)
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
        motions = fitted_motions(samples, tolerance.times(FITTED if share else LEFT), kinds, only_ptp)
    if splined and "SPL" in options.kinds:
        motions = with_splines(samples, motions, tolerance.times(splined), wherever=set(options.kinds) == {"SPL"})
    speeds = speeds_of(samples, motions, options.speed, options.percent, USED)
    blends = approximations(samples, motions, tolerance.times(CUT), share)
    return PathProgram(options.name, samples, motions, speeds, blends, base)


def _slow_enough(candidate: PathProgram, machine: MachineData | None) -> tuple[PathProgram, ProgramRun]:
    """The program, slower where an axis would be over its speed, and its run."""
    factor = 1.0
    while True:
        program = candidate if factor == 1.0 else with_slower(candidate, factor)
        fault = None
        try:
            run = run_program(program.program(), candidate.samples.arm, machine)
        except ProgramError as error:
            if error.code != "axis-speed" or factor < SLOWEST:
                raise
            fault = error
        if fault is None and (factor < SLOWEST or not any(d.code == "axis-speed" for d in run.diagnostics)):
            return program, run
        factor *= SLOWER
