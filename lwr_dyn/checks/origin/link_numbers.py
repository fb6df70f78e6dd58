"""Masses, centres of mass and tensors of links, of a model file as written and of every published set here."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from lwr_dyn.arms.loading import load
from lwr_dyn.arms.papers.catalog import open_paper, readings, robots
from lwr_dyn.checks.urdf.document import read_document
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.model.arm import Arm


@dataclass(frozen=True, slots=True, eq=False)
class LinkNumbers:
    """Links with mass, in order: `names`, `mass` (m,) [kg], `com` (m, 3) [m] and `tensor` (m, 3, 3) [kg m^2] about it.

    Both are in one frame of the link, whichever; a file in other units has other numbers.
    """

    names: tuple[str, ...]
    mass: Array
    com: Array
    tensor: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "mass", "com", "tensor")

    def __len__(self) -> int:
        return len(self.names)

    @classmethod
    def of(cls, links: Sequence[tuple[str, float, Array, Array]]) -> "LinkNumbers":
        """Of links that have a mass."""
        kept = [link for link in links if link[1] != 0.0]
        return cls(
            tuple(link[0] for link in kept), np.array([link[1] for link in kept]),
            np.array([link[2] for link in kept]).reshape(-1, 3), np.array([link[3] for link in kept]).reshape(-1, 3, 3),
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class KnownSet:
    """A published set: the `robot`, the `reading` of its data file, its links in their URDF frames and in the source's.

    `about` is what the reading says of itself.
    """

    robot: str
    reading: str
    about: str
    links: LinkNumbers
    native: LinkNumbers

    @property
    def name(self) -> str:
        """As commands take it."""
        return f"{self.robot}:{self.reading}"


def numbers_of_file(path: str | Path) -> LinkNumbers:
    """The links of a model file: of a .urdf or .xacro all of the tree, as written; of another file those of its arm.

    Raises
    ------
    FileAccessError, PaperError, UrdfError
        A file that cannot be read.
    MissingDataError
        No link with a mass, a centre and a tensor.
    """
    found = [*_written(path)] if ends_in(path, ".urdf", ".xacro") else [*_of_arm(load(str(path)))]
    links = LinkNumbers.of(found)
    if not len(links):
        raise MissingDataError(str(path), "masses and inertias", "an origin")
    return links


def _written(path: str | Path) -> Iterator[tuple[str, float, Array, Array]]:
    for link in read_document(path).links:
        inertial = link.inertial
        if inertial is None or inertial.mass is None or inertial.com is None or inertial.inertia is None:
            continue
        yield link.name, inertial.mass, inertial.com, inertial.inertia


def _of_arm(arm: Arm) -> Iterator[tuple[str, float, Array, Array]]:
    for link, body in zip(arm.chain.links, arm.bodies(), strict=True):
        if body is not None:
            yield link.link, body.mass, body.com, body.inertia_com


def known_set(robot: str, reading: str, about: str = "") -> KnownSet:
    """A reading of a robot, or of a data file, as a set; raises as `lwr_dyn.load`."""
    arm = load(robot, reading)
    own = [(x.link, x.body.mass, x.body.com, x.body.inertia_com) for x in arm.chain.links if x.body is not None]
    return KnownSet(arm.name, reading, about, LinkNumbers.of([*_of_arm(arm)]), LinkNumbers.of(own))


@cache
def known_sets() -> tuple[KnownSet, ...]:
    """The sets of all robots of the package; a reading without masses is none."""
    return tuple(
        known
        for robot in robots()
        for reading in readings(robot)
        if len((known := known_set(robot, reading, open_paper(robot).readings[reading].about)).links)
    )
