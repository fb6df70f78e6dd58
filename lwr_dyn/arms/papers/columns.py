"""Columns of a data file: one row per joint, finite numbers, units of the right quantity, a source.

Their numbers must be plausible too: signs, order, units that suit the kind of joint, symmetry.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.schema import (
    KINDS,
    LOAD,
    PER_JOINT,
    SIDES,
    SIGMOID,
    TABLES,
    UNITS,
    UNKNOWN,
    Column,
    ColumnRule,
    units_of,
)
from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.foundation.fields import LARGEST, Fields
from lwr_dyn.model.chain import JointKind


def read_columns(
    tables: dict[str, Any], n: int, touched: dict[str, dict[int, list[str]]], file: str
) -> dict[str, Column]:
    """All columns by path ("inertial.mass"); `touched` holds the errata per column and row. Raises `PaperError`."""
    columns = {}
    for table_name, table in tables.items():
        fields = Fields(table, file, table_name)
        for column_name, rule in TABLES[table_name].items():
            if column_name in table:
                column = fields.table(column_name)
                columns[column.path] = _column(column, rule, n, touched.get(column.path, {}))
            elif rule.required:
                raise fields.refuse(column_name, "missing", "a column")
        fields.refuse_unknown()
    return columns


def _column(fields: Fields, rule: ColumnRule, n: int, touched: dict[int, list[str]]) -> Column:
    values = fields.take("values", object)
    unit = fields.take("unit", object)
    where, kind = fields.text("where"), fields.choice("kind", KINDS)
    note, how = fields.text("note", default=""), fields.text("how", default="")
    symbols = tuple(str(x) for x in fields.take("symbols", list, default=[]))
    sigma = fields.take("sigma", object, default=None)
    fields.refuse_unknown()
    count = n if rule.per_joint else 1
    rows = values if rule.per_joint else [values]
    if not isinstance(rows, list) or len(rows) != count:
        actual = f"{len(rows)} rows" if isinstance(rows, list) else repr(rows)
        raise fields.refuse("values", actual, f"{count} rows, one per joint")
    if symbols and len(symbols) != count:
        raise fields.refuse("symbols", f"{len(symbols)} entries", f"{count}, one per joint, or none")
    units = list(unit) if isinstance(unit, list) else [unit] * count
    if len(units) != count:
        raise fields.refuse("unit", f"{len(units)} units", f"one unit, or {count}, one per joint")
    for u in units:
        if not isinstance(u, str) or u not in UNITS or UNITS[u][0] not in rule.quantities:
            raise fields.refuse("unit", repr(u), ", ".join(units_of(*rule.quantities)))
    shape = tuple(n if size == PER_JOINT else size for size in rule.row)
    places = [f"values[{i}]" for i in range(count)] if rule.per_joint else ["values"]
    cells = tuple(_row(fields, *row, shape, rule.may_be_unknown) for row in zip(places, rows, strict=True))
    errata = {row: tuple(ids) for row, ids in touched.items() if row < count}
    given = sigma if rule.per_joint else [sigma]
    errors = () if sigma is None else _row(fields, "sigma", given, (count, *shape), may_be_unknown=True)
    if (np.array(errors) < 0.0).any():
        raise fields.refuse("sigma", "a number below 0", "standard errors, in the unit of the values")
    return Column(fields.path, cells, tuple(units), where, kind, note, symbols, errata, errors, how)


def _row(fields: Fields, place: str, row: Any, shape: tuple[int, ...], may_be_unknown: bool) -> Any:
    """A row as nested tuples of a shape; NaN where the word "unknown" stands for a number, a row or all rows."""
    if may_be_unknown and row == UNKNOWN:
        return tuple(_row(fields, place, row, shape[1:], True) for _ in range(shape[0])) if shape else math.nan
    if not shape:
        return _number(fields, place, row)
    if not isinstance(row, list) or len(row) != shape[0]:
        raise fields.refuse(
            place, f"{len(row)} entries" if isinstance(row, list) else repr(row), f"a list of {shape[0]}"
        )
    return tuple(_row(fields, f"{place}[{i}]", cell, shape[1:], may_be_unknown) for i, cell in enumerate(row))


def _number(fields: Fields, place: str, cell: Any) -> float:
    if isinstance(cell, bool) or not isinstance(cell, int | float):
        raise fields.refuse(place, repr(cell), "a number")
    if not math.isfinite(cell):
        raise fields.refuse(place, repr(cell), "a finite number")
    return fields.number_at(place, cell, f"a number below {LARGEST:g}")


_OF_THE_JOINT = ("limits.", "friction.", "gains.", "elasticity.")
"""Tables whose units differ between revolute and prismatic joints."""
_LINEAR = {"length", "velocity", "force", "damping", "stiffness", "integral gain", "mass"}
_RATINGS = ("ratings.mass", "ratings.reach", "ratings.envelope_volume")

_ABOVE_ZERO = (
    "limits.velocity", "limits.effort", "drawing.radius", "transmission.ratio",
    "transmission.stage", "gains.kp", "gains.effort", "elasticity.stiffness", "friction.covered", *_RATINGS,
    "friction.sigmoid_slope",
    *(f"friction.{side}_stribeck_velocity" for side in SIDES),
)  # fmt: skip

_AT_LEAST_ZERO = (
    "inertial.mass", "rotors.inertia", "rotors.armature", "friction.viscous", "friction.coulomb", "drawing.pedestal",
    "gains.ki", "gains.kd", "elasticity.damping", "base.mass", "friction.sigmoid_level",
    *(f"friction.{side}_{name}" for side in SIDES for name in ("coulomb", "static")),
)  # fmt: skip

LARGEST_GRAVITY = 1e3
"""[m/s^2] Above the Sun's surface gravity a value is an error in the file, and its simulation would not end."""
_DIRECTED = tuple(f"friction.{side}_{name}" for side in SIDES for name in ("coulomb", "viscous"))


