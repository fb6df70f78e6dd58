"""How often a plus-minus of gains, shares of friction with the load, and bodies holds the truth, all of one log.

The truths, motions and noise of `cover_study`; friction of every joint has a share of 2 to 20 % of what its bodies and
rotor ask, and torques (before noise) are off by gains of exp(N(0, 10 %)). Fitted as `identify motion --gains 10%
--load-friction` does it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.motion.motion_result import DEFAULT_MOTION
from lwr_dyn.identification.motion.validation import Folds
from lwr_dyn.identification.regression.load_friction import load_indices, with_load_friction
from lwr_dyn.identification.regression.samples import Samples
from tests.identification.cover_study import case, cover_log, rms
from tests.identification.gain_study import WIDTH, gain_fit_of
from tests.identification.load_friction_study import SHARES


@dataclass(frozen=True, slots=True, eq=False)
class GainLoadCell:
    """Misses in standard errors: of gains and shares (runs, n), of all other parameters (runs, p), total mass (runs,).

    `moving` (runs,): by how many standard errors gains would still move.
    """

    gains: Array
    shares: Array
    others: Array
    masses: Array
    moving: Array
    refused: int

    @property
    def inside(self) -> tuple[float, float, float]:
        """Share of all plus-minus of 3 sigma that hold the truth: of gains, shares, and the others."""
        gains, shares, others = (float(np.mean(np.abs(z) <= 3.0)) for z in (self.gains, self.shares, self.others))
        return gains, shares, others

    def row(self) -> str:
        """RMS miss, % inside 3 sigma, largest: of gains, shares, all others, the total mass."""
        return " | ".join(f"{rms(z):.2f} {100 * np.mean(np.abs(z) <= 3.0):.1f} {np.abs(z).max():.1f}"
                          for z in (self.gains, self.shares, self.others, self.masses))  # fmt: skip


def gain_load_log(arm: str, truth: str, noise: str, run: int) -> tuple[Array, Array, Samples]:
    """Gains (n,), parameters (p,) of a truth with shares of the load, and its log."""
    plain, _ = case(arm)
    true, samples = cover_log(arm, truth, noise, run)
    rng = np.random.default_rng([run, 78, *map(ord, arm + truth + noise)])
    columns = replace(plain, carried=true[plain.table_indices])
    parameters, loads = np.zeros(columns.count), load_indices(columns)
    parameters[loads] = rng.uniform(*SHARES, columns.n)
    parameters[~np.isin(np.arange(columns.count), loads)] = true
    logs = rng.normal(0.0, WIDTH, columns.n)
    motion = samples.q, samples.dq, samples.ddq
    tau = samples.tau - plain.torques(*motion, true) + np.exp(logs) * columns.torques(*motion, parameters)
    return np.exp(logs), parameters, replace(samples, tau=tau)


def gain_load_cell(arm: str, truth: str, noise: str, runs: Iterable[int]) -> GainLoadCell:
    """Fits of one arm's logs, a truth, a noise, gains and shares a run."""
    rows = [_run(arm, truth, noise, run) for run in runs]
    gains, shares, others, masses, moving, refused = (list(x) for x in zip(*rows, strict=True))
    return GainLoadCell(*map(np.array, (gains, shares, others, masses, moving)), sum(refused))


def _run(arm: str, truth: str, noise: str, run: int) -> tuple[Array, Array, Array, float, float, bool]:
    gains, true, samples = gain_load_log(arm, truth, noise, run)
    columns = with_load_friction(samples, case(arm)[0])
    found = gain_fit_of(arm, Folds.of(samples, columns, DEFAULT_MOTION.folds, samples.used))
    fit = found.bodies
    assert fit is not None
    mass, error = fit.total_mass
    z, loads = (fit.parameters - true) / fit.sigma, load_indices(columns)
    off = np.log(found.gains.values / gains) / np.sqrt(np.diag(found.gains.covariance))
    total = (mass - float(true[: fit.bodies : 10].sum())) / error
    return off, z[loads], np.delete(z, loads), total, found.gains.moving, fit.price.refused
