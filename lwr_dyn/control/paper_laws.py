"""The paper's laws: PD with gravity compensation and PID, joint by joint, and inverse dynamics.

Their equations hold over any scalar, as the recursion of dynamics does: on arrays they are the controllers, and on
columns of symbols, with the gains and the model put in their place, the same text becomes a kernel of rollouts
(`codegen.rollouts.law_forms`).
"""

from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control import gains
from lwr_dyn.control.gains import OMEGA_N, XI, DampingRatio, LinearFeedback, NaturalFrequency, diagonal
from lwr_dyn.control.protocol import VelocityError, damping_words, positive_gains, saturate
from lwr_dyn.dynamics.protocol import Dynamics, UngatedDynamics, ungated
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm

OWN_GAINS = "gains of the arm's file"

OwnGains = Annotated[bool, Option(bool, "The gains of the arm's file.")]


class PDGravity:
    """tau = g(q) + Kp (q_ref - q) - Kd dq; with `velocity_error`, Kd (dq_ref - dq) in place of -Kd dq.

    Parameters
    ----------
    dynamics : Dynamics
        The controller's model, for g.
    Kp, Kd : float or (n,) array_like
        [N m/rad], [N m s/rad]; the paper takes omega_n^2 b and 2 xi omega_n b.
    velocity_error : bool
        Damp the speed of the error, not of the joint: this removes the lag (2 xi / omega_n) dq_ref of the paper's form.
    gains : str
        Where the gains come from, for the label; empty for those of the worst case.

    Raises
    ------
    ShapeError, OptionError
        Gains of the wrong length, or not positive.

    References
    ----------
    LWR 4+ paper, "Decentralized PID type joint controller"; Siciliano et al., eq. 8.51.
    """

    __slots__ = ("Kd", "Kp", "_dynamics", "_model", "gains", "velocity_error")

    name = "pd-gravity"

    def __init__(
        self, dynamics: Dynamics, Kp: ArrayLike, Kd: ArrayLike, velocity_error: bool = False, gains: str = ""
    ) -> None:
        self.Kp = positive_gains("Kp", Kp, dynamics.n)
        self.Kd = positive_gains("Kd", Kd, dynamics.n)
        self.velocity_error, self.gains = velocity_error, gains
        self._dynamics, self._model = dynamics, ungated(dynamics)

    @property
    def label(self) -> str:
        """The controller and its variant."""
        return ", ".join(["PD + gravity", damping_words(self.velocity_error), *([self.gains] if self.gains else [])])

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        return {"Kp": self.Kp.tolist(), "Kd": self.Kd.tolist(), "velocity_error": self.velocity_error}

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]."""
        if self.velocity_error:
            dq = dq - dq_ref
        tau: Array = self._model.gravity_vector(q) + self.Kp * (q_ref - q) - self.Kd * dq
        return tau

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`."""
        return LinearFeedback(diagonal(self.Kp, len(q)), diagonal(self.Kd, len(q)), gravity=self._dynamics)


def tuned_pd_gravity(
    arm: Arm,
    dynamics: Dynamics,
    *,
    omega_n: NaturalFrequency = OMEGA_N,
    xi: DampingRatio = XI,
    velocity_error: VelocityError = False,
    own_gains: OwnGains = False,
    inertia: ArrayLike | None = None,
) -> PDGravity:
    """PD with the gains of the arm's file (`own_gains`), or with `worst_case_gains`.

    Raises `MissingDataError` (the arm's file gives no gains; no limits to search the worst-case inertia in),
    `OptionError`, `ShapeError` (as `worst_case_gains`).
    """
    if own_gains and arm.gains is None:
        raise MissingDataError(arm.name, "controller gains", "own_gains (--own-gains)")
    found = arm.gains if own_gains and arm.gains else gains.worst_case_gains(arm, omega_n, xi, inertia)
    return PDGravity(dynamics, found.Kp, found.Kd, velocity_error, OWN_GAINS if own_gains else "")


def default_integral_gain(Kp: ArrayLike, omega_n: float = OMEGA_N) -> Array:
    """Ki = omega_n^3 b / 10 = omega_n Kp / 10, since Kp = omega_n^2 b, [N m/(rad s)].

    This is a twentieth of the gain at which the loop of a unit mass with xi = 1 turns unstable
    (s^3 + 2 omega_n s^2 + omega_n^2 s + ki: ki < 2 omega_n^3 by Routh). Raises `OptionError` for omega_n <= 0.

    >>> default_integral_gain([2500.0])
    array([12500.])
    """
    if not (np.isfinite(omega_n) and omega_n > 0.0):
        raise OptionError("omega_n", omega_n, "a number above 0, in rad/s")
    return np.asarray(omega_n * np.asarray(Kp, dtype=np.float64) / 10)


