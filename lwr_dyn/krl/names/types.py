"""Types of KRL: simple types, and the structures and enumerations that every controller has."""

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
_TEXT = Type("CHAR", 1)
STRUCTURES: Mapping[str, Mapping[str, Type]] = {
    "FRAME": _PLACE,
    "POS": _PLACE | _BRANCH,
    "E3POS": _PLACE | _BRANCH | _E3,
    "E6POS": _PLACE | _BRANCH | _E6,
    "AXIS": _AXES,
    "E3AXIS": _AXES | _E3,
    "E6AXIS": _AXES | _E6,
    "CP": _fields("REAL", "CP ORI1 ORI2"),
    "APO_T": _fields("REAL", "CDIS CORI CPTP CVEL"),
    "INERTIA": _fields("REAL", "X Y Z"),
    "LOAD": {"M": REAL, "CM": FRAME, "J": Type("INERTIA")},
    "FDAT": _fields("INT", "TOOL_NO BASE_NO") | {"IPO_FRAME": Type("IPO_M_T"), "POINT2": _TEXT, "TQ_STATE": BOOL},
    "PDAT": _fields("REAL", "VEL ACC APO_DIST GEAR_JERK EXAX_IGN") | {"APO_MODE": Type("APO_MODE_T")},
    "LDAT": _fields("REAL", "VEL ACC APO_DIST APO_FAC AXIS_VEL AXIS_ACC GEAR_JERK JERK_FAC EXAX_IGN")
    | {"ORI_TYP": Type("ORI_TYPE"), "CIRC_TYP": Type("CIRC_TYPE"), "ORI_TYPE": Type("ORI_TYPE")}
    | {"CIRC_TYPE": Type("CIRC_TYPE"), "APO_MODE": Type("APO_MODE_T"), "CB": UNKNOWN},
    "BASIS_SUGG_T": {"POINT1": _TEXT, "POINT2": _TEXT, "CP_PARAMS": _TEXT, "PTP_PARAMS": _TEXT, "CONT": _TEXT}
    | {"CP_VEL": _TEXT, "PTP_VEL": _TEXT, "SYNC_PARAMS": _TEXT, "SPL_NAME": _TEXT, "A_PARAMS": _TEXT},
}
"""Structures that need no declaration: name -> component -> its type."""
ENUMS: Mapping[str, frozenset[str]] = {
    "IPO_M_T": frozenset({"NONE", "TCP", "BASE"}),
    "IPO_MODE": frozenset({"NONE", "TCP", "BASE"}),
    "ORI_TYPE": frozenset({"VAR", "CONSTANT", "JOINT", "IGNORE", "NONE"}),
    "CIRC_TYPE": frozenset({"BASE", "PATH", "NONE"}),
    "APO_MODE_T": frozenset({"CDIS", "CPTP", "NONE", "VEL", "CPTPDIS"}),
}
