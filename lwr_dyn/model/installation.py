"""Where an arm is mounted and what tool it carries: Chain -> Chain, so both roads, files and kernels include them.

    T_world,tool(q) = T_world,base  T_base,flange(q)  T_flange,tool

The first frame of the chain is then the world, whose z is up, and the last one the tool centre point.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.spatial import Pose, rot_x, rot_y

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
