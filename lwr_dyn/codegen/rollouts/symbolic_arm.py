"""An arm on symbols: its dynamics, as a law or a plant knows it, and the plant's friction, tip and step of RK4.

The bodies of the lean recursion are constants, base parameters or symbols; joint vectors are casadi columns or
sequences of scalars. Sine and cosine of a stage's angles come by series from those of the start, which is near.
Friction is a table (5, n), rows as `kernel_spec.FRICTION`:

    tau_f = offset + F_c tanh(dq / width) + F_v dq,   F_c and F_v those of the direction of dq

as `model.friction.smooth_friction`. It has no stick: a joint under a load F below break-away creeps at about
width F / F_c.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil
from typing import Any, NamedTuple

import casadi
import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels import lean_recursion as lean
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters, to_parent
from lwr_dyn.codegen.kernels.lean_recursion import AxisFrame, Turn
from lwr_dyn.codegen.kernels.symbolic_functions import column, ldl_factor, ldl_solve, scalars
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.model.spatial import ZERO, Vector, Z, add, multiply
from lwr_dyn.simulation.arm_friction import braking_rate
from lwr_dyn.simulation.integrators import WEIGHTS
from lwr_dyn.simulation.setup import STABLE

Column = Any
"""A casadi.SX column."""


@dataclass(frozen=True, eq=False)
class KeptParameters:
    """The inertial parameters of a chain on which its torque depends, in the frames of its joints' axes."""

    chain: Chain
    frames: tuple[AxisFrame, ...]

    @staticmethod
    @lru_cache(maxsize=32)
    def of(chain: Chain) -> "KeptParameters":
        """With the frames of the chain; the same object for the same chain."""
        return KeptParameters(chain, lean.axis_frames(chain))

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
        return np.asarray(lean.base_matrix(self.frames, self.chain.gravity) @ lean.parameter_map(self.frames))

    @cached_property
    def payload_matrix(self) -> Array:
        """(kept, 10): inertial parameters of a load in the flange frame -> what it adds to the kept ones."""
        return np.asarray(self.matrix[:, 10 * (self.chain.n - 1) :] @ to_parent(self.chain.flange))

    @cached_property
    def own(self) -> Array:
        """Those of the chain itself, (kept,)."""
        return np.asarray(self.matrix @ inertial_parameters(self.chain).ravel())


