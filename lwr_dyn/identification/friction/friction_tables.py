"""The result of an identification as tables for people and records for programs."""

from dataclasses import asdict
from typing import Any

import numpy as np

from lwr_dyn.foundation.tables import aligned
from lwr_dyn.identification.friction.direction_fit import NAMES, DirectionFit
from lwr_dyn.identification.friction.identify_friction import FitOptions, FrictionIdentification

_UNITS = {"coulomb": "N m", "viscous": "N m s/rad", "static": "N m", "stribeck_velocity": "rad/s"}


def friction_record(
    result: FrictionIdentification, options: FitOptions, robot: str | None, subtract: str
) -> dict[str, Any]:
    """Fits, map and faults."""
    return {
        "robot": robot, "subtracted": subtract, "model": options.model, "robust": options.robust,
        "weights": "equal" if options.equal_weights else "samples", "rule": asdict(options.rule),
        "fits": [_fit_record(fit, result) for fit in result.fits],
        "map": [asdict(point) for point in result.points],
        "faults": [str(fault) for fault in result.faults],
    }  # fmt: skip


def _fit_record(fit: DirectionFit, result: FrictionIdentification) -> dict[str, Any]:
    e = fit.estimate
    parameters = {
        name: {
            "value": e.values[i], "standard_error": e.standard_errors[i], "three_sigma": e.half_widths[i],
            "unit": _UNITS[name], "bias_of_averaging": None if fit.bias is None else fit.bias[i],
        }
        for i, name in enumerate(fit.names)
    }  # fmt: skip
    return {
        "joint": fit.joint, "direction": "positive" if fit.sign > 0 else "negative", "parameters": parameters,
        "residual_rms": e.rms, "speeds": [fit.slowest, fit.fastest], "cruises": int(e.residuals.size), "dof": e.dof,
    }  # fmt: skip


def friction_text(result: FrictionIdentification, options: FitOptions, subtract: str) -> str:
    """One row a joint and direction, and what averaging does to it."""
    names = NAMES[options.model]
    head = ("joint", "way", *(f"{n} [{_UNITS[n]}]" for n in names), "RMS [N m]", "speeds [rad/s]", "cruises")
    files = len({p.source for p in result.points})
    loss = "Huber's loss" if options.robust else "least squares"
    lines = [f"{len(result.points)} cruises in {files} files, {loss}, taken out of the torques: {_taken(subtract)}"]
    if result.fits:
        lines.append(aligned([_row(fit) for fit in result.fits], head))
        lines.append(
            "value +- standard error; magnitudes against the motion; an offset raises one way, lowers the other"
        )
    lines += _bias_lines(result, subtract)
    return "\n".join(lines)


def _taken(subtract: str) -> str:
    return {"none": "nothing", "gravity": "g", "inertia": "B ddq + C dq", "all": "B ddq + C dq + g"}[subtract]


def _row(fit: DirectionFit) -> tuple[str, ...]:
    e = fit.estimate
    cells = [with_error(v, s) for v, s in zip(e.values, e.standard_errors, strict=True)]
    speeds = f"{fit.slowest:.4g} to {fit.fastest:.4g}"
    return (str(fit.joint), "+" if fit.sign > 0 else "-", *cells, f"{e.rms:.3g}", speeds, str(e.residuals.size))


def with_error(value: float, error: float) -> str:
    """`value +- standard error`."""
    return f"{value:.5g}" + (" (no error: as many cruises as parameters)" if np.isnan(error) else f" +- {error:.2g}")


def _bias_lines(result: FrictionIdentification, subtract: str) -> list[str]:
    known = [p for p in result.points if p.inertia is not None]
    if not known:
        return []
    worst = max(known, key=lambda p: abs(p.inertia or 0.0))
    sentence = (
        f"the mean of B ddq + C dq over a cruise is at most {abs(worst.inertia or 0.0):.3g} N m (joint {worst.joint})"
    )
    if subtract in ("inertia", "all"):
        return [f"{sentence}; it is taken out"]
    biases = [
        (abs(float(b)), f"{name} of joint {fit.joint}{'+' if fit.sign > 0 else '-'}")
        for fit in result.fits
        if fit.bias is not None
        for b, name in zip(fit.bias, fit.names, strict=True)
    ]
    if biases:
        size, where = max(biases)
        sentence += f"; left in, it moves a parameter by at most {size:.3g} ({where})"
    return [f"{sentence}; --subtract all takes it out"]
