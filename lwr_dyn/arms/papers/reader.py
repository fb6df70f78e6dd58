"""The strict reader: TOML text -> `Paper`. An unknown, missing, misspelt or non-finite entry raises, with its place."""

import copy
import hashlib
from collections.abc import Collection
from typing import Any

from lwr_dyn.arms.papers.columns import read_columns
from lwr_dyn.arms.papers.errata import apply_errata, one_erratum_a_cell
from lwr_dyn.arms.papers.fields import Fields, choice, parse_toml
from lwr_dyn.arms.papers.plausibility import check_plausibility
from lwr_dyn.arms.papers.schema import (
    ABOUT,
    KINDS,
    PRODUCTS,
    SCHEMA,
    SEVERITIES,
    STATUSES,
    TABLES,
    Erratum,
    Paper,
    Patch,
    Reading,
    Solids,
)
from lwr_dyn.arms.papers.solids import read_solids
from lwr_dyn.foundation.errors import PaperError, UnknownNameError
from lwr_dyn.model.dh import Convention, JointKind


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
