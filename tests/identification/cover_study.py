"""How often a plus-minus of bodies, rotors and friction holds the truth: a cell is an arm, a truth, a noise.

Logs have exact states; their torques go the whole way of `identify motion`, from folds to errors under coloured noise.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.bodies.body_prior import body_prior
from lwr_dyn.identification.bodies.consistent import consistent_fit
from lwr_dyn.identification.motion.motion_fit import said_by
from lwr_dyn.identification.motion.motion_result import DEFAULT_MOTION
from lwr_dyn.identification.motion.validation import Folds
from lwr_dyn.identification.regression.samples import Samples, exact_samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification import cover_truths as of
from tests.identification.plants import inside, rms

KINDS = {
    "masses": "m_", "centres": ("mx_", "my_", "mz_"), "moments": ("Ixx", "Iyy", "Izz"),
    "products": ("Ixy", "Ixz", "Iyz"), "rotors": "armature", "friction": ("coulomb", "viscous"),
}  # fmt: skip
"""Of parameters, by the beginnings of their names; centres as first moments."""
SLOWEST = 0.05
"""[rad/s]"""


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """Of some logs: misses in standard errors (runs, p) of bodies, rotors, friction."""

    names: tuple[str, ...]
    misses: Array
    sigma: Array
    """(runs, p)"""
    held_out: Array
    """(runs,) RMS torque error on a motion without noise that no fit saw [N m]."""
    refused: int

    def of_kind(self, kind: str) -> tuple[float, float, float, float]:
        """RMS miss, share inside 3 sigma, largest miss, median plus-minus."""
        places = [i for i, name in enumerate(self.names) if name.startswith(KINDS[kind])]
        z = self.misses[:, places]
        return rms(z), inside(z), float(np.abs(z).max()), float(np.median(self.sigma[:, places]))

    @property
    def inside(self) -> float:
        """Share of all plus-minus of 3 sigma that hold the truth."""
        return inside(self.misses)

    def row(self) -> str:
        """RMS miss / % inside 3 sigma / largest, of each kind."""
        kinds = (self.of_kind(kind) for kind in KINDS)
        return " | ".join(f"{z:.2f} {100 * share:.1f} {most:.1f}" for z, share, most, _ in kinds)


def cover_cell(arm: str, truth: str, noise: str, runs: Iterable[int]) -> Cell:
    """Fits of one arm's logs, a truth and a noise a run."""
    rows = zip(*[_run(arm, truth, noise, run) for run in runs], strict=True)
    misses, sigma, held_out, refused = (np.array(x) for x in rows)
    return Cell(tuple(case(arm)[0].names), misses, sigma, held_out, int(refused.sum()))


def cover_log(arm: str, truth: str, noise: str, run: int) -> tuple[Array, Samples]:
    """Parameters (p,) of a truth, and the log of its arm."""
    columns, table = case(arm)
    rng = of.cover_seed(arm, truth, noise, run)
    true = of.cover_truth(of.cover_arm(arm), columns, table, truth, rng)
    motion, Y = _motion(arm, run % of.MOTIONS, False)
    tau = Y @ true + of.cover_noise((len(Y), columns.n), noise, rng)
    return true, exact_samples(motion.t, motion.q, motion.dq, motion.ddq, tau, SLOWEST)


def folds_of(arm: str, samples: Samples, columns: TorqueColumns | None = None) -> Folds:
    """As `identify motion` makes them."""
    return Folds.of(samples, columns or case(arm)[0], DEFAULT_MOTION.folds, samples.used)


def _run(arm: str, truth: str, noise: str, run: int) -> Sequence[object]:
    true, samples = cover_log(arm, truth, noise, run)
    information, _ = said_by(folds_of(arm, samples))
    fit = consistent_fit(information, case(arm)[0].own(of.cover_arm(arm)))
    _, Y = _motion(arm, run % of.MOTIONS, True)
    away = fit.parameters - true
    return away / fit.sigma, fit.sigma, rms(Y @ away), fit.price.refused


@cache
def case(arm: str) -> tuple[TorqueColumns, Array]:
    """The columns of an arm, and its table (p,)."""
    columns = TorqueColumns(of.cover_arm(arm).chain, "directions")
    own = columns.own(of.cover_arm(arm))
    table = own.copy()
    table[: columns.bodies] = body_prior(columns, own).table[: columns.bodies]
    return columns, table


@cache
def _motion(arm: str, number: int, unseen: bool) -> tuple[of.Motion, Array]:
    motion = of.cover_motion(arm, number, unseen)
    Y = case(arm)[0](motion.q, motion.dq, motion.ddq)
    return motion, Y[::4] if unseen else Y