class PID:
    """tau = Kp e + I - Kd dq, dI/dt = Ki e + (sat(tau) - tau) / T_t, with e = q_ref - q.

    The integral I [N m] starts at zero. Sampled, it moves by explicit Euler from one call to the next; continuously,
    the integrator of the simulation carries it.

    Parameters
    ----------
    Kp, Kd : float or (n,) array_like
        [N m/rad], [N m s/rad].
    Ki : float or (n,) array_like, optional
        [N m/(rad s)]; `default_integral_gain(Kp, omega_n)` if not given.
    effort : (n,) array_like
        Torque limits [N m] of the back-calculation; inf where there is none.
    dynamics : Dynamics, optional
        Adds g(q) of this model; without it the integral must supply the gravity torque.
    velocity_error : bool
        Kd (dq_ref - dq) in place of -Kd dq.
    tracking_time : float or (n,) array_like, optional
        T_t [s]; sqrt(Kd / Ki) if not given (Astrom and Hagglund's sqrt(T_i T_d)).

    Raises
    ------
    ShapeError, OptionError
        Gains, limits or times of the wrong length, or not positive.

    References
    ----------
    Siciliano et al., section 8.3; Astrom, Hagglund, *PID Controllers*, section 3.5.
    """

    __slots__ = ("Kd", "Ki", "Kp", "_dynamics", "_effort", "_integral", "_model", "_rate", "_t", "tracking_time",
                 "velocity_error")  # fmt: skip

    name = "pid"

    def __init__(
        self,
        Kp: ArrayLike,
        Kd: ArrayLike,
        effort: ArrayLike,
        Ki: ArrayLike | None = None,
        dynamics: Dynamics | None = None,
        velocity_error: bool = False,
        omega_n: float = OMEGA_N,
        tracking_time: ArrayLike | None = None,
    ) -> None:
        ceiling = np.array(effort, dtype=np.float64)
        if ceiling.ndim != 1 or not (ceiling > 0.0).all():
            raise OptionError("effort", ceiling.tolist(), "one torque limit above 0 per joint, inf where there is none")
        n = ceiling.size
        self._effort = read_only(ceiling)
        self.Kp, self.Kd = positive_gains("Kp", Kp, n), positive_gains("Kd", Kd, n)
        self.Ki = positive_gains("Ki", default_integral_gain(self.Kp, omega_n) if Ki is None else Ki, n)
        tracking = np.sqrt(self.Kd / self.Ki) if tracking_time is None else tracking_time
        self.tracking_time = positive_gains("tracking_time", tracking, n)
        self.velocity_error, self._dynamics = velocity_error, dynamics
        self._model: UngatedDynamics | None = None if dynamics is None else ungated(dynamics)
        self.reset()

    @property
    def label(self) -> str:
        """The controller and its variant."""
        gravity = "PID" if self._model is None else "PID + gravity"
        return f"{gravity}, {damping_words(self.velocity_error)}"

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        columns = {name: getattr(self, name).tolist() for name in ("Kp", "Ki", "Kd", "tracking_time")}
        limits = [float(x) if np.isfinite(x) else None for x in self._effort]
        gravity = self._model is not None
        return columns | {"effort": limits, "velocity_error": self.velocity_error, "gravity": gravity}

    @property
    def memory_size(self) -> int:
        """One integral a joint."""
        return int(self.Kp.size)

    @property
    def integral(self) -> Array:
        """The present integral torque I (n,) [N m]."""
        return read_only(self._integral)

    def reset(self) -> None:
        """Sets the integral to zero."""
        self._integral, self._rate = np.zeros(self.memory_size), np.zeros(self.memory_size)
        self._t: float | None = None

    def torque_and_rate(
        self, memory: Array, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array
    ) -> tuple[Array, Array]:
        """Torques (n,) [N m] with the integral `memory`, and the rate of the integral (n,) [N m/s]."""
        if self.velocity_error:
            dq = dq - dq_ref
        error = q_ref - q
        tau = self.Kp * error + memory - self.Kd * dq
        if self._model is not None:
            tau = tau + self._model.gravity_vector(q)
        return tau, self.Ki * error + (saturate(tau, self._effort) - tau) / self.tracking_time

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m] at a sample; the integral moves on by the time since the last call."""
        if self._t is not None:
            self._integral = self._integral + (t - self._t) * self._rate
        tau, self._rate = self.torque_and_rate(self._integral, q, dq, q_ref, dq_ref, ddq_ref)
        self._t = t
        return tau

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`; no torque is at its limit."""
        return LinearFeedback(diagonal(self.Kp, len(q)), diagonal(self.Kd, len(q)), self.Ki, self._dynamics)