Fault = tuple[str, str, str]
"""Field, what stands there, what is allowed."""


def check_plausibility(
    columns: Mapping[str, Column], joints: Sequence[str], kinds: Sequence[JointKind], file: str
) -> None:
    """Raise `PaperError` for the first number or unit that cannot be right."""
    checks = (_signs, _shares, _limits, _symmetry, _rotors, _friction, _sigmoid, _gravity)
    for fault in chain(_units(columns, joints, kinds), *(check(columns) for check in checks)):
        raise PaperError(file, *fault)


def _cells(columns: Mapping[str, Column], name: str) -> Iterator[tuple[str, Any]]:
    """The rows of a column with their places; none where the file has no such column."""
    for i, value in enumerate(columns[name].values if name in columns else ()):
        yield f"{name}.values[{i}]", value


def _gravity(columns: Mapping[str, Column]) -> Iterator[Fault]:
    size = float(np.linalg.norm(columns["base.gravity"].si())) if "base.gravity" in columns else 0.0
    if size > LARGEST_GRAVITY:
        yield "base.gravity.values", f"{size:g} m/s^2", f"at most {LARGEST_GRAVITY:g} m/s^2"


def _units(columns: Mapping[str, Column], joints: Sequence[str], kinds: Sequence[JointKind]) -> Iterator[Fault]:
    for name in (x for x in columns if x.startswith(_OF_THE_JOINT) or x in ("poses.mastering", "rotors.armature")):
        for unit, joint, kind in zip(columns[name].unit, joints, kinds, strict=False):
            if unit != "1" and (UNITS[unit][0] in _LINEAR) != (kind is JointKind.PRISMATIC):
                yield f"{name}.unit", f"{unit!r} for {joint}", f"a unit of a {kind.value} joint"


def _signs(columns: Mapping[str, Column]) -> Iterator[Fault]:
    for name in (*_ABOVE_ZERO, *_AT_LEAST_ZERO):
        strict = name in _ABOVE_ZERO
        for place, value in _cells(columns, name):
            if value < 0.0 or (strict and value == 0.0):
                yield place, str(value), "a number above 0" if strict else "a number of at least 0"
    for place, value in _cells(columns, "dh.sign"):
        if value not in (1.0, -1.0):
            yield place, str(value), "1 or -1"
    for place, row in _cells(columns, "transmission.signs"):
        if any(value not in (1.0, 0.0, -1.0) for value in row):
            yield place, str(list(row)), "1, 0 or -1 for each joint"


