"""The simulated arm on symbols: its dynamics with smooth friction, its tip, and a step of RK4 under a held torque.

Sine and cosine of a stage's angles come by series from those of the start, which is near. Friction is a table (5, n),
rows as `kernel_spec.FRICTION`:

    tau_f = offset + F_c tanh(dq / width) + F_v dq,   F_c and F_v those of the direction of dq

as `model.friction.smooth_friction`. It has no stick: a joint under a load F below break-away creeps at about
width F / F_c.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any, NamedTuple

import casadi
import numpy as np

from lwr_dyn.codegen.kernels.symbolic_functions import scalars
from lwr_dyn.codegen.rollouts.symbolic_model import SymbolicAngle, SymbolicModel
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.friction import FRICTIONLESS, Direction, JointFriction, smooth_friction
from lwr_dyn.model.spatial import Vector, Z, multiply
from lwr_dyn.simulation.integrators import WEIGHTS
from lwr_dyn.simulation.setup import STABLE

LARGEST = 0.2
"""[rad] Largest change of an angle; the series then leaves 6e-16."""

_SINE = (-1 / 6, 1 / 120, -1 / 5040, 1 / 362880)

_COSINE = (-1 / 2, 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800)


def turned(angle: SymbolicAngle, by: Any) -> SymbolicAngle:
    """The angle and `by` [rad] more, of a size up to `LARGEST`, by the series of sin and cos - 1."""
    square = by * by
    sine = by + by * (square * _series(_SINE, square))
    less_one = square * _series(_COSINE, square)
    return SymbolicAngle(
        angle.cosine + (angle.cosine * less_one - angle.sine * sine),
        angle.sine + (angle.sine * less_one + angle.cosine * sine),
    )


def _series(coefficients: tuple[float, ...], x: Any) -> Any:
    total: Any = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        total = total * x + c
    return total


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


Column = Any
"""A casadi.SX column."""


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

    def positions(self, q: Column) -> list[Any]:
        """Sine and cosine of each angle; positions of sliding joints as they are."""
        return [
            SymbolicAngle.of(x) if frame.is_turning else x
            for frame, x in zip(self.model.frames, scalars(q), strict=True)
        ]

    def friction(self, dq: Column) -> Column:
        """Torque of friction, (n,)."""
        return casadi.SX.zeros(dq.numel()) if self.brake is None else self.brake(dq)

    def tip(self, positions: list[Any]) -> Vector:
        """Place of the tip in the base, from the flange inward."""
        frames, flange = self.model.frames, self.chain.flange.position
        own = frames[-1].link
        place = Vector.of(own.rotation @ flange + own.position)
        for frame, position in zip(reversed(frames), reversed(positions), strict=True):
            if frame.is_turning:
                c, s = position.cosine, position.sine
                x = multiply(c, place.x) - multiply(s, place.y)
                place = Vector(x, multiply(s, place.x) + multiply(c, place.y), place.z)
            else:
                place = place + Z.times(position)
            place = frame.turn @ place + frame.shift
        return place

    def moved(self, q: Column, dq: Column, tau: Column, h: float) -> Moved:
        """RK4 over h [s]; its stages are combinations of q, dq and four accelerations, as `integrators.held_rk4`."""
        start, lost = self.positions(q), casadi.SX(0.0)
        known: list[Column] = []
        for weight, speed, by in zip(WEIGHTS.tolist(), *self._stages(dq, known, h), strict=False):
            v = speed()
            resisted = self.friction(v)
            lost = lost + float(weight) * casadi.dot(resisted, v)
            known.append(self.model.forward_dynamics(_shifted(start, by()), v, tau - resisted))
        k1, k2, k3, k4 = known
        mean = k1 + k2 + k3
        return Moved(q + h * (dq + (h / 6) * mean), dq + (h / 6) * (k1 + 2 * (k2 + k3) + k4), -(h / 6) * lost)

    def _stages(self, dq: Column, k: list[Column], h: float) -> tuple[list[Any], list[Any]]:
        """Speed of each stage, and by how much its positions differ from the start's; None for the start itself."""
        half = h / 2
        speeds: list[Callable[[], Any]]
        speeds = [lambda: dq, lambda: dq + half * k[0], lambda: dq + half * k[1], lambda: dq + h * k[2]]
        return speeds, [lambda: None, lambda: half * dq, lambda: half * speeds[1](), lambda: h * speeds[2]()]


def _shifted(positions: list[Any], by: Column | None) -> list[Any]:
    if by is None:
        return positions
    return [
        turned(x, step) if isinstance(x, SymbolicAngle) else x + step
        for x, step in zip(positions, scalars(by), strict=True)
    ]
