"""The robust law on passivity: a load that is only known to lie in a set is held down by a term of fixed size.

    tau = Y(q, dq, dq_r, a) pi_0 + armature a + Y_l u,   a = ddq_r - k s
    dq_r = dq_ref + Lambda (q_ref - q),   s = dq - dq_r,   z = H Y_l^T s
    u = -rho H z / |z| where |z| > eps,   u = -rho H z / eps inside the layer |z| <= eps [W]

pi_0 are the parameters of the arm with half the largest load at its flange, Y_l the ten columns of the load, H the
diagonal of (m, m L, m L^2) with m half the largest load and L = 0.1 m, rho the size of the set in these units: it holds
every point mass from 0 to the largest load at the flange, with a fifth to spare.

Stability
---------
Continuous time, rigid arm, load in the set, no torque at its limit, no friction: V = s^T B s / 2, B the true mass
matrix, has dV/dt <= -k s^T B s + rho eps / 4, so s^T B s ends below rho eps / (4 k): uniformly ultimately bounded, a
ball that shrinks with eps. No adaptation, no memory.

Not covered: sampling. Inside the layer the term is damping of size rho H^2 / eps, which a sample period bounds as any
damping; once no sample falls inside the layer it is a switch: torque chatters and the error no longer falls with eps.
Delay and noise bound the layer in the same way; a torque limit takes the term away.

The honest figure: at the default layer the robust term takes 5 to 31 % off the error that the law has without it; most
of what it gains over a law without load comes from half of the largest load in its model. Adaptation does far more.

Source: Spong, "On the robust control of robot manipulators", IEEE Trans. Automatic Control 37(11) (1992), with the
regressor in place of its linear form; Siciliano et al., section 8.5.3.
"""

from collections.abc import Callable
from math import sqrt
from typing import Annotated, Any

import numpy as np

from lwr_dyn.control.gains import OMEGA_N, LinearFeedback, NaturalFrequency
from lwr_dyn.control.laws.adaptive import LENGTH, PER_LINK, SlotineLiRegressor, poses_of_box, sliding
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm, arm_with_payload

LAYER = 30.0
"""[W] eps: at 1 kHz on the LWR 4+ samples still fall inside the layer and torques are smooth."""
LOAD = 7.0
"""[kg] The largest load where the arm has no rating: that of the LWR 4+ by its maker, or what `unrated_load` makes
of it for arms that are lighter or weaker."""
HEAVIEST_SHARE, LIGHTEST_SHARE = 0.5, 0.01
"""Of the mass that moves: between them is the largest load of an arm without a rating."""
NO_LOAD = 1e-9
"""[N m/kg] A joint that the weight of a load turns less than this does not bear it."""
POSES, POSES_SEED = 256, 0
"""Poses drawn inside the position limits, in which its torque limits hold that load."""
SPARE = 1.2
"""Of rho, over what the set needs."""


