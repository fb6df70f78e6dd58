"""The strict reader: TOML text -> `Paper`. An unknown, missing, misspelt or non-finite entry raises, with its place.

Applies the errata of a reading to the printed tables; a patch must state exactly what is printed in its cell.

The solids of a drawn arm, and the bodies estimated from them where a source gives only a total mass.

A file's `drawing.solids` lists cylinders per link, in the frame of that link's DH row (the base: frame 0). The viewer
draws them, and where a paper has no masses the estimate is

    mass_i = total V_i / sum V,    com_i and tensor_i those of link i's cylinders at that one density

The base is part of the sum. Cylinders that overlap count twice, so joints, where the drives are, are denser. Such
tensors are always physical, and a drawing with mirror symmetry gives products of zero.
"""

import copy
import hashlib
import math
import re
from collections.abc import Collection, Iterable, Sequence
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.columns import Fields, check_plausibility, choice, parse_toml, read_columns
from lwr_dyn.arms.papers.schema import (
    ABOUT,
    KINDS,
    PRODUCTS,
    SCHEMA,
    SEVERITIES,
    STATUSES,
    TABLES,
    UNITS,
    Erratum,
    Paper,
    Patch,
    Reading,
    Solids,
    to_si,
    units_of,
)
from lwr_dyn.foundation.errors import PaperError, UnknownNameError
from lwr_dyn.model.arm import DrawnCylinder
from lwr_dyn.model.chain import Body, Convention, JointKind
from lwr_dyn.model.spatial import axis_to_z

_STEP = re.compile(r"\.?([A-Za-z_0-9]+)|\[(\d+)\]")

_PATH = re.compile(r"[A-Za-z_0-9]+(\.[A-Za-z_0-9]+|\[\d+\])+")


def apply_errata(tables: dict[str, Any], errata: tuple[Erratum, ...], file: str) -> dict[str, dict[int, list[str]]]:
    """Patches the parsed tables in place.

    Returns
    -------
    dict
        Column path ("inertial.mass") -> row -> ids of the errata that touched it.

    Raises
    ------
    PaperError
        A patch names no cell, the file prints something else there, or two errata change one cell.
    """
    touched: dict[str, dict[int, list[str]]] = {}
    one_erratum_a_cell(errata, file)
    for erratum in errata:
        for patch in erratum.of_tables():
            apply_patch(tables, patch, erratum.id, file)
            column, row = _column_and_row(patch.at)
            for i in [row] if row is not None else range(64):  # all rows: no arm has more joints
                touched.setdefault(column, {}).setdefault(i, []).append(erratum.id)
    return touched


def apply_patch(tables: dict[str, Any], patch: Patch, erratum: str, file: str) -> None:
    """Replaces one printed cell; raises `PaperError` when the file prints something else there."""
    holder, key = _locate(tables, patch.at, f"erratum {erratum}", file)
    if holder[key] != patch.printed:
        raise PaperError(
            file, f"erratum {erratum}: {patch.at}", f"printed {holder[key]!r}", f"{patch.printed!r} as stated"
        )
    holder[key] = patch.read


def one_erratum_a_cell(errata: Iterable[Erratum], file: str) -> None:
    """Raise `PaperError` when two errata change one cell, or one changes a cell inside what the other changes."""
    cells = [(e.id, p.at) for e in errata for p in e.patches]
    for k, (erratum, at) in enumerate(cells):
        steps = _steps(at)
        for other, place in cells[:k]:
            size = min(len(steps), len(_steps(place)))
            if other != erratum and steps[:size] == _steps(place)[:size]:
                raise PaperError(
                    file, f"errata {other} and {erratum}", f"both read {at}", "one erratum of a reading a cell"
                )


def _steps(path: str) -> list[str | int]:
    return [name or int(index) for name, index in _STEP.findall(path)]


