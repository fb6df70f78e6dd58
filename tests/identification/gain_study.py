"""How often a plus-minus of gains and bodies holds the truth, in logs whose torques are off by a gain a joint.

The logs of `cover_study`, their torques (before noise) times gains of exp(N(0, 10 %)), fitted as `identify motion
--gains 10%` does it; with `load` friction of every joint has a share of 2 to 20 % of what its bodies and rotor ask,
fitted too (`--load-friction`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.consistent import consistent_fit
from lwr_dyn.identification.motion.gain_fit import GainFit, fit_gains
from lwr_dyn.identification.motion.motion_fit import said_by
from lwr_dyn.identification.motion.validation import Folds
from lwr_dyn.identification.regression.load_friction import load_indices, with_load_friction
from lwr_dyn.identification.regression.samples import Samples
from tests.identification import cover_truths as of
from tests.identification.cover_study import case, cover_log, folds_of
from tests.identification.load_friction_study import SHARES
from tests.identification.plants import inside, rms

WIDTH = 0.1
"""Of the gains' logs: drawn and said."""


@dataclass(frozen=True, slots=True, eq=False)
class GainCell:
    """Misses in standard errors: of gains and shares of the load (runs, n), of all other parameters (runs, p).

    `masses`, `common` (runs,): of the total mass, and of the mean of the logs of gains. `moving` (runs,): by how many
    standard errors gains would still move.
    """

    gains: Array
    shares: Array
    others: Array
    masses: Array
    common: Array
    moving: Array
    refused: int


def row(cell: GainCell) -> str:
    """RMS miss, % inside 3 sigma, largest: of gains, shares if there are any, all others, the total mass."""
    parts = (z for z in (cell.gains, cell.shares, cell.others, cell.masses) if z.size)
    return " | ".join(f"{rms(z):.2f} {100 * inside(z):.1f} {np.abs(z).max():.1f}" for z in parts)


def gain_cell(arm: str, truth: str, noise: str, runs: Iterable[int], load: bool = False) -> GainCell:
    """Fits of one arm's logs, a truth, a noise, gains and perhaps shares a run."""
    rows = zip(*[_run(arm, truth, noise, run, load) for run in runs], strict=True)
    *parts, refused = (np.array(x) for x in rows)
    return GainCell(*parts, int(refused.sum()))


def gain_log(arm: str, truth: str, noise: str, run: int, load: bool = False) -> tuple[Array, Array, Samples]:
    """Gains (n,), parameters (p,) of a truth (with shares of the load), and its log."""
    columns, _ = case(arm)
    true, samples = cover_log(arm, truth, noise, run)
    motion = samples.q, samples.dq, samples.ddq
    exact = columns.torques(*motion, true)
    rng = np.random.default_rng([run, 78 if load else 77, *map(ord, arm + truth + noise)])
    if load:
        columns, plain = replace(columns, carried=true[columns.table_indices]), true
        true, loads = np.zeros(columns.count), load_indices(columns)
        true[loads] = rng.uniform(*SHARES, columns.n)
        true[~np.isin(np.arange(columns.count), loads)] = plain
    gains = np.exp(rng.normal(0.0, WIDTH, columns.n))
    return gains, true, replace(samples, tau=samples.tau - exact + gains * columns.torques(*motion, true))


def gain_fit_of(arm: str, folds: Folds, width: float = WIDTH) -> GainFit:
    """As `identify motion --gains` does it."""
    own = folds.columns.own(of.cover_arm(arm))
    return fit_gains(folds, width, lambda x: said_by(x)[0], lambda found, like: consistent_fit(found, own, like=like))


def _run(arm: str, truth: str, noise: str, run: int, load: bool) -> tuple[object, ...]:
    gains, true, samples = gain_log(arm, truth, noise, run, load)
    columns = with_load_friction(samples, case(arm)[0]) if load else case(arm)[0]
    found, loads = gain_fit_of(arm, folds_of(arm, samples, columns)), load_indices(columns)
    fit = found.bodies
    assert fit is not None
    mass, error = fit.total_mass
    total = (mass - float(true[: fit.bodies : 10].sum())) / error
    off, z = np.log(found.gains.values / gains), (fit.parameters - true) / fit.sigma
    common, off = float(off.mean()) / found.gains.common, off / np.sqrt(np.diag(found.gains.covariance))
    return off, z[loads], np.delete(z, loads), total, common, found.gains.moving, fit.price.refused
