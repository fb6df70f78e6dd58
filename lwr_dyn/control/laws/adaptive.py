"""The adaptive law of Slotine and Li: the load's parameters, and friction if asked for, are learnt while tracking.

    tau = Y(q, dq, dq_r, a) (pi + W theta) + armature a + tau_f,   a = ddq_r - k s
    dq_r = dq_ref + Lambda (q_ref - q),   s = dq - dq_r,   dtheta/dt = -Gamma W^T Y^T s
    tau_f = F_c tanh(dq_ref / width) + F_v dq_r,  dF_c/dt = -gamma_c s tanh(dq_ref / width),  dF_v/dt = -gamma_v s dq_r

Y is the Slotine-Li regressor, pi the parameters of the arm's model, Lambda and k [1/s] numbers, here the same. The
term -k s in a makes the damping K_D = k B_hat(q), B_hat the mass matrix with the parameters as they are. F_c and F_v
start at the arm's friction, 0 where that is unknown. A parameter at its bound does not move beyond it (projection),
and none moves while a torque is at its limit.

Stability
---------
Continuous time, rigid arm, true parameters inside the bounds, no torque at its limit, no friction, or viscous friction
that is adapted: V = s^T B s / 2 + theta_err^T Gamma^-1 theta_err / 2, B the true mass matrix and theta_err with the
error of friction, has dV/dt = -k s^T B s - s^T F_v s, so the error of the motion goes to zero and the parameters stay
bounded. They need not become the true ones: that takes a motion that excites all of them. K_D = k B_hat keeps the poles
where the arm turns light.

Not covered by it: dry friction (F_c follows tanh of the reference speed, not the sign of dq; what is left near
turning points stays as an error); any friction without `adapt_friction`: it is charged to the load; sampling, where
V rises by terms of order T^2 a step, and the gain of the adaptation is bounded by the rate; delay and encoder noise,
against which the bounds keep the parameters; torque limits; elastic joints, which bear about half of the gain that a
fixed law does. Near rest `linear_feedback` judges these, with the adaptation in it.

Source: Slotine, Li, "On the adaptive control of robot manipulators", Int. J. Robotics Research 6(3) (1987), eqs. 9 to
13; Siciliano et al., section 8.5.4.

Regressor
---------
Torques with two velocities are linear in the inertial parameters too.

    Y(q, dq, dq_r, ddq_r) pi = B(q) ddq_r + C(q, dq) dq_r + g(q)        (rotors left out)

C is the Christoffel matrix, so that C(q, u) w is symmetric in u and w, and h(v) = C(q, v) v is quadratic in v:
C(q, u) w = h((u + w)/2) - h((u - w)/2). Both the torque and its regressor follow from functions of one velocity:

    Y(q, u, w, a) = Y(q, (u + w)/2, a) - Y_0(q, (u - w)/2, 0),    Y_0 without gravity.

Columns are ten a link in the frame of its joint, as Pinocchio has them: (m, m c_x, m c_y, m c_z, I_xx, I_xy, I_yy,
I_xz, I_yz, I_zz) about the origin of the frame [kg, kg m, kg m^2]; the last ten take whatever is fixed to the flange.

Adapted are the ten parameters of what the flange carries, or those of all links. Gains are scaled by the unit of the
parameter: g for a mass [kg], g (0.1 m)^2 for a first moment [kg m], g (0.1 m)^4 for a second moment [kg m^2]. One gain
for all ten makes the second moments, whose torques are small, ruin the loop.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Self

import numpy as np

from lwr_dyn.control.gains import OMEGA_N, LinearFeedback, NaturalFrequency
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import FRICTIONLESS
from lwr_dyn.model.inertial_parameters import parameter_turns

PER_LINK = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""The parameters of a link, in the order of the columns."""


