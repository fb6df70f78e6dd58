"""What a kernel is made for: the arm's data that enter it, its inputs, its number type; and the digest of all that."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.codegen.functions import function_shape
from lwr_dyn.codegen.parameters import chosen_inputs, friction_parameters
from lwr_dyn.dynamics.recursion import Rotors
from lwr_dyn.errors import MissingDataError, OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain

GENERATOR = 2
"""Version of the generator: raised whenever the same arm gives another kernel, so that cached ones are not taken."""
NUMBER_TYPES = ("float64", "float32")
FRICTIONS = ("none", "arm")


@dataclass(frozen=True, slots=True, eq=False)
class Form:
    """An arm with the choices that a family of kernels is made by."""

    name: str
    chain: Chain
    friction: Array | None
    """(5, n) as constants, None without friction (or with friction as an input)."""
    inputs: tuple[str, ...] = ()
    rotors: Rotors = "armature"
    dtype: str = "float64"

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.chain.n

    def parameters_of(self, function: str) -> tuple[str, ...]:
        """The inputs of this form that enter a function, in order."""
        return tuple(name for name in self.inputs if name in function_shape(function).parameters)

    def digest(self, function: str) -> str:
        """SHA-256 over everything that the kernel of a function is traced from."""
        text = [f"generator {GENERATOR}", function, self.dtype, str(self.rotors), *self.inputs]
        for link in self.chain.links:
            text.append(link.kind.value)
            rotor = (0.0, 0.0) if link.rotor is None else (link.rotor.gear_ratio, link.rotor.inertia)
            arrays = [link.before.matrix(), link.after.matrix(), np.array(rotor)]
            if link.body is not None:
                arrays += [np.array(link.body.mass), link.body.com, link.body.inertia_com]
            text += [np.asarray(a, dtype=np.float64).tobytes().hex() for a in arrays]
        rest = [self.chain.flange.matrix(), self.chain.gravity]
        rest += [] if self.friction is None else [self.friction]
        text += [np.asarray(a, dtype=np.float64).tobytes().hex() for a in rest]
        return hashlib.sha256("\n".join(text).encode()).hexdigest()


def form_of(
    arm: Arm,
    inputs: Iterable[str] = (),
    friction: str = "none",
    rotors: str = "armature",
    dtype: str = "float64",
) -> Form:
    """The form of an arm's kernels.

    Parameters
    ----------
    arm : Arm
    inputs : names out of inertia, payload, gravity, friction
        What a kernel takes as an input instead of the arm's constant.
    friction : {"none", "arm"}
        "arm" adds the arm's own friction (Coulomb and viscous per direction, offset) to inverse and takes it from
        forward dynamics.
    rotors : {"armature", "full", "none"}
    dtype : {"float64", "float32"}

    Raises
    ------
    OptionError
        A choice that does not exist, or the arm's friction has a Stribeck curve, which kernels do not know.
    MissingDataError
        The arm has no inertias, or no friction with friction="arm".
    """
    chosen = chosen_inputs(inputs)
    for option, value, allowed in (
        ("friction", friction, FRICTIONS),
        ("rotors", rotors, ("armature", "full", "none")),
        ("dtype", str(dtype), NUMBER_TYPES),
    ):
        if value not in allowed:
            raise OptionError(option, repr(value), ", ".join(allowed))
    if friction == "arm" and "friction" in chosen:
        raise OptionError("friction", "'arm' and an input", "one of them")
    if friction == "arm" and not any(arm.friction_models()):
        raise MissingDataError(arm.name, "friction", "kernels with friction='arm'")
    constants = friction_parameters(arm) if friction == "arm" else None
    name = f"{arm.name} ({arm.reading})"
    return Form(name, arm.require_dynamics(), constants, chosen, rotors, str(dtype))  # type: ignore[arg-type]
