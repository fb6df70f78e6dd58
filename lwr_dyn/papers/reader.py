"""The strict reader: TOML text -> `Paper`. Unknown, missing, misspelt or non-finite things raise and say where."""

from __future__ import annotations

import copy
import hashlib
import math
import tomllib
from pathlib import Path
from typing import Any

from lwr_dyn.dh import Convention, JointKind
from lwr_dyn.errors import FileAccessError, PaperError, UnknownNameError
from lwr_dyn.papers.errata import apply_errata
from lwr_dyn.papers.fields import Fields
from lwr_dyn.papers.schema import (
    ABOUT,
    KINDS,
    PRODUCTS,
    SCHEMA,
    TABLES,
    Column,
    ColumnRule,
    Erratum,
    Paper,
    Patch,
    Reading,
)
from lwr_dyn.papers.units import UNITS, units_of


def read_paper(path: str | Path, reading: str | None = None) -> Paper:
    """Read a data file under one of its readings.

    Parameters
    ----------
    path : path
        A TOML file of schema 1.
    reading : str, optional
        The file's own default if not given.

    Raises
    ------
    FileAccessError
        The file cannot be read.
    PaperError
        Broken TOML or a breach of the schema, with file, field and what is allowed.
    UnknownNameError
        No reading of that name.
    """
    file = Path(path)
    try:
        text = file.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        raise FileAccessError(str(path), "not UTF-8 text", "a TOML file") from None
    except OSError as fault:
        raise FileAccessError(str(path), (fault.strerror or str(fault)).lower(), "a readable .toml file") from None
    return parse_paper(text, file.name, reading)


def parse_paper(text: str, file: str, reading: str | None = None) -> Paper:
    """`read_paper` on text; `file` is the name used in messages. Raises as `read_paper`."""
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as fault:
        raise PaperError(file, "TOML", str(fault), "valid TOML 1.0") from None
    top = Fields(raw, file, "")
    if top.take("schema", int) != SCHEMA:
        raise PaperError(file, "schema", str(raw["schema"]), str(SCHEMA))
    name, title = top.take("name", str), top.take("title", str)
    document = {k: str(v) for k, v in top.take("document", dict).items()}
    errata = tuple(_erratum(e, file, i) for i, e in enumerate(top.take("erratum", list, default=[])))
    readings = _readings(top.take("reading", dict, default={"printed": {"about": "as printed"}}), errata, file)
    default = top.take("default_reading", str, default="printed")
    for wanted in {default, reading or default} - set(readings):
        raise UnknownNameError(f"reading of {name}", wanted, readings)
    chosen = readings[reading or default]
    joints, kinds = _joints(top.take("joints", dict), file)
    tables = {key: top.take(key, dict) for key in TABLES if key in raw}
    if "dh" not in tables:
        raise PaperError(file, "dh", "missing", "a table of DH columns")
    top.done()
    tables = copy.deepcopy(tables)
    touched = apply_errata(tables, tuple(e for e in errata if e.id in chosen.errata), file)
    convention = _choice(tables["dh"].pop("convention", None), [c.value for c in Convention], file, "dh.convention")
    about, products = _inertia_words(tables, len(joints), file)
    columns = _columns(tables, len(joints), touched, file)
    _meaning(columns, joints, kinds, file)
    return Paper(
        name=name, title=title, file=file, document=document, reading=chosen, readings=readings, errata=errata,
        joints=joints, kinds=kinds, convention=Convention(convention), columns=columns,
        inertia_about=about, inertia_products=products, digest=hashlib.sha256(text.encode()).hexdigest(),
    )  # fmt: skip


