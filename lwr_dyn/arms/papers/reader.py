"""The strict reader: TOML text -> `Paper`. An unknown, missing, misspelt or non-finite entry raises, with its place.

The errata of a reading are applied to the printed tables first; a patch must state exactly what is printed in its cell.
"""

import copy
import hashlib
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

from lwr_dyn.arms.papers import schema
from lwr_dyn.arms.papers.columns import check_plausibility, read_columns
from lwr_dyn.arms.papers.schema import Erratum, Paper, Patch, PublishedSet, Reading, Solids
from lwr_dyn.arms.papers.sets import check_errata_of_set, read_sets, tables_under
from lwr_dyn.arms.papers.solids import read_solids
from lwr_dyn.foundation.errors import PaperError, UnknownNameError
from lwr_dyn.foundation.fields import Fields, parse_toml
from lwr_dyn.model.chain import Convention, JointKind

_STEP = re.compile(r"\.?([A-Za-z_0-9]+)|\[(\d+)\]")
_PATH = re.compile(r"[A-Za-z_0-9]+(\.[A-Za-z_0-9]+|\[\d+\])+")


def apply_errata(tables: dict[str, Any], errata: tuple[Erratum, ...], file: str) -> dict[str, dict[int, list[str]]]:
    """Patches the parsed tables in place: column path ("inertial.mass") -> row -> ids of the errata that touched it.

    Raises `PaperError`: a patch names no cell, the file prints something else there, or two errata change one cell.
    """
    touched: dict[str, dict[int, list[str]]] = {}
    one_erratum_a_cell(errata, file)
    for erratum in errata:
        for patch in erratum.of_tables():
            apply_patch(tables, patch, erratum.id, file)
            column, row = _column_and_row(patch.at)
            for i in [row] if row is not None else range(64):  # all rows: no arm has more joints
                ids = touched.setdefault(column, {}).setdefault(i, [])
                ids += [erratum.id] if erratum.id not in ids else []
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


@lru_cache(maxsize=128)
def parse_paper(text: str, file: str, reading: str | None = None) -> Paper:
    """The text of a data file (TOML of schema 1) under one of its readings, its own default if not given.

    The same text gives the same paper again: it is not to be changed.

    Raises `PaperError`, with file, field and what is allowed, for broken TOML or a breach of the schema;
    `UnknownNameError` for a reading of another name.
    """
    return paper_of_tables(parse_toml(text, file), file, reading, digest=_digest(text))


