"""`Arm`: one robot in SI units, with its chain in the source's frames and its joints and bodies in URDF frames.

The URDF frame of a link is the frame of its joint after the motion: its z axis is the joint axis. The origin of joint i
is given in link i-1. An arm with a payload or other masses is another `Arm`: its chain changes before the roads part.
"""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import Array, fixed_array, joint_array
from lwr_dyn.foundation.errors import MissingDataError, OptionError, RatingWarning, ShapeError, UnknownNameError
from lwr_dyn.foundation.registry import Option, Quantity
from lwr_dyn.model.caveats import ABSENT_ROTORS, ALL, DYNAMICS, ROTOR_OPTION, Caveats, absent_rotors
from lwr_dyn.model.chain import (
    Body,
    Chain,
    Installation,
    JointKind,
    Tool,
    lock_joint,
    unphysical_links,
    with_bodies,
    with_payload,
)
from lwr_dyn.model.file_layout import Drawing, FileLayout
from lwr_dyn.model.friction import JointFriction, symmetric
from lwr_dyn.model.run import repr_html
from lwr_dyn.model.spatial import Pose
from lwr_dyn.model.transmission import JointElasticity, Transmission

COUPLED = 1e-6
"""Share of the largest armature below which what stands between two joints is rounding."""
LINK_SIDE = "link"
"""Of torques that sensors behind the gears measure."""


