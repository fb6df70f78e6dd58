"""A fit to any motion as text for people and a record for programs: what is identified, and what no bodies can have."""

from dataclasses import asdict
from typing import Any

from lwr_dyn.identification.bodies.possible_bodies import CONFIGURATIONS, BodyVerdict
from lwr_dyn.identification.friction.friction_tables import with_error
from lwr_dyn.identification.motion.motion_fit import MotionIdentification
from lwr_dyn.identification.regression.least_squares import IDENTIFIED, NO_ERROR, NOT_EXCITED, SIGMAS, ZERO
from lwr_dyn.tables import aligned

NOISE_MODEL = (
    "the errors are those of white noise: filtered or correlated noise, friction that the model lacks, and "
    "accelerations that jump inside a smoothing window (--window) make the true ones larger"
)
MEANING = {
    IDENTIFIED: f"|value| above {SIGMAS:g} sigma (Student's t of 99.73 %)",
    NOT_EXCITED: f"nor is the model's own value above {SIGMAS:g} sigma: this motion cannot separate it from 0",
    ZERO: f"within {SIGMAS:g} sigma of 0, and the model's own value is not, or is 0",
    NO_ERROR: "as many equations as parameters",
}
"""What the states of a parameter mean."""
_LONGEST = 48
"""Letters of a parameter in the table."""


def motion_record(result: MotionIdentification, robot: str) -> dict[str, Any]:
    """Base parameters, which of them are identified, their values from the robot's own inertias, and the validation."""
    e = result.estimate
    rows = zip(
        result.base.statements(), e.values, e.standard_errors, e.half_widths, result.of_the_model, result.states,
        strict=True,
    )  # fmt: skip
    return {
        "robot": robot, "equations": result.equations, "condition": result.condition,
        "base_parameters": result.base.count, "identified": result.identified, "noise_model": NOISE_MODEL,
        "bodies": _bodies_record(result.bodies),
        "parameters": [
            {
                "parameter": s, "value": v, "standard_error": error, "three_sigma": half, "of_the_model": own,
                "identified": state == IDENTIFIED, "state": state,
            }
            for s, v, error, half, own, state in rows
        ],
        "validation": [asdict(v) for v in result.validation],
    }  # fmt: skip


def _bodies_record(bodies: BodyVerdict) -> dict[str, Any]:
    matrix = bodies.mass_matrix
    return {
        "impossible": bodies.impossible,
        "negative_parameters": [{**asdict(n), "noise_can_explain": n.noise_can_explain} for n in bodies.negative],
        "mass_matrix": None if matrix is None else asdict(matrix),
        "text": body_lines(bodies),
    }


def motion_text(result: MotionIdentification) -> str:
    """What is identified and what cannot be, the parameters by name, then measured against predicted torques."""
    e = result.estimate
    rows = zip(
        result.base.statements(), e.values, e.standard_errors, result.of_the_model, result.states, strict=True
    )  # fmt: skip
    named = [(_short(s), with_error(v, error), f"{own:.5g}", state) for s, v, error, own, state in rows]
    checked = [
        (str(v.joint), *(f"{x:.4g}" for x in (v.measured, v.fitted, v.held_out, v.model))) for v in result.validation
    ]
    head = (
        f"{result.identified} of {result.base.count} base parameters identified, from {result.equations} equations, "
        f"condition {result.condition:.3g}"
    )
    if result.bodies.impossible:
        head += "; NO BODIES CAN HAVE THESE VALUES"
    seen = [state for state in MEANING if state in result.states]
    return "\n".join(
        (
            head,
            *body_lines(result.bodies),
            aligned(named, ("parameter (SI)", "value", "of the model", "state")),
            *(f"{state}: {MEANING[state]}" for state in seen),
            f"value +- standard error; {NOISE_MODEL}",
            "",
            aligned(checked, ("joint", "RMS torque", "left, fitted time", "left, held-out time", "left by the model")),
        )
    )


def body_lines(bodies: BodyVerdict) -> list[str]:
    """What shows that no bodies can have the values, each with the links or joint; empty if nothing does."""
    lines = [
        f"impossible: {_short(n.parameter)} = {n.value:.5g} +- {n.three_sigma:.2g} (99.73 %), never below 0 "
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


def _short(statement: str) -> str:
    return statement if len(statement) <= _LONGEST else f"{statement[: _LONGEST - 3]}..."