def _joints(table: dict[str, Any], file: str) -> tuple[tuple[str, ...], tuple[JointKind, ...]]:
    fields = Fields(table, file, "joints")
    kinds = fields.take("kinds", list)
    if not kinds:
        raise PaperError(file, "joints.kinds", "an empty list", "one of revolute, prismatic per joint")
    for i, kind in enumerate(kinds):
        _choice(kind, [k.value for k in JointKind], file, f"joints.kinds[{i}]")
    names = fields.take("names", list, default=[f"joint_{i + 1}" for i in range(len(kinds))])
    fields.done()
    if len(names) != len(kinds) or len(set(names)) != len(names) or not all(isinstance(x, str) for x in names):
        raise PaperError(file, "joints.names", f"{names}", f"{len(kinds)} different names")
    return tuple(names), tuple(JointKind(k) for k in kinds)


def _erratum(table: Any, file: str, index: int) -> Erratum:
    fields = Fields(table, file, f"erratum[{index}]")
    words = [fields.take(key, str) for key in ("id", "where", "printed", "read_as", "why", "effect", "status")]
    patches = []
    for j, entry in enumerate(fields.take("patch", list, default=[])):
        patch = Fields(entry, file, f"erratum[{index}].patch[{j}]")
        patches.append(Patch(patch.take("at", str), patch.take("printed", object), patch.take("read", object)))
        patch.done()
    fields.done()
    return Erratum(*words, tuple(patches))


def _readings(table: dict[str, Any], errata: tuple[Erratum, ...], file: str) -> dict[str, Reading]:
    out = {}
    ids = [e.id for e in errata]
    for name, entry in table.items():
        fields = Fields(entry, file, f"reading.{name}")
        wanted = tuple(fields.take("errata", list, default=[]))
        out[name] = Reading(name, fields.take("about", str), wanted)
        fields.done()
        for missing in [w for w in wanted if w not in ids]:
            raise PaperError(file, f"reading.{name}.errata", repr(missing), f"one of {', '.join(ids) or 'none'}")
    return out


def _inertia_words(tables: dict[str, Any], n: int, file: str) -> tuple[str, tuple[str, ...]]:
    """`about`, `axes` and `products` of the tensors, taken out of the column."""
    inertia = tables.get("inertial", {}).get("inertia")
    if not isinstance(inertia, dict):
        return "com", ("tensor",) * n
    field = "inertial.inertia"
    about = _choice(inertia.pop("about", None), ABOUT, file, f"{field}.about")
    _choice(inertia.pop("axes", None), ("frame",), file, f"{field}.axes")
    products = inertia.pop("products", None)
    signs = [products] * n if not isinstance(products, list) else products
    if len(signs) != n:
        raise PaperError(file, f"{field}.products", f"{len(signs)} entries", f"one word, or {n}, one per joint")
    return about, tuple(_choice(s, PRODUCTS, file, f"{field}.products") for s in signs)


def _columns(tables: dict[str, Any], n: int, touched: dict[str, dict[int, list[str]]], file: str) -> dict[str, Column]:
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
        fields.done()
    return columns


def _column(
    table: dict[str, Any], rule: ColumnRule, n: int, touched: dict[int, list[str]], file: str, name: str
) -> Column:
    fields = Fields(table, file, name)
    values = fields.take("values", object)
    unit = fields.take("unit", object)
    where, kind = fields.take("where", str), fields.take("kind", str)
    note = fields.take("note", str, default="")
    fields.done()
    _choice(kind, KINDS, file, f"{name}.kind")
    count = n if rule.per_joint else 1
    rows = values if rule.per_joint else [values]
    if not isinstance(rows, list) or len(rows) != count:
        found = f"{len(rows)} rows" if isinstance(rows, list) else repr(rows)
        raise PaperError(file, f"{name}.values", found, f"{count} rows, one per joint")
    units = list(unit) if isinstance(unit, list) else [unit] * count
    if len(units) != count:
        raise PaperError(file, f"{name}.unit", f"{len(units)} units", f"one unit, or {count}, one per joint")
    for u in units:
        if u not in UNITS or UNITS[u][0] not in rule.quantities:
            raise PaperError(file, f"{name}.unit", repr(u), ", ".join(units_of(*rule.quantities)))
    label = f"{name}.values"
    cells = tuple(_row(r, rule.row, file, f"{label}[{i}]" if rule.per_joint else label) for i, r in enumerate(rows))
    errata = {row: tuple(ids) for row, ids in touched.items() if row < count}
    return Column(name, cells, tuple(units), where, kind, note, errata)


