"""An arm of four boxes with the inertials of full bodies, as URDF text in which single numbers can be changed."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from lwr_dyn.checks.urdf.document import UrdfDocument, UrdfFinding, document_of

SIZES = ((0.3, 0.3, 0.1), (0.1, 0.16, 0.5), (0.5, 0.08, 0.13), (0.08, 0.05, 0.2))
CENTRES = ((0.0, 0.0, 0.05), (0.02, 0.0, 0.23), (0.22, 0.01, 0.0), (0.0, 0.0, 0.09))
ORIGINS = ((0.0, 0.0, 0.1), (0.0, 0.0, 0.45), (0.45, 0.0, 0.0))
_DENSITY = 1200.0


@dataclass(frozen=True)
class Box:
    """A link: its shape and what its `<inertial>` says; a full body where nothing is changed."""

    size: tuple[float, float, float]
    com: tuple[float, ...]
    mass: float
    six: tuple[float, ...]
    """ixx ixy ixz iyy iyz izz"""
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    shapes: str = ""
    """The shapes, where they are no longer one box."""

    def text(self, name: str) -> str:
        names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        inertia = " ".join(f'{key}="{float(value)!r}"' for key, value in zip(names, self.six, strict=True))
        return (
            f'<link name="{name}">\n<inertial><origin xyz="{_words(self.com)}" rpy="{_words(self.rpy)}"/>\n'
            f'<mass value="{float(self.mass)!r}"/>\n<inertia {inertia}/></inertial>\n'
            f"{self.shapes or self.box()}</link>\n"
        )

    def box(self, role: str = "visual") -> str:
        origin = f'<origin xyz="{_words(self.com)}"/>'
        return f'<{role}>{origin}<geometry><box size="{_words(self.size)}"/></geometry></{role}>\n'

    def changed(self, **values) -> "Box":
        return replace(self, **values)


@dataclass(frozen=True)
class BoxArm:
    """The arm; link 0 is fixed, 1 to 3 turn about z, y, y."""

    boxes: tuple[Box, ...] = field(
        default_factory=lambda: tuple(full_box(s, c) for s, c in zip(SIZES, CENTRES, strict=True))
    )
    origins: tuple[tuple[float, ...], ...] = ORIGINS
    effort: float = 150.0

    def with_link(self, k: int, **values) -> "BoxArm":
        boxes = [box.changed(**values) if i == k else box for i, box in enumerate(self.boxes)]
        return replace(self, boxes=tuple(boxes))

    def text(self) -> str:
        links = "".join(box.text(f"l{k}") for k, box in enumerate(self.boxes))
        joints = "".join(
            f'<joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/>'
            f'<origin xyz="{_words(origin)}"/><axis xyz="{"0 0 1" if k == 1 else "0 1 0"}"/>'
            f'<limit lower="-2" upper="2" effort="{self.effort!r}" velocity="2"/></joint>\n'
            for k, origin in enumerate(self.origins, start=1)
        )
        return f'<robot name="boxes">\n{links}{joints}</robot>\n'

    def document(self, file: str = "boxes.urdf") -> UrdfDocument:
        return document_of(self.text(), file)


def full_box(size, com) -> Box:
    x, y, z = size
    mass = _DENSITY * x * y * z
    moments = mass / 12.0 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    ixx, iyy, izz = (float(v) for v in moments)
    return Box(size, com, mass, (ixx, 0.0, 0.0, iyy, 0.0, izz))


def _words(values) -> str:
    return " ".join(repr(float(v)) for v in values)


def said(findings: Iterable[UrdfFinding], *expected: str) -> bool:
    """Whether these and no other findings are made, each "level subject: how its message begins … what it holds"."""
    lines = [f"{f.level} {f.message}" for f in findings]
    parts = [words.split(" … ") for words in expected]
    alike = [line.startswith(x[0]) and all(y in line for y in x) for line, x in zip(lines, parts, strict=False)]
    if not all(alike) or len(lines) != len(parts):
        raise AssertionError(f"said {lines}, expected {expected}")
    return True
