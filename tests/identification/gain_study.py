"""How often a plus-minus of gains and bodies holds the truth, in logs whose torques are off by a gain a joint.

The logs of `cover_study`, their torques (before noise) times gains of exp(N(0, 10 %)), fitted as `identify motion
--gains 10%` does it.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.consistent import consistent_fit
from lwr_dyn.identification.motion.gain_fit import GainFit, fit_gains
from lwr_dyn.identification.motion.motion_fit import said_by
from lwr_dyn.identification.motion.motion_result import DEFAULT_MOTION
from lwr_dyn.identification.motion.validation import Folds
from tests.identification import cover_truths as of
from tests.identification.cover_study import case, cover_log, rms

WIDTH = 0.1
"""Of the gains' logs: drawn and said."""


@dataclass(frozen=True, slots=True, eq=False)
class GainCell:
    """Misses in standard errors: of gains (runs, n), all parameters (runs, p), the total mass (runs,)."""

    gains: Array
    misses: Array
    masses: Array
    shared: Array
    """(runs,) the same of the mean of the logs of gains."""
    refused: int
    seconds: float
    """Processor time of a fit."""

    @property
    def inside(self) -> float:
        """Share of all plus-minus of 3 sigma that hold the truth."""
        return float(np.mean(np.abs(np.hstack([self.gains, self.misses])) <= 3.0))

    def row(self) -> str:
        """RMS miss, % inside 3 sigma, largest: of gains, of all parameters, of the total mass."""
        return " | ".join(f"{rms(z):.2f} {100 * np.mean(np.abs(z) <= 3.0):.1f} {np.abs(z).max():.1f}"
                          for z in (self.gains, self.misses, self.masses))  # fmt: skip


def gain_cell(arm: str, truth: str, noise: str, runs: Iterable[int]) -> GainCell:
    """Fits of one arm's logs, a truth, a noise and gains a run."""
    rows = [_run(arm, truth, noise, run) for run in runs]
    gains, misses, masses, shared, refused, seconds = (list(x) for x in zip(*rows, strict=True))
    return GainCell(np.array(gains), np.array(misses), np.array(masses), np.array(shared), sum(refused),
                    float(np.mean(seconds)))  # fmt: skip


def gain_log(arm: str, truth: str, noise: str, run: int) -> tuple[Array, Array, Folds]:
    """Gains (n,), parameters (p,) of a truth, and the folds of its log."""
    columns, _ = case(arm)
    true, samples = cover_log(arm, truth, noise, run)
    logs = np.random.default_rng([run, 77, *map(ord, arm + truth + noise)]).normal(0.0, WIDTH, columns.n)
    exact = columns.torques(samples.q, samples.dq, samples.ddq, true)
    samples = replace(samples, tau=samples.tau + (np.exp(logs) - 1.0) * exact)
    return np.exp(logs), true, Folds.of(samples, columns, DEFAULT_MOTION.folds, samples.used)


def gain_fit_of(arm: str, folds: Folds, width: float = WIDTH) -> GainFit:
    """As `identify motion --gains` does it."""
    own = folds.columns.own(of.cover_arm(arm))
    return fit_gains(folds, width, lambda x: said_by(x)[0], lambda found, like: consistent_fit(found, own, like=like))


def _run(arm: str, truth: str, noise: str, run: int) -> tuple[Array, Array, float, float, bool, float]:
    gains, true, folds = gain_log(arm, truth, noise, run)
    start = time.process_time()
    found = gain_fit_of(arm, folds)
    seconds = time.process_time() - start
    fit = found.bodies
    assert fit is not None
    mass, error = fit.total_mass
    total = (mass - float(true[: fit.bodies : 10].sum())) / error
    off = np.log(found.gains.values / gains)
    shared, off = float(off.mean()) / found.gains.common, off / np.sqrt(np.diag(found.gains.covariance))
    return off, (fit.parameters - true) / fit.sigma, total, shared, fit.price.refused, seconds