def tuned_pid(
    arm: Arm,
    dynamics: Dynamics,
    *,
    omega_n: NaturalFrequency = OMEGA_N,
    xi: DampingRatio = XI,
    ki: Annotated[float | None, Option(float, "Integral gain, N m/(rad s); omega_n^3 b/10 if not given.")] = None,
    velocity_error: VelocityError = False,
    gravity: Annotated[bool, Option(bool, "No gravity compensation beside the integral.")] = True,
    inertia: ArrayLike | None = None,
) -> PID:
    """PID with `worst_case_gains`, whose errors it raises; without `gravity` the integral supplies it."""
    found = gains.worst_case_gains(arm, omega_n, xi, inertia)
    return PID(found.Kp, found.Kd, arm.effort, ki, dynamics if gravity else None, velocity_error, omega_n)


class InverseDynamics:
    """tau = B(q) y + n(q, dq), y = Kp (q_ref - q) + Kd (dq_ref - dq) + ddq_ref, n = C dq + g.

    B y + n is one run of the Newton-Euler recursion with y for the acceleration.

    Parameters
    ----------
    dynamics : Dynamics
        The controller's model.
    Kp, Kd : float or (n,) array_like
        omega_n^2 and 2 xi omega_n of the error equation [1/s^2], [1/s].
    feedforward : bool
        False leaves ddq_ref out, as the paper does ("it was decided to define ddq_d = 0").
    gravity : bool
        False leaves g out of n: under this hypothesis Table VIII of the paper is reproduced.

    Raises
    ------
    ShapeError, OptionError
        Gains of the wrong length, or not positive.

    References
    ----------
    LWR 4+ paper, "Centralized inverse dynamics controller"; Siciliano et al., eqs. 8.56 to 8.60.
    """

    __slots__ = ("Kd", "Kp", "_dynamics", "_model", "feedforward", "gravity")

    name = "inverse-dynamics"

    def __init__(
        self, dynamics: Dynamics, Kp: ArrayLike, Kd: ArrayLike, feedforward: bool = True, gravity: bool = True
    ) -> None:
        self.Kp = positive_gains("Kp", Kp, dynamics.n)
        self.Kd = positive_gains("Kd", Kd, dynamics.n)
        self.feedforward, self.gravity = feedforward, gravity
        self._dynamics, self._model = dynamics, ungated(dynamics)

    @property
    def label(self) -> str:
        """The controller and its variant."""
        forward = "with feed-forward" if self.feedforward else "without feed-forward (ddq_ref := 0)"
        return f"inverse dynamics {forward}{'' if self.gravity else ', without g'}"

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        switches = {"feedforward": self.feedforward, "gravity": self.gravity}
        return {"Kp": self.Kp.tolist(), "Kd": self.Kd.tolist()} | switches

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]."""
        y = self.Kp * (q_ref - q) + self.Kd * (dq_ref - dq)
        if self.feedforward:
            y += ddq_ref
        tau: Array = self._model.inverse_dynamics(q, dq, y)
        return tau if self.gravity else tau - self._model.gravity_vector(q)

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`: B Kp and B Kd.

        The change of B with q, times the steady error that an unknown load leaves, is left out.
        """
        B = self._dynamics.mass_matrix(q)
        return LinearFeedback(B * self.Kp, B * self.Kd, gravity=self._dynamics if self.gravity else None)


def tuned_inverse_dynamics(
    arm: Arm,
    dynamics: Dynamics,
    *,
    omega_n: NaturalFrequency = OMEGA_N,
    xi: DampingRatio = XI,
    feedforward: Annotated[bool, Option(bool, "Without ddq_ref, as the paper has it.")] = True,
    gravity: Annotated[bool, Option(bool, "Without g in n.")] = True,
) -> InverseDynamics:
    """Inverse dynamics with omega_n^2 and 2 xi omega_n for gains; raises `OptionError` when they are not positive."""
    unit = gains.second_order_gains(np.ones(arm.n), omega_n, xi)
    return InverseDynamics(dynamics, unit.Kp, unit.Kd, feedforward, gravity)
