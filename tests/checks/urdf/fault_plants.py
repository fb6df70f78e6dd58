"""Faults of `faults.toml` planted in a URDF, one at a time: an edit a kind, each returning the size of the fault.

The size is in the kind's own measure; None where the edit would change nothing that matters at this link.
"""

import math
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.checks.urdf import inertial_faults, joint_faults
from tests.checks.urdf.plant_site import sites

KINDS_FILE = Path(__file__).parent / "faults.toml"
Edit = Callable[..., float | None]


@dataclass(frozen=True, slots=True, eq=False)
class FaultKind:
    """A row of `faults.toml`."""

    name: str
    edit: str
    arguments: Mapping[str, Any]
    measure: str
    floor: float
    """The fault counts as large from here on, in its measure; 0: always."""
    hopeless: bool

    @property
    def function(self) -> Edit:
        """Its edit."""
        module, _, name = self.edit.partition(":")
        function: Edit = getattr({"inertial": inertial_faults, "joint": joint_faults}[module], name)
        return function

    @property
    def needs_inertial(self) -> bool:
        """Whether its edit is of an `<inertial>`, which must then be usable."""
        return self.edit.startswith("inertial:")


@dataclass(frozen=True, slots=True, eq=False)
class FaultPlant:
    """A URDF with one fault."""

    kind: FaultKind
    link: str
    joint: str
    subjects: frozenset[str]
    """What a finding about it is about: "link ...", "joint ..."."""
    size: float
    text: str

    @property
    def is_large(self) -> bool:
        """Whether it is above its kind's floor."""
        return bool(self.size >= self.kind.floor)


def fault_kinds() -> tuple[FaultKind, ...]:
    """The rows of `faults.toml`."""
    rows = tomllib.loads(KINDS_FILE.read_text(encoding="utf-8"))["kind"]
    default = {"arguments": {}, "measure": "", "floor": 0.0, "hopeless": False}
    return tuple(FaultKind(**{x: ({**default, **row})[x] for x in FaultKind.__slots__}) for row in rows)


def plants(
    text: str,
    path: Path,
    kinds: tuple[FaultKind, ...],
    skip: frozenset[str] = frozenset(),
    wanted: Callable[[str, str], bool] = lambda link, kind: True,
) -> Iterator[FaultPlant]:
    """Every fault at every moving link of a URDF that has shapes, but links in `skip`."""
    for where in sites(text, path):
        if where.link in skip or not where.diameter:
            continue
        for kind in (kind for kind in kinds if wanted(where.link, kind.name)):
            site = where.fresh()
            usable = site.inertial is not None or not kind.needs_inertial
            size = kind.function(site, **kind.arguments) if usable else None
            if size is None or not math.isfinite(size):
                continue
            names = {f"link {where.link}", f"joint {where.joint}", f"joint {site.joint.get('name')}"}
            edited = ET.tostring(site.robot, encoding="unicode")
            yield FaultPlant(kind, where.link, where.joint, frozenset(names), float(size), edited)
