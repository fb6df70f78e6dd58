"""How often a plus-minus of gains and bodies holds the truth, in logs whose torques are off by a gain a joint.

The logs of `cover_study`, their torques (before noise) times gains of exp(N(0, 10 %)), fitted as `identify motion
--gains 10%` does it; with `load` friction of every joint has a share of 2 to 20 % of what its bodies and rotor ask,
fitted too (`--load-friction`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.consistent import consistent_fit
from lwr_dyn.identification.motion.gain_fit import GainFit, fit_gains
from lwr_dyn.identification.motion.motion_fit import said_by
from lwr_dyn.identification.motion.validation import Folds
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.load_friction import load_indices, with_load_friction, with_moving_loads
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification import cover_truths as of
from tests.identification.cover_study import case, cover_log, folds_of
from tests.identification.plants import Plant, inside, perturbed_plant, random_motion, rms, simulated_samples

WIDTH = 0.1
"""Of the gains' logs: drawn and said."""
SHARES = (0.02, 0.2)
"""Of the load, drawn for every joint: from the figures of published arms to twice them."""
SECONDS, NOISE = 20.0, 0.1


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
        columns, true = _with_shares(columns, true, rng)
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


@cache
def load_plant(arm: str, run: int) -> Plant:
    """A truth off the arm's table whose friction grows with the torques of its own bodies and rotors."""
    table, rng = of.cover_arm(arm), np.random.default_rng([run, 45, *map(ord, arm)])
    plain = perturbed_plant(TorqueColumns(table.chain, "directions"), table, rng)
    return Plant(*_with_shares(plain.columns, plain.parameters, rng))


def _with_shares(columns: TorqueColumns, plain: Array, rng: np.random.Generator) -> tuple[TorqueColumns, Array]:
    """Columns and parameters with shares of the load that bodies and rotors ask."""
    columns = replace(columns, carried=plain[columns.table_indices])
    parameters, loads = np.zeros(columns.count), load_indices(columns)
    parameters[loads] = rng.uniform(*SHARES, columns.n)
    parameters[~np.isin(np.arange(columns.count), loads)] = plain
    return columns, parameters


def load_samples(arm: str, run: int, seconds: float = SECONDS) -> tuple[Plant, Samples]:
    """The truth and a motion of it with noisy torques."""
    plant, rng = load_plant(arm, run), np.random.default_rng([run, 46, *map(ord, arm)])
    return plant, simulated_samples(plant, random_motion(of.cover_arm(arm), seconds, rng), NOISE, rng, 0.05)


def load_misses(arm: str, runs: Iterable[int], seconds: float = SECONDS) -> Array:
    """Of all base parameters in standard errors, (runs, b)."""
    rows = []
    for run in runs:
        plant, samples = load_samples(arm, run, seconds)
        columns = with_load_friction(samples, replace(plant.columns, carried=None))
        found = with_moving_loads(samples, information_of(samples, columns))
        rows.append((found.values - plant.base) / found.sigma)
    return np.array(rows)


def of_shares(arm: str, z: Array) -> Array:
    """Those of the shares of the load, (runs, n)."""
    columns = load_plant(arm, 0).columns
    return z[:, np.isin(columns.base().kept, load_indices(columns))]
