"""A load as text for people and as a record for programs."""

from typing import Any

import numpy as np

from lwr_dyn.foundation.tables import aligned
from lwr_dyn.identification.friction.friction_tables import with_error
from lwr_dyn.identification.payload.identify_load import SYSTEMATIC, LoadIdentification
from lwr_dyn.identification.payload.load_columns import NAMES as LINEAR
from lwr_dyn.identification.payload.possible_load import NAMES, PossibleLoad

UNITS = ("kg", *("m",) * 3, *("kg m^2",) * 6)
SIGMAS = 3.0
STATES = {True: "identified", False: "not excited"}
"""A linear parameter is excited where its 3-sigma interval is below what a body of the load's mass can have."""
_ARM_LENGTH = 0.1
"""[m] The size of a hand-held load, which makes mass, first moment and tensor comparable."""


def load_text(found: LoadIdentification, load: PossibleLoad | None) -> str:
    """The body, how sure each of its numbers is, and the torques with and without it."""
    torques = [
        (str(j), *(f"{x:.4g}" for x in row), str(count))
        for j, (*row, count) in enumerate(
            zip(found.without, found.left, found.noise, found.slow, found.equations, strict=True), 1
        )
    ]
    lines = _body_lines(found, load) if load is not None else [
        f"no load found: torques give {with_error(float(found.parameters[0]), float(found.sigma[0]))} kg{_doubt(found)}"
    ]  # fmt: skip
    return "\n".join((
        *lines,
        f"positions filtered at {found.cutoff:g} Hz" if found.cutoff else "positions not filtered",
        f"taken as known: {found.known}" + (f"; fitted beside it: {_kinds(found)}" if found.nuisance else ""),
        *load_warnings(found),
        "",
        aligned(torques, ("joint", "RMS torque left without it", "with it", "noise", "in slow sums", "equations")),
    ))  # fmt: skip


def _body_lines(found: LoadIdentification, load: PossibleLoad) -> list[str]:
    rows = [
        (f"{name} [{unit}]", with_error(float(value), float(sigma)), state)
        for name, unit, value, sigma, state in zip(NAMES, UNITS, load.values, load.sigma, states(found), strict=True)
    ]
    return [
        f"load of {with_error(float(load.values[0]), float(load.sigma[0]))} kg{_doubt(found)}",
        aligned(rows, ("of the load", "value", "by the motion")),
        "com in the frame of the flange (of the tool's point where the arm has one), tensor about com along its axes",
        "by the motion: of the mass, m com and the tensor about that frame, which are what least squares determines",
        _about(load),
    ]


def _doubt(found: LoadIdentification) -> str:
    if not (found.systematic or found.share):
        return ""
    wide = f", its errors widened for an arm {found.share:.0%} off its table" if found.share else ""
    return f"; IN DOUBT: residuals are not noise alone{wide}"


def load_warnings(found: LoadIdentification) -> tuple[str, ...]:
    """Where the residual is not noise; the errors are too small then."""
    if not found.systematic:
        return ()
    joints = ", ".join(map(str, found.systematic))
    return (
        f"not noise alone: what is left at joint{'s' * (len(found.systematic) > 1)} {joints} is more than "
        f"{SYSTEMATIC:g} times larger in slow sums, so the true errors are larger too; the arm's table or its friction "
        "is off, and logs without the load take that out (--without)",
    )


def load_record(found: LoadIdentification, load: PossibleLoad | None, robot: str) -> dict[str, Any]:
    """The body, the least-squares parameters about the flange's origin, and the torques; no body without a load."""
    body = () if load is None else zip(NAMES, UNITS, load.values, load.sigma, strict=True)
    linear = zip(LINEAR, found.parameters, found.sigma, states(found), strict=True)
    joints = zip(found.without, found.left, found.noise, found.slow, found.equations, strict=True)
    return {
        "robot": robot, "found": found.found, "known": found.known, "cutoff": found.cutoff,
        "fitted_beside": list(found.nuisance),
        "load": [{"name": n, "unit": u, "value": v, "standard_error": s} for n, u, v, s in body],
        "weight": None if load is None else load.weight, "price": None if load is None else load.price,
        "least_squares_is_a_body": load is not None and load.was_possible,
        "least_squares": [
            {"parameter": n, "value": v, "standard_error": s, "state": state} for n, v, s, state in linear
        ],
        "joints": [
            {"joint": j, "left_without": w, "left": left, "noise": noise, "in_slow_sums": slow, "equations": int(k)}
            for j, (w, left, noise, slow, k) in enumerate(joints, 1)
        ],
        "warnings": list(load_warnings(found)),
    }  # fmt: skip


def states(found: LoadIdentification) -> tuple[str, ...]:
    """Of each linear parameter: whether the motion shows it, by what a body of that mass and a hand's size can have."""
    mass = max(abs(float(found.parameters[0])), 3.0 * float(found.sigma[0]))
    size = mass * np.array([1.0, *(_ARM_LENGTH,) * 3, *(_ARM_LENGTH**2,) * 6])
    return tuple(STATES[bool(x)] for x in SIGMAS * found.sigma < size)


def _about(load: PossibleLoad) -> str:
    if load.was_possible:
        return f"least squares gives a body already; the ball of its mass moves it by a chi^2 of {load.price:.3g}"
    return (
        f"no body has what least squares gives; this one, {load.price:.3g} of chi^2 away, is near it and, where the "
        f"motion says little, near a solid ball of its mass (weight {load.weight:g})"
    )


def _kinds(found: LoadIdentification) -> str:
    kinds = dict.fromkeys(name.rsplit("_", 1)[0] for name in found.nuisance)
    return ", ".join(kinds) + " of the joints" if len(kinds) < 10 else f"{len(found.nuisance)} parameters of the arm"
