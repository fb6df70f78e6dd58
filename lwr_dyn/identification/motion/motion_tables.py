"""A fit to any motion as tables and text for people: what is identified, what bodies have it, how it predicts.

A fit to any motion as a record for programs.
"""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.bodies.consistent import ConsistentFit
from lwr_dyn.identification.bodies.possible_bodies import CONFIGURATIONS, BodyVerdict
from lwr_dyn.identification.friction.identify_friction import with_error
from lwr_dyn.identification.motion.identifiable import FROM_BOTH, FROM_LOG, FROM_TABLE, MEANING
from lwr_dyn.identification.motion.motion_fit import MotionIdentification
from lwr_dyn.identification.motion.validation import LAGS, LEVEL, Validation, Whiteness
from lwr_dyn.identification.regression.least_squares import IDENTIFIED

NOISE_MODEL = (
    "the errors are those of noise, widened where residuals of neighbouring instants are alike; friction that the "
    "columns lack makes the true ones larger"
)

WITHOUT_PARTS = (
    "instrumental variables on unfiltered rows: no part of the motion was kept from the fit, and the price is that "
    "along the command; judge the fit on other logs with --validate"
)

_LONGEST = 48
"""Letters of a parameter in the table."""

_FEW = 5
"""Groups and motions that the text names."""


def motion_text(result: MotionIdentification) -> str:
    """What is identified and what cannot be, the parameters, bodies, then measured against predicted torques."""
    parts = [_head(result), *body_lines(result.bodies), parameter_table(result).text(), *_meanings(result)]
    parts += _stribeck(result) + _not_identified(result)
    if result.consistent is not None:
        parts += ["", *_consistent(result, result.consistent)]
    if not result.validation:
        return "\n".join([*parts, WITHOUT_PARTS])
    about = f"{result.rule.folds} parts of the motion, each kept from a fit in turn"
    parts += ["", validation_table(result.validation, about).text()]
    parts += whiteness_lines(result.whiteness)
    return "\n".join(parts)


def _head(result: MotionIdentification) -> str:
    head = (
        f"{result.identified} of {result.base.count} base parameters identified, from {result.equations} equations, "
        f"condition {result.condition:.3g}"
    )
    if (result.information.inflation > 1.0).any():
        head += "; sigma widened: residuals not white"
    return head + ("; NO BODIES CAN HAVE THESE VALUES" if result.bodies.impossible else "")


def parameter_table(result: MotionIdentification) -> Table:
    """One row a base parameter."""
    information = result.information
    rows = zip(
        result.base.statements(), information.values, information.sigma, result.of_the_model, result.states, strict=True
    )  # fmt: skip
    cells = [(short(s), _value(v, error), float(own), state) for s, v, error, own, state in rows]
    heads = ("parameter (SI)", "value", Heading("of the model", format=".5g"), "state")
    return Table("", heads, cells, f"value +- standard error; {NOISE_MODEL}")


def _value(value: float, error: float) -> str:
    return "-" if np.isinf(error) else with_error(value, error)


def _meanings(result: MotionIdentification) -> list[str]:
    return [f"{state}: {text}" for state, text in MEANING.items() if state in result.states]


def _stribeck(result: MotionIdentification) -> list[str]:
    found = result.stribeck
    if found is None:
        return []
    sigma = result.stribeck_sigma
    joints = [
        f"joint {j + 1} {v:.3g}" + (" (bound of the search)" if found.at_bound[j] else _spread(sigma, j))
        for j, v in enumerate(found.speeds)
        if np.isfinite(v)
    ]
    return [f"Stribeck speeds [rad/s, m/s]: {', '.join(joints) or 'no joint asks for one'}"]


def _spread(sigma: Array | None, joint: int) -> str:
    return "" if sigma is None else f" +- {sigma[joint]:.2g}"


def _not_identified(result: MotionIdentification) -> list[str]:
    names = result.base.statements()
    lines = [
        f"known only together (correlation {g.largest:+.3f}): {', '.join(short(names[i]) for i in g.members)}"
        for g in result.groups[:_FEW]
    ]
    short_names = [short(name) for name in names]
    motions = result.missing_motions() if result.identified < result.base.count else ()
    return [*lines, *(f"not identified yet: {motion.text(short_names)}" for motion in motions[:_FEW])]


