"""A load in the hand of an arm from a log: ten parameters, beside the friction of the joints or the arm as a whole.

What errors of the arm's own table do to a load that is fitted on it:

    y = X b + Y d + e,   d ~ N(0, t^2 C0),   b^ - b = (X^T W X)^-1 X^T W (Y d + e)

b are the load and the friction, Y d the torques of what the table has wrong of bodies and rotors, C0 the covariance of
the kinds of `bodies.link_spreads` for a share of 1. The share t is the one whose expected residual squares are those
that neighbouring instants have in common, and never below `LEAST_SHARE`: the columns of a load take up most of what a
table has wrong of a wrist, so that what is left may look like noise where the load is 250 of its own errors off.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.bodies.body_prior import body_prior
from lwr_dyn.identification.bodies.link_spreads import Scales, link_spreads
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.regression.coupled_motors import motors_or_joints
from lwr_dyn.identification.regression.information import BLOCK, GroupedEstimate, NormalEquations, equations_of, grouped
from lwr_dyn.identification.regression.instrumental import WINDOW, window_sums
from lwr_dyn.identification.regression.joints_alone import motor_words
from lwr_dyn.identification.regression.least_squares import Spectrum
from lwr_dyn.identification.regression.samples import SampleRule, Samples, samples_of
from lwr_dyn.identification.regression.torque_columns import FrictionForm, TorqueColumns
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body
from lwr_dyn.model.inertial_parameters import TENSOR, UNITS, inertial_parameters
from lwr_dyn.model.run import short_repr
from lwr_dyn.model.spatial import Pose, steiner, symmetric_part

NAMES = INERTIAL
"""Mass, first moment and tensor about the origin of the flange's frame (the tool's point where the arm has a tool)."""


def load_shift(flange: Pose) -> Array:
    """A (10, 10): parameters of a body in the frame of the link that carries it, from those in the flange's frame.

    With H the pose of the flange and P the pseudo-inertia, P_link = H P H^T, which is linear in the parameters. Columns
    of the load are those of the last link, which it is a part of, times A.
    """
    H = flange.matrix()
    return inertial_parameters(H @ UNITS @ H.T).T


def body_of(parameters: Array) -> Body:
    """The body with parameters (10,) about the origin of its frame; the mass must not be 0."""
    m, first = float(parameters[0]), parameters[1:4]
    com = first / m
    return Body(m, com, symmetric_part(parameters[TENSOR] - steiner(m, com)))


LEAST_SHARE = 0.03
"""By which an arm is taken to be off its table, whatever its residuals look like."""
SURE = 5.0
"""Standard errors by which the residuals of neighbours must be alike, in all joints together."""


def model_squares(left: Array, used: NDArray[np.bool_], recording: NDArray[np.intp]) -> Array:
    """Mean squares (n,) of what is wrong in residuals (k, n), by their neighbours [(N m)^2 or N^2]; 0 if by chance.

    White noise has no covariance with its neighbour, an error of the model hardly changes from one to the next. For
    noise alone the sum over joints of m r, r the correlation in m pairs, has the variance of the sum of m.

    >>> one = np.tile([0.2, 0.2, -0.2, -0.2], 100)[:, None]
    >>> both = np.concatenate([one + 1.0, one - 1.0])
    >>> model_squares(both, np.ones((800, 1), dtype=bool), np.repeat([0, 1], 400)).round(2).tolist()
    [1.0]
    """
    pairs = used[1:] & used[:-1] & (recording[1:] == recording[:-1])[:, None]
    count = pairs.sum(axis=0)
    alike = np.where(pairs, left[1:] * left[:-1], 0.0).sum(axis=0) / np.maximum(count, 1)
    squares = np.where(used, left**2, 0.0).sum(axis=0) / np.maximum(used.sum(axis=0), 1)
    sure = float((count * alike / np.maximum(squares, 1e-300)).sum()) > SURE * float(np.sqrt(count.sum()))
    return np.asarray(np.maximum(alike, 0.0) * sure)


def arm_doubt(
    normal: NormalEquations, columns: TorqueColumns, own: Array, fitted: int, noise: Array, wrong: Array
) -> tuple[float, Array]:
    """How far the arm seems to be off its table, and what that adds to the covariance of what was fitted.

    Parameters
    ----------
    normal : NormalEquations
        Of `fitted` columns, then all bodies and rotors of `columns`.
    own : (p,) array
        The table's parameters.
    noise, wrong : (n,) array
        Noise that weighs each joint's equations, and the mean squares of `model_squares`.

    Returns
    -------
    share : float
        Of masses, tensors and rotors, half of it of shapes, and centres by as much of 5 cm; at least `LEAST_SHARE`.
    covariance : (fitted, fitted) array
    """
    matrix, _ = normal.weighted(noise)
    prior = _table_covariance(columns, own)
    across = matrix[:fitted, fitted:]
    bias = Spectrum.of(matrix[:fitted, :fitted]).inverse() @ across
    left = matrix[fitted:, fitted:] - across.T @ bias
    seen = normal.equations > 0
    square = float((normal.equations * wrong / noise**2)[seen].sum()) / max(float((prior * left).sum()), 1e-300)
    square = max(square, LEAST_SHARE**2)
    return float(np.sqrt(square)), square * bias @ prior @ bias.T


def _table_covariance(columns: TorqueColumns, own: Array) -> Array:
    """Of bodies and rotors about the table's for a share of 1, to first order, (11 n, 11 n)."""
    one, table = Scales.of_deviation(1.0), body_prior(columns, own).table
    kinds = np.square([one.shape, one.centre, one.tensor, one.mass])
    links = np.einsum("k,nkab->nab", kinds, link_spreads(table[: columns.bodies].reshape(-1, TEN))[:, :4])
    return np.asarray(block_diag(*links, np.diag(np.square(table[columns.rotor_indices]))))


