"""Identification from any motion: base parameters by least squares, bodies near the table, judged on other motions.

Beyond the paper, which needs constant velocities. Base parameters are combinations: other sets give the same torques.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.identification.bodies.body_prior import constraints_of
from lwr_dyn.identification.bodies.consistent import ConsistentFit, consistent_fit
from lwr_dyn.identification.bodies.possible_bodies import judge_bodies
from lwr_dyn.identification.logs.clock import on_even_clock
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.motion import validation
from lwr_dyn.identification.motion.gain_fit import NearTheTable, fit_gains
from lwr_dyn.identification.motion.identifiable import correlated_groups
from lwr_dyn.identification.motion.load_hint import load_hint
from lwr_dyn.identification.motion.motion_result import DEFAULT_MOTION, MotionIdentification, MotionRule
from lwr_dyn.identification.regression.coupled_motors import at_motors, motors_or_joints
from lwr_dyn.identification.regression.drive_gains import DriveGains
from lwr_dyn.identification.regression.information import Information, information_of, widened
from lwr_dyn.identification.regression.instrumental import instrumental_information
from lwr_dyn.identification.regression.least_squares import ROUNDING, Estimate
from lwr_dyn.identification.regression.load_friction import with_load_friction, with_moving_loads
from lwr_dyn.identification.regression.samples import SampleRule, Samples, sample_parts, samples_of
from lwr_dyn.identification.regression.stribeck import StribeckSearch, stribeck_search, with_unknown_speeds
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm


def identify_motion(
    logs: Iterable[JointLog], arm: Arm, rule: MotionRule = DEFAULT_MOTION, instruments: Sequence[JointLog] = ()
) -> MotionIdentification:
    """Inertial and friction parameters from recordings of any motion.

    Parameters
    ----------
    logs : iterable of JointLog
        Uneven rows are brought to an even clock.
    arm : Arm
        Gives the geometry; its masses are what the consistent fit stays near, where the logs do not say otherwise.
    instruments : sequence of JointLog, optional
        The motion that was commanded for each log: parameters are then those of instrumental variables on unfiltered
        rows (`instrumental_information`), and no part of the motion is kept from the fit.

    Raises
    ------
    LogError
        Uneven or too few rows, or a motion from which nothing can be had.
    OptionError, UnknownNameError
        More folds than instants; something known that is no equation between parameters; gains, friction with the load
        or coupled motors with instruments; coupled motors of an arm without.
    ConstraintError
        No bodies obey what is known; names the ones that contradict each other.
    MissingDataError
        Something is known of the bodies of an arm without masses.
    """
    several = [on_even_clock(log) for log in logs]
    if rule.cutoffs and not instruments:
        rule = replace(rule, samples=likeliest_samples(several, arm, rule))
    if not instruments:
        rule = _with_motors(several, arm, rule)
    seen = _by_command(several, instruments, arm, rule) if instruments else _filtered(several, arm, rule)
    columns = seen.information.columns
    own = columns.own(arm)
    constraints = constraints_of(rule.known, columns.names) if rule.known else None
    near_the_table = None
    if arm.chain.bodies is not None or rule.known:
        arm.require_dynamics()

        def near_the_table(found: Information, like: ConsistentFit | None = None) -> ConsistentFit:
            return consistent_fit(found, own, deviation=rule.deviation, like=like, constraints=constraints)

    seen, consistent, gains = _fitted(seen, rule.gains, near_the_table)
    information = seen.information
    if consistent is not None and columns.link_side:  # no torque shows rotors: they stay the table's, or none
        parameters = consistent.parameters.copy()
        parameters[columns.rotor_indices] = own[columns.rotor_indices]
        consistent = replace(consistent, parameters=parameters)
    of_the_model = columns.base().of(own)
    of_the_model[np.abs(of_the_model) < ROUNDING] = 0.0

    def again(found: Information) -> Array:
        assert consistent is not None
        return consistent_fit(found, own, like=consistent, constraints=constraints).parameters

    refit = None if consistent is None else again
    unseen = () if seen.folds is None else validation.cross_validation(seen.folds, information, own, refit)
    covariance = information.covariance.copy()
    covariance[np.diag_indices_from(covariance)] = np.square(information.sigma)  # infinite where not determined
    estimate = Estimate(information.values, covariance, np.zeros(0), information.dof)
    return MotionIdentification(
        arm, rule, seen.samples, information, consistent, of_the_model, unseen, seen.whiteness,
        correlated_groups(information), judge_bodies(arm, columns, estimate), seen.search, seen.search_sigma, gains,
        None if seen.folds is None else load_hint(seen.folds, information, lambda x: said_by(x)[0]),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _SeenLogs:
    """What logs say, and how well a fit predicts parts of them; without folds and whiteness for unfiltered ones."""

    samples: Samples
    information: Information
    folds: validation.Folds | None = None
    whiteness: tuple[validation.Whiteness, ...] = ()
    search: StribeckSearch | None = None
    search_sigma: Array | None = None

    @classmethod
    def of(cls, folds: validation.Folds, search: StribeckSearch | None) -> "_SeenLogs":
        """What folds of logs say, whose Stribeck speeds were searched or not."""
        information, whiteness, sigma = _with_speeds(folds)
        if folds.columns.carried is not None:
            information = with_moving_loads(folds.samples, information)
        return cls(folds.samples, information, folds, whiteness, search, sigma)


def _with_speeds(folds: validation.Folds) -> tuple[Information, tuple[validation.Whiteness, ...], Array | None]:
    """What folds of logs say where the loads that friction grows with are known, and the errors of Stribeck speeds."""
    information, whiteness = said_by(folds)
    if folds.columns.stribeck_velocity is None:
        return information, whiteness, None
    information, sigma = with_unknown_speeds(folds.samples, information)
    return information, whiteness, sigma


def _by_command(logs: Sequence[JointLog], commands: Sequence[JointLog], arm: Arm, rule: MotionRule) -> _SeenLogs:
    if rule.gains is not None:
        raise OptionError("gains", f"{rule.gains:g}", "none with instruments, which take unfiltered rows")
    if rule.load_friction:
        raise OptionError("load friction", "given", "none with instruments, which take columns of one motion")
    if rule.coupled:
        raise OptionError("coupled motors", "given", "none with instruments, which leave out what is slow by joints")
    columns = TorqueColumns(arm.chain, rule.friction, link_side=rule.samples.link_side)
    information, along = instrumental_information(logs, commands, columns, float(np.max(rule.samples.slowest)))
    return _SeenLogs(along, information)


def _fitted(
    seen: _SeenLogs, width: float | None, near_the_table: NearTheTable | None
) -> tuple[_SeenLogs, ConsistentFit | None, DriveGains | None]:
    """Bodies by logs whose gains are known, or known to a width: then with what logs say at the gains found."""
    if width is None or seen.folds is None:
        return seen, None if near_the_table is None else near_the_table(seen.information, None), None

    found = fit_gains(seen.folds, width, lambda folds: _with_speeds(folds)[0], near_the_table)
    seen = replace(_SeenLogs.of(found.folds, seen.search), information=found.information)
    return seen, found.bodies, found.gains


def _filtered(logs: Sequence[JointLog], arm: Arm, rule: MotionRule) -> _SeenLogs:
    samples = samples_of(logs, rule.samples)
    columns = rule.columns(arm)
    if rule.load_friction:
        columns = with_load_friction(samples, columns)
    search = stribeck_search(samples, columns) if rule.stribeck else None
    columns = columns if search is None else search.columns
    if search is not None and rule.load_friction:  # without the Stribeck terms the share was another
        columns = with_load_friction(samples, columns)
    known = samples_of(logs, rule.samples.taking_all()).used
    folds = validation.Folds.of(samples, columns, rule.folds, known)
    _check_enough(logs, folds.information(), samples, rule.samples)
    return _SeenLogs.of(folds, search)


def _with_motors(logs: Sequence[JointLog], arm: Arm, rule: MotionRule) -> MotionRule:
    """With columns of motors that turn several joints: where the rule asks for them, or leaves it open and logs do."""
    if rule.coupled and rule.samples.transmission is None:
        return replace(rule, samples=at_motors(rule.samples, arm))
    if rule.coupled is None and rule.gains is None and not rule.load_friction:
        return replace(rule, samples=motors_or_joints(rule.samples, logs, arm, rule.friction))
    return rule


def motion_information(
    logs: Sequence[JointLog], arm: Arm, rule: MotionRule = DEFAULT_MOTION
) -> tuple[Information, SampleRule]:
    """What logs say of the base parameters, as `identify_motion` takes it, and how instants were taken.

    Rotors and friction are those of the joints, whatever turns them.

    Raises `LogError` for uneven or too few rows.
    """
    samples = likeliest_samples(logs, arm, rule) if rule.cutoffs else rule.samples
    return _filtered(logs, arm, replace(rule, samples=samples)).information, samples


TRIED = 2000
"""Instants on which filters are tried, about: noise is known to 2 % then."""
GAIN = 0.02
"""Log likelihood of an equation, a fiftieth of the noise, by which a lower filter, or the log's own speeds, must be
better: a higher one keeps more of the motion."""


def likeliest_samples(logs: Sequence[JointLog], arm: Arm, rule: MotionRule) -> SampleRule:
    """Of filters on positions or on the log's own speeds, the one that leaves least of the torques, which none touches.

    Of n Gaussian groups of N_j equations with noise s_j the log likelihood is -sum N_j log s_j. Noise of accelerations
    does not only add to the torques' noise: errors in variables shrink inertias. Where no filter can be judged, that of
    `rule` stays.

    References
    ----------
    Fuller, Measurement Error Models (1987), section 1.1, for the shrinking.
    """
    columns = rule.columns(arm)
    seconds = sum(float(log.t[-1] - log.t[0]) for log in logs if log.t.size)
    spacing = max(rule.samples.spacing, seconds / TRIED)
    sources = (False, True) if all(log.dq is not None for log in logs) else (False,)
    best, least = rule.samples, np.inf
    for cutoff in sorted(rule.cutoffs, reverse=True):
        for own in sources:
            tried = replace(rule.samples, cutoff=cutoff, own_speeds=own)
            try:
                found = information_of(sample_parts(logs, replace(tried, spacing=spacing)), columns)
            except LogError:
                continue
            seen = found.equations > 0
            if found.dof > 0 and (noise := _mean_log(found.noise[seen], found.equations[seen])) < least - GAIN:
                best, least = tried, noise
    return best


def _mean_log(noise: Array, equations: NDArray[np.intp]) -> float:
    return float(equations @ np.log(noise) / equations.sum())


def said_by(folds: validation.Folds) -> tuple[Information, tuple[validation.Whiteness, ...]]:
    """What folds of a log say together, its errors widened by all that lasts longer than an instant.

    By the correlation of residuals, joint by joint, and then by what leaving a fold out moves.
    """
    samples, columns, information = folds.samples, folds.columns, folds.information()
    residuals = validation.residuals_of(samples, columns, information.values)
    whiteness = validation.whiteness_of(residuals, samples.recording, information.paid)
    information = widened(information, validation.inflation_of(whiteness, columns.n))
    return widened(information, np.full(columns.n, folds.inflation(information))), whiteness


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