def _consistent(result: MotionIdentification, fit: ConsistentFit) -> list[str]:
    """A line on the weight and the price, then a row a link."""
    chosen = "of most evidence" if fit.chosen else "as given"
    lines = [
        f"bodies near the table: {int(fit.physical.sum())} of {result.arm.n} links are bodies; deviation from the "
        f"table {fit.deviation:.2%} ({chosen}); price against least squares: chi^2 {fit.price.chi2:+.3g}, "
        f"{np.nanmax(fit.price.rms):.2g} N m (N) RMS at the worst joint"
    ]
    if fit.constraints:
        lines.append(f"known: {'; '.join(fit.constraints)}")
    if fit.lifted:
        lines.append(f"no body has the table's values of link {', '.join(map(str, fit.lifted))}: the nearest was taken")
    return [*lines, link_table(result, fit).text()]


def link_table(result: MotionIdentification, fit: ConsistentFit) -> Table:
    """One row a link of the consistent fit: mass, centre of mass, rotor, and how much of it the log says."""
    own, origins = result.columns.own(result.arm), result.origins
    rows = []
    for i in range(result.arm.n):
        cells = slice(len(INERTIAL) * i, len(INERTIAL) * (i + 1))
        found, sigma = fit.parameters[cells], fit.sigma[cells]
        rotor = int(result.columns.rotor_indices[i])
        counts = "/".join(str(origins[cells].count(word)) for word in (FROM_LOG, FROM_BOTH, FROM_TABLE))
        com = ", ".join(f"{x:.4g}" for x in found[1:4] / found[0])
        rotor_cell = with_error(fit.parameters[rotor], fit.sigma[rotor])
        rows.append((str(i + 1), with_error(found[0], sigma[0]), float(own[cells][0]), com, rotor_cell, counts))
    heads = (
        "link", Heading("mass", "kg"), Heading("of the model", "kg", ".5g"), Heading("centre of mass", "m"),
        Heading("rotor", "kg m^2"), "log/both/table",
    )  # fmt: skip
    return Table("", heads, rows, "log/both/table: of a link's ten numbers, how many each says more of")


def validation_table(validation: Sequence[Validation], about: str) -> Table:
    """One row a joint: RMS torques that are left."""
    rows = []
    for v in validation:
        cells = [v.measured, v.fitted, v.held_out, v.consistent, v.model]
        bands = " ".join(f"{band.left:.3g}" for band in v.by_speed)
        rows.append((str(v.joint), *(None if x is None or np.isnan(x) else x for x in cells), bands, v.left_out))
    words = ("RMS torque", "left, seen", "left, unseen", "by bodies", "by the model")
    figures = [Heading(word, format=".4g") for word in words]
    heads = [Heading("joint"), *figures, Heading("unseen, thirds of the speed, slow first"),
             Heading("unseen, left out", format=".3g")]  # fmt: skip
    return Table(f"validation, RMS in N m (N): {about}", heads, rows)


def whiteness_lines(whiteness: Sequence[Whiteness]) -> list[str]:
    """What the residuals of joints say that are not white."""
    coloured = [w for w in whiteness if not w.white]
    if not coloured:
        return [f"residuals: white at {LEVEL:.0%} over {LAGS} instants (Box, Pierce)"]
    parts = [f"joint {w.joint} (lag 1 {w.autocorrelation[0]:+.2f}, errors x {w.inflation:.2g})" for w in coloured]
    return [f"residuals: not white at {LEVEL:.0%} (Box, Pierce): {', '.join(parts)}"]


def body_lines(bodies: BodyVerdict) -> list[str]:
    """What shows that no bodies can have the values, each with the links or joint; empty if nothing does."""
    lines = [
        f"impossible: {short(n.parameter)} = {n.value:.5g} +- {n.three_sigma:.2g} (99.73 %), never below 0 "
        f"for any bodies ({_numbered('link', n.links)}); {_cause(n.noise_can_explain)}"
        for n in bodies.negative
    ]
    m = bodies.mass_matrix
    if m is not None:
        q = ", ".join(f"{x:.4g}" for x in m.q)
        lines.append(
            f"impossible: B(q) is not positive definite at {m.share:.1%} of {CONFIGURATIONS} configurations; lowest "
            f"eigenvalue {m.lowest:.5g} at q = {q}, mostly joint {m.joint}; {_cause(m.noise_can_explain)}"
        )
    return lines


def _cause(noise_can_explain: bool) -> str:
    if noise_can_explain:
        return "noise can explain it: a longer or faster motion may mend it"
    return "noise cannot explain it: look at geometry, signs and units of the log"


def _numbered(noun: str, numbers: tuple[int, ...]) -> str:
    return f"{noun}{'s' if len(numbers) > 1 else ''} {', '.join(str(n) for n in numbers)}"


def short(statement: str) -> str:
    """The start of a long combination of parameters."""
    return statement if len(statement) <= _LONGEST else f"{statement[: _LONGEST - 3]}..."


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
