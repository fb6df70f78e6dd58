"""The torque with two velocities of Slotine and Li on symbols, and its power by the parameters of a load.

    B(q) ddq_r + C(q, dq) dq_r + g(q) = tau(q, (dq + dq_r)/2, ddq_r) - tau_0(q, (dq - dq_r)/2, 0)

with tau the torque of inverse dynamics and tau_0 without gravity: C dq is quadratic in dq, its polar form is C(q, u) w
(`feedback.slotine_li_regressor`). Rotors count as armature ddq_r.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi
import numpy as np

from lwr_dyn.codegen.axis_frames import axis_frames
from lwr_dyn.codegen.parameters import in_parent_frame
from lwr_dyn.codegen.symbolic_dynamics import scalars
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.vectors import add
from lwr_dyn.rollout.symbolic_model import SymbolicModel

Bodies = Sequence[Sequence[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Sliding:
    """A state with two velocities, as columns (n,)."""

    q: Any
    dq: Any
    dq_r: Any
    ddq_r: Any

    @property
    def s(self) -> Any:
        """s = dq - dq_r."""
        return self.dq - self.dq_r

    @classmethod
    def of(cls, x: Any, omega_n: Any) -> "Sliding":
        """dq_r = dq_ref + Lambda (q_ref - q) and ddq_r - k s, with Lambda = k = omega_n, of `LawInputs`."""
        dq_r = x.dq_ref + omega_n * (x.q_ref - x.q)
        return cls(x.q, x.dq, dq_r, x.ddq_ref + omega_n * (x.dq_ref - x.dq - (x.dq - dq_r)))


def torque(model: SymbolicModel, at: Sliding, load: Any = None) -> Any:
    """B ddq_r + C(q, dq) dq_r + g, (n,) [N m].

    `load` (10,) is added to the parameters of the last link, in the frame of its joint's axis (`load_in_axis`).
    """
    bodies = list(model.bodies)
    if load is not None:
        bodies[-1] = [add(a, b) for a, b in zip(bodies[-1], scalars(load), strict=True)]
    return _polar(model, bodies, at, at.ddq_r)


def load_power(model: SymbolicModel, at: Sliding) -> Any:
    """The power at the speeds s of that torque, by each parameter of a load, (10,)."""
    load = casadi.SX.sym("load", 10)
    nothing: list[list[Any]] = [[0.0] * 10 for _ in range(model.n - 1)]
    bare = SymbolicModel(model.frames, [], [0.0] * model.n, model.pull)
    power = casadi.dot(at.s, _polar(bare, [*nothing, list(scalars(load))], at, at.ddq_r))
    return casadi.substitute(casadi.gradient(power, load), load, casadi.DM.zeros(10))  # it is linear in them


def load_in_axis(chain: Chain) -> Any:
    """The matrix (10, 10) from parameters in the frame of the last joint to those in the frame of its axis."""
    shift = axis_frames(chain)[-1].link.position - chain.links[-1].after.position
    rows = [in_parent_frame(list(unit), np.eye(3), shift) for unit in np.eye(10)]
    return np.array(rows, dtype=np.float64).T


def _polar(model: SymbolicModel, bodies: Bodies, at: Sliding, ddq_r: Any) -> Any:
    half = 0.5 * (at.dq + at.dq_r)
    return model.torque(bodies, at.q, half, ddq_r) - model.torque(bodies, at.q, half - at.dq_r, None, gravity=False)
