"""How many wrong signs, orders and units of columns are recognised, planted one by one into logs of perturbed arms."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

import lwr_dyn
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.log_faults.column_trials import column_changes
from lwr_dyn.identification.log_faults.found_faults import log_faults
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm
from tests.identification.plants import perturbed_plant, random_motion, simulated_log

LEVEL, NOISE, ENCODER, SECONDS = 0.2, 0.1, 1e-5, 10.0
"""How far arms are from their tables, [N m], [rad], [s]."""


@dataclass(slots=True)
class Recognised:
    """Faults planted, those named as planted and alone, those with a wrong name, alarms of whole logs."""

    planted: int = 0
    right: int = 0
    wrong: int = 0
    alarms: int = 0
    missed: Counter[str] = field(default_factory=Counter)

    @property
    def text(self) -> str:
        """The counts, and what was missed most."""
        listed = ", ".join(f"{name} ({count})" for name, count in self.missed.most_common(6))
        said = f"{self.right} of {self.planted} recognised, {self.wrong} misnamed, {self.alarms} false alarms"
        return f"{said}; not recognised: {listed}"


def slips(n: int) -> Iterator[tuple[str, Array, Array]]:
    """Every fault by the text that must name it, and the maps of positions and torques that plant it."""
    for change in column_changes(n):
        yield change.text, np.linalg.inv(change.Q), np.linalg.inv(change.T)
    for factor, text in ((1e-3, "in N m, read as mN m"), (1e3, "in mN m, read as N m")):
        yield f"all torques {text}", np.eye(n), factor * np.eye(n)


def recognised(name: str, reading: str | None, plants: int, each: int, seed: int = 0) -> Recognised:
    """Some faults each in logs of some arms, drawn at random."""
    arm: Arm = lwr_dyn.load(name, reading)
    columns, rng, every = TorqueColumns(arm.chain), np.random.default_rng(seed), list(slips(arm.n))
    counts = Recognised()
    for _ in range(plants):
        plant = perturbed_plant(columns, arm, rng, LEVEL)
        log = simulated_log(plant, random_motion(arm, SECONDS, rng), NOISE, rng, encoder=ENCODER)
        counts.alarms += bool(log_faults([log], arm))
        for k in rng.choice(len(every), each, replace=False):
            text, Q, T = every[k]
            found = log_faults([replace(log, q=log.q @ Q, tau=log.tau @ T)], arm)
            counts.planted += 1
            if len(found) == 1 and text in found[0].found:
                counts.right += 1
            else:
                counts.wrong += bool(found)
                counts.missed[text] += 1
    return counts
