"""Impedance: the arm as springs and dampers along its reference, its own dynamics kept and not cancelled (PD+).

Joint impedance
---------------
Every joint a spring and a damper about its reference, the arm's own inertia is kept.

    tau = B(q) ddq_ref + C(q, dq) dq_ref + g(q) + K (q_ref - q) + D(q) (dq_ref - dq)

D(q) = 2 xi Q S Q^T from B = Q Q^T, K = Q S^2 Q^T (`control.gains`): every mode of the arm in this pose is damped by
xi, also where B changes from pose to pose, and no gain of one joint spoils that of another.

Stability, in continuous time, rigid, with the exact model: with e = q_ref - q the storage V = (de^T B de + e^T K e) /
2 has dV/dt = -de^T D de + de^T (-tau_external), so the map from the outer torque to the speed of the error is passive,
also along a moving reference, and without outer torque e goes to 0. With a wrong model g is off and e settles at K^-1
(g - g_model); D stays positive definite. Any passive environment then keeps the loop stable.

What takes this away: sampling (a held spring feeds in about T K dq^2 / 2 of power; 2 xi S T must stay below about 2,
see `lwr-dyn margins`), delay and encoder filters (the same, T grown by them), torque limits (no spring beyond them),
elastic joints (the statement then holds for the motor side alone).

Sources: Paden, Panja, Int. J. Control 47 (1988) (PD+); Hogan, J. Dyn. Sys. Meas. Control 107 (1985) (impedance);
Albu-Schaeffer, Ott, Hirzinger, IJRR 26 (2007) (damping design). SI units.

Cartesian impedance
-------------------
The tip is a spring and a damper in space about its reference, the rest of the arm another one.

    tau = B ddq_ref + C dq_ref + g + J^T (K e + D (v_ref - J dq)) + N B (w^2 (q_ref - q) + d (dq_ref - dq))
    e = (p_ref - p, log3(R_ref R^T)),   K = diag(k_x, k_y, k_z, k_r, k_r, k_r),   N = 1 - J^T Jbar^T

in axes of the base, at the arm's flange, or at the tool point of an arm with a tool. The pose p_ref, R_ref and its
speed v_ref are those of the joint reference. D = 2 xi Q S Q^T from Lambda = Q Q^T, K = Q S^2 Q^T (`control.gains`). N
is the dynamically consistent projector: J B^-1 N = 0, so the posture spring (w, d) accelerates the tip in no pose.
Settled, the arm answers a force f at the tip with K e = -f exactly, at any deflection. An arm with six joints has N =
0.

Turning: one stiffness k_r about all axes. Then k_r log3(R_ref R^T) is the gradient of k_r angle^2 / 2; it holds below
half a turn, where log3 jumps.

Singular poses: J^T, Q and N are formed without an inverse, so the torque stays bounded. J_bar exists up to the
singular pose, and N keeps the posture spring out of all six directions of the tip there too, also out of the one that
the arm cannot move in. That direction has no stiffness at the pose itself (J^T f = 0: the joints do not feel such a
force), and a mode slower than `SLOWEST` is damped as one of that frequency, so that it does not coast. Damping shifts
no equilibrium. An inner singularity (wrist, shoulder) keeps the stiffness up to there. At the stretched elbow the
workspace ends: outward no law gives the stiffness.

Stability, in continuous time, rigid, with the exact model, constant reference, w = 0: V = dq^T B dq / 2 + e^T K e / 2
has dV/dt = -dq^T (J^T D J + d N B) dq + v^T f, both matrices positive semidefinite: passive from outer force to speed
of the tip. The posture spring w is projected and no gradient: in a closed motion of the joints it can give energy, d
takes it out again, and nothing is proven with it. Along a moving reference the feed-forward is exact on it and V is
not monotone beside it.

What takes this away: sampling (a held torque takes about omega T / 4 off the damping ratio of a mode of omega rad/s),
delay, encoder filters, torque limits, elastic joints. Dry friction tau_c at rest holds the tip off by up to |Jbar^T
tau_c| / K: a law without friction compensation gives its stiffness only up to that force.

Sources: Khatib, IEEE J. Robotics and Automation 3 (1987) (Jbar, N); Albu-Schaeffer, Ott, Frese, Hirzinger, ICRA 2003
(damping design); Ott, "Cartesian impedance control of redundant and flexible-joint robots", Springer 2008; Paden,
Panja, Int. J. Control 47 (1988) (PD+). SI units.
"""

