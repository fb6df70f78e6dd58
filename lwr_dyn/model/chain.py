"""`Chain`: the serial arm in the frames of its source; both roads to the dynamics start from it.

    T_{i-1,i}(q) = before_i @ motion_z(q_i) @ after_i

Standard DH has before = identity, modified DH has after = Rz Tz only, a URDF has its joint origin before and a rotation
of the axis after. A payload, a changed mass and a locked joint are Chain -> Chain, so both roads include them.

Denavit-Hartenberg rows are constant poses before and after the joint's motion:

standard  T_{i-1,i} = Rz(theta) Tz(d) Tx(a) Rx(alpha)        (Denavit and Hartenberg 1955; Siciliano eq. 2.52)
modified  T_{i-1,i} = Rx(alpha) Tx(a) Rz(theta) Tz(d)        (Craig, Introduction to Robotics, eq. 3.6)

theta = sign q + theta_offset for a revolute joint, d = sign q + d for a prismatic one. `sign` is -1 where the source's
positive direction is against the DH axis; half turns about x before and after the motion express it. `beta` follows
alpha, Rx(alpha) Ry(beta) (Hayati and Mirmirani 1985): axes that are almost parallel meet too far away for DH alone.

A mount and a tool are Chain -> Chain too:

    T_world,tool(q) = T_world,base  T_base,flange(q)  T_flange,tool

The first frame of the chain is then the world, whose z is up, and the last one the tool centre point.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, fixed_array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.spatial import Pose, principal_moments, rot_x, rot_y, rot_z, steiner, symmetric_part


class Convention(enum.Enum):
    """The DH convention of a table; there is no default."""

    STANDARD = "standard"
    MODIFIED = "modified"


class JointKind(enum.Enum):
    """The motion of a joint: about its axis or along it."""

    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"


@dataclass(frozen=True, slots=True)
class DHRow:
    """One row of a DH table: angles [rad], lengths [m]."""

    alpha: float
    a: float
    d: float
    theta_offset: float = 0.0
    sign: int = 1
    beta: float = 0.0

    def fixed_poses(self, convention: Convention) -> tuple[Pose, Pose]:
        """The constant poses around the motion: T_{i-1,i}(q) = before @ motion_z(q) @ after.

        >>> before, after = DHRow(alpha=0.0, a=0.5, d=0.2).fixed_poses(Convention.STANDARD)
        >>> before.is_identity(), after.position
        (True, array([0.5, 0. , 0.2]))
        """
        bend = Pose(rot_x(self.alpha) @ rot_y(self.beta), np.array([self.a, 0.0, 0.0]))
        rise = Pose(rot_z(self.theta_offset), np.array([0.0, 0.0, self.d]))
        if convention is Convention.STANDARD:
            before, after = Pose.identity(), rise @ bend
        else:
            before, after = bend, rise
        if self.sign < 0:
            half_turn = Pose(rot_x(np.pi), np.zeros(3))
            before, after = before @ half_turn, half_turn @ after
        return before, after


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A rigid body in its link's frame."""

    mass: float  # [kg]
    com: Array  # (3,) [m]
    inertia_com: Array  # (3, 3) [kg m^2], about the centre of mass
    unknown: tuple[int, ...] = ()
    """Which of (m, m c, Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the origin) the source leaves open, 0-based: zeros here."""

    def __post_init__(self) -> None:
        freeze_arrays(self, "com", "inertia_com")

    @classmethod
    def massless(cls) -> Body:
        """The massless body."""
        return cls(0.0, np.zeros(3), np.zeros((3, 3)))

    @property
    def is_weightless(self) -> bool:
        """Whether it is known to be nothing, as the zeros on a frame."""
        return self.mass == 0.0 and not self.inertia_com.any() and not self.unknown

    def inertia_origin(self) -> Array:
        """The tensor about the origin of the link's frame, (3, 3) [kg m^2]."""
        return self.inertia_com + steiner(self.mass, self.com)

    def seen_from(self, pose: Pose) -> Body:
        """The same body in the frame in which `pose` is given."""
        r = pose.rotation
        unknown = self.unknown and (self.unknown if pose.is_identity() else tuple(range(10)))
        return Body(self.mass, r @ self.com + pose.position, symmetric_part(r @ self.inertia_com @ r.T), unknown)

    def __add__(self, other: Body) -> Body:
        """Two bodies in the same frame, rigidly joined."""
        if self.is_weightless or other.is_weightless:
            return self if other.is_weightless else other
        unknown = tuple(sorted({*self.unknown, *other.unknown}))
        mass = self.mass + other.mass
        if mass == 0.0:
            return Body(0.0, np.zeros(3), self.inertia_com + other.inertia_com, unknown)
        com = (self.mass * self.com + other.mass * other.com) / mass
        tensor = self.inertia_com + steiner(self.mass, self.com - com)
        return Body(mass, com, tensor + other.inertia_com + steiner(other.mass, other.com - com), unknown)