def sliding(omega_n: Any, q: Any, dq: Any, q_ref: Any, dq_ref: Any, ddq_ref: Any) -> tuple[Any, Any, Any]:
    """dq_r, s and a (n,) each, with Lambda = k = omega_n; of arrays, or of columns of symbols."""
    dq_r = dq_ref + omega_n * (q_ref - q)
    s = dq - dq_r
    return dq_r, s, ddq_ref + omega_n * (dq_ref - dq - s)


class SlotineLiRegressor:
    """Y (n, 10 n) and torque (n,) [N m] of single states (n,), unchecked, for loops; see this module.

    `parameters` (10 n,) are the arm's own, `armature` (n,) the rotors, which stand outside of Y. Raises
    `MissingDataError`: the arm has no inertias.
    """

    def __init__(self, arm: Arm) -> None:
        weightless = arm.with_chain(replace(arm.chain, gravity=np.zeros(3)))
        with_gravity, without = (ungated(dynamics_of(one)) for one in (arm, weightless))
        raw: Any = with_gravity
        self.n, self.armature = arm.n, np.array(arm.armature)
        self.parameters = np.concatenate([body.toDynamicParameters() for body in raw.model.inertias[1:]])
        self._columns, self._columns_0 = raw.torque_regressor, getattr(without, "torque_regressor")  # noqa: B009
        self._torque, self._torque_0 = with_gravity.inverse_dynamics, without.bias_torque
        self._still = np.zeros(arm.n)

    def __call__(self, q: Array, dq: Array, dq_r: Array, ddq_r: Array) -> Array:
        """Y (n, 10 n): the torque per unit of each parameter."""
        half = 0.5 * (dq + dq_r)
        Y: Array = self._columns(q, half, ddq_r)
        Y -= self._columns_0(q, half - dq_r, self._still)
        return Y.reshape(self.n, -1)  # Pinocchio's of one joint is flat

    def torque(self, q: Array, dq: Array, dq_r: Array, ddq_r: Array) -> Array:
        """B ddq_r + C(q, dq) dq_r + g with the arm's own parameters and rotors: Y parameters + armature ddq_r."""
        half = 0.5 * (dq + dq_r)
        tau: Array = self._torque(q, half, ddq_r) - self._torque_0(q, half - dq_r)
        return tau


SETS = ("payload", "base")

LENGTH = 0.1
"""[m] Of a load: a first moment is of the order of its mass times it."""

HEAVIEST = 20.0
"""[kg] The largest load, where the arm has no rating; three times the rating otherwise."""

FAR = 0.5
"""[m] The farthest centre of a load from the frame of the last joint."""

STATES, STATES_SEED = 100, 0
"""Random states whose torques show which combinations of parameters matter."""

RANK = 1e-9
"""Of the largest singular value: a combination below it moves no torque."""