def _locate(tables: dict[str, Any], path: str, field: str, file: str) -> tuple[Any, Any]:
    """The container and the key of the cell that `path` names."""
    steps = _steps(path) if _PATH.fullmatch(path) else [""]
    holder: Any = None
    cell: Any = tables
    for step in steps:
        holder = cell
        known = step in holder if isinstance(holder, dict) else isinstance(holder, list) and step in range(len(holder))
        if not known:
            raise PaperError(file, field, f"no cell {path!r}", "a path such as inertial.mass.values[2]")
        cell = holder[step]
    return holder, steps[-1]


def _column_and_row(path: str) -> tuple[str, int | None]:
    """("inertial.mass", 2) of "inertial.mass.values[2][0]"; the row is None when the whole column is meant.

    >>> _column_and_row("inertial.inertia.about")
    ('inertial.inertia', None)
    """
    steps = _steps(path)
    column = ".".join(str(s) for s in steps[:2])
    row = steps[3] if len(steps) > 3 and isinstance(steps[3], int) else None
    return column, row


COLOURS = ("orange", "grey", "dark")

MASS_DIGITS, COM_DIGITS, INERTIA_DIGITS = 2, 4, 5
"""Decimals of an estimate in a data file, in kg, m, kg m^2: enough for the smallest link's triangle inequality."""


def read_solids(table: Any, links: Sequence[str], file: str) -> Solids:
    """`drawing.solids` of a file: unit, where, kind and rows of link, from, to, radius, colour; raises `PaperError`."""
    name = "drawing.solids"
    fields = Fields(table, file, name)
    unit, where = fields.take("unit", str), fields.take("where", str)
    kind = fields.take_one_of("kind", KINDS)
    rows = fields.take("rows", list)
    fields.refuse_unknown()
    if unit not in UNITS or UNITS[unit][0] != "length":
        raise PaperError(file, f"{name}.unit", repr(unit), ", ".join(units_of("length")))
    cylinders = tuple(_solid(row, links, unit, file, f"{name}.rows[{i}]") for i, row in enumerate(rows))
    return Solids(cylinders, where, kind)


def _solid(row: Any, links: Sequence[str], unit: str, file: str, name: str) -> DrawnCylinder:
    fields = Fields(row, file, name)
    link = fields.take_one_of("link", links)
    start, end = (_point(fields.take(key, list), unit, file, f"{name}.{key}") for key in ("from", "to"))
    radius = fields.take("radius", object)
    if isinstance(radius, bool) or not isinstance(radius, int | float) or not 0.0 < radius < math.inf:
        raise PaperError(file, f"{name}.radius", repr(radius), "a number above 0")
    if start == end:
        raise PaperError(file, name, f"from and to are both {list(start)}", "a cylinder with a length")
    colour = fields.take_one_of("colour", COLOURS)
    fields.refuse_unknown()
    return DrawnCylinder(link, start, end, to_si(float(radius), unit), colour)


def _point(cells: list[Any], unit: str, file: str, name: str) -> tuple[float, float, float]:
    good = all(isinstance(x, int | float) and not isinstance(x, bool) and math.isfinite(x) for x in cells)
    if len(cells) != 3 or not good:
        raise PaperError(file, name, repr(cells), "a list of 3 finite numbers")
    x, y, z = (to_si(float(cell), unit) for cell in cells)
    return x, y, z


def cylinder_body(cylinder: DrawnCylinder, density: float) -> Body:
    """A solid cylinder of one density [kg/m^3] in the frame of its ends.

    I = m r^2/2 about its axis, m (3 r^2 + l^2)/12 across.
    """
    start, end = np.array(cylinder.start), np.array(cylinder.end)
    length, radius = float(np.linalg.norm(end - start)), cylinder.radius
    mass = density * math.pi * radius**2 * length
    across = mass * (3.0 * radius**2 + length**2) / 12.0
    turn = axis_to_z(end - start)
    tensor = turn @ np.diag([across, across, mass * radius**2 / 2.0]) @ turn.T
    return Body(mass, (start + end) / 2.0, (tensor + tensor.T) / 2.0)


