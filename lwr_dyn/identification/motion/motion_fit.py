"""Identification from any motion: base parameters by least squares, bodies near the table, judged on other motions.

Beyond the paper, which needs constant velocities. Base parameters are combinations: other sets give the same torques.

How parameters are taken from logs of any motion.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.bodies.body_prior import body_prior, constraints_of
from lwr_dyn.identification.bodies.consistent import ConsistentFit, consistent_fit
from lwr_dyn.identification.bodies.possible_bodies import BodyVerdict, judge_bodies
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion.identifiable import (
    CorrelatedGroup,
    MissingMotion,
    cell_origins,
    correlated_groups,
    half_widths,
    missing_motions,
    parameter_states,
)
from lwr_dyn.identification.motion.validation import (
    Folds,
    Validation,
    Whiteness,
    cross_validation,
    inflation_of,
    residuals_of,
    validated_on,
    whiteness_of,
)
from lwr_dyn.identification.regression.information import Information, widened
from lwr_dyn.identification.regression.instrumental import instrumental_information
from lwr_dyn.identification.regression.least_squares import IDENTIFIED, ROUNDING, BaseParameters, Estimate
from lwr_dyn.identification.regression.samples import DEFAULT_SAMPLES, SampleRule, Samples, samples_of
from lwr_dyn.identification.regression.stribeck import StribeckSearch, stribeck_search, with_unknown_speeds
from lwr_dyn.identification.regression.torque_columns import FrictionForm, TorqueColumns
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import repr_html, short_repr

LARGEST_DEVIATION = 10.0  # beyond, the table says nothing and leaves no bodies


@dataclass(frozen=True, slots=True, eq=False)
class MotionRule:
    """How parameters are taken from logs.

    Parameters
    ----------
    samples : SampleRule
        How instants are taken; with a transmission rotors and friction are those of the motors.
    friction : {"directions", "symmetric"}
        Coulomb and viscous friction of each direction, or the same in both with an offset.
    stribeck : bool
        Whether Stribeck speeds are searched, on all motions; take samples at low speeds then.
    folds : int
        Parts into which the motions are dealt; each is kept from a fit in turn.
    deviation : float, optional
        Relative deviation of the arm from its table that is expected, such as 0.2; that of most evidence if not given.
    known : tuple of str
        What is known for certain of the bodies, as `total mass = 15.8` or `m_7 = 0.24` (`constraints_of`).

    Raises
    ------
    OptionError
        A deviation that is not above 0 or beyond `LARGEST_DEVIATION`; fewer than two folds.
    """

    samples: SampleRule = DEFAULT_SAMPLES
    friction: FrictionForm = "directions"
    stribeck: bool = False
    folds: int = 5
    deviation: float | None = None
    known: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.folds < 2:
            raise OptionError("folds", self.folds, "a number of at least 2")
        if self.deviation is not None and not (0.0 < self.deviation <= LARGEST_DEVIATION):
            allowed = f"a share above 0 and up to {LARGEST_DEVIATION:g}, such as 0.2 for 20 %"
            raise OptionError("deviation", self.deviation, allowed)

    @property
    def weight(self) -> float | None:
        """Of the table in the consistent fit."""
        return None if self.deviation is None else self.deviation**-2


DEFAULT_MOTION = MotionRule()


@dataclass(frozen=True, slots=True, eq=False)
class MotionIdentification:
    """Base parameters with their errors, bodies that have them, and how well both predict torques they did not see."""

    arm: Arm
    rule: MotionRule
    samples: Samples = field(repr=False)
    information: Information
    """What the logs say of the base parameters."""
    consistent: ConsistentFit | None
    """Bodies, rotors and friction near the arm's table; None for an arm without masses."""
    of_the_model: Array
    """Values from the arm's own inertias and friction for the base parameters (b,)."""
    validation: tuple[Validation, ...]
    """One a joint, over motions kept from the fit in turn."""
    whiteness: tuple[Whiteness, ...]
    """Of the residuals of every joint that moved."""
    groups: tuple[CorrelatedGroup, ...]
    bodies: BodyVerdict
    """Whether no bodies can have the values of least squares."""
    stribeck: StribeckSearch | None = None
    """The search for Stribeck speeds, where one was asked for."""
    stribeck_sigma: Array | None = None
    """Their standard errors (n,) [rad/s or m/s], NaN for a joint without one."""
    __repr__ = short_repr
    _repr_html_ = repr_html

    @property
    def columns(self) -> TorqueColumns:
        """Of the torques."""
        return self.information.columns

    @property
    def base(self) -> BaseParameters:
        """Which combinations are determined."""
        return self.information.base

    @property
    def half_widths(self) -> Array:
        """Of the 3-sigma intervals of the base parameters (b,)."""
        return half_widths(self.information)

    @property
    def states(self) -> tuple[str, ...]:
        """Of each base parameter: identified, or why not (`parameter_states.MEANING`)."""
        return parameter_states(self.information, self.of_the_model)

    @property
    def identified(self) -> int:
        """How many base parameters are identified."""
        return self.states.count(IDENTIFIED)

    @property
    def condition(self) -> float:
        """Of the columns scaled to length 1; above a few hundred the motion excites some parameters poorly."""
        return self.information.condition

    @property
    def equations(self) -> int:
        """How many were used."""
        return int(self.information.equations.sum())

    @property
    def origins(self) -> tuple[str, ...]:
        """Of each parameter of the consistent fit (p,): whether the log or the table says more of it."""
        if self.consistent is None:
            return ()
        own = self.columns.own(self.arm)
        prior = replace(body_prior(self.columns, own), rotor_weight=self.consistent.rotor_weight)
        return cell_origins(self.consistent.sigma, np.sqrt(np.diag(prior.covariance(self.consistent.weight))))

    def missing_motions(self) -> tuple[MissingMotion, ...]:
        """Swings that would identify what this motion does not."""
        wanted = [i for i, state in enumerate(self.states) if state != IDENTIFIED]
        return missing_motions(self.information, self.arm, wanted)

    def residuals(self) -> Array:
        """Measured torques less those of the fit, (k, n) [N m or N], NaN where not used."""
        return residuals_of(self.samples, self.columns, self.information.values)

    def validated_on(self, logs: Iterable[JointLog]) -> tuple[Validation, ...]:
        """The same figures on logs that the fit has not seen; raises `LogError` as `identify_motion`."""
        parameters = None if self.consistent is None else self.consistent.parameters
        several = list(logs)
        samples = samples_of(several, self.rule.samples)
        known = samples_of(several, self.rule.samples.taking_all()).used
        values, own = self.information.values, self.columns.own(self.arm)
        return validated_on(samples, known, self.columns, values, own, parameters)