@dataclass(frozen=True, slots=True, eq=False)
class AdaptedParameters:
    """theta (m,), added to the parameters of the arm's model: pi_hat = pi + W theta.

    `W` (10 n, m), or None where theta are the last ten; `gains`, `lower`, `upper` (m,) of theta.
    """

    name: str
    W: Array | None
    gains: Array
    lower: Array
    upper: Array
    turns: Array
    """(k, 10, 10) of the links that are adapted: parameters in the joint's frame -> in the frame of the URDF's link."""

    def __post_init__(self) -> None:
        freeze_arrays(self, "gains", "lower", "upper")

    @classmethod
    def payload(cls, arm: Arm, regressor: SlotineLiRegressor, gain: float) -> Self:
        """The ten of what is fixed to the last link; the mass of both together stays positive."""
        most = _heaviest(arm)
        moments = np.r_[[FAR * most] * 3, [FAR**2 * most] * 6]
        own = float(regressor.parameters[-len(PER_LINK)])
        bounds = np.r_[-own, -moments], np.r_[most, moments]
        return cls("payload", None, scaled_gains(gain), *bounds, parameter_turns(arm)[-1:])

    @classmethod
    def base(cls, arm: Arm, regressor: SlotineLiRegressor, gain: float) -> Self:
        """All combinations of the parameters of all links that move a torque, in coordinates in which the gains are 1.

        W = S V with S the roots of the scaled gains and V (10 n, m) an orthonormal base of the row space of Y S. The
        gradient law for all 10 n parameters never leaves this space, so it is that law with fewer numbers.
        """
        root = np.sqrt(np.tile(scaled_gains(gain), arm.n))
        states = np.random.default_rng(STATES_SEED).uniform(-np.pi, np.pi, (STATES, 4, arm.n))
        rows = np.concatenate([regressor(*state) for state in states]) * root
        _, sizes, V = np.linalg.svd(rows, full_matrices=False)
        V = V[sizes > RANK * sizes[0]]
        bound = np.full(len(V), len(PER_LINK) * _heaviest(arm) / np.sqrt(gain))
        return cls("base", root[:, None] * V.T, np.ones(len(V)), -bound, bound, parameter_turns(arm))

    @classmethod
    def of(cls, name: str, arm: Arm, regressor: SlotineLiRegressor, gain: float) -> Self:
        """One of `SETS`; raises `OptionError` for another name, or a gain that is not above 0."""
        if name not in SETS:
            raise OptionError("adapt", repr(name), ", ".join(SETS))
        if not (np.isfinite(gain) and gain > 0.0):
            raise OptionError("adapt_gain", gain, "a number above 0")
        return cls.payload(arm, regressor, gain) if name == SETS[0] else cls.base(arm, regressor, gain)

    def link_parameters(self, theta: Array) -> Array:
        """What theta (..., m) adds to the parameters: of the payload (..., 10), or of all links (..., 10 n).

        They are in the frames of the URDF's links; see `parameter_turns`.
        """
        added = theta if self.W is None else np.asarray(theta @ self.W.T)
        by_link = added.reshape(*added.shape[:-1], len(self.turns), len(PER_LINK))
        return np.asarray(np.einsum("kij,...kj->...ki", self.turns, by_link)).reshape(added.shape)

    def columns(self, Y: Array) -> Array:
        """The columns (n, m) of theta out of all columns Y (n, 10 n)."""
        return Y[:, -len(PER_LINK) :] if self.W is None else np.asarray(Y @ self.W)


def scaled_gains(gain: float) -> Array:
    """Gains of the ten parameters of one body, in the order of `PER_LINK`.

    >>> scaled_gains(100.0)[[0, 1, 4]].round(9).tolist()
    [100.0, 1.0, 0.01]
    """
    return np.array(gain * np.r_[1.0, [LENGTH**2] * 3, [LENGTH**4] * 6])


def _heaviest(arm: Arm) -> float:
    rated = arm.ratings.payload
    return HEAVIEST if rated is None else 3.0 * rated


GAIN = 10.0
"""[kg/J] g of `scaled_gains`. At 1 kHz without friction 10 to 100 was tried on the LWR 4+; with friction that is not
adapted, 30 is too much for the light wrist of its reading `computed`."""

FRICTION_GAIN = 30.0
"""[1/s^2] Of Coulomb friction, times the inertia of the joint."""

FRICTION_WIDTH = 5e-3
"""[rad/s or m/s] Of the tanh in the Coulomb friction that is adapted."""

POSES, POSES_SEED = 64, 0
"""Poses of the joint box over which the inertia of a joint is averaged, for the gains of its friction."""