FRICTIONS = ("directions", "symmetric", "own")
"""Friction of the joints: fitted to the same logs, per direction or the same in both with an offset; the arm's own."""
SYSTEMATIC = 1.5
"""Times its own size that a joint's residual may have in slow sums and pass for noise."""
CUTOFFS = (20.0, 10.0, 5.0)
"""[Hz] Filters on positions that are tried: fast motions need a high one; slow ones a low one, or the noise of their
accelerations shrinks inertias."""
RULES = tuple(SampleRule(cutoff) for cutoff in CUTOFFS)
TEN = len(INERTIAL)


@dataclass(frozen=True, slots=True, eq=False)
class LoadIdentification:
    """A load: `parameters` (10,) as `NAMES` about the flange's origin [kg, kg m, kg m^2], and `covariance` (10, 10).

    `determined` (10,): whether the motion shows a parameter; where not, its sigma is infinite. `noise` (n,) is that of
    every joint's torque, `slow` (n,) what it is in slow sums: the same for noise, more where the model is wrong;
    `without` (n,) is the RMS torque left when no load is assumed and all else is fitted again, `left` (n,) that with
    the load [N m or N]. `known` says what was taken as known. The covariance has the larger of the two noises.
    """

    parameters: Array
    covariance: Array
    determined: NDArray[np.bool_]
    noise: Array
    slow: Array
    equations: NDArray[np.intp]
    left: Array
    without: Array
    cutoff: float | None
    """Of the filter on positions [Hz]."""
    known: str
    nuisance: tuple[str, ...]
    """What was fitted beside the load."""
    share: float = 0.0
    """How far the arm is taken to be off its table, whose errors are in the covariance; 0 where the arm is fitted."""
    motors: str = ""
    """Which motors turn several joints, where rotors and friction are theirs (`regression.coupled_motors`)."""
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "parameters", "covariance", "noise", "slow", "left", "without")

    @property
    def sigma(self) -> Array:
        """Standard errors (10,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def found(self) -> bool:
        """Whether there is a load: its mass is above 3 sigma."""
        return bool(self.parameters[0] > 3.0 * self.sigma[0])

    @property
    def colour(self) -> float:
        """How unlike noise the residuals are: largest |log| of slow over plain noise among the joints."""
        seen = self.equations > 0
        return float(np.abs(np.log(self.slow[seen] / self.noise[seen])).max())

    @property
    def in_doubt(self) -> bool:
        """Whether residuals are not noise alone: some joint's, or by those of all the arm is further off."""
        return bool(self.systematic) or self.share > LEAST_SHARE

    @property
    def systematic(self) -> tuple[int, ...]:
        """Joints, from 1, whose residual is not noise: the arm's table, friction or log is not what was assumed."""
        return tuple(int(j) + 1 for j in np.flatnonzero(self.slow > SYSTEMATIC * self.noise))


