"""How well a fit predicts torques that it has not seen: over motions kept from it in turn, and on logs of their own."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise
from operator import add

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.motion.motion_pieces import motion_pieces
from lwr_dyn.identification.motion.residuals import predicted, residuals_of, rms
from lwr_dyn.identification.regression.base_parameters import BaseParameters
from lwr_dyn.identification.regression.information import Information, solve
from lwr_dyn.identification.regression.normal_equations import NormalEquations, normal_equations
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns

THIRDS = 3
"""Bands of speed of equal width, up to a joint's largest."""
Refit = Callable[[Information], Array]
"""From what logs say to the parameters (p,) of bodies."""


@dataclass(frozen=True, slots=True)
class SpeedBand:
    """RMS of what the fit leaves of unseen torques at speeds |dq| from `slowest` to `fastest` [rad/s or m/s]."""

    slowest: float
    fastest: float
    equations: int
    left: float


@dataclass(frozen=True, slots=True)
class Validation:
    """RMS torques of one joint [N m or N]: measured, and what is left of them.

    `fitted`: by the fit, of torques it saw. `held_out`: by fits that did not see the motion. `consistent`: by fits
    whose links are bodies, that did not see it either; None if there are none. `model`: by the arm's own model with its
    own friction. `by_speed` splits `held_out`. `left_out`: by fits that did not see the motion, of torques at instants
    that no fit takes, slower than its slowest speed or beside a reversal; None without such instants.
    """

    joint: int
    measured: float
    fitted: float
    held_out: float
    consistent: float | None
    model: float
    by_speed: tuple[SpeedBand, ...] = ()
    left_out: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Folds:
    """Motions of which some are kept from a fit in turn: which fold an instant is of, and their normal equations."""

    samples: Samples
    known: NDArray[np.bool_]
    """Which torques (k, n) were measured, whether a fit takes them or not."""
    columns: TorqueColumns
    base: BaseParameters
    fold: NDArray[np.intp]
    normal: tuple[NormalEquations, ...]

    @classmethod
    def of(cls, samples: Samples, columns: TorqueColumns, count: int, known: NDArray[np.bool_]) -> "Folds":
        """Motions dealt to `count` folds; raises `OptionError` as `motion_pieces`."""
        base, fold = columns.base(), motion_pieces(samples, count)
        parts = [samples.select(fold == i) for i in range(count)]
        normal = tuple(normal_equations(part, columns, base) for part in parts)
        return cls(samples, known, columns, base, fold, normal)

    def information(self) -> Information:
        """What all of them say."""
        return solve(reduce(add, self.normal), self.columns, self.base)

    def held_out(self, noise: Array, refit: Refit | None = None) -> Array:
        """Residuals (k, n) of torques by fits to the other folds, NaN where not known; `refit` makes bodies of them."""
        out = np.full(self.samples.tau.shape, np.nan)
        for i in range(len(self.normal)):
            rows = self.fold == i
            if not rows.any():
                continue
            others = reduce(add, (part for k, part in enumerate(self.normal) if k != i))
            found = solve(others, self.columns, self.base, noise)
            values = found.values if refit is None else self.base.of(refit(found))
            out[rows] = self.samples.tau[rows] - predicted(self.samples.select(rows), self.columns, values)
        return np.where(self.known, out, np.nan)


def cross_validation(
    folds: Folds, information: Information, own: Array, refit: Refit | None = None
) -> tuple[Validation, ...]:
    """One `Validation` a joint, over motions kept from the fit in turn.

    Parameters
    ----------
    folds : Folds
    information : Information
        Of all of them.
    own : (p,) array
        The arm's own parameters.
    refit : callable, optional
        Makes bodies of what a part of the logs says.
    """
    samples, columns = folds.samples, folds.columns
    noise = np.where(np.isfinite(information.noise), information.noise, 1.0)
    unseen = folds.held_out(noise)
    bodies = None if refit is None else folds.held_out(noise, refit)
    seen = residuals_of(samples, columns, information.values)
    return _by_joint(samples, seen, unseen, bodies, _model(folds, own))


def validated_on(
    samples: Samples, known: NDArray[np.bool_], columns: TorqueColumns, values: Array, own: Array,
    parameters: Array | None = None,
) -> tuple[Validation, ...]:  # fmt: skip
    """The same on logs that no fit saw: base values (b,), parameters (p,) of bodies; `fitted` is NaN.

    `known` (k, n): which torques were measured, whether a fit would take them or not.
    """
    unseen = np.where(known, samples.tau - predicted(samples, columns, values), np.nan)
    bodies = None if parameters is None else residuals_of(samples, columns, columns.base().of(parameters))
    nothing = np.full(unseen.shape, np.nan)
    left = np.where(samples.used, samples.tau - predicted(samples, columns, own), np.nan)
    return _by_joint(samples, nothing, unseen, bodies, left)


def _model(folds: Folds, own: Array) -> Array:
    left = folds.samples.tau - predicted(folds.samples, folds.columns, own)
    return np.where(folds.samples.used, left, np.nan)


def _by_joint(
    samples: Samples, fitted: Array, unseen: Array, bodies: Array | None, model: Array
) -> tuple[Validation, ...]:
    measured, taken = (np.where(samples.used, x, np.nan) for x in (samples.tau, unseen))
    beside = np.where(samples.used, np.nan, unseen)
    others = None if bodies is None else np.where(samples.used, bodies, np.nan)
    return tuple(
        Validation(
            j + 1, rms(measured[:, j]), rms(fitted[:, j]), rms(taken[:, j]),
            None if others is None else rms(others[:, j]), rms(model[:, j]),
            speed_bands(samples.dq[:, j], taken[:, j]),
            rms(beside[:, j]) if np.isfinite(beside[:, j]).any() else None,
        )
        for j in range(samples.n)
    )  # fmt: skip


def speed_bands(dq: Array, left: Array) -> tuple[SpeedBand, ...]:
    """Residuals (k,), NaN where not used, by thirds of the largest speed of dq (k,); bands without any are left out."""
    used = np.isfinite(left)
    speed = np.abs(dq)
    if not used.any():
        return ()
    edges: Sequence[float] = np.linspace(0.0, float(speed[used].max()), THIRDS + 1).tolist()
    out = []
    for slowest, fastest in pairwise(edges):
        rows = used & (speed > slowest) & (speed <= fastest)
        if rows.any():
            out.append(SpeedBand(slowest, fastest, int(np.count_nonzero(rows)), rms(left[rows])))
    return tuple(out)
