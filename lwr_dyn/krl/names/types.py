"""Types of KRL: simple types, and the structures of the language itself; those of the controller are in kernel.toml."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

SIMPLE = frozenset({"INT", "REAL", "BOOL", "CHAR"})
NUMBERS = frozenset({"INT", "REAL", "CHAR"})
CARTESIAN = ("FRAME", "POS", "E3POS", "E6POS")
AXES = ("AXIS", "E3AXIS", "E6AXIS")
LARGEST = 2**31 - 1
"""The largest INT."""


@dataclass(frozen=True, slots=True)
class Type:
    """A type by its name in capitals; an array if it has dimensions. `UNKNOWN` fits every type."""

    name: str
    dimensions: int = 0
    sizes: tuple[int, ...] = field(default=(), compare=False)
    """The last index of each dimension where it is known: 0 or nothing where it is not."""

    def __str__(self) -> str:
        return self.name + (f"[{',' * (self.dimensions - 1)}]" if self.dimensions else "")

    @property
    def element(self) -> Type:
        """The type of one element."""
        return Type(self.name)

    def accepts(self, value: Type) -> bool:
        """Whether a value of that type may be assigned: numbers to numbers, poses to poses, axes to axes.

        >>> INT.accepts(REAL), BOOL.accepts(INT), FRAME.accepts(Type("E6POS"))
        (True, False, True)
        """
        if "?" in (self.name, value.name) or self == value:
            return True
        groups = (NUMBERS, CARTESIAN, AXES)
        return self.dimensions == value.dimensions and any(self.name in g and value.name in g for g in groups)


UNKNOWN = Type("?")
INT, REAL, BOOL, CHAR = (Type(name) for name in ("INT", "REAL", "BOOL", "CHAR"))
FRAME = Type("FRAME")


def _fields(kind: str, names: str) -> dict[str, Type]:
    return {name: Type(kind) for name in names.split()}


_PLACE = _fields("REAL", "X Y Z A B C")
_BRANCH = _fields("INT", "S T")
_E3, _E6 = _fields("REAL", "E1 E2 E3"), _fields("REAL", "E1 E2 E3 E4 E5 E6")
_AXES = _fields("REAL", "A1 A2 A3 A4 A5 A6")
GEOMETRY: Mapping[str, Mapping[str, Type]] = {
    "FRAME": _PLACE,
    "POS": _PLACE | _BRANCH,
    "E3POS": _PLACE | _BRANCH | _E3,
    "E6POS": _PLACE | _BRANCH | _E6,
    "AXIS": _AXES,
    "E3AXIS": _AXES | _E3,
    "E6AXIS": _AXES | _E6,
}
"""The structures of the language itself: name -> component -> its type."""
