"""Reads the columns of a data file: one row per joint, finite numbers, units of the right quantity, a source.

A TOML table read field by field: a field that is missing, of another type or unknown raises `PaperError`.

Plausibility of a data file's numbers: signs, order, units that suit the kind of joint, symmetry.
"""

import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.schema import KINDS, PER_JOINT, SIDES, TABLES, UNITS, UNKNOWN, Column, ColumnRule, units_of
from lwr_dyn.foundation.errors import PaperError, did_you_mean
from lwr_dyn.model.chain import JointKind

_TYPE_NAMES = {str: "text", int: "an integer", dict: "a table", list: "a list"}

_REQUIRED = object()


class Fields:
    """Reads the fields of one table; `refuse_unknown` raises for those that were not read."""

    def __init__(self, table: Any, file: str, path: str) -> None:
        if not isinstance(table, dict):
            raise PaperError(file, path, repr(table), "a table")
        self._unread = dict(table)
        self._read: list[str] = []
        self._file, self._path = file, path

    def name_of(self, key: str) -> str:
        """The name of a field in messages."""
        return f"{self._path}.{key}" if self._path else key

    def take(self, key: str, kind: type, default: Any = _REQUIRED) -> Any:
        """The value of `key`; raises `PaperError` when it is missing or not of `kind`."""
        self._read.append(key)
        if key not in self._unread:
            if default is _REQUIRED:
                raise PaperError(self._file, self.name_of(key), "missing", _TYPE_NAMES.get(kind, "a value"))
            return default
        value = self._unread.pop(key)
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            raise PaperError(self._file, self.name_of(key), repr(value), _TYPE_NAMES.get(kind, kind.__name__))
        return value

    def take_one_of(self, key: str, allowed: Sequence[str], default: Any = _REQUIRED) -> str:
        """The text of `key`, one of the allowed words (or the default); raises `PaperError`."""
        value = self.take(key, str, default)
        return str(value) if value is default else choice(value, allowed, self._file, self.name_of(key))

    def refuse_unknown(self) -> None:
        """Raise `PaperError` for a field that was not read."""
        for key in self._unread:
            found = f"unknown field{did_you_mean(key, self._read)}"
            raise PaperError(self._file, self.name_of(key), found, ", ".join(self._read))


def parse_toml(text: str, file: str, parse_float: Callable[[str], Any] = float) -> dict[str, Any]:
    """A TOML text as tables; raises `PaperError` for broken TOML and for integers beyond TOML's 64 bits."""
    try:
        tables = tomllib.loads(text, parse_float=parse_float)
        _check_integers(tables)
    except (ValueError, RecursionError) as fault:
        reason = str(fault) if isinstance(fault, tomllib.TOMLDecodeError | RecursionError) else "an integer too long"
        raise PaperError(file, "TOML", reason, "valid TOML 1.0, with integers of 64 bits") from None
    return tables


def _check_integers(value: Any) -> None:
    """Raise `ValueError` for an integer of more than 64 bits: Python reads it, floats and messages cannot hold it."""
    if isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise ValueError
    for part in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        _check_integers(part)


def choice(value: Any, allowed: Sequence[str], file: str, field: str) -> str:
    """`value` when it is one of the allowed words; raises `PaperError` otherwise."""
    if value not in allowed:
        actual = "missing" if value is None else repr(value)
        raise PaperError(file, field, actual, f"one of {', '.join(allowed)}")
    return str(value)


LARGEST = 1e30
"""Limit of every number in its printed unit: no quantity of a robot is larger, and products stay finite."""


def read_columns(
    tables: dict[str, Any], n: int, touched: dict[str, dict[int, list[str]]], file: str
) -> dict[str, Column]:
    """All columns by path ("inertial.mass"); `touched` holds the errata per column and row. Raises `PaperError`."""
    columns = {}
    for table_name, table in tables.items():
        fields = Fields(table, file, table_name)
        for column_name, rule in TABLES[table_name].items():
            if column_name in table:
                name = f"{table_name}.{column_name}"
                column = _column(fields.take(column_name, dict), rule, n, touched.get(name, {}), file, name)
                columns[name] = column
            elif rule.required:
                raise PaperError(file, f"{table_name}.{column_name}", "missing", "a column")
        fields.refuse_unknown()
    return columns