@dataclass(frozen=True, slots=True)
class Source:
    """The source of a number: the cell of the data file, the page, the kind of number, and how it was converted."""

    cell: str
    where: str
    kind: str
    value: object  # under the reading, in the printed unit; `errata` lists what changed it
    unit: str
    conversion: str
    errata: tuple[str, ...] = ()
    sigma: object = None  # standard error of `value`; None where not given


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Limits and friction of a joint; None is unknown, never zero."""

    lower: float | None = None  # [rad or m]
    upper: float | None = None  # [rad or m]
    velocity: float | None = None  # [rad/s or m/s]
    effort: float | None = None  # [N m or N]
    viscous: float | None = None  # [N m s/rad or N s/m]
    coulomb: float | None = None  # [N m or N]

    @property
    def friction(self) -> JointFriction | None:
        """The same friction in both directions; None where neither part is known."""
        if self.viscous is None and self.coulomb is None:
            return None
        return symmetric(self.coulomb or 0.0, self.viscous or 0.0)


@dataclass(frozen=True, slots=True)
class Ratings:
    """Data sheet values of the whole arm; None is unknown."""

    payload: float | None = None  # [kg]
    mass: float | None = None  # [kg], base included
    base_mass: float | None = None  # [kg]
    reach: float | None = None  # [m]
    envelope_volume: float | None = None  # [m^3]


@dataclass(frozen=True, slots=True, eq=False)
class JointGains:
    """Gains of the joint controller that a source gives, (n,) each; None is unknown (prismatic joints: N/m, ...)."""

    Kp: Array  # [N m/rad]
    Kd: Array  # [N m s/rad]
    Ki: Array | None = None  # [N m/(rad s)]
    effort: Array | None = None  # [N m], at which the controller saturates

    def of_joints(self, joints: Sequence[int]) -> JointGains:
        """The gains of some joints (0-based)."""
        kept = list(joints)
        columns = [None if x is None else x[kept] for x in (self.Ki, self.effort)]
        return JointGains(self.Kp[kept], self.Kd[kept], *columns)


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """A joint as in a URDF: its origin in the frame of the previous link; its axis is z of its own frame."""

    name: str
    kind: JointKind
    origin: Pose
    limits: JointLimits
    armature: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """A robot: its chain, its limits, and the source of each number.

    >>> import lwr_dyn
    >>> lwr_dyn.load("lwr4plus")
    Arm('lwr4plus', reading='physical', n=7)
    >>> lwr_dyn.load("lwr4plus", "computed")
    Arm('lwr4plus', reading='computed', n=7, leaves rotor-inertia-power in place, a proven error)
    """

    name: str
    reading: str
    title: str
    chain: Chain
    limits: tuple[JointLimits, ...]
    drawing: Drawing = field(default_factory=Drawing)
    ratings: Ratings = Ratings()
    mastering: tuple[float, ...] = ()
    """Joint positions of the maker's mastering pose [rad or m]; empty when not given."""
    sources: Mapping[str, tuple[Source, ...]] = field(default_factory=dict)
    """Quantity ("link_3.mass", "joint_2.lower") -> the cells it was computed from."""
    errata: tuple[str, ...] = ()
    digest: str = ""  # SHA-256 of the source file
    file: str = ""  # path of a user's own file, empty for a robot that comes with the package
    loaded_with: Mapping[str, Any] = field(default_factory=dict)
    """The tip, locked joints, mount and tool it was loaded with, as JSON values."""
    friction: tuple[JointFriction | None, ...] = ()
    """Friction per joint and direction, empty if the source gives at most a pair in `limits`; see `friction_models`."""
    transmission: Transmission | None = None
    """The motor map; None if not given."""
    torques: str = ""
    """Where its own torques are measured: "motor", or "link" behind the gears, where rotors are no part of them."""
    gains: JointGains | None = None
    """The gains of the arm's own joint controller; None if not given."""
    elasticity: JointElasticity | None = None  # springs and dampers of the gears; None if not given
    layout: FileLayout | None = None
    """The rest of the URDF file that it was read from."""
    installation: Installation | None = None
    """Its mount and tool; None for an arm that stands on its base and ends at its flange."""
    notes: tuple[str, ...] = ()
    """What was chosen when it was loaded: the tip, joints that are held."""
    caveats: Caveats = field(default_factory=Caveats)
    """Proven errors that its reading leaves in place, and which of its numbers are estimated or assumed."""
    _repr_html_ = repr_html

    def __repr__(self) -> str:
        parts = [f"{self.name!r}, reading={self.reading!r}, n={self.n}", self.caveats.of_reading]
        return f"Arm({', '.join(filter(None, parts))})"

    def caveat(self, used: Collection[str] = ALL) -> str:
        """What must be known before its numbers, of those that are `used`: one line with its name, or nothing.

        >>> import lwr_dyn
        >>> lwr_dyn.load("lwr4plus", "computed").caveat(used=())
        'lwr4plus (computed): leaves rotor-inertia-power in place, a proven error'
        """
        bad = unphysical_links(self.chain) if "inertias" in used else ()
        body = f"no body can have the inertia of {', '.join(bad)}" if bad else ""
        coupled = self.coupled_rotors if "rotor inertias" in used else ""
        load = self.friction_with_load if "friction" in used else ""
        words = "; ".join(filter(None, (self.caveats.words(used), body, coupled, load)))
        return f"{self.name} ({self.reading}): {words}" if words else ""

    @property
    def coupled_rotors(self) -> str:
        """What rotors between joints would add, in words: no model here holds it; nothing where there are none.

        >>> import lwr_dyn
        >>> lwr_dyn.load("tx40").coupled_rotors
        'left out: a rotor that turns with joint_5 and joint_6 adds 0.0105 kg m^2 between them'
        """
        if self.transmission is None or self.transmission.n != self.n:
            return ""
        added = np.triu(self.transmission.between_joints(self.armature))
        pairs = np.argwhere(np.abs(added) > COUPLED * np.abs(self.armature).max())
        said = [
            f"a rotor that turns with {self.joint_names[i]} and {self.joint_names[j]} adds {added[i, j]:.3g} kg m^2"
            for i, j in pairs
        ]
        return f"left out: {', '.join(said)} between them" if said else ""

    @property
    def friction_with_load(self) -> str:
        """The shares of the load by which friction grows, in words: no run has it; nothing where there are none.

        References
        ----------
        Hamon, Gautier, Garrec, Dynamic identification of robots with a dry friction model depending on load and
        velocity (2010).
        """
        pairs = zip(self.joint_names, self.friction, strict=False)
        said = [f"{x.load:.2g} of it at {name}" for name, x in pairs if x is not None and x.load > 0.0]
        return f"left out: friction that grows with the load, {', '.join(said)}" if said else ""

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.chain.n

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints from the base outward."""
        return tuple(link.joint for link in self.chain.links)

    def rotor_caveat(self, remedy: str = ROTOR_OPTION) -> str:
        """Which joints have no rotor inertia, on which gains and rates rest, and a remedy: a line, or nothing."""
        words = absent_rotors([link.joint for link in self.chain.links if link.rotor is None], self.n, remedy)
        return f"{self.name} ({self.reading}): {words}" if words else ""

    def joints(self) -> tuple[Joint, ...]:
        """The joints in URDF frames; a mount is part of the first origin."""
        out, after = [], Pose.identity()
        for link, limits in zip(self.chain.links, self.limits, strict=True):
            armature = None if link.rotor is None else link.rotor.armature
            out.append(Joint(link.joint, link.kind, after @ link.before, limits, armature))
            after = link.after
        return tuple(out)

    def bodies(self) -> tuple[Body | None, ...]:
        """The links' bodies in URDF frames; None where no inertia is given."""
        return tuple(None if link.body is None else link.body.seen_from(link.after) for link in self.chain.links)

    def friction_models(self) -> tuple[JointFriction | None, ...]:
        """Friction of every joint, per direction if given, else the pair in `limits`; None where unknown."""
        given = self.friction or (None,) * self.n
        return tuple(model or limits.friction for model, limits in zip(given, self.limits, strict=True))

    @property
    def has_friction(self) -> bool:
        """Whether friction of some joint is given that is not zero at all speeds, as zeros of a URDF are."""
        return any(model is not None and not model.is_zero for model in self.friction_models())

    def flange(self) -> Pose:
        """The flange, or the centre point of the tool, in the URDF frame of the last link."""
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
        return self.chain.armature

    def with_chain(self, chain: Chain) -> Arm:
        """The arm with another chain (a payload, other bodies); changed bodies lose their sources."""
        changed = {a.link for a, b in zip(chain.links, self.chain.links, strict=True) if a.body is not b.body}
        sources = {name: cells for name, cells in self.sources.items() if name.split(".")[0] not in changed}
        return replace(self, chain=chain, sources=sources)

    def installed(self, mount: Pose | None, tool: Tool) -> Arm:
        """The arm on a mount and with a tool, whose mass becomes part of the last link; no mount leaves the base."""
        load = with_payload(self.chain, tool.mass, tool.com, tool.inertia_com) if tool.mass else self.chain
        there = Installation.of(load, mount, tool)
        return replace(self.with_chain(load), chain=there.put_on(load), installation=there)

    def uninstalled(self) -> Arm:
        """The arm from its base to its flange, as its source has it; the mass of a tool stays part of the last link."""
        there = self.installation
        return self if there is None else replace(self, chain=there.taken_off(self.chain), installation=None)

    def with_locked_joint(self, joint: str, value: float) -> Arm:
        """The arm with one joint fixed at `value` [rad or m], so n - 1 joints.

        Raises `UnknownNameError` for a joint that does not exist, `OptionError` outside its limits or for the last one.
        """
        if joint not in self.joint_names:
            raise UnknownNameError(f"joint of {self.name}", joint, self.joint_names)
        index = self.joint_names.index(joint)
        if not self.lower[index] <= value <= self.upper[index]:
            raise OptionError(f"lock of {joint}", value, f"{self.lower[index]:g} to {self.upper[index]:g}")
        if self.n == 1:
            raise OptionError(f"lock of {joint}", "the last joint", "at least one joint that moves")
        if self.installation is not None:
            mount, tool = self.installation.mount, replace(self.installation.tool, mass=0.0)
            return self.uninstalled().with_locked_joint(joint, value).installed(mount, tool)
        fixed = {self.chain.links[index].link, joint} | ({self.chain.links[index - 1].link} if index else set())
        sources = {name: cells for name, cells in self.sources.items() if name.split(".")[0] not in fixed}
        chain = lock_joint(self.chain, index, value)
        kept = [i for i in range(self.n) if i != index]
        return replace(
            self, chain=chain, sources=sources, limits=tuple(self.limits[i] for i in kept),
            friction=tuple(self.friction[i] for i in kept) if self.friction else (),
            gains=None if self.gains is None else self.gains.of_joints(kept), transmission=None,
            elasticity=None if self.elasticity is None else self.elasticity.of_joints(kept),
            drawing=replace(self.drawing, radius=tuple(self.drawing.radius[i] for i in kept if self.drawing.radius)),
        )  # fmt: skip

    def require_dynamics(self) -> Chain:
        """The chain when every link has a body; raises `MissingDataError` otherwise."""
        if self.chain.bodies is None:
            bare = [link.link for link in self.chain.links if link.body is None]
            which = "" if len(bare) == self.n else f" of {', '.join(bare)}"
            raise MissingDataError(self.name, f"masses and inertias{which}", "dynamics")
        return self.chain