from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control import gains
from lwr_dyn.control.gains import OMEGA_N, XI, DampingRatio, LinearFeedback, modes
from lwr_dyn.control.protocol import positive_gains
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm

CarriedTorque = Callable[[Array, Array, Array, Array], Array]
"""(q, dq, dq_ref, ddq_ref) -> (n,) [N m]."""


def carried_torque(dynamics: Dynamics, feedforward: bool) -> CarriedTorque:
    """B(q) ddq_ref + C(q, dq) dq_ref + g(q), or g(q) alone without feed-forward.

    C(q, v) w is symmetric in v and w (Christoffel form), so with c(v) = C(q, v) v it is
    C(q, dq) dq_ref = c((dq + dq_ref) / 2) - c((dq - dq_ref) / 2): three runs of the recursion, no matrix.

    References
    ----------
    Paden, Panja, "Globally asymptotically stable PD+ controller for robot manipulators", Int. J. Control 47 (1988).
    """
    raw = ungated(dynamics)
    if feedforward:
        return partial(_carried, raw.inverse_dynamics, raw.bias_torque, raw.gravity_vector)
    return partial(_held, raw.gravity_vector)


def _carried(
    torque: Any, bias: Any, gravity: Any, q: Array, dq: Array, dq_ref: Array, ddq_ref: Array
) -> Array:  # a function of the module, so that a law can be pickled
    tau: Array = torque(q, 0.5 * (dq + dq_ref), ddq_ref) - bias(q, 0.5 * (dq - dq_ref)) + gravity(q)
    return tau


def _held(gravity: Any, q: Array, dq: Array, dq_ref: Array, ddq_ref: Array) -> Array:
    weight: Array = gravity(q)
    return weight


Feedforward = Annotated[bool, Option(bool, "Without B ddq_ref + C dq_ref.")]


class JointImpedance:
    """The law of this module.

    Parameters
    ----------
    dynamics : Dynamics
        The controller's model.
    stiffness : float or (n,) array_like
        K [N m/rad; N/m for a sliding joint].
    xi : float
        Damping ratio of every mode.
    feedforward : bool
        False leaves B ddq_ref + C dq_ref out.

    Raises
    ------
    ShapeError, OptionError
        A stiffness of the wrong length, or a number that is not above 0.
    """

    __slots__ = ("_carried", "_dynamics", "_mass", "_root", "feedforward", "stiffness", "xi")

    name = "joint-impedance"

    def __init__(self, dynamics: Dynamics, stiffness: ArrayLike, xi: float = XI, feedforward: bool = True) -> None:
        self.stiffness = positive_gains("stiffness", stiffness, dynamics.n)
        self.xi = float(positive_gains("xi", xi, 1)[0])
        self.feedforward, self._dynamics = feedforward, dynamics
        self._mass = ungated(dynamics).mass_matrix
        self._carried = carried_torque(dynamics, feedforward)
        self._root = np.sqrt(self.stiffness)

    @property
    def label(self) -> str:
        """The controller and its variant."""
        return f"joint impedance{'' if self.feedforward else ' without feed-forward'}"

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        return {"stiffness": self.stiffness.tolist(), "xi": self.xi, "feedforward": self.feedforward}

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]."""
        found = modes(self._mass(q), np.diag(self._root))
        if found is None:
            return gains.no_torque_known(q.size)
        root, joint, _, task = found
        damped = task.dot(self._root * (dq_ref - dq))
        tau = self._carried(q, dq, dq_ref, ddq_ref) + self.stiffness * (q_ref - q)
        tau += root.dot(joint.dot((2.0 * self.xi) * damped))
        return tau

    def damping(self, q: Array) -> Array:
        """D(q) (n, n) [N m s/rad] at one pose q (n,)."""
        found = modes(self._mass(q), np.diag(self._root))
        if found is None:
            return np.full((q.size, q.size), np.nan)
        root, joint, frequency, _ = found
        half = root @ (joint * np.sqrt(2.0 * self.xi * frequency))
        return np.asarray(half @ half.T)

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`: K and D(q)."""
        damping = np.array([self.damping(pose) for pose in q])
        return LinearFeedback(gains.diagonal(self.stiffness, len(q)), damping, gravity=self._dynamics)


