"""PD with gravity compensation, joint by joint: the paper's decentralised controller."""

from collections.abc import Callable
from typing import Annotated, Any

from numpy.typing import ArrayLike

from lwr_dyn.control.gains import OMEGA_N, XI, DampingRatio, NaturalFrequency, worst_case_gains
from lwr_dyn.control.linear_feedback import LinearFeedback, diagonal
from lwr_dyn.control.protocol import VelocityError, damping_words, positive_gains
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
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

    __slots__ = ("Kd", "Kp", "_dynamics", "_gravity", "gains", "velocity_error")

    name = "pd-gravity"

    def __init__(
        self, dynamics: Dynamics, Kp: ArrayLike, Kd: ArrayLike, velocity_error: bool = False, gains: str = ""
    ) -> None:
        self.Kp = positive_gains("Kp", Kp, dynamics.n)
        self.Kd = positive_gains("Kd", Kd, dynamics.n)
        self.velocity_error, self.gains, self._dynamics = velocity_error, gains, dynamics
        self._gravity: Callable[[Array], Array] = ungated(dynamics).gravity_vector

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
        return self._gravity(q) + self.Kp * (q_ref - q) - self.Kd * dq

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

    Raises
    ------
    MissingDataError
        The arm's file gives no gains; no limits to search the worst-case inertia in.
    OptionError, ShapeError
        As `worst_case_gains`.
    """
    if own_gains and arm.gains is None:
        raise MissingDataError(arm.name, "controller gains", "own_gains (--own-gains)")
    gains = arm.gains if own_gains and arm.gains else worst_case_gains(arm, omega_n, xi, inertia)
    return PDGravity(dynamics, gains.Kp, gains.Kd, velocity_error, OWN_GAINS if own_gains else "")
