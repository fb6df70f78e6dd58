"""How often a plus-minus holds the truth, in logs of arms whose friction grows with the torque that a gear carries."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cache

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.load_friction import load_indices, with_load_friction, with_moving_loads
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import FrictionForm, TorqueColumns
from tests.identification import cover_truths as of
from tests.identification.plants import Plant, perturbed_plant, random_motion, simulated_samples

SHARES = (0.02, 0.2)
"""Of the load, drawn for every joint: from the figures of published arms to twice them."""
SECONDS, NOISE = 20.0, 0.1


@cache
def load_plant(arm: str, run: int, friction: FrictionForm = "directions") -> Plant:
    """A truth off the arm's table whose friction grows with the torques of its own bodies and rotors."""
    table, rng = of.cover_arm(arm), np.random.default_rng([run, 45, *map(ord, arm)])
    plain = perturbed_plant(TorqueColumns(table.chain, friction), table, rng)
    rigid = plain.parameters[plain.columns.table_indices]
    columns = replace(plain.columns, carried=rigid)
    parameters, loads = np.zeros(columns.count), load_indices(columns)
    parameters[loads] = rng.uniform(*SHARES, loads.size)
    parameters[~np.isin(np.arange(columns.count), loads)] = plain.parameters
    return Plant(columns, parameters)


def load_samples(arm: str, run: int, seconds: float = SECONDS) -> tuple[Plant, Samples]:
    """The truth and a motion of it with noisy torques."""
    plant, rng = load_plant(arm, run), np.random.default_rng([run, 46, *map(ord, arm)])
    return plant, simulated_samples(plant, random_motion(of.cover_arm(arm), seconds, rng), NOISE, rng, 0.05)


def misses(arm: str, runs: Iterable[int], seconds: float = SECONDS) -> Array:
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
