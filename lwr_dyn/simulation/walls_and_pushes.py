"""A push at a point of the arm, and a compliant wall that its tip touches: external torques.

A push is a force with a direction in the base and a course over time, with two continuous derivatives, so that a step
of the simulation keeps its order:

    tau_external = J(q)^T f s(t),   s = 0, smoothly up over `rise`, 1, smoothly down, 0,

with J the Jacobian (3, n) of the point: J^T f is the weight of a unit mass at the point where gravity is -f.

A wall is Hunt and Crossley's contact, with Coulomb's friction along it:

    f_n = k depth^m (1 + c d depth/dt), cut at 0: a wall does not pull
    f_t = -mu f_n v_t / sqrt(v_t^2 + v_s^2)

Without the term c the wall is a spring with the energy k depth^(m+1) / (m+1); c and mu only take energy out, so the
wall is passive, and for slow impacts the share of the speed that comes back is about 1 - 2 c v / 3. With m > 1 the
force starts without a jump of its slope: a run's energy audit then closes where the spring is slow against the sample
(`substeps`).

References
----------
Hunt, Crossley, "Coefficient of restitution interpreted as damping in vibroimpact", J. Appl. Mech. 42 (1975). SI units.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.pinocchio_engine import flange_and_jacobian
from lwr_dyn.dynamics.protocol import ungated
from lwr_dyn.foundation.arrays import Array, arm_argument, fixed_array, joint_array
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, with_bodies

RISE = 0.02
"""[s] A blow of a hard body rises in some ms, a hand in some tens."""


@dataclass(frozen=True, slots=True)
class Course:
    """A push over time [s]: from `start` on for `duration`, of which it rises and falls for `rise` each."""

    start: float
    duration: float
    rise: float = RISE

    def __post_init__(self) -> None:
        for name, least in (("start", -np.inf), ("duration", 0.0), ("rise", 0.0)):
            value = getattr(self, name)
            if not (isfinite(value) and value > least):
                raise OptionError(f"push {name}", value, "a number above 0, in s" if least == 0.0 else "a number, in s")
        if 2 * self.rise > self.duration:
            raise OptionError("push rise", self.rise, f"at most half of the duration, {self.duration / 2:g} s")

    def share(self, t: float) -> float:
        """S(t) of the force, 0 to 1.

        >>> round(Course(1.0, 0.5, 0.1).share(1.05), 12)
        0.5
        """
        x = min(t - self.start, self.start + self.duration - t) / self.rise
        return 0.0 if x <= 0.0 else 1.0 if x >= 1.0 else x**3 * (10.0 + x * (6.0 * x - 15.0))


class Push:
    """A push as an external torque of `simulate`.

    Parameters
    ----------
    arm : Arm
        Its kinematics.
    force : (3,) array_like
        f [N] in the base.
    start, duration, rise : float
        See `Course` [s].
    at : str
        "flange", or the name of a link, such as "link_3".
    point : (3,) array_like
        In the frame of the flange or link [m].

    Raises
    ------
    ShapeError, OptionError
        A force or point that is not three finite numbers; a link that is not there; a course that is none.
    """

    name = "push"

    def __init__(
        self,
        arm: Arm,
        force: ArrayLike,
        start: float,
        duration: float = 0.2,
        rise: float = RISE,
        at: str = "flange",
        point: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        self.force, self.point = fixed_array("push force", force, (3,)), fixed_array("push point", point, (3,))
        self.course, self.at = Course(start, duration, rise), at
        chain, names = arm.chain, [link.link for link in arm.chain.links]
        if at not in ("flange", *names):
            raise OptionError("push at", at, ", ".join(("flange", *names)))
        unit = Body(1.0, self.point, np.zeros((3, 3)))
        unit, place = (unit.seen_from(chain.flange), len(names) - 1) if at == "flange" else (unit, names.index(at))
        bodies = [unit if j == place else Body.massless() for j in range(len(names))]
        weightless = with_bodies(replace(chain, gravity=-self.force), bodies)
        self._pull = ungated(dynamics_of(arm.with_chain(weightless))).gravity_vector
        self._none = np.zeros(arm.n)

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this push, as JSON values."""
        course = {"start": self.course.start, "duration": self.course.duration, "rise": self.course.rise}
        return {"force": self.force.tolist(), "at": self.at, "point": self.point.tolist(), **course}

    def __call__(self, t: float, q: Array, dq: Array) -> Array:
        """tau_external (n,) [N m]."""
        share = self.course.share(t)
        return self._none if share == 0.0 else share * self._pull(q)


STIFFNESS, LOSS, EXPONENT, SLIP_SPEED = 1e5, 1.0, 1.5, 0.01
"""[N/m^m], [s/m], 1, [m/s]: 1 kg that meets it at 0.1 m/s goes 1.7 mm deep."""


