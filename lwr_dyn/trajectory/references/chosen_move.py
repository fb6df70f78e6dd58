"""The task `move`: a move between two poses that are chosen inside the arm's own limits of position, speed and torque.

Each joint goes a share of its range to each side of its middle, at most 0.35 rad (0.1 m) and no further than a slow one
comes in 8 s, on a quintic from rest to rest. Where the known torque limits do not hold the arm's weight there, other
poses are tried, drawn with a fixed seed. The duration keeps the speeds to a share of their limits, and the torque of
inverse dynamics with friction to what the weight leaves.
"""

from dataclasses import dataclass, replace
from math import ceil, sqrt
from typing import Annotated

import numpy as np

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.friction import friction_torque
from lwr_dyn.model.run import Reference
from lwr_dyn.trajectory.motion_profile import positive_number, quintic
from lwr_dyn.trajectory.references.joint_moves import JointReference, point_to_point

STEP, LONGEST = 0.15, {JointKind.REVOLUTE: 0.35, JointKind.PRISMATIC: 0.1}
"""Share of its range by which a joint goes to each side of the middle pose, and the most that this may be [rad, m]."""

NARROW = 1e-6
"""[rad or m] A joint with less than this between its limits cannot move."""

PATIENT = 8.0
"""[s] In which a joint passes its way at the share of its speed that is used: a slow lift goes less far."""

HALF = {JointKind.REVOLUTE: np.pi, JointKind.PRISMATIC: 0.25}
"""[rad or m] To each side of 0 (of a single known limit: of where it ends): the range of a joint without limits."""

SPEED, UNKNOWN_SPEED = 0.3, {JointKind.REVOLUTE: 1.0, JointKind.PRISMATIC: 0.25}
"""Share of a speed limit that is used; the speed of a joint without limit [rad/s, m/s]."""

TORQUE, HEAVY, SPARE = 0.6, 0.5, 0.1
"""Share of a torque limit that is used; of weight, with which a pose is taken at once; what a heavy arm has beside."""

MOST_WEIGHT = 0.85
"""Share of a torque limit that weight and friction may take at most."""

POSES, SEED, WITHIN = 200, 0, (0.3, 0.7)
"""Middle poses that are tried, the first with all joints at half of their range; shares of a range for the others."""

LEAST, MOST = 2.0, 60.0
"""[s] Of the duration."""

TIMES = np.linspace(0.0, 1.0, 101)
"""Shares of the duration at which torques are looked at."""

Seconds = Annotated[float | None, Option(float, "Duration, s; if not given, what the limits allow, 2 s at least.")]


@dataclass(frozen=True, slots=True)
class LimitUse:
    """The largest use of known limits by a motion, as a share; None where no limit of the kind is known."""

    speed: float | None
    torque: float | None

    @property
    def fits(self) -> bool:
        """Whether no known limit is passed."""
        return max(self.speed or 0.0, self.torque or 0.0) <= 1.0


def chosen_move(arm: Arm, duration: Seconds = None) -> JointReference:
    """A move inside the arm's own limits, the same for the same arm; its `about` says what was chosen.

    Parameters
    ----------
    arm : Arm
        Without masses, or without torque limits, torques are not looked at.
    duration : float, optional
        [s]

    Raises
    ------
    OptionError
        A duration that is not positive; limits that leave a joint no room; weight and friction take more of the torque
        limits than 85 % at all of the poses that are tried; no duration up to 60 s keeps the limits.

    >>> import lwr_dyn
    >>> move = chosen_move(lwr_dyn.load("wam7"))
    >>> move.duration, move.about["task"]
    (4.2, 'move')
    """
    fixed = [name for name, room in zip(arm.joint_names, arm.upper - arm.lower, strict=True) if room < NARROW]
    if fixed:
        found = f"{arm.name}: the position limits of {', '.join(fixed)} leave no room"
        raise OptionError("task move, robot", found, "limits that do, or --lock JOINT=VALUE")
    dynamics = None if arm.chain.bodies is None else dynamics_of(arm)
    middle = _middle(arm, dynamics)
    step = _half_step(arm)
    move = point_to_point(arm, [middle - step, middle + step], [1.0])
    seconds = _duration(arm, dynamics, move) if duration is None else positive_number("duration", duration)
    move = point_to_point(arm, move.waypoints, [seconds])
    use = limit_use(arm, move, dynamics)
    chosen = {"value": seconds, "kind": "chosen" if duration is None else "assumed"}
    about = {"task": "move", "duration": chosen, "use": {"speed": use.speed, "torque": use.torque}}
    return replace(move, about=about | {"start": move.waypoints[0].tolist(), "end": move.waypoints[1].tolist()})