def identify_load(
    logs: Iterable[JointLog],
    arm: Arm,
    rules: Sequence[SampleRule] = RULES,
    friction: str = FRICTIONS[0],
    unloaded: Iterable[JointLog] = (),
) -> LoadIdentification:
    """The ten parameters of a load that is fixed to the flange.

    Parameters
    ----------
    logs : iterable of JointLog
        Recordings with the load.
    arm : Arm
        The arm without it. Its inertias are taken as known, unless there are unloaded logs.
    rules : sequence of SampleRule
        How instants are taken: by the one under which the residuals are most like noise. That of accelerations is fast,
        what a filter takes off the motion is slow.
    friction : {"directions", "symmetric", "own"}
        Fitted beside the load, in one of two forms, or as the arm's source has it.
    unloaded : iterable of JointLog
        Recordings of the same arm without the load: then its base parameters are fitted too, in all logs together, and
        errors of its table do not go into the load.

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
    several, empty = list(logs), list(unloaded)
    arm.require_dynamics()
    if friction not in FRICTIONS:
        raise OptionError("friction", repr(friction), ", ".join(FRICTIONS))
    if friction == "own" and empty:
        raise OptionError("friction", "the arm's own, with unloaded logs", "fitted, as the whole arm is then")
    if friction == "own" and not arm.has_friction:
        raise OptionError("friction", f"the own one of {arm.name}, which has none", "fitted")
    if friction == "own" and any(one is not None and one.sigmoid is not None for one in arm.friction_models()):
        raise OptionError("friction", f"the own one of {arm.name}, a sigmoid of the speed", "fitted")
    found = [_identified(several, arm, each, friction, empty) for each in rules]
    return min(found, key=lambda each: each.colour)


def _identified(
    logs: list[JointLog], arm: Arm, rule: SampleRule, friction: str, empty: list[JointLog]
) -> LoadIdentification:
    form: FrictionForm = "symmetric" if friction == "symmetric" else "directions"
    if friction != "own":
        rule = motors_or_joints(rule, logs, arm, form)
    loaded = samples_of(logs, rule)
    transmission = None if friction == "own" else rule.transmission
    columns = TorqueColumns(arm.chain, form, transmission=transmission, link_side=rule.link_side)
    own = columns.own(arm)
    if empty:
        beside, known = columns.base().kept, np.zeros(columns.count)
        said = f"the arm's geometry; the arm is fitted to {len(empty)} log{'s' * (len(empty) > 1)} without the load"
    elif friction == "own":
        beside, known, said = np.zeros(0, np.intp), own, "the arm's inertias and friction"
    else:
        beside, known, said = columns.friction_indices, own.copy(), "the arm's inertias"
        known[beside] = 0.0
    problems = [_LoadProblem(loaded, columns, known, beside, load_shift(arm.chain.flange), arm)]
    if empty:
        problems.append(_LoadProblem(samples_of(empty, rule), columns, known, beside, np.zeros((TEN, TEN)), arm))
    normal = sum((p.equations() for p in problems[1:]), problems[0].equations())
    start = np.sqrt(normal.squares / np.maximum(normal.equations, 1)) + 1e-9
    fit = grouped(normal, start)
    if not fit.determined[0]:
        needed = "a motion that turns the load against gravity, at changing speeds"
        raise LogError(loaded.sources[0], "columns q1..", "the load's mass is not determined", needed)
    found = _result(fit, problems, rule.cutoff, said, tuple(columns.names[k] for k in beside))
    found = replace(found, motors=motor_words(transmission))
    return found if empty else _doubted(found, fit, problems[0])


@dataclass(frozen=True, slots=True, eq=False)
class _LoadProblem:
    """Equations of a load's ten parameters, through `shift` (10, 10) from the last link's, and of others."""

    samples: Samples
    columns: TorqueColumns
    known: Array
    beside: NDArray[np.intp]
    shift: Array
    arm: Arm

    def blocks(self) -> Iterator[tuple[slice, Array, Array]]:
        """Rows, X (k, n, p) and y (k, n) with what is known taken off."""
        s, last = self.samples, slice(self.columns.bodies - TEN, self.columns.bodies)
        for first in range(0, len(s), BLOCK):
            rows = slice(first, first + BLOCK)
            Y = self.columns(s.q[rows], s.dq[rows], s.ddq[rows])
            X = np.concatenate([Y[:, :, last] @ self.shift, Y[:, :, self.beside]], axis=2)
            yield rows, X, s.tau[rows] - Y @ self.known

    def equations(self) -> NormalEquations:
        """Sums over the samples; raises nothing, as samples have at least one instant."""
        parts = [equations_of(X, y, self.samples.used[rows]) for rows, X, y in self.blocks()]
        return sum(parts[1:], parts[0])

    def residuals(self, values: Array) -> Array:
        """(k, n) [N m or N], 0 where not used."""
        return np.concatenate([(y - X @ values) * self.samples.used[rows] for rows, X, y in self.blocks()])

    def slow_squares(self, values: Array) -> Array:
        """Of the residuals in slow sums, (n,) [(N m)^2 or N^2], times the number of equations."""
        sums = window_sums(self.residuals(values), self.samples.recording, self.samples.rows_in(WINDOW))
        return np.asarray(np.square(sums).sum(axis=0))


def _doubted(found: LoadIdentification, fit: GroupedEstimate, problem: _LoadProblem) -> LoadIdentification:
    """With the errors of the arm's table in the covariance, as large as the residuals say or a usual arm's are."""
    columns, samples = problem.columns, problem.samples
    wrong = model_squares(problem.residuals(fit.values), samples.used, samples.recording)
    whole = replace(problem, beside=np.concatenate([problem.beside, columns.table_indices])).equations()
    noise = np.where(np.isnan(fit.noise), 1.0, fit.noise)
    share, more = arm_doubt(whole, columns, columns.own(problem.arm), fit.values.size, noise, wrong)
    covariance = found.covariance + np.where(np.isfinite(found.covariance), more[:TEN, :TEN], 0.0)
    return replace(found, covariance=covariance, share=share)


def _result(
    fit: GroupedEstimate, problems: Sequence[_LoadProblem], cutoff: float | None, known: str, nuisance: tuple[str, ...]
) -> LoadIdentification:
    n = fit.normal
    bare = NormalEquations(n.matrices[:, TEN:, TEN:], n.sides[:, TEN:], n.squares, n.equations)
    noise = np.where(np.isnan(fit.noise), 1.0, fit.noise)
    without = grouped(bare, noise).values if nuisance else np.zeros(0)
    slow = np.sqrt(sum(p.slow_squares(fit.values) for p in problems) / np.maximum(n.equations, 1))
    hidden = ~fit.determined
    inverse = np.where(hidden[:, None] | hidden, 0.0, fit.covariance)
    covariance = inverse @ np.tensordot(np.maximum(slow / noise, 1.0) ** 2 / noise**2, n.matrices, 1) @ inverse
    covariance[hidden, hidden] = np.inf
    return LoadIdentification(
        fit.values[:TEN], covariance[:TEN, :TEN], fit.determined[:TEN], fit.noise, slow, n.equations,
        n.residual_rms(fit.values), n.residual_rms(np.concatenate([np.zeros(TEN), without])), cutoff, known, nuisance,
    )  # fmt: skip