class Adaptive:
    """The law of Slotine and Li; see this module for equations and stability.

    Parameters
    ----------
    regressor : SlotineLiRegressor
        Of the arm as the controller knows it.
    dynamics : Dynamics
        Of the same arm, for its linear form.
    omega_n : float
        Lambda and k [1/s]: without parameter errors the error follows (p + Lambda)(p + k) = 0.
    adapted : AdaptedParameters
    friction_gains : (2, n) array_like, optional
        gamma_c [N m/rad], gamma_v [N m s^2/rad^2]; friction is not adapted without them.
    friction : (2, n) array, optional
        F_c and F_v at the start [N m, N m s/rad]; 0 if not given.
    effort : (n,) array
        Torque limits [N m]; also bounds of the friction.

    Raises
    ------
    OptionError
        omega_n that is not above 0.
    """

    name = "adaptive"

    def __init__(
        self,
        regressor: SlotineLiRegressor,
        dynamics: Dynamics,
        omega_n: float,
        adapted: AdaptedParameters,
        friction_gains: Array | None = None,
        effort: Array | None = None,
        friction: Array | None = None,
    ) -> None:
        if not (np.isfinite(omega_n) and omega_n > 0.0):
            raise OptionError("omega_n", omega_n, "a number above 0")
        n = regressor.n
        self.omega_n, self.adapted, self.friction_gains = float(omega_n), adapted, friction_gains
        self._dynamics, self._regressor = dynamics, regressor
        self._parameters, self._armature = regressor.parameters, regressor.armature
        self._effort = np.full(n, np.inf) if effort is None else np.array(effort, dtype=np.float64)
        self._bodies = adapted.gains.size
        both = np.zeros((2, 0)) if friction_gains is None else np.array(friction_gains, dtype=np.float64)
        self._gains = np.concatenate([adapted.gains, both.ravel()])
        start = np.zeros((2, n)) if friction is None else np.array(friction, dtype=np.float64)
        self._coulomb, self._viscous = start
        self._lower = np.concatenate([adapted.lower, -start.ravel()[: both.size]])
        self._upper = np.concatenate([adapted.upper, np.tile(self._effort, 2)[: both.size]])
        self._split = self._bodies + n
        self.reset()

    @property
    def label(self) -> str:
        """The controller and its variant."""
        return f"adaptive ({self.adapted.name}{'' if self.friction_gains is None else ', friction'})"

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        friction = None if self.friction_gains is None else np.asarray(self.friction_gains).tolist()
        gains = {"adapted": self.adapted.name, "gains": self.adapted.gains.tolist(), "friction_gains": friction}
        return {"omega_n": self.omega_n, **gains}

    @property
    def memory_size(self) -> int:
        """The number of adapted parameters: bodies, then Coulomb, then viscous friction."""
        return int(self._gains.size)

    @property
    def signals(self) -> Mapping[str, Array]:
        """The parameters at present: what is added to the bodies' own, and friction [N m, N m s/rad]."""
        theta, first = self._theta, self._bodies
        shown = {f"adapted_{self.adapted.name}": self.adapted.link_parameters(theta[:first])}
        if self.friction_gains is not None:
            shown["adapted_coulomb"] = self._coulomb + theta[first : self._split]
            shown["adapted_viscous"] = self._viscous + theta[self._split :]
        return shown

    def reset(self) -> None:
        """Back to the arm's own parameters."""
        self._theta, self._rate = np.zeros(self.memory_size), np.zeros(self.memory_size)
        self._t: float | None = None

    def torque_and_rate(
        self, memory: Array, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array
    ) -> tuple[Array, Array]:
        """Torques (n,) [N m] with the parameters `memory` (m,), and their rates (m,) [per s]."""
        first, (dq_r, s, a) = self._bodies, sliding(self.omega_n, q, dq, q_ref, dq_ref, ddq_ref)
        Y = self._regressor(q, dq, dq_r, a)
        columns = self.adapted.columns(Y)
        tau = Y @ self._parameters + self._armature * a + columns @ memory[:first]
        slope = s @ columns
        if self.friction_gains is not None:
            shape = np.tanh(dq_ref / FRICTION_WIDTH)
            tau += (self._coulomb + memory[first : self._split]) * shape
            tau += (self._viscous + memory[self._split :]) * dq_r
            slope = np.concatenate([slope, shape * s, dq_r * s])
        rate = -self._gains * slope
        if (np.abs(tau) > self._effort).any():
            return tau, np.zeros_like(rate)
        out = ((memory >= self._upper) & (rate > 0.0)) | ((memory <= self._lower) & (rate < 0.0))
        return tau, np.where(out, 0.0, rate)

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m] at a sample; the parameters move on by the time since the last call."""
        if self._t is not None:
            moved = self._theta + (t - self._t) * self._rate
            self._theta = np.minimum(np.maximum(moved, self._lower), self._upper)
        tau, self._rate = self.torque_and_rate(self._theta, q, dq, q_ref, dq_ref, ddq_ref)
        self._t = t
        return tau

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`, with the adaptation: theta = -Gamma Y_g^T (x + Lambda int x), Y_g the columns at rest.

        With G = Y_g Gamma Y_g^T: position k Lambda B + G, velocity (k + Lambda) B, integral Lambda G. Friction that is
        adapted rests with the reference. Parameters that move from sample to sample lag by half of one, which is left
        out: at gains of thousands the true limit is lower (3e3 for 5e3 at one pose of the LWR 4+, 1 kHz).
        """
        k = Lambda = self.omega_n
        B, still = self._dynamics.mass_matrix(q), np.zeros(q.shape[-1])
        at_rest = np.array([self.adapted.columns(self._regressor(pose, still, still, still)) for pose in q])
        G = at_rest * self.adapted.gains @ np.swapaxes(at_rest, -1, -2)
        return LinearFeedback(k * Lambda * B + G, (k + Lambda) * B, Lambda * G, self._dynamics)