class Wall:
    """A plane that one point of an arm's last link touches; an `external` of `simulate`.

    Parameters
    ----------
    arm : Arm
        The arm that touches it.
    place : (3,) array_like
        A point of the plane [m] in the base (the world, for an arm on a mount).
    normal : (3,) array_like
        Out of the wall, towards where the arm is free; any length.
    stiffness : float
        k [N/m^m].
    loss : float
        c [s/m], at least 0.
    exponent : float
        m, at least 1: 1 for a flat contact, 1.5 for a ball (Hertz).
    friction : float
        mu, at least 0.
    slip_speed : float
        v_s [m/s]: below it friction grows with the speed, so a contact at rest creeps.
    point : (3,) array_like
        What touches, in the flange, or in the tool's frame of an arm with a tool [m].

    Raises
    ------
    OptionError, ShapeError
        A number out of its range, a normal without length, arrays of another shape.

    >>> import lwr_dyn
    >>> arm = lwr_dyn.load("lwr4plus")
    >>> table = Wall(arm, [0.0, 0.0, 0.5], [0.0, 0.0, 1.0], stiffness=1e4, exponent=1.0)
    >>> q = [0.0, 1.2, 0.0, 1.2, 0.0, 0.0, 0.0]
    >>> table.forces(q, [0.0] * 7).round(3).tolist(), round(table.energy(q), 3)
    ([0.0, 0.0, 0.0], 0.0)
    """

    name = "wall"

    def __init__(
        self,
        arm: Arm,
        place: ArrayLike,
        normal: ArrayLike,
        stiffness: float = STIFFNESS,
        loss: float = LOSS,
        exponent: float = EXPONENT,
        friction: float = 0.0,
        slip_speed: float = SLIP_SPEED,
        point: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        self._n = arm_argument(arm).n
        for key, value, least, inside in (
            ("stiffness", stiffness, 0.0, False), ("loss", loss, 0.0, True), ("exponent", exponent, 1.0, True),
            ("friction", friction, 0.0, True), ("slip_speed", slip_speed, 0.0, False),
        ):  # fmt: skip
            if not (np.isfinite(value) and (value >= least if inside else value > least)):
                raise OptionError(
                    f"{key} of a wall", value, f"a number {'of at least' if inside else 'above'} {least:g}"
                )
        self.stiffness, self.loss, self.exponent = float(stiffness), float(loss), float(exponent)
        self.friction, self.slip_speed = float(friction), float(slip_speed)
        self.place, self.point = fixed_array("place", place, (3,)), fixed_array("point", point, (3,))
        way = fixed_array("normal", normal, (3,))
        if not way.any():
            raise OptionError("normal of a wall", way.tolist(), "a direction")
        self.normal: Array = way / np.linalg.norm(way)
        self._tip: Callable[[Array], tuple[Array, Array]] = flange_and_jacobian(arm)

    @property
    def parameters(self) -> dict[str, Any]:
        """What makes this wall, as JSON values."""
        numbers = ("stiffness", "loss", "exponent", "friction", "slip_speed")
        arrays = {key: getattr(self, key).tolist() for key in ("place", "normal", "point")}
        return arrays | {key: getattr(self, key) for key in numbers}

    def __call__(self, t: float, q: Array, dq: Array) -> Array:
        """tau_external (n,) [N m]."""
        T, J = self._tip(q)
        arm_of_force = T[:3, :3].dot(self.point)
        depth = self.normal.dot(self.place - T[:3, 3] - arm_of_force)
        if not depth > 0.0:
            return np.zeros(self._n)
        linear = J[:3] + _cross(arm_of_force).T.dot(J[3:])
        torque: Array = linear.T.dot(self._force(depth, linear.dot(dq)))
        return torque

    def _force(self, depth: float, velocity: Array) -> Array:
        """The force (3,) [N] on a point at a depth above 0 [m] that moves with `velocity` (3,) [m/s]."""
        inward = -self.normal.dot(velocity)
        size = max(self.stiffness * depth**self.exponent * (1.0 + self.loss * inward), 0.0)
        if self.friction == 0.0:
            return np.asarray(size * self.normal)
        along = velocity + inward * self.normal
        drag = self.friction / np.sqrt(along.dot(along) + self.slip_speed**2)
        return np.asarray(size * (self.normal - drag * along))

    def touched(self, q: Array) -> tuple[Array, Array]:
        """Place (3,) [m] and Jacobian (3, n) of the touching point at one state q (n,)."""
        T, J = self._tip(q)
        arm_of_force = T[:3, :3].dot(self.point)
        return T[:3, 3] + arm_of_force, J[:3] + _cross(arm_of_force).T.dot(J[3:])

    def depth(self, q: ArrayLike) -> Array:
        """How deep the point is in the wall, (...) [m], negative in front of it, at q (..., n); raises `ShapeError`."""
        states = joint_array("q", q, self._n)
        places = np.array([self.touched(row)[0] for row in states.reshape(-1, self._n)])
        return np.asarray(((self.place - places) @ self.normal).reshape(states.shape[:-1]))

    def forces(self, q: ArrayLike, dq: ArrayLike) -> Array:
        """The force on the arm, (..., 3) [N] in the base, at states q, dq (..., n); raises `ShapeError`."""
        states, speeds = joint_array("q", q, self._n), joint_array("dq", dq, self._n)
        if states.shape != speeds.shape:
            raise ShapeError("dq", f"shape {speeds.shape}", f"{states.shape}, as q")
        out = np.zeros((*states.shape[:-1], 3))
        for force, row, speed in zip(
            out.reshape(-1, 3), *(x.reshape(-1, self._n) for x in (states, speeds)), strict=True
        ):
            place, J = self.touched(row)
            depth = float(self.normal.dot(self.place - place))
            if depth > 0.0:
                force[:] = self._force(depth, J.dot(speed))
        return out

    def energy(self, q: ArrayLike) -> float:
        """The energy of the wall's spring at q (n,) [J]."""
        depth = max(float(self.depth(q)), 0.0)
        return float(self.stiffness * depth ** (self.exponent + 1.0) / (self.exponent + 1.0))


def _cross(v: Array) -> Array:
    """The matrix of v x (3, 3)."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
