"""An arm's torque, mass matrix and potential energy on symbols: the lean recursion, traced.

Where inertial parameters are constants it is traced on base parameters. Rotors that enter completely ("full") add the
torque of the readable recursion on links without bodies.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from typing import Any

import casadi
import numpy as np

from lwr_dyn.codegen.kernels import lean_recursion as lean
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec, in_parent_frame, inertial_parameters
from lwr_dyn.codegen.kernels.lean_recursion import EXACT, AxisFrame, axis_frames, base_matrix, parameter_map
from lwr_dyn.dynamics.recursion import inverse_dynamics, link_constants
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.spatial import ZERO, Matrix3, Pose, Vector, add, multiply

Symbols = Any
"""A NumPy array of casadi.SX scalars."""


def column(scalars: Any) -> Any:
    """An array of scalars as one casadi column."""
    return casadi.vertcat(*(casadi.SX(x) for x in np.asarray(scalars, dtype=object).ravel()))


def scalars(vector: Any) -> Symbols:
    """A casadi column as an array of scalars."""
    out = np.empty(vector.numel(), dtype=object)
    out[:] = casadi.vertsplit(vector)
    return out


def _moved(parameters: Any, pose: Pose) -> list[Any]:
    """Inertial parameters (10,) of symbols in the parent of a frame with this pose, by numbers times each of them.

    As terms that cancel do not stand in it, single precision keeps its digits.
    """
    units = [in_parent_frame(list(unit), pose.rotation, pose.position) for unit in np.eye(10)]
    matrix = np.array(units, dtype=np.float64).T
    rows = np.where(np.abs(matrix) < EXACT, 0.0, matrix).tolist()
    return [reduce(add, map(multiply, parameters, row)) for row in rows]


@dataclass(frozen=True, eq=False)
class SymbolicDynamics:
    """The dynamics of one `KernelSpec` on symbols: joint vectors and inputs."""

    spec: KernelSpec
    q: Symbols
    dq: Symbols
    last: Symbols
    """ddq, or tau for forward dynamics."""
    inputs: dict[str, Symbols]
    """The inputs, flat."""
    frames: tuple[AxisFrame, ...]

    @classmethod
    def of(cls, spec: KernelSpec, q: Symbols, dq: Symbols, last: Symbols, inputs: dict[str, Symbols]) -> Any:
        """With the frames of the arm's joint axes."""
        return cls(spec, q, dq, last, inputs, axis_frames(spec.chain))

    def gravity(self) -> Vector:
        """The gravity vector, constant or input."""
        return Vector(*self.inputs["gravity"]) if "gravity" in self.inputs else Vector.of(self.spec.chain.gravity)

    def own(self, given: Any) -> list[list[Any]]:
        """Parameters in the links' frames, flat, as the lean recursion takes them."""
        rows = np.reshape(np.asarray(given, dtype=object), (self.spec.n, 10))
        return [_moved(row, frame.link) for frame, row in zip(self.frames, rows, strict=True)]

    def bodies(self, are_folded: bool = True) -> list[list[Any]]:
        """The ten parameters of each body: those of the inputs, or constants, folded into base parameters."""
        if "inertia" in self.inputs:
            bodies = self.own(self.inputs["inertia"])
        else:
            bodies = (self.folded if are_folded else self.constants).reshape(self.spec.n, 10).tolist()
        if "payload" in self.inputs:
            load = _moved(self.inputs["payload"], self.frames[-1].link @ self.spec.chain.flange)
            bodies[-1] = [add(a, b) for a, b in zip(bodies[-1], load, strict=True)]
        return bodies

    @cached_property
    def constants(self) -> Array:
        """The arm's inertial parameters in the frames of its joint axes, (10 n,)."""
        return np.asarray(parameter_map(self.frames) @ inertial_parameters(self.spec.chain).ravel())

    @cached_property
    def folded(self) -> Array:
        """The same as base parameters, (10 n,)."""
        gravity = None if "gravity" in self.inputs else self.spec.chain.gravity
        return np.asarray(base_matrix(self.frames, gravity) @ self.constants)

    def torque(self, dq: Any, ddq: Any, gravity: Vector | None = None) -> Any:
        """Torque of the bodies and rotors, as a column; None for a joint vector of zeros."""
        pull = self.gravity() if gravity is None else gravity
        dq, ddq = ([0.0] * self.spec.n if x is None else list(x) for x in (dq, ddq))
        bodies = lean.inverse_dynamics(self.frames, self.bodies(), pull, self._positions, dq, ddq)
        return column([add(a, b) for a, b in zip(bodies, self._rotors(dq, ddq), strict=True)])

    def mass_matrix(self) -> Any:
        """B, by composite bodies."""
        n = self.spec.n
        B = lean.mass_matrix(self.frames, self.bodies(), self._positions)
        for j in range(n):
            rotors = self._rotors([0.0] * n, [float(i == j) for i in range(n)])
            for i in range(n):
                B[i][j] = add(B[i][j], rotors[i])
        return casadi.vertcat(*(column(row).T for row in B))

    def potential_energy(self) -> Any:
        """U of the bodies."""
        return lean.potential_energy(self.frames, self.bodies(are_folded=False), self.gravity(), self._positions)

    def friction(self) -> Any:
        """Torque of friction, as a column: per direction F_c sign(dq) + F_v dq, plus the offset (`model.friction`)."""
        n = self.spec.n
        table = self.inputs.get("friction", self.spec.friction)
        if table is None:
            return casadi.SX.zeros(n)
        return column([_friction(x, *row) for x, row in zip(self.dq, np.reshape(table, (-1, n)).T, strict=True)])

    def applied(self, ddq: Any) -> Any:
        """Torque of the motors: of bodies and rotors, plus friction."""
        return self.torque(self.dq, ddq) + self.friction()

    @property
    def _positions(self) -> list[Any]:
        return [self.q[..., i] for i in range(self.spec.n)]  # as NumPy's cos takes symbols

    def _rotors(self, dq: Sequence[Any], ddq: Sequence[Any]) -> list[Any]:
        """Torques of the rotors alone."""
        links, rotors = link_constants(self.spec.chain), self.spec.rotors
        if rotors == "none":
            return [0.0] * len(links)
        if rotors == "armature":
            armature = (x.gear_ratio**2 * x.rotor_inertia for x in links)
            return [multiply(j, a) for j, a in zip(armature, ddq, strict=True)]
        bare = [replace(x, mass=0.0, com=ZERO, inertia=Matrix3(ZERO, ZERO, ZERO)) for x in links]
        return inverse_dynamics(bare, ZERO, self._positions, dq, ddq, rotors)


def _friction(dq: Any, c_up: Any, v_up: Any, c_down: Any, v_down: Any, offset: Any) -> Any:
    """Friction torque of one moving joint: `up` towards positive, `down` towards negative values."""
    up, down = dq > 0, dq < 0
    return offset + c_up * up - c_down * down + v_down * dq + (v_up - v_down) * up * dq
