"""What the numbers of a data file must obey whatever they are: signs, order, units of the joint's kind, symmetry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lwr_dyn.dh import JointKind
from lwr_dyn.errors import PaperError
from lwr_dyn.papers.schema import Column
from lwr_dyn.papers.units import UNITS

_LIMITS = ("limits.zero", "limits.lower", "limits.upper", "limits.velocity", "limits.effort", "poses.mastering")
_LINEAR = {"length", "velocity", "force"}
_RATINGS = ("ratings.mass", "ratings.reach", "ratings.envelope_volume")
_ABOVE_ZERO = ("inertial.mass", "limits.velocity", "limits.effort", "rotors.gear_ratio", "drawing.radius", *_RATINGS)
_AT_LEAST_ZERO = ("rotors.inertia", "friction.viscous", "friction.coulomb", "drawing.pedestal", "base.mass")


def check_meaning(columns: Mapping[str, Column], joints: Sequence[str], kinds: Sequence[JointKind], file: str) -> None:
    """Raise `PaperError` for the first number or unit that cannot be meant."""
    _units(columns, joints, kinds, file)
    _signs(columns, file)
    _limits(columns, file)
    _symmetry(columns, file)


def _units(columns: Mapping[str, Column], joints: Sequence[str], kinds: Sequence[JointKind], file: str) -> None:
    for name in (x for x in _LIMITS if x in columns):
        for i, unit in enumerate(columns[name].unit):
            if (UNITS[unit][0] in _LINEAR) != (kinds[i] is JointKind.PRISMATIC):
                allowed = f"a unit of a {kinds[i].value} joint"
                raise PaperError(file, f"{name}.unit", f"{unit!r} for {joints[i]}", allowed)


def _signs(columns: Mapping[str, Column], file: str) -> None:
    for name in (x for x in (*_ABOVE_ZERO, *_AT_LEAST_ZERO) if x in columns):
        strict = name in _ABOVE_ZERO
        for i, value in enumerate(columns[name].values):
            if value < 0.0 or (strict and value == 0.0):
                allowed = "a number above 0" if strict else "a number of at least 0"
                raise PaperError(file, f"{name}.values[{i}]", str(value), allowed)
    for i, value in enumerate(columns["dh.sign"].values if "dh.sign" in columns else ()):
        if value not in (1.0, -1.0):
            raise PaperError(file, f"dh.sign.values[{i}]", str(value), "1 or -1")


def _limits(columns: Mapping[str, Column], file: str) -> None:
    if ("limits.lower" in columns) != ("limits.upper" in columns):
        raise PaperError(file, "limits", "only one of lower, upper", "both or neither")
    if "limits.lower" not in columns:
        return
    pairs = zip(columns["limits.lower"].values, columns["limits.upper"].values, strict=True)
    for i, (lower, upper) in enumerate(pairs):
        if lower >= upper:
            allowed = "a lower limit below the upper"
            raise PaperError(file, f"limits.lower.values[{i}]", f"{lower}, upper is {upper}", allowed)


def _symmetry(columns: Mapping[str, Column], file: str) -> None:
    for i, tensor in enumerate(columns["inertial.inertia"].values if "inertial.inertia" in columns else ()):
        for r, c in ((0, 1), (0, 2), (1, 2)):
            if tensor[r][c] != tensor[c][r]:
                field = f"inertial.inertia.values[{i}][{r}][{c}]"
                raise PaperError(file, field, f"{tensor[r][c]} against {tensor[c][r]}", "a symmetric tensor")