class Robust:
    """The passivity-based robust law; see this module for equations and stability.

    Parameters
    ----------
    regressor : SlotineLiRegressor
        Of the arm with the load in the middle of the set.
    dynamics : Dynamics
        Of the same arm with that load.
    omega_n : float
        Lambda and k [1/s].
    scale : (10,) array
        H, in the order of `PER_LINK`.
    rho : float
        Size of the set in these units.
    layer : float
        eps, above 0.

    Raises
    ------
    OptionError
        omega_n, rho or layer that is not above 0.
    """

    name = "robust"

    def __init__(
        self, regressor: SlotineLiRegressor, dynamics: Dynamics, omega_n: float, scale: Array, rho: float, layer: float
    ) -> None:
        for option, value in (("omega_n", omega_n), ("rho", rho), ("layer", layer)):
            if not (np.isfinite(value) and value > 0.0):
                raise OptionError(option, value, "a number above 0")
        self.omega_n, self.scale, self.rho, self.layer = float(omega_n), np.array(scale), float(rho), float(layer)
        self._dynamics, self._parameters, self._armature = dynamics, regressor.parameters, regressor.armature
        self._regressor: Callable[..., Array] = regressor
        self._squared = self.scale**2

    @property
    def label(self) -> str:
        """The controller and its variant."""
        return f"robust (passivity), layer {self.layer:g}"

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        return {"omega_n": self.omega_n, "rho": self.rho, "layer": self.layer, "scale": self.scale.tolist()}

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]."""
        dq_r, s, a = sliding(self.omega_n, q, dq, q_ref, dq_ref, ddq_ref)
        Y = self._regressor(q, dq, dq_r, a)
        load = Y[:, -len(PER_LINK) :]
        z = self.scale * (s @ load)
        size = max(sqrt(z.dot(z)), self.layer)
        tau: Array = Y @ self._parameters + self._armature * a - load @ ((self.rho / size) * self.scale * z)
        return tau

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`: inside the layer, where the term is damping G = (rho / eps) Y_l H^2 Y_l^T at rest."""
        k = Lambda = self.omega_n
        B, still = self._dynamics.mass_matrix(q), np.zeros(q.shape[-1])
        at_rest = np.array([self._regressor(pose, still, still, still)[:, -len(PER_LINK) :] for pose in q])
        G = (self.rho / self.layer) * (at_rest * self._squared) @ np.swapaxes(at_rest, -1, -2)
        return LinearFeedback(Lambda * (k * B + G), (k + Lambda) * B + G, gravity=self._dynamics)


def unrated_load(arm: Arm, dynamics: Dynamics) -> float:
    """[kg] `LOAD`, but no more than half of the mass that moves, and than the torque limits hold in poses drawn.

    A hundredth of that mass where they do not hold the arm itself. Without a torque limit nothing is known of what a
    joint holds.
    """
    moving = sum(body.mass for body in arm.require_dynamics().bodies or ())
    q = poses_of_box(arm, POSES, POSES_SEED)
    own = dynamics.gravity_vector(q)
    per_kg = dynamics_of(arm_with_payload(arm, 1.0)).gravity_vector(q) - own
    return max(min(LOAD, HEAVIEST_SHARE * moving, held_load(arm.effort, own, per_kg)), LIGHTEST_SHARE * moving)


def held_load(effort: Array, own: Array, per_kg: Array) -> float:
    """[kg] The largest load that the limits `effort` (n,) hold in all k states, beside the arm's `own` torques (k, n).

    `per_kg` (k, n) are those of one kg: a load's torques are linear in its mass. inf without limits, below 0 where the
    arm itself is not held.
    """
    counts = np.abs(per_kg) > NO_LOAD
    held = np.where(counts, effort - np.sign(per_kg) * own, np.inf) / np.where(counts, np.abs(per_kg), 1.0)
    return float(held.min())


def tuned_robust(
    arm: Arm,
    dynamics: Dynamics,
    *,
    omega_n: NaturalFrequency = OMEGA_N,
    largest_load: Annotated[
        float | None, Option(float, "Largest load, kg; the rated one, else what fits the arm, to 7 kg.")
    ] = None,
    layer: Annotated[float, Option(float, "Thickness of the layer in which the robust term is smooth.")] = LAYER,
) -> Robust:
    """The robust law for loads from 0 to `largest_load` [kg] at the flange; the rated one, else `unrated_load`.

    Raises `MissingDataError`: the arm has no inertias; `OptionError`: numbers that are not above 0.
    """
    most = arm.ratings.payload if largest_load is None else largest_load
    most = unrated_load(arm, dynamics) if most is None else most
    if not (np.isfinite(most) and most > 0.0):
        raise OptionError("largest_load", most, "a mass above 0, in kg")
    middle = arm_with_payload(arm, most / 2)
    regressor, empty = SlotineLiRegressor(middle), SlotineLiRegressor(arm)
    scale = most / 2 * np.r_[1.0, [LENGTH] * 3, [LENGTH**2] * 6]
    load = (regressor.parameters - empty.parameters)[-len(PER_LINK) :]
    rho = SPARE * float(np.linalg.norm(load / scale))
    return Robust(regressor, dynamics_of(middle), omega_n, scale, rho, layer)
