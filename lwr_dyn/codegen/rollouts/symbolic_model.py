"""An arm's dynamics on symbols: the lean recursion on bodies that are constants, base parameters or symbols.

A plant and a law each have one. Joint vectors are casadi columns or sequences of scalars.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import casadi
import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels import lean_recursion as lean
from lwr_dyn.codegen.kernels.kernel_spec import in_parent_frame, inertial_parameters
from lwr_dyn.codegen.kernels.lean_recursion import AxisFrame, axis_frames, base_matrix, parameter_map
from lwr_dyn.codegen.kernels.symbolic_functions import column, ldl_factor, ldl_solve, scalars
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.spatial import ZERO, Vector, add, multiply


@dataclass(frozen=True, eq=False)
class KeptParameters:
    """The inertial parameters of a chain on which its torque depends, in the frames of its joints' axes."""

    chain: Chain
    frames: tuple[AxisFrame, ...]

    @staticmethod
    @lru_cache(maxsize=32)
    def of(chain: Chain) -> "KeptParameters":
        """With the frames of the chain; the same object for the same chain."""
        return KeptParameters(chain, axis_frames(chain))

    @cached_property
    def matrix(self) -> Array:
        """(kept, 10 n): inertial parameters of the links in their own frames, flat -> those that are kept."""
        return np.ascontiguousarray(self._whole[self.kept])

    @cached_property
    def kept(self) -> NDArray[np.intp]:
        """Places of the kept ones among 10 n, ascending."""
        return np.flatnonzero(self._whole.any(axis=1))

    @cached_property
    def _whole(self) -> Array:
        return np.asarray(base_matrix(self.frames, self.chain.gravity) @ parameter_map(self.frames))

    @cached_property
    def payload_matrix(self) -> Array:
        """(kept, 10): inertial parameters of a load in the flange frame -> what it adds to the kept ones."""
        flange, n = self.chain.flange, self.chain.n
        moved = [in_parent_frame(list(unit), flange.rotation, flange.position) for unit in np.eye(10)]
        return np.asarray(self.matrix[:, 10 * (n - 1) :] @ np.array(moved, dtype=np.float64).T)

    @cached_property
    def own(self) -> Array:
        """Those of the chain itself, (kept,)."""
        return np.asarray(self.matrix @ inertial_parameters(self.chain).ravel())

    def bodies(self, values: Any) -> list[list[Any]]:
        """The ten parameters of each body from the kept ones, numbers or symbols; all others are a literal 0.0."""
        out: list[list[Any]] = [[0.0] * 10 for _ in range(self.chain.n)]
        for place, value in zip(self.kept.tolist(), values, strict=True):
            out[place // 10][place % 10] = value
        return out


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicAngle:
    """An angle by its cosine and sine, as NumPy's `cos` and `sin` take it."""

    cosine: Any
    sine: Any

    @classmethod
    def of(cls, angle: Any) -> "SymbolicAngle":
        """Of a symbol."""
        return cls(casadi.cos(angle), casadi.sin(angle))

    def cos(self) -> Any:
        """The cosine."""
        return self.cosine

    def sin(self) -> Any:
        """The sine."""
        return self.sine


@dataclass(frozen=True, eq=False)
class SymbolicModel:
    """Dynamics on symbols with rotors as armature, without friction."""

    frames: tuple[AxisFrame, ...]
    bodies: Sequence[Sequence[Any]]
    """Ten parameters a body in `frames`, ordered as `kernel_spec.PER_LINK`; numbers or symbols."""
    armature: Sequence[Any]
    """Of each joint [kg m^2], numbers or symbols."""
    pull: Vector
    """The vector of gravity [m/s^2]."""

    @classmethod
    def of(cls, chain: Chain, values: Any = None, armature: Any = None) -> "SymbolicModel":
        """Of a chain: its own constants, or symbols for the kept `KeptParameters` and for the armature."""
        base = KeptParameters.of(chain)
        bodies = base.bodies(base.own.tolist() if values is None else _each(values))
        return cls(
            base.frames,
            bodies,
            armature_of(chain).tolist() if armature is None else _each(armature),
            Vector.of(chain.gravity),
        )

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.frames)

    def inverse_dynamics(self, q: Any, dq: Any, ddq: Any) -> Any:
        """B ddq + C dq + g as a column; None for a joint vector of zeros."""
        return self.torque(self.bodies, q, dq, ddq)

    def gravity_vector(self, q: Any) -> Any:
        """g(q) as a column."""
        return self.torque(self.bodies, q, None, None)

    def torque(self, bodies: Sequence[Sequence[Any]], q: Any, dq: Any, ddq: Any, gravity: bool = True) -> Any:
        """As `inverse_dynamics` of other bodies (see `bodies`), with the rotors of this model."""
        dq, ddq = ([0.0] * self.n if x is None else _each(x) for x in (dq, ddq))
        pull = self.pull if gravity else ZERO
        tau = lean.inverse_dynamics(self.frames, bodies, pull, self._positions(q), dq, ddq)
        return column([add(a, multiply(j, b)) for a, j, b in zip(tau, self.armature, ddq, strict=True)])

    def mass_matrix(self, q: Any) -> list[list[Any]]:
        """B(q) with rotors, as rows of scalars."""
        B = lean.mass_matrix(self.frames, self.bodies, self._positions(q))
        for i, armature in enumerate(self.armature):
            B[i][i] = add(B[i][i], armature)
        return B

    def forward_dynamics(self, q: Any, dq: Any, tau: Any) -> Any:
        """ddq = B^-1 (tau - C dq - g) as a column, pivots from the last joint first."""
        B = casadi.vertcat(*(column(row).T for row in self.mass_matrix(q)))
        return ldl_solve(ldl_factor(B), tau - self.torque(self.bodies, q, dq, None))

    def _positions(self, q: Any) -> list[Any]:
        """Angles as `SymbolicAngle`, unless they are given so; positions of sliding joints as they are."""
        return [
            SymbolicAngle.of(x) if frame.is_turning and not isinstance(x, SymbolicAngle) else x
            for frame, x in zip(self.frames, _each(q), strict=True)
        ]


def armature_of(chain: Chain) -> Array:
    """Gear ratio^2 times the rotor's inertia of each joint, (n,) [kg m^2]; 0 without a rotor."""
    rotors = [link.rotor for link in chain.links]
    return np.array([0.0 if rotor is None else rotor.gear_ratio**2 * rotor.inertia for rotor in rotors])


def _each(vector: Any) -> list[Any]:
    """The scalars of a casadi column or of any sequence."""
    return list(scalars(vector)) if hasattr(vector, "numel") else list(vector)