def placed_bodies(n: int, places: NDArray[np.intp], values: Any) -> list[list[Any]]:
    """The ten parameters of each body, with values at some places among 10 n; all others are a literal 0.0."""
    out: list[list[Any]] = [[0.0] * 10 for _ in range(n)]
    for place, value in zip(places.tolist(), values, strict=True):
        out[place // 10][place % 10] = value
    return out


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
        bodies = placed_bodies(chain.n, base.kept, base.own.tolist() if values is None else _each(values))
        rotors = chain.armature.tolist() if armature is None else _each(armature)
        return cls(base.frames, bodies, rotors, Vector.of(chain.gravity))

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
        tau = lean.inverse_dynamics(self.frames, bodies, pull, self.positions(q), dq, ddq)
        return column([add(a, multiply(j, b)) for a, j, b in zip(tau, self.armature, ddq, strict=True)])

    def mass_matrix(self, q: Any) -> list[list[Any]]:
        """B(q) with rotors, as rows of scalars."""
        B = lean.mass_matrix(self.frames, self.bodies, self.positions(q))
        for i, armature in enumerate(self.armature):
            B[i][i] = add(B[i][i], armature)
        return B

    def forward_dynamics(self, q: Any, dq: Any, tau: Any) -> Any:
        """ddq = B^-1 (tau - C dq - g) as a column, pivots from the last joint first."""
        B = casadi.vertcat(*(column(row).T for row in self.mass_matrix(q)))
        return ldl_solve(ldl_factor(B), tau - self.torque(self.bodies, q, dq, None))

    def positions(self, q: Any) -> list[Any]:
        """Angles by cosine and sine, unless they are given so; positions of sliding joints as they are."""
        return [
            Turn(casadi.cos(x), casadi.sin(x)) if frame.is_turning and not isinstance(x, Turn) else x
            for frame, x in zip(self.frames, _each(q), strict=True)
        ]


def _each(vector: Any) -> list[Any]:
    """The scalars of a casadi column or of any sequence."""
    return list(scalars(vector)) if hasattr(vector, "numel") else list(vector)


LARGEST = 0.2
"""[rad] Largest change of an angle; the series then leaves 6e-16."""

_SINE = (-1 / 6, 1 / 120, -1 / 5040, 1 / 362880)

_COSINE = (-1 / 2, 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800)


def turned(angle: Turn, by: Any) -> Turn:
    """The angle and `by` [rad] more, of a size up to `LARGEST`, by the series of sin and cos - 1."""
    square = by * by
    sine = by + by * (square * _series(_SINE, square))
    less_one = square * _series(_COSINE, square)
    c, s = angle.c, angle.s
    return Turn(c + (c * less_one - s * sine), s + (s * less_one + c * sine))


def _series(coefficients: tuple[float, ...], x: Any) -> Any:
    total: Any = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        total = total * x + c
    return total


def friction_column(dq: Any, table: Any, width: Any) -> Any:
    """tau_f (n,) as a casadi column, of the speeds (n,) and a table (5 n,) in C order."""
    positive_coulomb, positive_viscous, negative_coulomb, negative_viscous, offset = casadi.vertsplit(
        casadi.SX(table), dq.numel()
    )
    forward = dq > 0
    level = casadi.if_else(forward, positive_coulomb, negative_coulomb)
    slope = casadi.if_else(forward, positive_viscous, negative_viscous)
    return offset + level * casadi.tanh(dq / width) + slope * dq


def friction_models(table: Array) -> tuple[JointFriction, ...]:
    """The friction of each joint from a table (5, n); raises `OptionError` for a Coulomb level below 0."""
    return tuple(
        JointFriction(Direction(float(a), float(b)), Direction(float(c), float(d)), float(e))
        for a, b, c, d, e in table.T
    )


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
    coulomb, viscous = (np.maximum(tables[..., i, :], tables[..., i + 2, :]) for i in range(2))
    if (tables[..., (0, 2), :] < 0.0).any():
        raise OptionError("friction", f"a Coulomb level of {tables[..., (0, 2), :].min():.4g}", "0 or more")
    rates = np.atleast_1d(braking_rate(B, np.maximum(viscous + coulomb / width, 0.0)))
    worst, step = int(np.argmax(rates)), 1.0 / (rate * substeps)
    if rates[worst] * step > STABLE:
        need = ceil(rates[worst] / rate / STABLE)
        fault = f"smooth, brakes at up to {rates[worst]:.4g} 1/s (run {worst}), too fast for RK4 steps of {step:.3g} s"
        raise OptionError("friction", fault, f"substeps from {need} on, or a larger friction_width")
    return rates


class Moved(NamedTuple):
    """The state (n,) after a step, and the work of friction in it [J]."""

    q: Column
    dq: Column
    friction_work: Any


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicPlant:
    """The plant with a law of friction, None for no friction."""

    chain: Chain
    model: SymbolicModel
    brake: Callable[[Column], Column] | None

    @classmethod
    def of(cls, chain: Chain, x: Mapping[str, Column], varies: bool, friction_width: float | None) -> "SymbolicPlant":
        """With the slots `x` of `step.CONSTANTS`: armature, kept parameters where they vary, friction."""
        model = SymbolicModel.of(chain, x["plant"] if varies else None, x["armature"])
        if friction_width is None:
            return cls(chain, model, None)
        return cls(chain, model, lambda dq: friction_column(dq, x["friction"], friction_width))

    def friction(self, dq: Column) -> Column:
        """Torque of friction, (n,)."""
        return casadi.SX.zeros(dq.numel()) if self.brake is None else self.brake(dq)

    def tip(self, q: Column) -> Vector:
        """Place of the tip in the base, from the flange inward."""
        frames, flange = self.model.frames, self.chain.flange.position
        own = frames[-1].link
        place = Vector.of(own.rotation @ flange + own.position)
        for frame, position in zip(reversed(frames), reversed(self.model.positions(q)), strict=True):
            place = position.ahead(place) if frame.is_turning else place + Z.times(position)
            place = frame.turn @ place + frame.shift
        return place

    def moved(self, q: Column, dq: Column, tau: Column, h: float) -> Moved:
        """RK4 over h [s]; its stages are combinations of q, dq and four accelerations, as `integrators.held_rk4`."""
        start = positions = self.model.positions(q)
        lost, v = casadi.SX(0.0), dq
        known: list[Column] = []
        for weight, ahead in zip(WEIGHTS.tolist(), (h / 2, h / 2, h, 0.0), strict=True):
            resisted = self.friction(v)
            lost = lost + float(weight) * casadi.dot(resisted, v)
            known.append(self.model.forward_dynamics(positions, v, tau - resisted))
            steps, v = scalars(ahead * v), dq + ahead * known[-1]
            positions = [turned(x, by) if isinstance(x, Turn) else x + by for x, by in zip(start, steps, strict=True)]
        k1, k2, k3, k4 = known
        mean = k1 + k2 + k3
        return Moved(q + h * (dq + (h / 6) * mean), dq + (h / 6) * (k1 + 2 * (k2 + k3) + k4), -(h / 6) * lost)