@dataclass(frozen=True, slots=True)
class Rotor:
    """A motor's rotor on the link before its joint; it turns `gear_ratio` times as fast about the joint's axis."""

    gear_ratio: float
    inertia: float
    """Moment of inertia about its own axis [kg m^2]."""
    reflected: bool = False
    """`inertia` is reflected to the joint, and `gear_ratio` is 1 because it is unknown: no spin couplings."""

    @property
    def armature(self) -> float:
        """The rotor's inertia reflected to the joint, k_r^2 I_m [kg m^2]."""
        return self.gear_ratio**2 * self.inertia


@dataclass(frozen=True, slots=True, eq=False)
class ChainLink:
    """A joint and the link it moves; `body` is None where the source gives no inertia."""

    joint: str
    link: str
    kind: JointKind
    before: Pose
    after: Pose
    body: Body | None = None
    rotor: Rotor | None = None

    def pose(self, q: float) -> Pose:
        """T_{i-1,i}(q), q in rad or m."""
        return self.before @ joint_motion(self.kind, q) @ self.after


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """A serial arm: links from the base outward, the flange in the last link's frame, gravity in the base [m/s^2]."""

    links: tuple[ChainLink, ...]
    flange: Pose
    gravity: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "gravity")

    def __repr__(self) -> str:
        return f"Chain(n={self.n}, joints={', '.join(link.joint for link in self.links)})"

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.links)

    @property
    def bodies(self) -> tuple[Body, ...] | None:
        """The bodies in order; None if one is not given."""
        bodies = tuple(link.body for link in self.links if link.body is not None)
        return bodies if len(bodies) == self.n else None

    @property
    def turning(self) -> NDArray[np.bool_]:
        """Whether a joint turns, (n,); others slide."""
        return np.array([link.kind is JointKind.REVOLUTE for link in self.links])

    @property
    def armature(self) -> Array:
        """Rotor inertia seen at the joints (n,) [kg m^2 or kg], 0 where no rotor is given."""
        return np.array([0.0 if link.rotor is None else link.rotor.armature for link in self.links])


def joint_motion(kind: JointKind, q: float) -> Pose:
    """The motion of a joint: rotation about z by q [rad], or translation along z by q [m]."""
    if kind is JointKind.REVOLUTE:
        return Pose(rot_z(q), np.zeros(3))
    return Pose(np.eye(3), np.array([0.0, 0.0, q]))


def link_frames(chain: Chain, q: Array) -> Iterator[Array]:
    """T_{0,1}(q) ... T_{0,n}(q) and T_{0,flange}(q), each (..., 4, 4), for q (..., n)."""
    batch = q.shape[:-1]
    pose, motion = np.broadcast_to(np.eye(4), (*batch, 4, 4)), np.empty((*batch, 4, 4), q.dtype)
    for i, link in enumerate(chain.links):
        motion[...] = np.eye(4)
        if link.kind is JointKind.REVOLUTE:
            c, s = np.cos(q[..., i]), np.sin(q[..., i])
            motion[..., 0, 0], motion[..., 0, 1] = c, -s
            motion[..., 1, 0], motion[..., 1, 1] = s, c
        else:
            motion[..., 2, 3] = q[..., i]
        pose = followed_by(followed_by(pose, link.before) @ motion, link.after)
        yield pose
    yield followed_by(pose, chain.flange)


def followed_by(poses: Array, constant: Pose) -> Array:
    """Poses (..., 4, 4), then a constant one: all rows in one product, several times as fast as one a pose."""
    product: Array = (poses.reshape(-1, 4) @ constant.matrix()).reshape(poses.shape)
    return product


def with_payload(chain: Chain, mass: float, com: Any = (0.0, 0.0, 0.0), inertia_com: Any = None) -> Chain:
    """The chain with a load fixed to its flange: mass [kg], com (3,) [m] and inertia (3, 3) [kg m^2], flange axes.

    The inertia is about the load's own centre of mass; a point mass if not given. Raises `OptionError` for a mass that
    is negative or not finite.
    """
    if not (np.isfinite(mass) and mass >= 0.0):
        raise OptionError("payload mass", mass, "a number >= 0, in kg")
    tensor = np.zeros((3, 3)) if inertia_com is None else fixed_array("payload inertia", inertia_com, (3, 3))
    load = Body(float(mass), fixed_array("payload com", com, (3,)), tensor).seen_from(chain.flange)
    last = chain.links[-1]
    body = load if last.body is None else last.body + load
    return replace(chain, links=(*chain.links[:-1], replace(last, body=body)))


def with_bodies(chain: Chain, bodies: Sequence[Body]) -> Chain:
    """The chain with other bodies, one per link."""
    links = tuple(replace(link, body=body) for link, body in zip(chain.links, bodies, strict=True))
    return replace(chain, links=links)


