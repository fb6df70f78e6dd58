"""What a file holds beyond the arm in it: how it is drawn, and of a URDF its own links, frames, axes and shapes.

An arm that was read from a URDF carries its layout, so that the file can be written again; the dynamics uses none of
it. Links are kept as written, before fixed joints weld them together: a fault of one link can vanish in the sum of the
links that move with it, so each is judged by itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lwr_dyn.model.chain import Body, Chain
from lwr_dyn.model.spatial import Pose


@dataclass(frozen=True, slots=True)
class DrawnCylinder:
    """A cylinder drawn for a link, in its URDF frame (in a `Paper`: the frame of its DH row): ends, radius [m]."""

    link: str
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float
    colour: str


@dataclass(frozen=True, slots=True)
class Drawing:
    """How the arm is drawn; the dynamics uses none of these numbers."""

    pedestal: float = 0.0
    radius: tuple[float, ...] = ()
    cylinders: tuple[DrawnCylinder, ...] = ()
    """The file's own shapes; if empty, shapes are derived from the joints."""


@dataclass(frozen=True, slots=True, eq=False)
class WrittenLink:
    """A link of the file; `body` is None where it has no `<inertial>`."""

    link: str
    body: Body | None
    """In the frame of the link that a joint moves; in the frame of the root where nothing moves it."""


def welded(links: Sequence[WrittenLink]) -> Body | None:
    """The links rigidly joined; None where no link has an inertial.

    Zeros on a frame say nothing about the first link, to which the others are welded.
    """
    joined: Body | None = None
    for _, body in heavy(links):
        joined = body if joined is None else joined + body
    return joined


def heavy(links: Sequence[WrittenLink]) -> list[tuple[str, Body]]:
    """The links whose inertials count, with their bodies."""
    given = [(link, link.body) for link in links if link.body is not None]
    return [(link.link, body) for link, body in given if link is links[0] or not body.is_weightless]


@dataclass(frozen=True, slots=True, eq=False)
class FixedLink:
    """A link that moves with another one: by a fixed joint, or by a joint that was locked when the file was read."""

    link: str
    joint: str
    parent: str
    origin: Pose
    """The link in its parent, at the locked value."""


@dataclass(frozen=True, slots=True, eq=False)
class FileJoint:
    """A joint of the chain as the file has it: its links, its origin in the parent, its axis in its own frame."""

    joint: str
    parent: str
    child: str
    origin: Pose
    axis: tuple[float, ...]
    unlimited: bool
    """Whether it is `continuous`."""
    before: Pose
    """The pose before its motion in the chain, which joins fixed joints and turns z onto the axis."""
    transmission: str = ""
    """Its `<transmission>` as XML, without the rotor; empty if the file has none."""


@dataclass(frozen=True, slots=True, eq=False)
class FileLayout:
    """The links and joints of a URDF file that belong to an arm; shapes and materials as XML."""

    root: str
    joints: tuple[FileJoint, ...]
    flange: Pose
    """The chain's flange."""
    fixed: tuple[tuple[FixedLink, ...], ...]
    """The links fixed to the root, then those fixed to each moving link, parents first."""
    shapes: Mapping[str, tuple[str, ...]]
    """Link -> its `<visual>` and `<collision>` elements; meshes are named, not held."""
    inertials: Mapping[str, str]
    """The `<inertial>` of the root and of links fixed to it, which the arm leaves out because they do not move."""
    materials: tuple[str, ...]
    tip: str = ""
    """The link of the flange."""
    written: Mapping[str, tuple[WrittenLink, ...]] = field(default_factory=dict)
    """Link of the chain -> the links of the file that move with it, itself first; "" -> those at rest."""

    def unlimited(self) -> frozenset[str]:
        """The joints that turn without end."""
        return frozenset(joint.joint for joint in self.joints if joint.unlimited)


def fitting(layout: FileLayout | None, chain: Chain) -> FileLayout | None:
    """The layout if the chain still has its joints and frames; None after a change in code, such as a locked joint."""
    if layout is None:
        return None
    frames = [(joint.joint, joint.before) for joint in layout.joints] + [("", layout.flange)]
    theirs = [(link.joint, link.before) for link in chain.links] + [("", chain.flange)]
    same = len(frames) == len(theirs) and all(
        a == b and np.array_equal(x.rotation, y.rotation) and np.array_equal(x.position, y.position)
        for (a, x), (b, y) in zip(frames, theirs, strict=True)
    )
    return layout if same else None
