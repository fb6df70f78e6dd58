"""Any law on the motor side of elastic joints, with the deflection under gravity taken off ("LAW+motor-side").

    tau = law(theta - g(q_ref) / K, dtheta, reference)

The law is given the motors' angles and speeds in place of the links', whatever the plant's encoders read, less what
gravity bends the gears at the reference: at rest on the reference the law sees no error. The rest of the deflection,
(M ddq + C dq)/K, is seen as an error of position while the arm moves.

Stability
---------
Motor and feedback stand on the same side of the spring, so PD forms stay passive in continuous time (collocated; see
`motor_side_pd`). For laws that cancel the dynamics of the rigid arm no proof is known; their linear form was stable in
continuous time wherever it was tried. g(q_ref)/K is a function of the reference alone and cannot make a loop unstable;
a wrong K or g moves the arm by its error. Sampling and delay take away what they take from fast rotors: a law with B(q)
in front of its damping (inverse dynamics) asks the rotor B_m to follow the torque for heavy links, and at 1 kHz loses
stability in a part of the joint box. Torque limits leave a region around the reference.

On a rigid arm (`readings.theta is readings.q`), and where nothing is sensed, the law is given q and dq as they are.

Source: De Luca, Book, "Robots with flexible elements", in Siciliano, Khatib, *Handbook of Robotics* (2008), chapter 13.
"""

from dataclasses import replace
from typing import Any, cast

from numpy.typing import ArrayLike

from lwr_dyn.control.laws.motor_side_pd import GearStiffness, assumed_elasticity
from lwr_dyn.control.laws.wrapped import Wrapped
from lwr_dyn.control.linear_feedback import LinearFeedback
from lwr_dyn.control.protocol import Controller, JointReadings, positive_gains, reset
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm


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

    Raises
    ------
    MissingDataError
        Neither the arm's file nor `gear_stiffness` gives a stiffness.
    OptionError
        A stiffness that is not above 0.
    """
    elasticity = assumed_elasticity(arm, gear_stiffness)
    return MotorSide(controller, dynamics, elasticity.stiffness)
