"""PD on the motor side of elastic joints, with feed-forward and torque feedback; and any law on the motor side.

PD on the motor side
--------------------
With theta, dtheta of the motors (seen at the joints), joint torque tau_J = K (theta - q) + D (dtheta - dq), rotors B_m:

    u   = tau_d + (B_m / r) ddq_d + Kp (theta_d - theta) + Kd (dtheta_d - dtheta),   theta_d = q_d + tau_d / K
    tau = u + (r - 1) (u - tau_J)

tau_d is what the links need along the reference, M(q_d) ddq_d + C dq_d + g(q_d); without feed-forward it is g(q_d)
and the term of the rotors is left out. dtheta_d = dq_d + d(tau_d / K)/dt by the difference of two samples; of
ddtheta_d only ddq_d is taken. Torque feedback makes rotors feel r times lighter: B_m ddtheta + tau_J = tau becomes
(B_m / r) ddtheta + tau_J = u.

Continuous, exact model, torques unlimited: at a constant q_d the equilibrium q = q_d, theta = theta_d is globally
asymptotically stable for every Kd > 0 if dg/dq + (1/Kp + 1/K)^-1 is positive definite at all poses: Kp in series with K
exceeds |dg/dq| (`static_margin`). Motor, spring and links are passive, so a wrong K, B or g moves the equilibrium only;
so does torque feedback, which is a lighter motor. Along a moving reference nothing is proven for the whole state space:
the feed-forward is exact for the exact model. What is lost:
- sampling: the rotor alone needs T r Kd / B_m < 2, which light rotors miss by far; torque feedback divides it by r;
- delay: the same limit, earlier; and r - 1 times a late torque reading is a loop of its own;
- torque limits: what remains is a region around the reference. A jump of ddq_d is a jump of theta_d, so a torque at the
  limit for a sample.

On a rigid arm there is no spring: theta = q, and the law is u with 1/K = 0 and r = 1. It acts so until joint readings
(`sense`) show a motor side of its own.

Sources: Tomei, IEEE Trans. Automatic Control 36 (1991) 1208, PD with g(q_d); for torque feedback Ott, Albu-Schaeffer,
Kugi, Hirzinger, IEEE Trans. Robotics 24 (2008) 416, and Albu-Schaeffer, Ott, Hirzinger, Int. J. Robotics Research 26
(2007) 23.

Any law ("LAW+motor-side")
--------------------------
    tau = law(theta - g(q_ref) / K, dtheta, reference)

The law is given the motors' angles and speeds in place of the links', whatever the plant's encoders read, less what
gravity bends the gears at the reference: at rest on the reference the law sees no error. The rest of the deflection,
(M ddq + C dq)/K, is seen as an error of position while the arm moves.

Motor and feedback stand on the same side of the spring, so PD forms stay passive in continuous time (collocated; see
above). For laws that cancel the dynamics of the rigid arm no proof is known; their linear form was stable in
continuous time wherever it was tried. g(q_ref)/K is a function of the reference alone and cannot make a loop unstable;
a wrong K or g moves the arm by its error. Sampling and delay take away what they take from fast rotors: a law with B(q)
in front of its damping (inverse dynamics) asks the rotor B_m to follow the torque for heavy links, and at 1 kHz loses
stability in a part of the joint box. Torque limits leave a region around the reference.

On a rigid arm (`readings.theta is readings.q`), and where nothing is sensed, the law is given q and dq as they are.

Source: De Luca, Book, "Robots with flexible elements", in Siciliano, Khatib, *Handbook of Robotics* (2008), chapter 13.
"""

from dataclasses import replace
from typing import Annotated, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control import gains
from lwr_dyn.control.gains import OMEGA_N, XI, DampingRatio, LinearFeedback, NaturalFrequency
from lwr_dyn.control.protocol import Controller, JointReadings, Wrapped, positive_gains, reset
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array, joint_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.transmission import JointElasticity, chosen_elasticity

NO_MEMORY = np.zeros(0)

GearStiffness = Annotated[
    float | None, Option(float, "Largest stiffness of a gear as the law assumes it, N m/rad; the file's if not given.")
]


def assumed_elasticity(arm: Arm, gear_stiffness: float | None) -> JointElasticity:
    """The gears as a law assumes them: the file's, or with another largest stiffness [N m/rad].

    Raises `OptionError` for a stiffness that is not above 0, `MissingDataError` where neither gives one.
    """
    if gear_stiffness is not None and not 0.0 < gear_stiffness < np.inf:
        raise OptionError("gear_stiffness", f"{gear_stiffness:g}", "a number above 0 in N m/rad")
    return cast(JointElasticity, chosen_elasticity(arm, "file" if gear_stiffness is None else gear_stiffness))