def solid_bodies(solids: Solids, total: float) -> dict[str, Body]:
    """Link (the base included) -> its body when `total` [kg] is spread over all solids at one density."""
    unit: dict[str, Body] = {}
    for cylinder in solids.cylinders:
        unit[cylinder.link] = unit.get(cylinder.link, Body.massless()) + cylinder_body(cylinder, 1.0)
    density = total / sum(body.mass for body in unit.values())
    return {link: Body(density * body.mass, body.com, density * body.inertia_com) for link, body in unit.items()}


def parse_paper(text: str, file: str, reading: str | None = None) -> Paper:
    """The text of a data file under one of its readings.

    Parameters
    ----------
    text : str
        TOML of schema 1.
    file : str
        Its name, for messages.
    reading : str, optional
        The file's own default if not given.

    Raises
    ------
    PaperError
        Broken TOML or a breach of the schema, with file, field and what is allowed.
    UnknownNameError
        No reading of that name.
    """
    return paper_of_tables(parse_toml(text, file), file, reading, digest=_digest(text))


def parse_readings(text: str, file: str) -> tuple[Paper, ...]:
    """The text of a data file under each of its readings, the default first; raises as `parse_paper`."""
    tables, digest = parse_toml(text, file), _digest(text)
    paper = paper_of_tables(tables, file, digest=digest)
    return (paper, *(paper_of_tables(tables, file, name, digest=digest) for name in paper.reading_names[1:]))


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def paper_of_tables(
    raw: dict[str, Any],
    file: str,
    reading: str | None = None,
    errata_read: Collection[str] | None = None,
    digest: str = "",
) -> Paper:
    """`parse_paper` on parsed TOML, which is not changed.

    With `errata_read`, exactly those errata (ids) are applied instead of the reading's. Raises as `parse_paper`.
    """
    top = Fields(raw, file, "")
    if top.take("schema", int) != SCHEMA:
        raise PaperError(file, "schema", str(raw["schema"]), str(SCHEMA))
    name, title = top.take("name", str), top.take("title", str)
    _printable({"name": name, "title": title}, file)
    document = {k: str(v) for k, v in top.take("document", dict).items()}
    errata = tuple(_erratum(e, file, i) for i, e in enumerate(top.take("erratum", list, default=[])))
    ids = [e.id for e in errata]
    for repeated in {x for x in ids if ids.count(x) > 1}:
        raise PaperError(file, "erratum.id", f"{repeated!r} twice", "each id once")
    readings = _readings(top.take("reading", dict, default={"printed": {"about": "as printed"}}), errata, file)
    default = top.take("default_reading", str, default="printed")
    for unknown in {default, reading or default} - set(readings):
        raise UnknownNameError(f"reading of {name}", unknown, readings)
    chosen = readings[reading or default]
    if errata_read is not None:
        chosen = Reading(chosen.name, chosen.about, tuple(e for e in ids if e in errata_read))
    joints, kinds = _joints(top.take("joints", dict), file)
    printed = {key: top.take(key, dict) for key in TABLES if key in raw}
    if "dh" not in printed:
        raise PaperError(file, "dh", "missing", "a table of DH columns")
    top.refuse_unknown()
    tables = copy.deepcopy(printed)
    touched = apply_errata(tables, tuple(e for e in errata if e.id in chosen.errata), file)
    convention = choice(tables["dh"].pop("convention", None), [c.value for c in Convention], file, "dh.convention")
    about, products = _inertia_conventions(tables, len(joints), file)
    solids = _solids(tables, len(joints), file)
    columns = read_columns(tables, len(joints), touched, file)
    check_plausibility(columns, joints, kinds, file)
    return Paper(
        name=name, title=title, file=file, document=document, reading=chosen, readings=readings,
        default_reading=default, errata=errata, joints=joints, kinds=kinds, convention=Convention(convention),
        printed=printed, columns=columns, inertia_about=about, inertia_products=products, digest=digest, solids=solids,
    )  # fmt: skip