def identify_motion(
    logs: Iterable[JointLog], arm: Arm, rule: MotionRule = DEFAULT_MOTION, instruments: Sequence[JointLog] = ()
) -> MotionIdentification:
    """Inertial and friction parameters from recordings of any motion.

    Parameters
    ----------
    logs : iterable of JointLog
        Evenly sampled.
    arm : Arm
        Gives the geometry; its masses are what the consistent fit stays near, where the logs do not say otherwise.
    rule : MotionRule
    instruments : sequence of JointLog, optional
        The motion that was commanded for each log: parameters are then those of instrumental variables on unfiltered
        rows (`instrumental_information`), and no part of the motion is kept from the fit.

    Returns
    -------
    MotionIdentification

    Raises
    ------
    LogError
        Uneven or too few rows, or a motion from which nothing can be had.
    OptionError, UnknownNameError
        More folds than instants; something known that is no equation between parameters.
    ConstraintError
        No bodies obey what is known; names the ones that contradict each other.
    MissingDataError
        Something is known of the bodies of an arm without masses.
    """
    several = list(logs)
    seen = _commanded(several, arm, rule, instruments) if instruments else _filtered(several, arm, rule)
    columns, information = seen.information.columns, seen.information
    own = columns.own(arm)
    constraints = constraints_of(rule.known, columns.names) if rule.known else None
    consistent = None
    if arm.chain.bodies is not None or rule.known:
        arm.require_dynamics()
        consistent = consistent_fit(information, own, weight=rule.weight, constraints=constraints)
    of_the_model = columns.base().of(own)
    of_the_model[np.abs(of_the_model) < ROUNDING] = 0.0

    def again(found: Information) -> Array:
        assert consistent is not None
        weights = {"weight": consistent.weight, "rotor_weight": consistent.rotor_weight}
        return consistent_fit(found, own, **weights, constraints=constraints).parameters

    refit = None if consistent is None else again
    validation = () if seen.folds is None else cross_validation(seen.folds, information, own, refit)
    return MotionIdentification(
        arm, rule, seen.samples, information, consistent, of_the_model, validation, seen.whiteness,
        correlated_groups(information), judge_bodies(arm, columns, _estimate(information)), seen.search,
        seen.search_sigma,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _SeenLogs:
    """What logs say, and how well a fit predicts parts of them; without folds and whiteness for unfiltered ones."""

    samples: Samples
    information: Information
    folds: Folds | None = None
    whiteness: tuple[Whiteness, ...] = ()
    search: StribeckSearch | None = None
    search_sigma: Array | None = None


def _filtered(logs: Sequence[JointLog], arm: Arm, rule: MotionRule) -> _SeenLogs:
    samples = samples_of(logs, rule.samples)
    columns = TorqueColumns(arm.chain, rule.friction, transmission=rule.samples.transmission)
    search = stribeck_search(samples, columns) if rule.stribeck else None
    columns = columns if search is None else search.columns
    known = samples_of(logs, rule.samples.taking_all()).used
    folds = Folds.of(samples, columns, rule.folds, known)
    information = folds.information()
    _check_enough(logs, information, samples, rule.samples)
    whiteness = whiteness_of(residuals_of(samples, columns, information.values), samples.recording)
    information = widened(information, inflation_of(whiteness, arm.n))
    if search is None or columns.stribeck_velocity is None:
        return _SeenLogs(samples, information, folds, whiteness, search)
    information, sigma = with_unknown_speeds(samples, information)
    return _SeenLogs(samples, information, folds, whiteness, search, sigma)


def _commanded(logs: Sequence[JointLog], arm: Arm, rule: MotionRule, instruments: Sequence[JointLog]) -> _SeenLogs:
    columns = TorqueColumns(arm.chain, rule.friction)
    information, along = instrumental_information(logs, instruments, columns, float(np.max(rule.samples.slowest)))
    return _SeenLogs(along, information)


def _estimate(information: Information) -> Estimate:
    """With infinite errors where a parameter is not determined."""
    covariance = information.covariance.copy()
    covariance[np.diag_indices_from(covariance)] = np.square(information.sigma)
    return Estimate(information.values, covariance, np.zeros(0), information.dof)


def _check_enough(logs: Sequence[JointLog], information: Information, samples: Samples, rule: SampleRule) -> None:
    used, parameters = int(information.equations.sum()), information.base.count
    if information.dof > 0 and information.determined.any():
        return
    files = ", ".join(dict.fromkeys(log.source for log in logs))
    joints = information.columns.n
    found = f"{used} equations for {parameters} parameters of {joints} joints"
    needed = "a longer motion of every joint both ways, at changing speeds"
    if not samples.used.any() and not rule.moving(samples.dq).any() and np.ptp(samples.q, axis=0).max() > 1e-3:
        found = f"no joint is faster than --slowest {np.max(rule.slowest):g} (rad/s or m/s)"
        needed = f"a slowest far below the speeds of the log, which reach {np.abs(samples.dq).max():.3g}"
    raise LogError(files, f"columns q1..q{joints}", found, needed)