def _row(row: Any, shape: tuple[int, ...], file: str, field: str) -> Any:
    """One row of the right shape with finite numbers, as nested tuples."""
    if not shape:
        if isinstance(row, bool) or not isinstance(row, int | float):
            raise PaperError(file, field, repr(row), "a number")
        if not math.isfinite(row):
            raise PaperError(file, field, repr(row), "a finite number")
        return float(row)
    if not isinstance(row, list) or len(row) != shape[0]:
        found = f"{len(row)} entries" if isinstance(row, list) else repr(row)
        raise PaperError(file, field, found, f"a list of {shape[0]}")
    return tuple(_row(cell, shape[1:], file, f"{field}[{i}]") for i, cell in enumerate(row))


def _choice(value: Any, allowed: Any, file: str, field: str) -> str:
    if value not in allowed:
        found = "missing" if value is None else repr(value)
        raise PaperError(file, field, found, f"one of {', '.join(allowed)}")
    return str(value)


def _meaning(columns: dict[str, Column], joints: tuple[str, ...], kinds: tuple[JointKind, ...], file: str) -> None:
    """What the numbers must obey whatever they are: units of the joint's kind, signs, order of limits, symmetry."""
    for name in ("limits.zero", "limits.lower", "limits.upper", "limits.velocity", "limits.effort"):
        linear = {"length", "velocity", "force"}
        for i, unit in enumerate(columns[name].unit if name in columns else ()):
            if (UNITS[unit][0] in linear) != (kinds[i] is JointKind.PRISMATIC):
                raise PaperError(file, f"{name}.unit", f"{unit!r} for {joints[i]}", f"a unit of a {kinds[i].value} joint")
    for name, lowest, words in (
        ("inertial.mass", 0.0, "a mass above 0"),
        ("limits.velocity", 0.0, "a number above 0"),
        ("limits.effort", 0.0, "a number above 0"),
        ("rotors.gear_ratio", 0.0, "a number above 0"),
    ):
        for i, value in enumerate(columns[name].values if name in columns else ()):
            if value <= lowest:
                raise PaperError(file, f"{name}.values[{i}]", str(value), words)
    for name in ("rotors.inertia", "friction.viscous", "friction.coulomb"):
        for i, value in enumerate(columns[name].values if name in columns else ()):
            if value < 0.0:
                raise PaperError(file, f"{name}.values[{i}]", str(value), "a number of at least 0")
    for i, value in enumerate(columns["dh.sign"].values if "dh.sign" in columns else ()):
        if value not in (1.0, -1.0):
            raise PaperError(file, f"dh.sign.values[{i}]", str(value), "1 or -1")
    if ("limits.lower" in columns) != ("limits.upper" in columns):
        raise PaperError(file, "limits", "only one of lower, upper", "both or neither")
    if "limits.lower" in columns:
        for i, (low, up) in enumerate(zip(columns["limits.lower"].values, columns["limits.upper"].values, strict=True)):
            if low >= up:
                raise PaperError(file, f"limits.lower.values[{i}]", f"{low}, upper is {up}", "a lower limit below the upper")
    tensors = columns["inertial.inertia"].values if "inertial.inertia" in columns else ()
    for i, tensor in enumerate(tensors):
        for r, c in ((0, 1), (0, 2), (1, 2)):
            if tensor[r][c] != tensor[c][r]:
                field = f"inertial.inertia.values[{i}]"
                raise PaperError(file, field, f"{tensor[r][c]} against {tensor[c][r]}", "a symmetric tensor")
