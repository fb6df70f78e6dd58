"""Derivatives along a direction, made from emitted functions by forward mode: f'(x) v, in about three times f's work.

Of forward dynamics, the pose of the flange and smooth friction: what an FMU needs for its directional derivatives.
"""

from collections.abc import Iterator
from dataclasses import replace

import casadi

from lwr_dyn.codegen.emit.emission import EmittedArm
from lwr_dyn.codegen.emit.functions import Argument, EmittedFunction, emitted_code

ALONG = {
    "forward_dynamics": ("q", "dq", "tau"), "flange_pose": ("q",), "smooth_friction_torque": ("dq",),
}  # fmt: skip
"""Function -> the arguments in whose directions it is differentiated."""


def with_tangents(emitted: EmittedArm) -> EmittedArm:
    """The same with `NAME_tangent` for each of its functions that `ALONG` has."""
    made = [emitted_code(one, emitted.kind, emitted.dtype) for one in tangents(emitted)]
    return replace(emitted, codes=(*emitted.codes, *made))


def tangents(emitted: EmittedArm) -> Iterator[EmittedFunction]:
    """The derivatives of the functions, which have the directions as further arguments: `q_along`, ...

    >>> import lwr_dyn
    >>> from lwr_dyn.codegen.emit.emission import emitted_arm
    >>> (made,) = tangents(emitted_arm(lwr_dyn.load("lwr4plus"), ["flange_pose"]))
    >>> made.name, [argument.name for argument in made.arguments]
    ('flange_pose_tangent', ['q', 'q_along'])
    """
    for function in (code.function for code in emitted.codes):
        if function.name in ALONG:
            yield _tangent(function)


def _tangent(function: EmittedFunction) -> EmittedFunction:
    name, moved = f"{function.name}_tangent", ALONG[function.name]
    at = {a.name: casadi.SX.sym(a.name, a.width) for a in function.arguments}
    along = {x: casadi.SX.sym(f"{x}_along", at[x].size1()) for x in moved}
    value = casadi.SX(function.symbolic(*at.values()))
    slope = casadi.jtimes(value, casadi.vertcat(*(at[x] for x in moved)), casadi.vertcat(*along.values()))
    directions = [replace(a, name=f"{a.name}_along") for a in function.arguments if a.name in moved]
    symbolic = casadi.Function(name, [*at.values(), *along.values()], [casadi.densify(slope)])
    arguments: tuple[Argument, ...] = (*function.arguments, *directions)
    text = f"derivative of {function.name} along the directions of {', '.join(moved)}"
    return EmittedFunction(name, text, arguments, function.shape, function.unit, symbolic)