def caveats_of(arms: Iterable[Arm], used: Collection[str] = DYNAMICS, remedy: str = ROTOR_OPTION) -> tuple[str, ...]:
    """What must be known before numbers of some arms, of those that are `used`: each line once."""
    lines = ((arm.caveat(used), arm.rotor_caveat(remedy) if ABSENT_ROTORS in used else "") for arm in arms)
    return tuple(dict.fromkeys(line for pair in lines for line in pair if line))


def arm_with_payload(arm: Arm, mass: float, com: ArrayLike = (0.0, 0.0, 0.0), inertia_com: Any = None) -> Arm:
    """The arm with a payload fixed to its flange: mass [kg], com (3,) [m] and inertia in the flange frame.

    Give it to the plant alone and the payload is unknown to the controller; build the controller's dynamics on it
    too and it is known. Raises `OptionError` for a negative mass, `ShapeError` for other shapes; warns with
    `RatingWarning` of a mass over the rated payload.
    """
    rated = arm.ratings.payload
    if rated is not None and mass > rated:
        warnings.warn(
            f"{arm.name}: a payload of {mass:g} kg is over the rated {rated:g} kg", RatingWarning, stacklevel=2
        )
    return arm.with_chain(with_payload(arm.chain, mass, com, inertia_com))


def arm_with_scaled_inertia(arm: Arm, factor: float) -> Arm:
    """The arm with every mass and inertia multiplied by `factor`; raises `OptionError` unless it is above 0."""
    if not (np.isfinite(factor) and factor > 0.0):
        raise OptionError("mass factor", factor, "a number above 0")
    bodies = [
        replace(b, mass=factor * b.mass, inertia_com=factor * b.inertia_com)
        for b in arm.require_dynamics().bodies or ()
    ]
    return replace(arm, chain=with_bodies(arm.chain, bodies))


def positions(arm: Arm, values: tuple[float, ...], name: str) -> Array:
    """Joint positions of an option (n,) [rad or m]; raises `ShapeError`, which names the arm."""
    if len(values) != arm.n:
        raise ShapeError(name, f"{len(values)} numbers", f"{arm.n} numbers: {arm.name} has {arm.n} joints")
    return joint_array(name, values, arm.n)


def from_degrees(arm: Arm, values: tuple[float, ...], name: str) -> Array:
    """Joint positions given in deg (m for sliding joints) as rad and m; raises `ShapeError`."""
    q = positions(arm, values, name)
    return np.where(arm.chain.turning, np.radians(q), q)


def si_value(option: Option, value: Any, arm: Arm, name: str) -> Any:
    """A value of an option as its factory takes it [rad, m]; `name` is what messages call it. Raises `ShapeError`."""
    if option.kind is bool:
        return not option.default
    if option.kind is Quantity.ANGLE:
        return float(np.radians(value))
    if option.kind is Quantity.ANGLES:
        return np.radians(fixed_array(name, value, (3,)))
    return from_degrees(arm, value, name) if option.kind is Quantity.JOINT_POSITIONS else value