def tuned_joint_impedance(
    arm: Arm,
    dynamics: Dynamics,
    *,
    stiffness: Annotated[float | None, Option(float, "Stiffness: N m/rad of the joints, N/m of the tip.")] = None,
    omega_n: Annotated[float, Option(float, "Natural frequency, rad/s.", unless="stiffness")] = OMEGA_N,
    xi: DampingRatio = XI,
    feedforward: Feedforward = True,
    inertia: ArrayLike | None = None,
) -> JointImpedance:
    """Joint impedance with one stiffness for all joints, or as `worst_case_gains` gives it (`inertia` as there).

    Raises `OptionError`, `MissingDataError`: a number that is not above 0; no limits to search the worst-case inertia
    in.
    """
    K = gains.worst_case_gains(arm, omega_n, xi, inertia).Kp if stiffness is None else stiffness
    return JointImpedance(dynamics, K, xi, feedforward)


TRANSLATION, ROTATION = 2000.0, 200.0
"""[N/m], [N m/rad]"""

POSTURE = 15.0
"""[rad/s] Natural frequency of the posture spring."""

SLOWEST = 0.1
"""[rad/s] Modes of the tip below it are damped as if they had it."""

TASK = 6
"""Directions of the tip."""


class CartesianImpedance:
    """The law of this module.

    Parameters
    ----------
    arm : Arm
        As the controller knows it; its flange, or tool point, is the tip.
    dynamics : Dynamics
        The controller's model.
    stiffness : float or (3,) array_like
        k_x, k_y, k_z [N/m] along the axes of the base.
    rotation : float
        k_r [N m/rad].
    xi : float
        Damping ratio of every mode of the tip.
    posture : float
        w [rad/s] of the joints that the tip leaves free; 0 for none, which is the passive law.
    posture_damping : float, optional
        d [1/s]; 2 w if not given, or 2 `POSTURE` where w is 0.
    feedforward : bool
        False leaves B ddq_ref + C dq_ref out.

    Raises
    ------
    OptionError
        A number that is not above 0 (`posture`: below 0).
    ShapeError
        A stiffness of another shape.
    MissingDataError
        An arm with fewer than six joints.
    """

    name = "cartesian-impedance"

    def __init__(
        self,
        arm: Arm,
        dynamics: Dynamics,
        stiffness: ArrayLike = TRANSLATION,
        rotation: float = ROTATION,
        xi: float = XI,
        posture: float = POSTURE,
        posture_damping: float | None = None,
        feedforward: bool = True,
    ) -> None:
        from lwr_dyn.dynamics.pinocchio_engine import flange_and_jacobian, rotation_vector  # a heavy library

        if arm.n < TASK:
            raise MissingDataError(
                arm.name, f"six joints or more (it has {arm.n})", "cartesian-impedance, to hold a pose"
            )
        if not (np.isfinite(posture) and posture >= 0.0):
            raise OptionError("posture", posture, "a number, at least 0")
        turning = positive_gains("rotation", rotation, 1)
        self.stiffness = np.concatenate([positive_gains("stiffness", stiffness, 3), np.repeat(turning, 3)])
        self.xi, self.posture = float(positive_gains("xi", xi, 1)[0]), float(posture)
        damping = 2.0 * (self.posture or POSTURE) if posture_damping is None else posture_damping
        self.posture_damping = float(positive_gains("posture_damping", damping, 1)[0])
        self.feedforward, self._dynamics, self._mass = feedforward, dynamics, ungated(dynamics).mass_matrix
        self._tip: Callable[[Array], tuple[Array, Array]] = flange_and_jacobian(arm)
        self._turn: Callable[[Array], Array] = rotation_vector
        self._carried, self._root = carried_torque(dynamics, feedforward), np.sqrt(self.stiffness)

    @property
    def label(self) -> str:
        """The controller and its variant."""
        left_out = [] if self.feedforward else ["feed-forward"]
        left_out += [] if self.posture else ["posture spring"]
        return f"Cartesian impedance{' without ' if left_out else ''}{' and '.join(left_out)}"

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this controller, as JSON values."""
        posture = {"posture": self.posture, "posture_damping": self.posture_damping}
        return {"stiffness": self.stiffness.tolist(), "xi": self.xi, **posture, "feedforward": self.feedforward}

    def __call__(self, t: float, q: Array, dq: Array, q_ref: Array, dq_ref: Array, ddq_ref: Array) -> Array:
        """Tau (n,) [N m]."""
        error, late = q_ref - q, dq_ref - dq
        T_ref, J_ref = self._tip(q_ref)
        speed_ref = J_ref.dot(dq_ref)  # before the next call of _tip
        T, J = self._tip(q)
        found = modes(self._mass(q), (self._root[:, None] * J).T)
        if found is None:
            return gains.no_torque_known(q.size)
        root, joint, frequency, task = found
        off = self.offset(T_ref, T)
        along = task.dot(self._root * (speed_ref - J.dot(dq)))
        pull = root.T.dot(self.posture**2 * error + self.posture_damping * late)
        inside = (2.0 * self.xi) * along - joint.T.dot(pull)
        if frequency[-1] < SLOWEST:
            inside += self._extra(frequency) * joint.T.dot(root.T.dot(late))
        tau: Array = self._carried(q, dq, dq_ref, ddq_ref) + J.T.dot(self.stiffness * off)
        tau += root.dot(pull + joint.dot(inside))
        return tau

    def offset(self, T_ref: Array, T: Array) -> Array:
        """e (6,) [m, rad] from poses (4, 4): the way and the turn from T to T_ref, in axes of the base."""
        e = np.empty(TASK)
        e[:3] = T_ref[:3, 3] - T[:3, 3]
        e[3:] = self._turn(T_ref[:3, :3].dot(T[:3, :3].T))
        return e

    def _extra(self, frequency: Array) -> Array:
        """What the damping of modes slower than `SLOWEST` is raised by [1/s]."""
        return 2.0 * self.xi * np.maximum(SLOWEST - frequency, 0.0)

    def at(self, q: Array) -> tuple[gains.Modes, Array] | None:
        """The modes at one pose q (n,) and J (6, n); None where the model's B is not positive definite."""
        J = self._tip(q)[1].copy()
        found = modes(self._mass(q), (self._root[:, None] * J).T)
        return None if found is None else (found, J)

    def linear_feedback(self, q: Array) -> LinearFeedback:
        """See `Linearised`: J^T K J + w^2 N B and J^T D J + d N B."""
        position, velocity = np.full((2, len(q), q.shape[-1], q.shape[-1]), np.nan)
        for k, pose in enumerate(q):
            found = self.at(pose)
            if found is None:
                continue
            (root, joint, frequency, _), J = found
            free = root @ (np.eye(pose.size) - joint @ joint.T) @ root.T
            damped = 2.0 * self.xi * frequency + self._extra(frequency)
            position[k] = J.T @ (self.stiffness[:, None] * J) + self.posture**2 * free
            velocity[k] = root @ (joint * damped) @ (root @ joint).T + self.posture_damping * free
        return LinearFeedback(position, velocity, gravity=self._dynamics)


def tuned_cartesian_impedance(
    arm: Arm,
    dynamics: Dynamics,
    *,
    stiffness: Annotated[float, Option(float, "Stiffness: N m/rad of the joints, N/m of the tip.")] = TRANSLATION,
    rotation: Annotated[float, Option(float, "Stiffness of the tip's turn, N m/rad.")] = ROTATION,
    xi: DampingRatio = XI,
    posture: Annotated[float, Option(float, "Natural frequency of the posture spring, rad/s; 0: none.")] = POSTURE,
    feedforward: Feedforward = True,
) -> CartesianImpedance:
    """Cartesian impedance; raises as `CartesianImpedance`."""
    return CartesianImpedance(arm, dynamics, stiffness, rotation, xi, posture, feedforward=feedforward)
