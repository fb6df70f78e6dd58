"""Solutions of inverse kinematics as rows of one array; a `Solution` is a row's place, read when asked."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, TypedDict

from lwr_dyn.foundation.arrays import Array

TOUCH = 1e-12
"""[rad] A margin this little below a level keeps it: a joint at its limit is inside."""


class SolutionRecord(TypedDict):
    """`Solution.record`."""

    q: Annotated[list[float], "Joint positions, rad (m for sliding joints)."]
    branch: Annotated[str | None, "Signs of shoulder, elbow and wrist; null from the numeric search."]
    arm_angle: Annotated[float | None, "rad; null for an arm that has none, and from the numeric search."]
    margin: Annotated[float, "Distance from the nearest limit, rad (m), negative outside; null where none is known."]
    joint: Annotated[str, "The joint that has this margin."]
    inside_limits: Annotated[bool, "Whether all joints are inside their limits."]
    residual: Annotated[float, "Largest difference that is left between the flange's pose and T."]
    singular: Annotated[list[str], "Singularities nearby: shoulder, elbow, wrist."]


@dataclass(frozen=True, slots=True, eq=False)
class SolutionRows:
    """Solutions of one pose."""

    joint_names: Sequence[str]
    numbers: Array
    """(k, n + 3) q, the margin, the place of the joint that has it, the place of the branch; read-only."""
    branches: Sequence[str]
    """By the place of the branch, as all that follow."""
    arm_angles: Sequence[float | None]
    residuals: Sequence[float]
    singular: Sequence[tuple[str, ...]]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Solution:
    """One set of joint positions for a pose."""

    rows: SolutionRows
    """All solutions that were found with it."""
    place: int
    """Which of them it is."""

    @property
    def q(self) -> Array:
        """(n,) [rad or m], read-only."""
        row: Array = self.rows.numbers[self.place, :-3]
        return row

    @property
    def branch(self) -> str:
        """Signs of shoulder, elbow and wrist ("+-+"); empty from the numeric search."""
        return self.rows.branches[self._kind]

    @property
    def arm_angle(self) -> float | None:
        """[rad]; None for an arm that has none, and from the numeric search."""
        return self.rows.arm_angles[self._kind]

    @property
    def margin(self) -> float:
        """Smallest distance to a position limit [rad or m], negative outside, infinite when no limit is known."""
        return self.rows.numbers.item(self.place, -3)

    @property
    def joint(self) -> str:
        """The joint that has it."""
        return self.rows.joint_names[int(self.rows.numbers.item(self.place, -2))]

    @property
    def inside_limits(self) -> bool:
        """Whether all joints are."""
        return self.margin >= -TOUCH

    @property
    def residual(self) -> float:
        """Largest entry of FK(q) - T [m and dimensionless]."""
        return self.rows.residuals[self._kind]

    @property
    def singular(self) -> tuple[str, ...]:
        """Singularities (shoulder, elbow, wrist) nearer than `spherical_wrist.NEAR_SINGULAR`."""
        return self.rows.singular[self._kind]

    @property
    def _kind(self) -> int:
        return int(self.rows.numbers.item(self.place, -1))

    @property
    def record(self) -> SolutionRecord:
        """For programs."""
        return {
            "q": self.q.tolist(), "branch": self.branch or None, "arm_angle": self.arm_angle, "margin": self.margin,
            "joint": self.joint, "inside_limits": self.inside_limits, "residual": self.residual,
            "singular": list(self.singular),
        }  # fmt: skip

    def __repr__(self) -> str:
        names = ("q", "branch", "arm_angle", "margin", "joint", "inside_limits", "residual", "singular")
        return f"Solution({', '.join(f'{name}={getattr(self, name)!r}' for name in names)})"
