"""From a fit to what the page shows: full parameters, predicted torques, friction over speed, a row a parameter."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.regression.samples import Samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.identification.report.parameter_rows import ShownParameter
from lwr_dyn.identification.report.torque_charts import ShownRecording
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.transmission import Transmission

MOST_ROWS = 12_000
"""Instants of a recording that the page draws: two minutes at 100 Hz; of longer ones every second, third, ..."""
MOST_RECORDINGS = 8
"""Recordings that are drawn, the first ones."""
_BLOCK = 1000


@dataclass(frozen=True, slots=True, eq=False)
class DrawnFit:
    """The recordings as they are drawn, and the dots of the friction maps: speed and torque (k, n)."""

    recordings: tuple[ShownRecording, ...]
    speed: Array
    torque: Array
    left_out: int
    """Recordings that are not drawn."""
    every: int
    """Of the longest recording drawn, one in so many instants is there."""


def full_parameters(information: Information, arm: Arm) -> Array:
    """All parameters (p,): those that fit best and are nearest to the arm's own, column by column to its scale.

    Of the sets with the fitted base values, the one with the least sum of squared relative changes; no set of bodies
    need have them.
    """
    own, grouping = information.columns.own(arm), information.base.grouping
    weight = np.square(np.maximum(np.abs(own), 1e-3 * np.abs(own).max()))
    missing = information.values - grouping @ own
    pull = (grouping * weight) @ grouping.T
    return np.asarray(own + weight * (grouping.T @ np.linalg.solve(pull, missing)))


def drawn_fit(samples: Samples, columns: TorqueColumns, parameters: Array) -> DrawnFit:
    """Torques as parameters (p,) predict them, and what bodies and rotors leave of the measured ones.

    With a transmission, speeds and friction are those of the motors.
    """
    numbers = np.unique(samples.recording)
    rigid = parameters.copy()
    rigid[columns.bodies :] = 0.0
    rigid[columns.rotor_indices] = parameters[columns.rotor_indices]
    recordings, speeds, torques, every = [], [], [], 1
    names = _names([samples.sources[k] for k in numbers])
    for name, number in zip(names[:MOST_RECORDINGS], numbers[:MOST_RECORDINGS], strict=True):
        rows = np.flatnonzero(samples.recording == number)
        step = -(-rows.size // MOST_ROWS)
        one, every = samples.select(rows[::step]), max(every, step)
        whole, bodies = _torques(one, columns, parameters, rigid)
        cut = ~one.used & (one.tau == 0.0)  # a torque that was cut out stands as 0 there
        measured = np.where(cut, np.nan, one.tau)
        recordings.append(ShownRecording(name, one.t - one.t[0], one.q, measured, whole, one.used))
        left = np.where(one.used, one.tau - bodies, np.nan)
        speeds.append(one.dq if columns.transmission is None else one.dq @ columns.transmission.matrix.T)
        torques.append(left if columns.transmission is None else _at_motors(left, columns.transmission))
    hidden = len(numbers) - len(recordings)
    return DrawnFit(tuple(recordings), np.concatenate(speeds), np.concatenate(torques), hidden, every)


def _torques(one: Samples, columns: TorqueColumns, *sets: Array) -> Iterator[Array]:
    """Y pi (k, n) of each parameter set, in blocks."""
    both = np.column_stack(sets)
    blocks = [slice(k, k + _BLOCK) for k in range(0, len(one), _BLOCK)]
    out = np.concatenate([columns(one.q[b], one.dq[b], one.ddq[b]) @ both for b in blocks])
    return (out[..., k] for k in range(len(sets)))


def _at_motors(left: Array, transmission: Transmission) -> Array:
    """Torques of the motors (k, n): T^T tau_m = tau; NaN where one joint's is unknown."""
    return np.asarray(np.linalg.solve(transmission.matrix.T, left.T).T)


def _names(sources: Sequence[str]) -> list[str]:
    """A name a recording: the file, numbered where it has several."""
    return [
        source if sources.count(source) == 1 else f"{source} ({list(sources[: k + 1]).count(source)})"
        for k, source in enumerate(sources)
    ]


def link_parameters(columns: TorqueColumns, parameters: Array) -> Array:
    """The ten of each link, (n, 10)."""
    return np.asarray(parameters[: columns.bodies].reshape(columns.n, len(INERTIAL)))


def parameter_rows(
    information: Information, arm: Arm, states: Sequence[str], bodies: Array | None = None
) -> tuple[ShownParameter, ...]:
    """A row a base parameter, with the arm's own value and that of the result's bodies (b,)."""
    own = information.base.of(information.columns.own(arm))
    bodies = np.full(own.size, np.nan) if bodies is None else bodies
    rows = zip(information.base.statements(), information.values, information.sigma, own, bodies, states, strict=True)
    return tuple(
        ShownParameter(name, float(value), float(sigma), float(table), float(body), state)
        for name, value, sigma, table, body, state in rows
    )