@lru_cache(maxsize=128)
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

    With `errata_read`, exactly those errata (ids) are applied, to the tables as they are, instead of the reading's set
    and errata. Raises as `parse_paper`.
    """
    top = Fields(raw, file)
    if top.take("schema", int) != schema.SCHEMA:
        raise top.refuse("schema", str(raw["schema"]), str(schema.SCHEMA))
    name, title = _printable(top, "name", top.text("name")), _printable(top, "title", top.text("title"))
    document = {k: str(v) for k, v in top.take("document", dict).items()}
    if "kind" in document:
        top.choice_at("document.kind", document["kind"], schema.DOCUMENT_KINDS)
    sources = tuple(_source(x) for x in top.tables("source", default=[]))
    sets = read_sets(top)
    errata = tuple(_erratum(e, (*sets,)) for e in top.tables("erratum", default=[]))
    ids = [e.id for e in errata]
    for repeated in {x for x in ids if ids.count(x) > 1}:
        raise top.refuse("erratum.id", f"{repeated!r} twice", "each id once")
    readings = _readings(top.table("reading", default={"printed": {"about": "as printed"}}), errata, sets)
    default = top.text("default_reading", default="printed")
    for unknown in {default, reading or default} - set(readings):
        raise UnknownNameError(f"reading of {name}", unknown, readings)
    chosen = readings[reading or default]
    if errata_read is not None:
        chosen = replace(chosen, errata=tuple(e for e in ids if e in errata_read), set_name="")
    joints, kinds, torques = _joints(top.table("joints"))
    own = {key: top.take(key, dict) for key in schema.TABLES if key in raw}
    printed = tables_under(own, sets.get(chosen.set_name))
    if "dh" not in printed:
        raise top.refuse("dh", "missing", "a table of DH columns")
    top.take(schema.RESULT, list, default=[])
    top.take(schema.RUN, dict, default={})
    top.refuse_unknown()
    tables = copy.deepcopy(printed)
    touched = apply_errata(tables, tuple(e for e in errata if e.id in chosen.errata), file)
    convention = top.choice_at("dh.convention", tables["dh"].pop("convention", None), [c.value for c in Convention])
    about, products = _inertia_conventions(tables, len(joints), file)
    seen = tables.get("friction", {}).pop("side", "joint")
    side = Fields({}, file, "friction").choice_at("side", seen, schema.FRICTION_SIDES)
    solids = _solids(tables, len(joints), file)
    columns = read_columns(tables, len(joints), touched, file)
    check_plausibility(columns, joints, kinds, file)
    return Paper(
        name=name, title=title, file=file, document=document, sources=sources, reading=chosen, readings=readings,
        default_reading=default, sets=sets, errata=errata, joints=joints, kinds=kinds, torques=torques,
        convention=Convention(convention), printed=printed, columns=columns, inertia_about=about,
        inertia_products=products, friction_side=side, digest=digest, solids=solids,
    )  # fmt: skip


def _source(fields: Fields) -> dict[str, str]:
    found = {key: fields.text(key) for key in schema.SOURCE_FIELDS}
    fields.choice_at("kind", found["kind"], schema.DOCUMENT_KINDS)
    fields.refuse_unknown()
    return found


def _joints(fields: Fields) -> tuple[tuple[str, ...], tuple[JointKind, ...], str]:
    kinds = fields.take("kinds", list)
    if not kinds:
        raise fields.refuse("kinds", "an empty list", "one of revolute, prismatic per joint")
    for i, kind in enumerate(kinds):
        fields.choice_at(f"kinds[{i}]", kind, [k.value for k in JointKind])
    names = fields.take("names", list, default=[f"joint_{i + 1}" for i in range(len(kinds))])
    torques = fields.choice("torques", schema.TORQUES, default="")
    fields.refuse_unknown()
    if not all(isinstance(x, str) for x in names) or len(names) != len(kinds) or len(set(names)) != len(names):
        raise fields.refuse("names", f"{names}", f"{len(kinds)} different names")
    printable = tuple(_printable(fields, f"names[{i}]", x) for i, x in enumerate(names))
    return printable, tuple(map(JointKind, kinds)), torques


def _printable(fields: Fields, place: str, name: str) -> str:
    if not name.strip() or not name.isprintable():
        raise fields.refuse(place, repr(name), "text of printable characters")
    return name


def _erratum(fields: Fields, sets: tuple[str, ...]) -> Erratum:
    texts = {key: fields.text(key) for key in ("id", "where", "printed", "read_as", "why", "effect")}
    status, severity = (
        fields.choice("status", schema.STATUSES),
        fields.choice("severity", schema.SEVERITIES, default=""),
    )
    patches = tuple(map(_patch, fields.tables("patch", default=[])))
    of_set = fields.choice("set", sets, default="")
    fields.refuse_unknown()
    return Erratum(**texts, status=status, patches=patches, severity=severity, set_name=of_set)


def _patch(fields: Fields) -> Patch:
    kind = fields.choice("kind", schema.KINDS, default="")
    fitted_to = tuple(str(at) for at in fields.take("fitted_to", list, default=[]))
    printed, read = fields.take("printed", object), fields.take("read", object)
    patch = Patch(fields.text("at"), printed, read, kind, fitted_to)
    fields.refuse_unknown()
    return patch


def _readings(tables: Fields, errata: tuple[Erratum, ...], sets: Mapping[str, PublishedSet]) -> dict[str, Reading]:
    out = {}
    ids = [e.id for e in errata]
    for name in tables.unread():
        fields = tables.table(name)
        applied = tuple(fields.take("errata", list, default=[]))
        out[name] = Reading(name, fields.text("about"), applied, fields.choice("set", (*sets,), default=""))
        fields.refuse_unknown()
        for missing in [e for e in applied if e not in ids]:
            raise fields.refuse("errata", repr(missing), f"one of {', '.join(ids) or 'none'}")
        read = [e for e in errata if e.id in applied]
        check_errata_of_set(fields, read, sets.get(out[name].set_name))
        one_erratum_a_cell(read, fields.file)
    return out


def _inertia_conventions(tables: dict[str, Any], n: int, file: str) -> tuple[str, tuple[str, ...]]:
    """`about` and `products` of the tensors; their fields are removed from the column, and `axes` is checked."""
    inertia = tables.get("inertial", {}).get("inertia")
    if not isinstance(inertia, dict):
        return "com", ("tensor",) * n
    fields = Fields({}, file, "inertial.inertia")
    about = fields.choice_at("about", inertia.pop("about", None), schema.ABOUT)
    turned = "rpy" in tables["inertial"]
    fields.choice_at("axes", inertia.pop("axes", None), ("rpy",) if turned else ("frame",))
    products = inertia.pop("products", None)
    signs = [products] * n if not isinstance(products, list) else products
    if len(signs) != n:
        raise fields.refuse("products", f"{len(signs)} entries", f"one word, or {n}, one per joint")
    return about, tuple(fields.choice_at("products", s, schema.PRODUCTS) for s in signs)


def _solids(tables: dict[str, Any], n: int, file: str) -> Solids | None:
    """The drawn cylinders; their table is removed from the columns."""
    drawing = tables.get("drawing")
    if not isinstance(drawing, dict) or "solids" not in drawing:
        return None
    fields = Fields(drawing.pop("solids"), file, "drawing.solids")
    return read_solids(fields, ("base", *(f"link_{i + 1}" for i in range(n))))