def poses_of_box(arm: Arm, count: int, seed: int) -> Array:
    """Positions (count, n) drawn evenly inside the limits, and within half a turn (pi m) of 0."""
    half = np.full(arm.n, np.pi)
    low, high = np.maximum(arm.lower, -half), np.minimum(arm.upper, half)
    return np.random.default_rng(seed).uniform(low, high, (count, arm.n))


def friction_gains(arm: Arm, dynamics: Dynamics, gain: float = FRICTION_GAIN) -> Array:
    """gamma_c = gain b and gamma_v = gamma_c / 10, (2, n), with b the mean inertia of each joint over its box."""
    if not (np.isfinite(gain) and gain > 0.0):
        raise OptionError("friction_gain", gain, "a number above 0")
    b = np.einsum("kii->ki", dynamics.mass_matrix(poses_of_box(arm, POSES, POSES_SEED))).mean(axis=0)
    return gain * np.array([b, 0.1 * b])


def tuned_adaptive(
    arm: Arm,
    dynamics: Dynamics,
    *,
    omega_n: NaturalFrequency = OMEGA_N,
    adapt: Annotated[str, Option(str, "What is adapted: payload, or base for all links.")] = "payload",
    adapt_gain: Annotated[float, Option(float, "Gain of the adaptation of a mass; others are scaled.")] = GAIN,
    adapt_friction: Annotated[bool, Option(bool, "Adapt friction too.")] = False,
    friction_gain: Annotated[float, Option(float, "Gain of the friction that is adapted, 1/s^2.")] = FRICTION_GAIN,
) -> Adaptive:
    """The adaptive law for an arm.

    Raises `MissingDataError`: the arm has no inertias; `OptionError`: gains that are not above 0, nothing of that name
    to adapt.
    """
    regressor = SlotineLiRegressor(arm)
    adapted = AdaptedParameters.of(adapt, arm, regressor, adapt_gain)
    if not adapt_friction:
        return Adaptive(regressor, dynamics, omega_n, adapted, effort=arm.effort)
    sides = [(one.positive, one.negative) for one in (model or FRICTIONLESS for model in arm.friction_models())]
    known = np.array([[(getattr(a, x) + getattr(b, x)) / 2 for a, b in sides] for x in ("coulomb", "viscous")])
    gains = friction_gains(arm, dynamics, friction_gain)
    return Adaptive(regressor, dynamics, omega_n, adapted, gains, arm.effort, np.maximum(known, 0.0))