def _column(
    table: dict[str, Any], rule: ColumnRule, n: int, touched: dict[int, list[str]], file: str, name: str
) -> Column:
    fields = Fields(table, file, name)
    values = fields.take("values", object)
    unit = fields.take("unit", object)
    where, kind = fields.take("where", str), fields.take_one_of("kind", KINDS)
    note = fields.take("note", str, default="")
    symbols = tuple(str(x) for x in fields.take("symbols", list, default=[]))
    sigma = fields.take("sigma", object, default=None)
    fields.refuse_unknown()
    count = n if rule.per_joint else 1
    rows = values if rule.per_joint else [values]
    if not isinstance(rows, list) or len(rows) != count:
        actual = f"{len(rows)} rows" if isinstance(rows, list) else repr(rows)
        raise PaperError(file, f"{name}.values", actual, f"{count} rows, one per joint")
    if symbols and len(symbols) != count:
        raise PaperError(file, f"{name}.symbols", f"{len(symbols)} entries", f"{count}, one per joint, or none")
    units = list(unit) if isinstance(unit, list) else [unit] * count
    if len(units) != count:
        raise PaperError(file, f"{name}.unit", f"{len(units)} units", f"one unit, or {count}, one per joint")
    for u in units:
        if not isinstance(u, str) or u not in UNITS or UNITS[u][0] not in rule.quantities:
            raise PaperError(file, f"{name}.unit", repr(u), ", ".join(units_of(*rule.quantities)))
    label = f"{name}.values"
    shape = tuple(n if size == PER_JOINT else size for size in rule.row)
    read = partial(_row_or_unknown if rule.may_be_unknown else _row, shape=shape, file=file)
    cells = tuple(read(r, field=f"{label}[{i}]" if rule.per_joint else label) for i, r in enumerate(rows))
    errata = {row: tuple(ids) for row, ids in touched.items() if row < count}
    given = sigma if rule.per_joint else [sigma]
    errors = () if sigma is None else _sigma(given, (count, *shape), file, f"{name}.sigma")
    return Column(name, cells, tuple(units), where, kind, note, symbols, errata, errors)


def _sigma(rows: Any, shape: tuple[int, ...], file: str, field: str) -> tuple[Any, ...]:
    table: tuple[Any, ...] = _row_or_unknown(rows, shape, file, field)
    if (np.array(table) < 0.0).any():
        raise PaperError(file, field, "a number below 0", "standard errors, in the unit of the values")
    return table


def _row_or_unknown(row: Any, shape: tuple[int, ...], file: str, field: str) -> Any:
    """`_row` where the word "unknown" stands for a number, a row or all rows: NaN each."""
    if row == UNKNOWN:
        return tuple(_row_or_unknown(row, shape[1:], file, field) for _ in range(shape[0])) if shape else math.nan
    if shape and isinstance(row, list) and len(row) == shape[0]:
        return tuple(_row_or_unknown(cell, shape[1:], file, f"{field}[{i}]") for i, cell in enumerate(row))
    return _row(row, shape, file, field)


def _row(row: Any, shape: tuple[int, ...], file: str, field: str) -> Any:
    """One row as nested tuples, after a check of its shape and its numbers."""
    if not shape:
        if isinstance(row, bool) or not isinstance(row, int | float):
            raise PaperError(file, field, repr(row), "a number")
        try:
            number = float(row)
        except OverflowError:
            raise PaperError(file, field, "a number of too many digits", f"a number below {LARGEST:g}") from None
        if not math.isfinite(number):
            raise PaperError(file, field, repr(row), "a finite number")
        if abs(number) > LARGEST:
            raise PaperError(file, field, repr(row), f"a number below {LARGEST:g}")
        return number
    if not isinstance(row, list) or len(row) != shape[0]:
        actual = f"{len(row)} entries" if isinstance(row, list) else repr(row)
        raise PaperError(file, field, actual, f"a list of {shape[0]}")
    return tuple(_row(cell, shape[1:], file, f"{field}[{i}]") for i, cell in enumerate(row))


_OF_THE_JOINT = ("limits.", "friction.", "gains.", "elasticity.")
"""Tables whose units differ between revolute and prismatic joints."""

_LINEAR = {"length", "velocity", "force", "damping", "stiffness", "integral gain", "mass"}

_RATINGS = ("ratings.mass", "ratings.reach", "ratings.envelope_volume")

_ABOVE_ZERO = (
    "limits.velocity", "limits.effort", "drawing.radius", "transmission.ratio",
    "transmission.stage", "gains.kp", "gains.effort", "elasticity.stiffness", "friction.covered", *_RATINGS,
    *(f"friction.{side}_stribeck_velocity" for side in SIDES),
)  # fmt: skip

