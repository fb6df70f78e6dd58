"""A push at a point of the arm: a force with a direction in the base and a course over time.

    tau_external = J(q)^T f s(t),   s = 0, smoothly up over `rise`, 1, smoothly down, 0,

with J the Jacobian (3, n) of the point. J^T f is the weight of a unit mass at the point where
gravity is -f.
The course has two continuous derivatives, so that a step of the simulation keeps its order.
"""

from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import ungated
from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.errors import OptionError
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
