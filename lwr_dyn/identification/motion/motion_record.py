"""A fit to any motion as a record for programs."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from lwr_dyn.identification.bodies.possible_bodies import BodyVerdict
from lwr_dyn.identification.motion.motion_fit import MotionIdentification
from lwr_dyn.identification.motion.motion_tables import NOISE_MODEL, body_lines
from lwr_dyn.identification.motion.residuals import Whiteness
from lwr_dyn.identification.motion.validation import Validation
from lwr_dyn.identification.regression.least_squares import IDENTIFIED


def motion_record(result: MotionIdentification, robot: str) -> dict[str, Any]:
    """Base parameters, which are identified, bodies that have them, the arm's own values, and the validation."""
    information = result.information
    rows = zip(
        result.base.statements(), information.values, information.sigma, result.half_widths, result.of_the_model,
        result.states, strict=True,
    )  # fmt: skip
    return {
        "robot": robot, "equations": result.equations, "condition": result.condition,
        "base_parameters": result.base.count, "identified": result.identified, "noise_model": NOISE_MODEL,
        "noise": information.residual_noise, "inflation": information.inflation,
        "chi2": information.chi2, "dof": information.dof,
        "bodies": _bodies_record(result.bodies),
        "parameters": [
            {
                "parameter": s, "value": v, "standard_error": error, "three_sigma": half, "of_the_model": own,
                "identified": state == IDENTIFIED, "state": state,
            }
            for s, v, error, half, own, state in rows
        ],
        "stribeck_velocity": None if result.stribeck is None else result.stribeck.speeds,
        "stribeck_velocity_error": result.stribeck_sigma,
        "together": [{"parameters": list(g.members), "largest_correlation": g.largest} for g in result.groups],
        "missing_motions": [asdict(motion) for motion in result.missing_motions()],
        "consistent": _consistent_record(result),
        "folds": result.rule.folds,
        "validation": validation_record(result.validation),
        "whiteness": [_whiteness_record(w) for w in result.whiteness],
    }  # fmt: skip


def validation_record(validation: Sequence[Validation]) -> list[dict[str, Any]]:
    """One object a joint."""
    return [asdict(v) for v in validation]


def _bodies_record(bodies: BodyVerdict) -> dict[str, Any]:
    matrix = bodies.mass_matrix
    return {
        "impossible": bodies.impossible,
        "negative_parameters": [{**asdict(n), "noise_can_explain": n.noise_can_explain} for n in bodies.negative],
        "mass_matrix": None if matrix is None else asdict(matrix),
        "text": body_lines(bodies),
    }


def _consistent_record(result: MotionIdentification) -> dict[str, Any] | None:
    fit = result.consistent
    if fit is None:
        return None
    own = result.columns.own(result.arm)
    rows = zip(result.columns.names, fit.parameters, fit.sigma, own, result.origins, strict=True)
    return {
        "deviation": fit.deviation, "deviation_chosen": fit.chosen,
        "price_chi2": fit.price.chi2, "price_rms": fit.price.rms,
        "physical": [bool(x) for x in fit.physical], "lifted": list(fit.lifted), "known": list(fit.constraints),
        "iterations": fit.iterations,
        "parameters": [
            {"parameter": name, "value": v, "standard_error": error, "of_the_model": mine, "says": origin}
            for name, v, error, mine, origin in rows
        ],
    }  # fmt: skip


def _whiteness_record(w: Whiteness) -> dict[str, Any]:
    return {
        "joint": w.joint, "white": w.white, "probability": w.probability, "inflation": w.inflation,
        "autocorrelation": w.autocorrelation,
    }  # fmt: skip