def ranges(arm: Arm) -> tuple[Array, Array]:
    """Lower and upper ends (n,) [rad or m] of what a joint is moved in: its limits, a turn at most about their middle.

    >>> import lwr_dyn
    >>> low, up = ranges(lwr_dyn.load("lwr4plus"))
    >>> bool((low < up).all())
    True
    """
    half = np.array([HALF[link.kind] for link in arm.chain.links])
    low, up = arm.lower, arm.upper
    known_low, known_up = np.isfinite(low), np.isfinite(up)
    low = np.where(known_low, low, np.where(known_up, up - 2 * half, -half))
    up = np.where(known_up, up, np.where(known_low, low + 2 * half, half))
    turning = np.array([link.kind is JointKind.REVOLUTE for link in arm.chain.links])
    middle, reach = (low + up) / 2, (up - low) / 2
    reach = np.where(turning, np.minimum(reach, np.pi), reach)
    return middle - reach, middle + reach


def limit_use(arm: Arm, motion: Reference, dynamics: Dynamics | None = None) -> LimitUse:
    """The largest shares of the known speed and torque limits that a motion takes; without `dynamics` no torque."""
    found = motion.sample(TIMES * motion.duration)
    speed = np.abs(found.dq) / arm.velocity
    use = float(speed.max()) if np.isfinite(arm.velocity).any() else None
    if dynamics is None or not np.isfinite(arm.effort).any():
        return LimitUse(use, None)
    torque = dynamics.inverse_dynamics(found.q, found.dq, found.ddq) + friction_torque(arm.friction_models(), found.dq)
    return LimitUse(use, float((np.abs(torque) / arm.effort).max()))


def _half_step(arm: Arm) -> Array:
    low, up = ranges(arm)
    far = SPEED * arm.velocity * PATIENT / (2 * quintic(1.0, 1.0).peaks().speed)
    return np.minimum(np.minimum(STEP * (up - low), far), [LONGEST[link.kind] for link in arm.chain.links])


def _weight_use(arm: Arm, dynamics: Dynamics, middle: Array) -> Array:
    """The share of each torque limit (k, n) that holds the arm and overcomes friction, over the move about (k, n)."""
    along = np.linspace(-1.0, 1.0, 5)[:, None, None] * _half_step(arm)
    weight = np.abs(dynamics.gravity_vector(middle + along))
    slow = np.abs(friction_torque(arm.friction_models(), np.full(arm.n, 1e-3)))
    return np.asarray(((weight + slow) / arm.effort).max(axis=0))


def _middle(arm: Arm, dynamics: Dynamics | None) -> Array:
    """The middle pose (n,): the first that the torque limits hold easily, else the one that they hold best."""
    low, up = ranges(arm)
    half = (low + up) / 2
    if dynamics is None or not np.isfinite(arm.effort).any():
        return np.asarray(half)
    shares = np.random.default_rng(SEED).uniform(*WITHIN, (POSES, arm.n))
    middle = np.concatenate([half[None, :], low + shares * (up - low)])
    uses = _weight_use(arm, dynamics, middle)
    worst = uses.max(axis=1)
    easy = np.flatnonzero(worst <= HEAVY)
    best = int(easy[0]) if easy.size else int(np.argmin(worst))
    if worst[best] > MOST_WEIGHT:
        joint = arm.joint_names[int(np.argmax(uses[best]))]
        found = f"{arm.name}: weight and friction take {100 * worst[best]:.0f} % of the torque limit of {joint}"
        raise OptionError("task move, robot", f"{found} at the best of {len(middle)} poses", "a task of your own")
    return np.asarray(middle[best])


def _duration(arm: Arm, dynamics: Dynamics | None, unit: JointReference) -> float:
    """The shortest duration [s], to 0.1 s, that keeps the shares of speed and torque; `unit` is the move in 1 s."""
    limits = np.where(np.isfinite(arm.velocity), SPEED * arm.velocity, np.inf)
    free = np.array([UNKNOWN_SPEED[link.kind] for link in arm.chain.links])
    speed = np.abs(unit.sample(TIMES).dq).max(axis=0)
    seconds = max(LEAST, float((speed / np.minimum(limits, np.where(np.isfinite(limits), np.inf, free))).max()))
    if dynamics is not None and np.isfinite(arm.effort).any():
        weight = float(_weight_use(arm, dynamics, unit.waypoints.mean(axis=0)[None, :]).max())
        allowed = max(TORQUE, weight + SPARE)
        while (limit_use(arm, _in_time(arm, unit, seconds), dynamics).torque or 0.0) > allowed and seconds <= MOST:
            seconds *= sqrt(2.0)
    if seconds > MOST:
        raise OptionError("task move, robot", f"{arm.name} needs more than {MOST:g} s", "a task of your own")
    return ceil(10 * seconds - 1e-9) / 10


def _in_time(arm: Arm, move: JointReference, seconds: float) -> JointReference:
    return point_to_point(arm, move.waypoints, [seconds])