def lock_joint(chain: Chain, index: int, value: float) -> Chain:
    """The chain with joint `index` (0-based) fixed at `value` [rad or m]: its link becomes part of the previous one.

    The rotor of a locked joint no longer turns; its mass belongs to the link that carries it.
    """
    locked = chain.links[index]
    fixed = locked.pose(value)
    links = list(chain.links)
    if index > 0 and locked.body is not None:
        before = links[index - 1]
        moved = locked.body.seen_from(fixed)
        links[index - 1] = replace(before, body=moved if before.body is None else before.body + moved)
    flange = chain.flange
    if index + 1 < chain.n:
        after = links[index + 1]
        links[index + 1] = replace(after, before=fixed @ after.before)
    else:
        flange = fixed @ flange
    del links[index]
    return replace(chain, links=tuple(links), flange=flange)


def first_links(chain: Chain, count: int) -> Chain:
    """The first `count` links only; the flange is then the frame of the last of them."""
    return replace(chain, links=chain.links[:count], flange=Pose.identity()) if count < chain.n else chain


ROUNDING = 1e-12
"""Allowed rounding error relative to the largest principal moment; a point mass and a thin rod are limit cases."""


def is_physical(body: Body) -> bool:
    """Whether a distribution of mass can have this body's inertia.

    The mass is not negative, the tensor about the centre of mass is symmetric, its principal moments I1 <= I2 <= I3 are
    not negative, and I1 + I2 >= I3 (the second moments of mass are not negative). Zero mass needs zero inertia. A body
    of which a part is unknown is not judged.

    >>> is_physical(Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.0])))
    True
    >>> is_physical(Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.1])))
    False
    """
    tensor = body.inertia_com
    if body.unknown:
        return True
    if not (np.isfinite(body.mass) and np.isfinite(body.com).all() and np.isfinite(tensor).all()):
        return False
    if body.mass <= 0.0:
        return bool(body.mass == 0.0 and (tensor == 0.0).all())
    slack = ROUNDING * float(np.abs(tensor).max())
    if np.abs(tensor - tensor.T).max() > slack:
        return False
    smallest, middle, largest = principal_moments(tensor)
    return bool(smallest >= -slack and smallest + middle >= largest - slack)


@lru_cache(maxsize=32)  # a chain does not change, and every run asks
def unphysical_links(chain: Chain) -> tuple[str, ...]:
    """Names of the links with an infeasible inertia, from the base outward; links without a body are skipped."""
    return tuple(link.link for link in chain.links if link.body is not None and not is_physical(link.body))


MOUNTS = {
    "floor": Pose.identity(),
    "wall": Pose(rot_y(math.pi / 2), np.zeros(3)),
    "ceiling": Pose(rot_x(math.pi), np.zeros(3)),
}
"""Base in the world: on a wall z of the base is along x of the world and its x downward, on a ceiling its z is down."""


@dataclass(frozen=True, slots=True, eq=False)
class Tool:
    """A tool on the flange: its centre point, and its body as data sheets and robot controllers give it."""

    frame: Pose = field(default_factory=Pose.identity)
    """The tool centre point in the flange."""
    mass: float = 0.0  # [kg]
    com: Array = field(default_factory=lambda: np.zeros(3))  # (3,) in the flange [m]
    inertia_com: Array = field(default_factory=lambda: np.zeros((3, 3)))  # [kg m^2] about com, axes of the flange

    def __post_init__(self) -> None:
        freeze_arrays(self, "com", "inertia_com")


@dataclass(frozen=True, slots=True, eq=False)
class Installation:
    """A mount and a tool, with the two frames of the chain that they took the place of."""

    mount: Pose | None
    """The base in the world; None where nothing is said."""
    tool: Tool
    first: Pose
    """Joint 1 in the base, before its motion."""
    flange: Pose
    """The flange in the frame of the last link."""

    @classmethod
    def of(cls, chain: Chain, mount: Pose | None, tool: Tool) -> Self:
        """The installation of an arm that has none."""
        return cls(mount, tool, chain.links[0].before, chain.flange)

    def put_on(self, chain: Chain) -> Chain:
        """The chain from the world to the tool centre point; gravity keeps its size and points down."""
        (place, _), gravity = ends_of(self), chain.gravity
        if self.mount is not None:
            gravity = np.array([0.0, 0.0, 0.0 - math.hypot(*gravity)])
        return replace(_with_ends(chain, place @ self.first, self.flange @ self.tool.frame), gravity=gravity)

    def taken_off(self, chain: Chain) -> Chain:
        """The chain from base to flange again; the tool's mass and the direction of gravity stay."""
        return _with_ends(chain, self.first, self.flange)


def ends_of(there: Installation | None) -> tuple[Pose, Pose]:
    """The base in the first frame of the chain, and the flange in its last one; identities without an installation."""
    if there is None:
        return Pose.identity(), Pose.identity()
    return Pose.identity() if there.mount is None else there.mount, there.tool.frame.inverse()


def names_of_ends(there: Installation | None) -> tuple[str, str]:
    """What the first and the last frame of the chain are, in words."""
    first = "base" if there is None or there.mount is None else "world"
    return first, "flange" if there is None or there.tool.frame.is_identity() else "tool centre point"


def _with_ends(chain: Chain, first: Pose, flange: Pose) -> Chain:
    links = (replace(chain.links[0], before=first), *chain.links[1:])
    return replace(chain, links=links, flange=flange)
