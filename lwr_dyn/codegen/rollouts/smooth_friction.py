"""Smooth friction of plant and laws on symbols, as tables (5, n), and how stiff it is for RK4.

    tau_f = offset + F_c tanh(dq / width) + F_v dq,   F_c and F_v those of the direction of dq

as `model.friction.smooth_friction`. It has no stick: a joint under a load F below break-away creeps at about
width F / F_c. Rows of a table are those of `codegen.parameters.FRICTION`.
"""

from collections.abc import Callable, Sequence
from math import ceil
from typing import Any

import casadi
import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.friction import FRICTIONLESS, Direction, JointFriction, smooth_friction
from lwr_dyn.simulation.options import STABLE

NAMES = ("coulomb", "viscous")


def friction_column(dq: Any, table: Any, width: Any) -> Any:
    """tau_f (n,) as a casadi column, of the speeds (n,) and a table (5 n,) in C order."""
    positive_coulomb, positive_viscous, negative_coulomb, negative_viscous, offset = casadi.vertsplit(
        casadi.SX(table), dq.numel()
    )
    forward = dq > 0
    level = casadi.if_else(forward, positive_coulomb, negative_coulomb)
    slope = casadi.if_else(forward, positive_viscous, negative_viscous)
    return offset + level * casadi.tanh(dq / width) + slope * dq


def friction_table(models: Sequence[JointFriction | None]) -> Array:
    """The friction of joints as a table (5, n); zero where it is unknown.

    Raises
    ------
    OptionError
        A joint whose friction falls along a Stribeck curve.
    """
    columns = []
    for i, model in enumerate(models, start=1):
        friction = model or FRICTIONLESS
        sides = (friction.positive, friction.negative)
        if any(side.stribeck_velocity is not None and side.holding > side.coulomb for side in sides):
            allowed = "in kernels Coulomb and viscous friction per direction, and an offset"
            raise OptionError(f"friction of joint {i}", "a Stribeck curve", allowed)
        columns.append([*(getattr(side, name) for side in sides for name in NAMES), friction.offset])
    return np.array(columns).T


def friction_models(table: Array) -> tuple[JointFriction, ...]:
    """The friction of each joint from a table (5, n); raises `OptionError` for a Coulomb level below 0."""
    return tuple(
        JointFriction(Direction(float(a), float(b)), Direction(float(c), float(d)), float(e))
        for a, b, c, d, e in table.T
    )


def friction_function(table: Array, width: float) -> Callable[[Array], Array]:
    """tau_f(dq) (n,) [N m] of a table (5, n), as `simulate` takes it; raises `OptionError` as `friction_models`."""
    return smooth_friction(friction_models(table), width)


def check_friction(B: Array, tables: Array, width: float, rate: float, substeps: int) -> Array:
    """The fastest rate at which friction brakes [1/s], (runs,): the largest eigenvalue of B^-1 diag(slope).

    Parameters
    ----------
    B : (n, n) or (runs, n, n) array
        Mass matrix where the runs begin.
    tables : (5, n) or (runs, 5, n) array
    width : float
        Of the tanh [rad/s or m/s], above 0.
    rate, substeps
        Samples a second [Hz], and steps of RK4 in each.

    Raises
    ------
    OptionError
        A width that is not above 0, a Coulomb level below 0; RK4's step is too long for a run: its motion would grow
        instead of coming to rest.
    """
    if not (np.isfinite(width) and width > 0.0):
        raise OptionError("friction_width", width, "a speed above 0")
    coulomb, viscous = (np.maximum(tables[..., i, :], tables[..., i + len(NAMES), :]) for i in range(len(NAMES)))
    if (tables[..., :: len(NAMES), :][..., :2, :] < 0.0).any():
        raise OptionError("friction", f"a Coulomb level of {tables[..., (0, 2), :].min():.4g}", "0 or more")
    root = np.sqrt(np.maximum(viscous + coulomb / width, 0.0))
    rates = np.linalg.eigvalsh(root[..., :, None] * np.linalg.inv(B) * root[..., None, :])[..., -1]
    rates = np.atleast_1d(rates)
    worst, step = int(np.argmax(rates)), 1.0 / (rate * substeps)
    if rates[worst] * step > STABLE:
        need = ceil(rates[worst] / rate / STABLE)
        fault = f"smooth, brakes at up to {rates[worst]:.4g} 1/s (run {worst}), too fast for RK4 steps of {step:.3g} s"
        raise OptionError("friction", fault, f"substeps from {need} on, or a larger friction_width")
    return np.asarray(rates)