def _joints(table: dict[str, Any], file: str) -> tuple[tuple[str, ...], tuple[JointKind, ...]]:
    fields = Fields(table, file, "joints")
    kinds = fields.take("kinds", list)
    if not kinds:
        raise PaperError(file, "joints.kinds", "an empty list", "one of revolute, prismatic per joint")
    for i, kind in enumerate(kinds):
        choice(kind, [k.value for k in JointKind], file, f"joints.kinds[{i}]")
    names = fields.take("names", list, default=[f"joint_{i + 1}" for i in range(len(kinds))])
    fields.refuse_unknown()
    if not all(isinstance(x, str) for x in names) or len(names) != len(kinds) or len(set(names)) != len(names):
        raise PaperError(file, "joints.names", f"{names}", f"{len(kinds)} different names")
    _printable({f"joints.names[{i}]": name for i, name in enumerate(names)}, file)
    return tuple(names), tuple(JointKind(k) for k in kinds)


def _printable(names: dict[str, str], file: str) -> None:
    for field, name in names.items():
        if not name.strip() or not name.isprintable():
            raise PaperError(file, field, repr(name), "text of printable characters")


def _erratum(table: Any, file: str, index: int) -> Erratum:
    fields = Fields(table, file, f"erratum[{index}]")
    texts = {key: fields.take(key, str) for key in ("id", "where", "printed", "read_as", "why", "effect")}
    status, severity = fields.take_one_of("status", STATUSES), fields.take_one_of("severity", SEVERITIES, default="")
    patches = []
    for j, entry in enumerate(fields.take("patch", list, default=[])):
        patch = Fields(entry, file, f"erratum[{index}].patch[{j}]")
        kind = patch.take_one_of("kind", KINDS, default="")
        fitted_to = tuple(str(at) for at in patch.take("fitted_to", list, default=[]))
        values = patch.take("printed", object), patch.take("read", object)
        patches.append(Patch(patch.take("at", str), *values, kind, fitted_to))
        patch.refuse_unknown()
    fields.refuse_unknown()
    return Erratum(**texts, status=status, patches=tuple(patches), severity=severity)


def _readings(table: dict[str, Any], errata: tuple[Erratum, ...], file: str) -> dict[str, Reading]:
    out = {}
    ids = [e.id for e in errata]
    for name, entry in table.items():
        fields = Fields(entry, file, f"reading.{name}")
        applied = tuple(fields.take("errata", list, default=[]))
        out[name] = Reading(name, fields.take("about", str), applied)
        fields.refuse_unknown()
        for missing in [e for e in applied if e not in ids]:
            raise PaperError(file, f"reading.{name}.errata", repr(missing), f"one of {', '.join(ids) or 'none'}")
        one_erratum_a_cell([e for e in errata if e.id in applied], file)
    return out


def _inertia_conventions(tables: dict[str, Any], n: int, file: str) -> tuple[str, tuple[str, ...]]:
    """`about` and `products` of the tensors; their fields are removed from the column, and `axes` is checked."""
    inertia = tables.get("inertial", {}).get("inertia")
    if not isinstance(inertia, dict):
        return "com", ("tensor",) * n
    field = "inertial.inertia"
    about = choice(inertia.pop("about", None), ABOUT, file, f"{field}.about")
    choice(inertia.pop("axes", None), ("frame",), file, f"{field}.axes")
    products = inertia.pop("products", None)
    signs = [products] * n if not isinstance(products, list) else products
    if len(signs) != n:
        raise PaperError(file, f"{field}.products", f"{len(signs)} entries", f"one word, or {n}, one per joint")
    return about, tuple(choice(s, PRODUCTS, file, f"{field}.products") for s in signs)


def _solids(tables: dict[str, Any], n: int, file: str) -> Solids | None:
    """The drawn cylinders; their table is removed from the columns."""
    drawing = tables.get("drawing")
    if not isinstance(drawing, dict) or "solids" not in drawing:
        return None
    return read_solids(drawing.pop("solids"), ("base", *(f"link_{i + 1}" for i in range(n))), file)