def _shares(columns: Mapping[str, Column]) -> Iterator[Fault]:
    for place, value in _cells(columns, f"friction.{LOAD}"):
        if not 0.0 <= value < 1.0:
            yield place, str(value), "a share of at least 0 and below 1"


def _limits(columns: Mapping[str, Column]) -> Iterator[Fault]:
    if ("limits.lower" in columns) != ("limits.upper" in columns):
        yield "limits", "only one of lower, upper", "both or neither"
    for (place, lower), (_, upper) in zip(
        _cells(columns, "limits.lower"), _cells(columns, "limits.upper"), strict=True
    ):
        if lower >= upper:
            yield place, f"{lower}, upper is {upper}", "a lower limit below the upper"


def _symmetry(columns: Mapping[str, Column]) -> Iterator[Fault]:
    for place, tensor in _cells(columns, "inertial.inertia"):
        for r, c in ((0, 1), (0, 2), (1, 2)):
            if tensor[r][c] != tensor[c][r] and not math.isnan(tensor[r][c] + tensor[c][r]):
                yield f"{place}[{r}][{c}]", f"{tensor[r][c]} against {tensor[c][r]}", "a symmetric tensor"


def _rotors(columns: Mapping[str, Column]) -> Iterator[Fault]:
    """Gear ratio and inertia together, or the reflected inertia alone; an invertible motor map."""
    for signs in (columns[name] for name in ("transmission.signs", "transmission.matrix") if name in columns):
        if np.linalg.matrix_rank(signs.si()) < len(signs.values):
            yield signs.name, "a singular matrix", "as many independent motors as joints"
    map_ = {name for name in ("ratio", "stage", "signs", "matrix") if f"transmission.{name}" in columns}
    if map_ not in ({"ratio", "signs"}, {"ratio", "stage", "signs"}, {"matrix"}, set()):
        yield "transmission", " and ".join(sorted(map_)), "ratio and signs, with or without stage, or matrix alone"
    for place, ratio in _cells(columns, "rotors.gear_ratio"):
        if ratio == 0.0:
            yield place, "0", "a number other than 0; below 0, it reverses"
    given = {name for name in ("gear_ratio", "inertia", "armature") if f"rotors.{name}" in columns}
    if given not in (set(), {"gear_ratio", "inertia"}, {"armature"}):
        yield "rotors", " and ".join(sorted(given)), "gear_ratio and inertia, or armature alone"


def _sigmoid(columns: Mapping[str, Column]) -> Iterator[Fault]:
    """All three columns or none, and no other friction beside them."""
    given = {name.removeprefix("friction.") for name in columns if name.startswith("friction.")}
    sigmoid, others = given & {*SIGMOID}, sorted(given - {*SIGMOID})
    if sigmoid not in (set(), {*SIGMOID}):
        yield "friction", " and ".join(sorted(sigmoid)), "level, slope and shift of a sigmoid"
    if sigmoid and others:
        yield f"friction.{others[0]}", "beside a sigmoid", "the sigmoid alone"


def _friction(columns: Mapping[str, Column]) -> Iterator[Fault]:
    """Columns for both directions or for each; static friction is not below Coulomb friction."""
    directed = [name for name in columns if name.startswith(tuple(f"friction.{side}_" for side in SIDES))]
    both_ways = [name for name in ("friction.viscous", "friction.coulomb") if name in columns]
    if directed and both_ways:
        yield both_ways[0], f"beside {directed[0]}", "either one pair both ways or columns per direction"
    if directed or any(f"friction.{name}" in columns for name in ("offset", "covered", LOAD)):
        for name in (x for x in _DIRECTED if x not in columns):
            yield name, "missing", "Coulomb and viscous columns of both directions"
    for side in (s for s in SIDES if f"friction.{s}_static" in columns):
        static, coulomb = (columns[f"friction.{side}_{name}"].si() for name in ("static", "coulomb"))
        for i, (at_rest, moving) in enumerate(zip(static, coulomb, strict=True)):
            if at_rest < moving:
                yield f"friction.{side}_static.values[{i}]", f"{at_rest:g}", f"at least Coulomb, {moving:g}"