_AT_LEAST_ZERO = (
    "inertial.mass", "rotors.inertia", "rotors.armature", "friction.viscous", "friction.coulomb", "drawing.pedestal",
    "gains.ki", "gains.kd", "elasticity.damping", "base.mass",
    *(f"friction.{side}_{name}" for side in SIDES for name in ("coulomb", "static")),
)  # fmt: skip

LARGEST_GRAVITY = 1e3
"""[m/s^2] Above the Sun's surface gravity a value is an error in the file, and its simulation would not end."""

_DIRECTED = tuple(f"friction.{side}_{name}" for side in SIDES for name in ("coulomb", "viscous"))


def check_plausibility(
    columns: Mapping[str, Column], joints: Sequence[str], kinds: Sequence[JointKind], file: str
) -> None:
    """Raise `PaperError` for the first number or unit that cannot be right."""
    _units(columns, joints, kinds, file)
    _signs(columns, file)
    _limits(columns, file)
    _symmetry(columns, file)
    _rotors(columns, file)
    _friction(columns, file)
    _gravity(columns, file)


def _gravity(columns: Mapping[str, Column], file: str) -> None:
    if "base.gravity" not in columns:
        return
    size = float(np.linalg.norm(columns["base.gravity"].si()))
    if size > LARGEST_GRAVITY:
        raise PaperError(file, "base.gravity.values", f"{size:g} m/s^2", f"at most {LARGEST_GRAVITY:g} m/s^2")


def _units(columns: Mapping[str, Column], joints: Sequence[str], kinds: Sequence[JointKind], file: str) -> None:
    for name in (x for x in columns if x.startswith(_OF_THE_JOINT) or x in ("poses.mastering", "rotors.armature")):
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
    for i, row in enumerate(columns["transmission.signs"].values if "transmission.signs" in columns else ()):
        if any(value not in (1.0, 0.0, -1.0) for value in row):
            raise PaperError(file, f"transmission.signs.values[{i}]", str(list(row)), "1, 0 or -1 for each joint")


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
            if tensor[r][c] != tensor[c][r] and not math.isnan(tensor[r][c] + tensor[c][r]):
                field = f"inertial.inertia.values[{i}][{r}][{c}]"
                raise PaperError(file, field, f"{tensor[r][c]} against {tensor[c][r]}", "a symmetric tensor")


def _rotors(columns: Mapping[str, Column], file: str) -> None:
    """Gear ratio and inertia together, or the reflected inertia alone; an invertible motor map."""
    signs = columns.get("transmission.signs")
    if signs is not None and np.linalg.matrix_rank(signs.si()) < len(signs.values):
        raise PaperError(file, "transmission.signs", "a singular matrix", "as many independent motors as joints")
    for i, ratio in enumerate(columns["rotors.gear_ratio"].values if "rotors.gear_ratio" in columns else ()):
        if ratio == 0.0:
            raise PaperError(file, f"rotors.gear_ratio.values[{i}]", "0", "a number other than 0; below 0, it reverses")
    given = {name for name in ("gear_ratio", "inertia", "armature") if f"rotors.{name}" in columns}
    if given not in (set(), {"gear_ratio", "inertia"}, {"armature"}):
        raise PaperError(file, "rotors", " and ".join(sorted(given)), "gear_ratio and inertia, or armature alone")


def _friction(columns: Mapping[str, Column], file: str) -> None:
    """Columns for both directions or for each; static friction is not below Coulomb friction."""
    directed = [name for name in columns if name.startswith("friction.") and name.count("_")]
    both_ways = [name for name in ("friction.viscous", "friction.coulomb") if name in columns]
    if directed and both_ways:
        raise PaperError(
            file, both_ways[0], f"beside {directed[0]}", "either one pair both ways or columns per direction"
        )
    if directed or any(f"friction.{name}" in columns for name in ("offset", "covered")):
        for name in (x for x in _DIRECTED if x not in columns):
            raise PaperError(file, name, "missing", "Coulomb and viscous columns of both directions")
    for side in (s for s in SIDES if f"friction.{s}_static" in columns):
        static, coulomb = (columns[f"friction.{side}_{name}"].si() for name in ("static", "coulomb"))
        for i, (at_rest, moving) in enumerate(zip(static, coulomb, strict=True)):
            if at_rest < moving:
                raise PaperError(
                    file, f"friction.{side}_static.values[{i}]", f"{at_rest:g}", f"at least Coulomb, {moving:g}"
                )
