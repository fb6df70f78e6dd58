"""Friction of the joints as functions of their speeds: with a jump at rest, and smooth."""

from typing import Any

import casadi

from lwr_dyn.codegen.emit.functions import UNITS, Argument, EmittedFunction
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import FRICTIONLESS, JointFriction

TEXT = {
    "friction_torque": "tau_f(dq), Coulomb, viscous and Stribeck friction per direction; at rest the offset alone",
    "smooth_friction_torque": "tau_f(dq) with tanh(dq / width) in place of the sign; at rest the offset alone",
}


def friction_function(spec: KernelSpec, name: str, arm: Arm) -> EmittedFunction:
    """The rows of `EMITTED`; raises `MissingDataError` for an arm without friction."""
    models = [model or FRICTIONLESS for model in arm.friction_models()]
    if all(model is FRICTIONLESS for model in models):
        raise MissingDataError(arm.name, "friction", name)
    is_smooth = name != "friction_torque"
    dq, width = casadi.SX.sym("dq", arm.n), casadi.SX.sym("width")
    speeds = casadi.vertsplit(dq)
    if is_smooth:
        rows = [_smooth(model, x, width) for model, x in zip(models, speeds, strict=True)]
    else:
        rows = [_jumping(model, x) for model, x in zip(models, speeds, strict=True)]
    arguments = [Argument("dq", arm.n, UNITS["dq"]), Argument("width", 1, "rad/s or m/s, above 0")]
    given = [dq, width] if is_smooth else [dq]
    function = casadi.Function(name, given, [casadi.densify(casadi.SX(casadi.vertcat(*rows)))])
    return EmittedFunction(name, TEXT[name], tuple(arguments[: len(given)]), (arm.n,), UNITS["tau"], function)


def _jumping(model: JointFriction, dq: Any) -> Any:
    """`JointFriction.torque`."""
    return model.offset + (dq > 0) * _level(model, 0, dq) - (dq < 0) * _level(model, 1, dq) + _viscous(model, dq)


def _smooth(model: JointFriction, dq: Any, width: Any) -> Any:
    """`model.friction.smooth_friction`."""
    level = casadi.if_else(dq > 0, _level(model, 0, dq), _level(model, 1, dq))
    return model.offset + level * casadi.tanh(dq / width) + _viscous(model, dq)


def _viscous(model: JointFriction, dq: Any) -> Any:
    up, down = model.positive.viscous, model.negative.viscous
    return down * dq + (up - down) * (dq > 0) * dq


def _level(model: JointFriction, side: int, dq: Any) -> Any:
    """Coulomb's level with Stribeck's curve, of one direction."""
    direction = (model.positive, model.negative)[side]
    drop, scale = direction.holding - direction.coulomb, direction.stribeck_velocity
    if scale is None or drop <= 0.0:
        return direction.coulomb
    return direction.coulomb + drop * casadi.exp(-((dq / scale) ** 2))
