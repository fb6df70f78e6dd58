"""Kernel forms of the laws of Slotine and Li: adaptive (a load or all links, with friction if adapted), and robust.

Their torque with two velocities, and its power by parameters that a law adds:

    B(q) ddq_r + C(q, dq) dq_r + g(q) = tau(q, (dq + dq_r)/2, ddq_r) - tau_0(q, (dq - dq_r)/2, 0)

with tau the torque of inverse dynamics and tau_0 without gravity: C dq is quadratic in dq, its polar form is C(q, u) w
(`control.laws.adaptive`). Rotors count as armature ddq_r. The controllers get the same from Pinocchio's regressor, of
numbers alone: hence two texts, compared by `law_forms.check_form`.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from lwr_dyn.codegen.kernels.kernel_spec import to_parent
from lwr_dyn.codegen.kernels.lean_recursion import axis_frames
from lwr_dyn.codegen.kernels.symbolic_functions import scalars
from lwr_dyn.codegen.rollouts.law_forms import LawInputs, finite_limits
from lwr_dyn.codegen.rollouts.symbolic_arm import Column, KeptParameters, SymbolicModel, placed_bodies
from lwr_dyn.control.laws import adaptive
from lwr_dyn.control.laws.robust import Robust
from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.spatial import Pose, add

Bodies = Sequence[Sequence[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Sliding:
    """A state with two velocities, s = dq - dq_r and a = ddq_r - k s, as columns (n,)."""

    q: Any
    dq: Any
    dq_r: Any
    s: Any
    a: Any

    @classmethod
    def of(cls, x: LawInputs, omega_n: Any) -> "Sliding":
        """Of what a law is given, with Lambda = k = omega_n."""
        return cls(x.q, x.dq, *adaptive.sliding(omega_n, x.q, x.dq, x.q_ref, x.dq_ref, x.ddq_ref))


@dataclass(frozen=True, slots=True, eq=False)
class AddedBodies:
    """What parameters theta (m,) of a law add to the bodies of its model: `matrix` theta, at `places` (p,) of 10 n.

    `matrix` is (p, m), numbers; a place is 10 times the link plus that in `kernel_spec.PER_LINK`, in the frames
    of the joints' axes.
    """

    n: int
    places: NDArray[np.intp]
    matrix: Array

    @classmethod
    def load(cls, chain: Chain) -> "AddedBodies":
        """The ten of what is fixed to the last link, in the frame of its joint."""
        shift = axis_frames(chain)[-1].link.position - chain.links[-1].after.position
        return cls(chain.n, np.arange(10 * chain.n - 10, 10 * chain.n), to_parent(Pose(np.eye(3), shift)))

    @classmethod
    def combined(cls, chain: Chain, W: Array) -> "AddedBodies":
        """W theta (10 n,), W (10 n, m), in the frames of the joints, by the parameters on which a torque depends."""
        kept = KeptParameters.of(chain)
        to_link = block_diag(*(to_parent(link.after.inverse()) for link in chain.links))
        return cls(chain.n, kept.kept, np.asarray(kept.matrix @ to_link @ W))

    def bodies(self, values: Any) -> list[list[Any]]:
        """Ten parameters a body from those at the places, a casadi column (p,)."""
        return placed_bodies(self.n, self.places, scalars(values))

    def torque(self, model: SymbolicModel, at: Sliding, theta: Any) -> Any:
        """B a + C(q, dq) dq_r + g with theta added, (n,) [N m]."""
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
    return model.torque(bodies, at.q, half, at.a) - model.torque(bodies, at.q, half - at.dq_r, None, gravity=False)


LOAD = len(adaptive.PER_LINK)


@dataclass(frozen=True, slots=True, eq=False)
class AdaptiveForm:
    """The law of `control.laws.adaptive`; the adapted parameters are its memory.

    A sampled run needs no rule for rates at a bound: the memory is cut at its bounds after each sample.
    """

    law: adaptive.Adaptive
    added: AddedBodies
    takes = adaptive.Adaptive
    name = adaptive.Adaptive.name

    @classmethod
    def of(cls, law: adaptive.Adaptive, arm: Arm) -> "AdaptiveForm":
        """The form of a controller."""
        W = law.adapted.W
        return cls(law, AddedBodies.load(arm.chain) if W is None else AddedBodies.combined(arm.chain, W))

    @property
    def bodies(self) -> int:
        """Number of parameters of bodies; those of friction follow."""
        return int(self.law.adapted.gains.size)

    @property
    def adapts_friction(self) -> bool:
        """Whether friction is adapted."""
        return self.law.friction_gains is not None

    @property
    def memory(self) -> int:
        """The parameters of the load or of all links, then Coulomb, then viscous friction."""
        return self.law.memory_size

    @property
    def parameters(self) -> Mapping[str, tuple[int, ...]]:
        """omega_n [1/s], gains and bounds of what is adapted, the friction at the start, the limits that it knows."""
        n, bodies = self.added.n, (self.bodies,)
        of_friction = {"friction_gains": (2, n), "friction_start": (2, n)} if self.adapts_friction else {}
        bounds = {"lower_load": bodies, "upper_load": bodies}
        return {"omega_n": (), "adaptation_gains": bodies, **bounds, **of_friction, "law_effort": (n,)}

    @property
    def digest(self) -> str:
        """The variant, and what its parameters add to which parameters of the bodies."""
        added = hashlib.sha256(self.added.places.tobytes() + self.added.matrix.tobytes()).hexdigest()
        return f"{self.name} friction={self.adapts_friction} width={adaptive.FRICTION_WIDTH!r} bodies={added}"

    def values(self) -> Mapping[str, Array]:
        """The controller's gains, bounds and limits."""
        law, adapted = self.law, self.law.adapted
        values: dict[str, Any] = {
            "omega_n": np.array(law.omega_n),
            "adaptation_gains": adapted.gains,
            "lower_load": adapted.lower,
            "upper_load": adapted.upper,
            "law_effort": finite_limits(law._effort),
        }
        if self.adapts_friction:
            values["friction_gains"] = np.asarray(law.friction_gains)
            values["friction_start"] = np.array([law._coulomb, law._viscous])
        return values

    def start(self) -> Array:
        """Nothing is added to the arm's own parameters."""
        return np.zeros(self.memory)

    def torque(self, model: SymbolicModel, x: LawInputs) -> tuple[Column, Column]:
        """See `LawForm`."""
        p, at = x.parameters, Sliding.of(x, x.parameters["omega_n"])
        tau, slope = self.added.torque(model, at, x.memory[: self.bodies]), self.added.power(model, at)
        gains, lower, upper = p["adaptation_gains"], p["lower_load"], p["upper_load"]
        if self.adapts_friction:
            shape = casadi.tanh(x.dq_ref / adaptive.FRICTION_WIDTH)
            coulomb, viscous = casadi.vertsplit(p["friction_start"] + x.memory[self.bodies :], self.added.n)
            tau = tau + coulomb * shape + viscous * at.dq_r
            slope = casadi.vertcat(slope, shape * at.s, at.dq_r * at.s)
            gains = casadi.vertcat(gains, p["friction_gains"])
            lower = casadi.vertcat(lower, -p["friction_start"])
            upper = casadi.vertcat(upper, p["law_effort"], p["law_effort"])
        moves = 1 - (casadi.mmax(casadi.fabs(tau) - p["law_effort"]) > 0)
        moved = x.memory - x.h * (moves * gains * slope)
        return tau, casadi.fmin(casadi.fmax(moved, lower), upper)

    def signals(self, memory: Array) -> Mapping[str, Array]:
        """What the law tells of itself at samples whose memory was `memory` (k, m): as `Adaptive.signals`."""
        adapted, first, n = self.law.adapted, self.bodies, self.added.n
        of_bodies = memory[:, :first]
        shown = {f"adapted_{adapted.name}": adapted.link_parameters(of_bodies)}
        if self.adapts_friction:
            for i, name in enumerate(("coulomb", "viscous")):
                part = slice(first + i * n, first + (i + 1) * n)
                shown[f"adapted_{name}"] = self.values()["friction_start"][i] + memory[:, part]
        return shown

    def controller(self, arm: Arm, values: Mapping[str, Array]) -> Controller:
        """See `LawForm`."""
        v = {name: np.array(value) for name, value in values.items()}
        gains, lower, upper = (v[name] for name in ("adaptation_gains", "lower_load", "upper_load"))
        adapted = replace(self.law.adapted, gains=gains, lower=lower, upper=upper)
        friction = (v["friction_gains"], v["friction_start"]) if self.adapts_friction else (None, None)
        return adaptive.Adaptive(
            adaptive.SlotineLiRegressor(arm), dynamics_of(arm), float(v["omega_n"]), adapted,
            friction[0], v["law_effort"], friction[1],
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class RobustForm:
    """The law of `control.laws.robust`: the load in the middle of its set and the robust term are one load."""

    law: Robust
    middle: Array
    """(10,) The load that the law takes for granted, in the frame of the last joint."""
    added: AddedBodies
    takes = Robust
    name = Robust.name
    memory = 0

    @classmethod
    def of(cls, law: Robust, arm: Arm) -> "RobustForm":
        """The form of a controller."""
        middle = (law._parameters - adaptive.SlotineLiRegressor(arm).parameters)[-LOAD:]
        return cls(law, middle, AddedBodies.load(arm.chain))

    @property
    def parameters(self) -> Mapping[str, tuple[int, ...]]:
        """omega_n [1/s], rho, layer [W], the scale H, and the load that the law takes for granted."""
        return {"omega_n": (), "rho": (), "layer": (), "scale": (LOAD,), "middle_load": (LOAD,)}

    @property
    def digest(self) -> str:
        """There is one variant."""
        return self.name

    def values(self) -> Mapping[str, Array]:
        """The controller's numbers."""
        law = self.law
        numbers = {name: np.array(getattr(law, name)) for name in ("omega_n", "rho", "layer", "scale")}
        return {**numbers, "middle_load": self.middle}

    def start(self) -> Array:
        """No memory."""
        return np.zeros(0)

    def torque(self, model: SymbolicModel, x: LawInputs) -> tuple[Column, Column]:
        """See `LawForm`."""
        p, at = x.parameters, Sliding.of(x, x.parameters["omega_n"])
        z = p["scale"] * self.added.power(model, at)
        size = casadi.fmax(casadi.sqrt(casadi.dot(z, z)), p["layer"])
        load = p["middle_load"] - (p["rho"] / size) * p["scale"] * z
        return self.added.torque(model, at, load), casadi.SX.zeros(0)

    def controller(self, arm: Arm, values: Mapping[str, Array]) -> Controller:
        """See `LawForm`."""
        v = {name: np.array(value) for name, value in values.items()}
        regressor = adaptive.SlotineLiRegressor(arm)
        regressor.parameters[-LOAD:] += v["middle_load"]
        numbers = (float(v["omega_n"]), v["scale"], float(v["rho"]), float(v["layer"]))
        return Robust(regressor, dynamics_of(arm), *numbers)