class MotorSidePD:
    """The law of this module.

    Parameters
    ----------
    dynamics : Dynamics
        The controller's model, rotors included.
    Kp, Kd : float or (n,) array_like
        On the motor side, before torque feedback [N m/rad], [N m s/rad].
    stiffness, rotor : float or (n,) array_like
        K [N m/rad] and B_m [kg m^2], seen at the joint.
    feedforward : bool
        The reference torque and rotor acceleration; False: gravity only.
    lighter : float
        r >= 1: torque feedback makes the rotors feel lighter by it; 1 is none.

    Raises
    ------
    ShapeError, OptionError
        Gains or stiffness of the wrong length, or not positive; a factor below 1; torque feedback without rotors.
    """

    __slots__ = (
        "Kd", "Kp", "_bend", "_bend_rate", "_compliance", "_dynamics", "_excess", "_model", "_readings", "_t",
        "feedforward", "lighter", "rotor", "stiffness",
    )  # fmt: skip

    name = "motor-pd"

    def __init__(
        self,
        dynamics: Dynamics,
        Kp: ArrayLike,
        Kd: ArrayLike,
        stiffness: ArrayLike,
        rotor: ArrayLike = 0.0,
        feedforward: bool = True,
        lighter: float = 1.0,
    ) -> None:
        n = dynamics.n
        self.Kp, self.Kd = positive_gains("Kp", Kp, n), positive_gains("Kd", Kd, n)
        self.stiffness = positive_gains("stiffness", stiffness, n)
        self.rotor = joint_array("rotor", np.broadcast_to(rotor, (n,)), n)
        if not (np.isfinite(lighter) and lighter >= 1.0):
            raise OptionError("lighter", lighter, "a number from 1 on")
        if lighter > 1.0 and not (self.rotor > 0.0).all():
            raise OptionError("lighter", lighter, "1 where a rotor has no inertia")
        self.feedforward, self.lighter = feedforward, float(lighter)
        self._dynamics, self._model = dynamics, ungated(dynamics)
        self._compliance = 1.0 / self.stiffness
        self._excess = self.rotor * (1.0 - 1.0 / self.lighter)
        self.reset()

    @property
    def label(self) -> str:
        """The controller and its variant."""
        forward = "feed-forward" if self.feedforward else "gravity of q_ref"
        shaped = "" if self.lighter == 1.0 else f", torque feedback (rotors {self.lighter:g} times lighter)"
        return f"PD on the motor side, {forward}{shaped}"

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        arrays = {name: getattr(self, name).tolist() for name in ("Kp", "Kd", "stiffness", "rotor")}
        return {**arrays, "feedforward": self.feedforward, "lighter": self.lighter}

    def reset(self) -> None:
        """Forgets the readings and the last deflection."""
        self._readings: JointReadings | None = None
        self._t, (self._bend, self._bend_rate) = np.nan, np.zeros((2, self._dynamics.n))

    def sense(self, readings: JointReadings) -> None:
        """Takes the motor side and the joint torque; readings whose theta is their q are those of a rigid arm."""
        self._readings = None if readings.theta is readings.q else readings

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]; q, dq are read on a rigid arm only."""
        seen = self._readings
        if seen is None:
            return self._forward(q_ref, dq_ref, ddq_ref) + self.Kp * (q_ref - q) + self.Kd * (dq_ref - dq)
        u = self._forward(q_ref, dq_ref, ddq_ref)
        bend = u * self._compliance
        if self.feedforward:
            bend -= self.rotor * self._compliance * ddq_ref
            u -= self._excess * ddq_ref
            if t > self._t:
                self._bend_rate = (bend - self._bend) / (t - self._t)
            self._t, self._bend = t, bend
        u += self.Kp * (q_ref + bend - seen.theta) + self.Kd * (dq_ref + self._bend_rate - seen.dtheta)
        return u if self.lighter == 1.0 else u + (self.lighter - 1.0) * (u - seen.torque)

    memory_size = 0
    """As `WithMemory`: nothing is integrated."""

    def torque_and_rate(
        self, memory: Array, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array
    ) -> tuple[Array, Array]:
        """Tau (n,) [N m] for continuous runs, where dtheta_d is dq_ref: deflections are not differentiated."""
        return self(np.nan, q, dq, q_ref, dq_ref, ddq_ref), NO_MEMORY

    def _forward(self, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        model = self._model
        tau: Array = model.inverse_dynamics(q_ref, dq_ref, ddq_ref) if self.feedforward else model.gravity_vector(q_ref)
        return tau

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`: on the motor side, with torque feedback r - 1; what is fed forward is constant at rest."""
        k, r = len(q), self.lighter
        feedback = None if r == 1.0 else gains.diagonal(np.full(self.Kp.size, r - 1.0), k)
        return LinearFeedback(
            gains.diagonal(r * self.Kp, k), gains.diagonal(r * self.Kd, k), torque=feedback, motor=True
        )

    def static_margin(self, q: ArrayLike) -> Array:
        """The smallest eigenvalue of dg/dq + (1/Kp + 1/K)^-1 at the poses q (k, n), (k,) [N m/rad]."""
        slope = gains.gravity_stiffness(self._dynamics, np.asarray(q, dtype=np.float64))
        series = np.diag(1.0 / (1.0 / self.Kp + self._compliance))
        return np.asarray(np.linalg.eigvalsh((slope + np.swapaxes(slope, -1, -2)) / 2 + series)[..., 0])


