"""The torque with two velocities of Slotine and Li on symbols, and its power by parameters that a law adds.

    B(q) ddq_r + C(q, dq) dq_r + g(q) = tau(q, (dq + dq_r)/2, ddq_r) - tau_0(q, (dq - dq_r)/2, 0)

with tau the torque of inverse dynamics and tau_0 without gravity: C dq is quadratic in dq, its polar form is C(q, u) w
(`feedback.slotine_li_regressor`). Rotors count as armature ddq_r.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi
import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.axis_frames import axis_frames
from lwr_dyn.codegen.kernels.parameters import in_parent_frame
from lwr_dyn.codegen.kernels.symbolic_dynamics import scalars
from lwr_dyn.codegen.rollouts.symbolic_model import KeptParameters, SymbolicModel
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.vectors import add

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


@dataclass(frozen=True, slots=True, eq=False)
class AddedBodies:
    """What parameters theta (m,) of a law add to the bodies of its model: `matrix` theta, at `places` (p,) of 10 n.

    `matrix` is (p, m), numbers; a place is 10 times the link plus that in `codegen.parameters.PER_LINK`, in the frames
    of the joints' axes.
    """

    n: int
    places: NDArray[np.intp]
    matrix: Array

    @classmethod
    def load(cls, chain: Chain) -> "AddedBodies":
        """The ten of what is fixed to the last link, in the frame of its joint."""
        shift = axis_frames(chain)[-1].link.position - chain.links[-1].after.position
        rows = [in_parent_frame(list(unit), np.eye(3), shift) for unit in np.eye(10)]
        return cls(chain.n, np.arange(10 * chain.n - 10, 10 * chain.n), np.array(rows, dtype=np.float64).T)

    @classmethod
    def combined(cls, chain: Chain, W: Array) -> "AddedBodies":
        """W theta (10 n,), W (10 n, m), in the frames of the joints, by the parameters on which a torque depends."""
        kept, to_link = KeptParameters.of(chain), np.zeros((10 * chain.n, 10 * chain.n))
        for i, link in enumerate(chain.links):
            back = link.after.inverse()
            rows = [in_parent_frame(list(unit), back.rotation, back.position) for unit in np.eye(10)]
            to_link[10 * i : 10 * i + 10, 10 * i : 10 * i + 10] = np.array(rows, dtype=np.float64).T
        return cls(chain.n, kept.kept, np.asarray(kept.matrix @ to_link @ W))

    def bodies(self, values: Any) -> list[list[Any]]:
        """Ten parameters a body from those at the places, a casadi column (p,); all others are a literal 0.0."""
        out: list[list[Any]] = [[0.0] * 10 for _ in range(self.n)]
        for place, value in zip(self.places.tolist(), scalars(values), strict=True):
            out[place // 10][place % 10] = value
        return out

    def torque(self, model: SymbolicModel, at: Sliding, theta: Any) -> Any:
        """B ddq_r + C(q, dq) dq_r + g with theta added, (n,) [N m]."""
        added = self.bodies(casadi.mtimes(self._constants, theta))
        both = [[add(a, b) for a, b in zip(*pair, strict=True)] for pair in zip(model.bodies, added, strict=True)]
        return _polar(model, both, at)

    def power(self, model: SymbolicModel, at: Sliding) -> Any:
        """The power of that torque at the speeds s, by each of theta, (m,); it is linear in them."""
        values = casadi.SX.sym("values", len(self.places))
        bare = SymbolicModel(model.frames, [], [0.0] * model.n, model.pull)
        power = casadi.dot(at.s, _polar(bare, self.bodies(values), at))
        slope = casadi.substitute(casadi.gradient(power, values), values, casadi.DM.zeros(len(self.places)))
        return casadi.mtimes(self._constants.T, slope)

    @property
    def _constants(self) -> Any:
        return casadi.sparsify(casadi.DM(self.matrix))


def _polar(model: SymbolicModel, bodies: Bodies, at: Sliding) -> Any:
    half = 0.5 * (at.dq + at.dq_r)
    return model.torque(bodies, at.q, half, at.ddq_r) - model.torque(bodies, at.q, half - at.dq_r, None, gravity=False)
