"""A load in the hand of an arm from a log: ten parameters, beside the friction of the joints or the arm as a whole."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arrays import Array, freeze_arrays
from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.errors import OptionError
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.log_columns import LogError
from lwr_dyn.identification.payload.load_columns import NAMES, load_columns
from lwr_dyn.identification.regression.grouped import GroupedEstimate, equations_of, grouped
from lwr_dyn.identification.regression.normal_equations import BLOCK, NormalEquations
from lwr_dyn.identification.regression.samples import DEFAULT_SAMPLES, SampleRule, Samples, samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.shown import short_repr

FRICTIONS = ("fitted", "own")
"""Friction of the joints: fitted to the same logs, or the arm's own model."""
TEN = len(INERTIAL)


@dataclass(frozen=True, slots=True, eq=False)
class LoadIdentification:
    """A load: `parameters` (10,) as `NAMES` about the flange's origin [kg, kg m, kg m^2], and `covariance` (10, 10).

    `determined` (10,): whether the motion shows a parameter; where not, its sigma is infinite. `noise` (n,) is that of
    every joint's torque, `without` (n,) the RMS torque that is left when no load is assumed and all else is fitted
    again, `left` (n,) with the load [N m or N]. `known` says what was taken as known.
    """

    parameters: Array
    covariance: Array
    determined: NDArray[np.bool_]
    noise: Array
    equations: NDArray[np.intp]
    left: Array
    without: Array
    known: str
    nuisance: tuple[str, ...]
    """What was fitted beside the load."""
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "parameters", "covariance", "noise", "left", "without")

    @property
    def sigma(self) -> Array:
        """Standard errors (10,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def found(self) -> bool:
        """Whether there is a load: its mass is above 3 sigma."""
        return bool(self.parameters[0] > 3.0 * self.sigma[0])


def identify_load(
    logs: Iterable[JointLog],
    arm: Arm,
    rule: SampleRule = DEFAULT_SAMPLES,
    friction: str = "fitted",
    unloaded: Iterable[JointLog] = (),
) -> LoadIdentification:
    """The ten parameters of a load that is fixed to the flange.

    Parameters
    ----------
    logs : iterable of JointLog
        Recordings with the load.
    arm : Arm
        The arm without it. Its inertias are taken as known, unless there are unloaded logs.
    rule : SampleRule
        How instants are taken.
    friction : {"fitted", "own"}
        Fitted beside the load, symmetric with an offset, or as the arm's source has it.
    unloaded : iterable of JointLog
        Recordings of the same arm without the load: then its base parameters are fitted too, in all logs together, and
        errors of its table do not go into the load.

    Returns
    -------
    LoadIdentification

    Raises
    ------
    OptionError
        Another friction; the arm's own where it has none, or together with unloaded logs.
    LogError
        Uneven rows, recordings too short, or a motion that does not show the load's mass.

    References
    ----------
    Khalil, Gautier, Lemoine, Identification of the payload inertial parameters of industrial manipulators (2007),
    methods 2 (known arm) and 3 (both together).
    """
    loaded, empty = samples_of(logs, rule), list(unloaded)
    _check(arm, friction, bool(empty))
    columns = TorqueColumns(arm.chain)
    own = columns.own(arm)
    if empty:
        beside, known = columns.base().kept, np.zeros(columns.count)
        said = f"nothing: the arm is fitted to {len(empty)} log{'s' * (len(empty) > 1)} without the load"
    elif friction == "fitted":
        joints = np.arange(columns.bodies, columns.count)
        beside, known = np.setdiff1d(joints, columns.rotor_indices), np.zeros(columns.count)
        known[: columns.bodies], known[columns.rotor_indices] = own[: columns.bodies], own[columns.rotor_indices]
        said = "the arm's inertias"
    else:
        beside, known, said = np.zeros(0, np.intp), own, "the arm's inertias and friction"
    normal = _equations(loaded, columns, known, beside, arm, True)
    if empty:
        normal = normal + _equations(samples_of(empty, rule), columns, known, beside, arm, False)
    start = np.sqrt(normal.squares / np.maximum(normal.equations, 1)) + 1e-9
    fit = grouped(normal, start)
    if not fit.determined[0]:
        raise LogError(loaded.sources[0], "columns q1..", "the load's mass is not determined", _NEEDED)
    return _result(fit, said, tuple(columns.names[k] for k in beside))


_NEEDED = "a motion that turns the load against gravity, at changing speeds"


def _check(arm: Arm, friction: str, empty: bool) -> None:
    arm.require_dynamics()
    if friction not in FRICTIONS:
        raise OptionError("friction", repr(friction), ", ".join(FRICTIONS))
    if friction == "own" and empty:
        raise OptionError("friction", "the arm's own, with unloaded logs", "fitted, as the whole arm is then")
    if friction == "own" and not any(arm.friction_models()):
        raise OptionError("friction", f"the own one of {arm.name}, which has none", "fitted")


def _equations(
    samples: Samples, columns: TorqueColumns, known: Array, beside: NDArray[np.intp], arm: Arm, loaded: bool
) -> NormalEquations:
    """Of the load's ten parameters, 0 in a log without it, and the columns `beside` it; what is known is taken off."""
    last = slice(columns.bodies - TEN, columns.bodies)
    total: NormalEquations | None = None
    for first in range(0, len(samples), BLOCK):
        rows = slice(first, first + BLOCK)
        Y = columns(samples.q[rows], samples.dq[rows], samples.ddq[rows])
        load = load_columns(Y[:, :, last], arm.chain.flange) if loaded else np.zeros((*Y.shape[:2], TEN))
        X = np.concatenate([load, Y[:, :, beside]], axis=2)
        part = equations_of(X, samples.tau[rows] - Y @ known, samples.used[rows])
        total = part if total is None else total + part
    assert total is not None  # samples have at least one instant
    return total


def _result(fit: GroupedEstimate, known: str, nuisance: tuple[str, ...]) -> LoadIdentification:
    n = fit.normal
    bare = NormalEquations(n.matrices[:, TEN:, TEN:], n.sides[:, TEN:], n.squares, n.equations)
    noise = np.where(np.isnan(fit.noise), 1.0, fit.noise)
    without = grouped(bare, noise) if bare.sides.shape[1] else None
    squares = n.squares if without is None else n.residual_squares(np.concatenate([np.zeros(TEN), without.values]))
    rms = np.sqrt(np.where(n.equations > 0, squares / np.maximum(n.equations, 1), np.nan))
    return LoadIdentification(
        fit.values[:TEN], fit.covariance[:TEN, :TEN], fit.determined[:TEN], fit.noise, n.equations,
        fit.rms(fit.values), rms, known, nuisance,
    )  # fmt: skip


__all__ = ["FRICTIONS", "NAMES", "LoadIdentification", "identify_load"]
