"""The simulated arm on symbols: its dynamics with friction, its tip, and a step of RK4 under a held torque."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi

from lwr_dyn.codegen.kernels.symbolic_dynamics import scalars
from lwr_dyn.codegen.rollouts.small_turn import turned
from lwr_dyn.codegen.rollouts.smooth_friction import friction_column
from lwr_dyn.codegen.rollouts.symbolic_model import SymbolicAngle, SymbolicModel
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.vectors import Vector, Z, multiply
from lwr_dyn.simulation.integrators import WEIGHTS

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
        """With the slots `x` of `rollout.slots.CONSTANTS`: armature, kept parameters where they vary, friction."""
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
