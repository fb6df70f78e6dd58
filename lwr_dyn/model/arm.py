"""`Arm`: one robot in SI units and URDF frames, free of any paper's convention; it carries its native chain.

The URDF frame of a link is its moved joint frame: the axis is z, the origin of joint i stands in link i-1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import MissingDataError, OptionError, UnknownNameError
from lwr_dyn.model.chain import Body, Chain, lock_joint
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.friction.models import JointFriction
from lwr_dyn.model.spatial import Pose
from lwr_dyn.model.transmission import Transmission


@dataclass(frozen=True, slots=True)
class Source:
    """Where a number comes from: the cell of a data file, the page, and how it became what it is."""

    cell: str
    where: str
    kind: str
    value: object
    """As the reading takes it, in the printed unit; `errata` names what changed it."""
    unit: str
    conversion: str
    errata: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class JointLimits:
    """What is known of a joint: [rad or m], [rad/s or m/s], [N m or N]; None is unknown, never zero."""

    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None
    viscous: float | None = None
    coulomb: float | None = None


@dataclass(frozen=True, slots=True)
class DrawnCylinder:
    """A cylinder of a link's drawing, in the link's URDF frame: ends and radius [m]."""

    link: str
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float
    colour: str


@dataclass(frozen=True, slots=True)
class Drawing:
    """How the arm is drawn: no number of it enters the dynamics."""

    pedestal: float = 0.0
    radius: tuple[float, ...] = ()
    cylinders: tuple[DrawnCylinder, ...] = ()
    """The file's own shapes; drawn from the joints' places when there are none."""


@dataclass(frozen=True, slots=True)
class Ratings:
    """What a data sheet says of the whole arm: [kg], [m], [m^3]; None is unknown."""

    payload: float | None = None
    mass: float | None = None
    """With its base."""
    base_mass: float | None = None
    reach: float | None = None
    envelope_volume: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class JointGains:
    """Gains of the joint controller that a source gives, (n,) each.

    Kp [N m/rad], Kd [N m s/rad], Ki [N m/(rad s)], and the torques [N m] at which that controller cuts; None where not
    given (N/m and so on for sliding joints).
    """

    Kp: Array
    Kd: Array
    Ki: Array | None = None
    effort: Array | None = None

    def of_joints(self, joints: Sequence[int]) -> JointGains:
        """The gains of some joints (0-based)."""
        kept = list(joints)
        columns = [None if x is None else x[kept] for x in (self.Ki, self.effort)]
        return JointGains(self.Kp[kept], self.Kd[kept], *columns)


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """A joint in URDF terms: its origin in the link before it; its axis is z of its own frame."""

    name: str
    kind: JointKind
    origin: Pose
    limits: JointLimits
    armature: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """A robot: its native chain, its limits, and where each number comes from."""

    name: str
    reading: str
    title: str
    chain: Chain
    limits: tuple[JointLimits, ...]
    drawing: Drawing = Drawing()
    ratings: Ratings = Ratings()
    mastering: tuple[float, ...] = ()
    """Joint positions at which the maker masters the arm [rad or m]; empty when not given."""
    sources: Mapping[str, tuple[Source, ...]] = field(default_factory=dict)
    """Quantity ("link_3.mass", "joint_2.lower") -> the cells it was made from."""
    errata: tuple[str, ...] = ()
    digest: str = ""
    """SHA-256 of the source file."""
    file: str = ""
    """Path of a user's own file, empty for a robot that comes with the package."""
    loaded_with: Mapping[str, Any] = field(default_factory=dict)
    """The tip and the locked joints it was loaded with, as JSON values."""
    friction: tuple[JointFriction | None, ...] = ()
    """Friction per joint and direction, empty where the source gives none beyond the pair in `limits`; read it
    through `lwr_dyn.papers.actuation.friction_of`."""
    transmission: Transmission | None = None
    """The motor map, where the source gives one."""
    gains: JointGains | None = None
    """The gains of the arm's own joint controller, where the source gives them."""

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.chain.n

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints from the base outward."""
        return tuple(link.joint for link in self.chain.links)

    def joints(self) -> tuple[Joint, ...]:
        """The joints in URDF frames."""
        out, after = [], Pose.identity()
        for link, limits in zip(self.chain.links, self.limits, strict=True):
            armature = None if link.rotor is None else link.rotor.armature
            out.append(Joint(link.joint, link.kind, after @ link.before, limits, armature))
            after = link.after
        return tuple(out)

    def bodies(self) -> tuple[Body | None, ...]:
        """The links' bodies in URDF frames; None where no inertia is given."""
        return tuple(None if link.body is None else link.body.seen_from(link.after) for link in self.chain.links)

    def flange(self) -> Pose:
        """The flange in the URDF frame of the last link."""
        return self.chain.links[-1].after @ self.chain.flange

    @property
    def lower(self) -> Array:
        """Lower position limits (n,) [rad or m], -inf where unknown."""
        return np.array([-np.inf if x.lower is None else x.lower for x in self.limits])

    @property
    def upper(self) -> Array:
        """Upper position limits (n,) [rad or m], inf where unknown."""
        return np.array([np.inf if x.upper is None else x.upper for x in self.limits])

    @property
    def velocity(self) -> Array:
        """Speed limits (n,) [rad/s or m/s], inf where unknown."""
        return np.array([np.inf if x.velocity is None else x.velocity for x in self.limits])

    @property
    def effort(self) -> Array:
        """Torque or force limits (n,) [N m or N], inf where unknown."""
        return np.array([np.inf if x.effort is None else x.effort for x in self.limits])

    @property
    def armature(self) -> Array:
        """Rotor inertia seen at the joints (n,) [kg m^2 or kg], 0 where no rotor is given."""
        return np.array([0.0 if link.rotor is None else link.rotor.armature for link in self.chain.links])

    def with_chain(self, chain: Chain) -> Arm:
        """The same joints on a changed chain (a payload, other bodies): changed bodies lose their sources."""
        changed = {a.link for a, b in zip(chain.links, self.chain.links, strict=True) if a.body is not b.body}
        sources = {name: cells for name, cells in self.sources.items() if name.split(".")[0] not in changed}
        return replace(self, chain=chain, sources=sources)

    def with_locked_joint(self, joint: str, value: float) -> Arm:
        """The arm with one joint held at `value` [rad or m] and one joint less.

        Raises `UnknownNameError` for a joint that does not exist, `OptionError` for a value outside its limits, or
        when no joint would be left.
        """
        if joint not in self.joint_names:
            raise UnknownNameError(f"joint of {self.name}", joint, self.joint_names)
        index = self.joint_names.index(joint)
        if not self.lower[index] <= value <= self.upper[index]:
            raise OptionError(f"lock of {joint}", value, f"{self.lower[index]:g} to {self.upper[index]:g}")
        if self.n == 1:
            raise OptionError(f"lock of {joint}", "the last joint", "at least one joint that moves")
        welded = {self.chain.links[index].link, joint} | ({self.chain.links[index - 1].link} if index else set())
        sources = {name: cells for name, cells in self.sources.items() if name.split(".")[0] not in welded}
        chain = lock_joint(self.chain, index, value)
        left = [i for i in range(self.n) if i != index]
        return replace(
            self, chain=chain, sources=sources, limits=tuple(self.limits[i] for i in left),
            friction=tuple(self.friction[i] for i in left) if self.friction else (),
            gains=None if self.gains is None else self.gains.of_joints(left), transmission=None,
            drawing=replace(self.drawing, radius=tuple(self.drawing.radius[i] for i in left if self.drawing.radius)),
        )  # fmt: skip

    def require_dynamics(self) -> Chain:
        """The chain when every link has a body; raises `MissingDataError` otherwise."""
        if self.chain.bodies is None:
            bare = [link.link for link in self.chain.links if link.body is None]
            which = "" if len(bare) == self.n else f" of {', '.join(bare)}"
            raise MissingDataError(self.name, f"masses and inertias{which}", "dynamics")
        return self.chain