def tuned_motor_side_pd(
    arm: Arm,
    dynamics: Dynamics,
    *,
    omega_n: NaturalFrequency = OMEGA_N,
    xi: DampingRatio = XI,
    feedforward: Annotated[bool, Option(bool, "Gravity of the reference only, no torque and acceleration.")] = True,
    lighter: Annotated[float, Option(float, "Torque feedback: rotors feel lighter by this factor; 1 is none.")] = 1.0,
    gear_stiffness: GearStiffness = None,
    inertia: ArrayLike | None = None,
) -> MotorSidePD:
    """Motor-side PD with `worst_case_gains`, less the inertia that torque feedback takes off the rotors.

    Raises `MissingDataError` (neither the arm's file nor `gear_stiffness` gives a stiffness; no limits to search the
    worst-case inertia in), `OptionError`, `ShapeError` (as `worst_case_gains` and `MotorSidePD`).
    """
    elasticity = assumed_elasticity(arm, gear_stiffness)
    found = gains.worst_case_gains(arm, omega_n, xi, inertia)
    if lighter > 1.0:
        felt = found.Kp / omega_n**2 - arm.armature * (1.0 - 1.0 / lighter)
        found = gains.second_order_gains(felt, omega_n, xi)
    return MotorSidePD(dynamics, found.Kp, found.Kd, elasticity.stiffness, arm.armature, feedforward, lighter)


class MotorSide(Wrapped):
    """A controller that is given the motor side; see this module.

    Parameters
    ----------
    inner : Controller
    dynamics : Dynamics
        Its g(q_ref) bends the gears.
    stiffness : float or (n,) array_like
        K [N m/rad].

    Raises
    ------
    ShapeError, OptionError
        Stiffness of the wrong length, or not positive.
    """

    word, label_word = "motor-side", "on the motor side"

    def __init__(self, inner: Controller, dynamics: Dynamics, stiffness: ArrayLike) -> None:
        super().__init__(inner)
        self.stiffness = positive_gains("stiffness", stiffness, dynamics.n)
        self._gravity, self._readings = ungated(dynamics).gravity_vector, cast("JointReadings | None", None)
        self._hand_on = getattr(inner, "sense", None)
        self.sense, self.reset = self._sense, self._reset
        if hasattr(inner, "torque_and_rate"):
            self.torque_and_rate = inner.torque_and_rate
        if hasattr(inner, "linear_feedback"):
            self.linear_feedback = self._linear_feedback

    @property
    def own_parameters(self) -> dict[str, Any]:
        """The stiffness that is assumed."""
        return {"gear_stiffness": self.stiffness.tolist()}

    def _reset(self) -> None:
        self._readings = None
        reset(self.inner)

    def _sense(self, readings: JointReadings) -> None:
        """Takes the motor side, and hands the readings on."""
        self._readings = None if readings.theta is readings.q else readings
        if self._hand_on is not None:
            self._hand_on(readings)

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]."""
        seen = self._readings
        if seen is not None:
            q, dq = seen.theta - self._gravity(q_ref) / self.stiffness, seen.dtheta
        return self.inner(t, q, dq, q_ref, dq_ref, ddq_ref)

    def _linear_feedback(self, q: Array) -> LinearFeedback:
        """The inner controller's, on the motor side; see `Linearised`."""
        law: LinearFeedback = self.inner.linear_feedback(q)  # type: ignore[attr-defined]
        return replace(law, motor=True)


def on_motor_side(
    controller: Controller, arm: Arm, dynamics: Dynamics, *, gear_stiffness: GearStiffness = None
) -> MotorSide:
    """A controller on the motor side of the gears of this arm, or of gears with another largest stiffness.

    Raises `MissingDataError`: neither the arm's file nor `gear_stiffness` gives a stiffness; `OptionError`: a stiffness
    that is not above 0.
    """
    elasticity = assumed_elasticity(arm, gear_stiffness)
    return MotorSide(controller, dynamics, elasticity.stiffness)
