"""Which papers can be reproduced: each folder of this package with a `results.toml`, described by its `STUDY`.

The printed results of a paper as data: a block per table, figure or sentence; the strict reader of `results.toml`.

A block states its place in the paper, its unit, and the function that recomputes it. Its cells are text, digit for
digit as printed; `given` holds values that are printed beside them and are no results. A cell of a figure has a range:
how far its axis or its line can be read. `form` "derived" marks numbers that this package states and the paper does
not print.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from decimal import Decimal, InvalidOperation
from functools import cache
from importlib import import_module, resources
from typing import Any, Literal

from lwr_dyn.foundation.errors import OptionError, UnknownNameError, needs_extra
from lwr_dyn.foundation.fields import Fields, parse_toml

ALL = "all"
"""In place of a paper's name: every paper."""
OWN = ".toml"
"""Ending of a user's own paper, in place of a name."""


@dataclass(frozen=True, slots=True)
class StudyOption:
    """An option of `lwr-dyn reproduce` that a study takes: one of `values`, or a flag where there are none."""

    name: str
    about: str
    values: tuple[str, ...] = ()
    for_all: bool = False
    """Whether `reproduce all` takes it too, for the papers that have it."""

    @property
    def keyword(self) -> str:
        """Its name as an argument of a function."""
        return self.name.replace("-", "_")


SENSITIVITY = StudyOption("sensitivity", "also the task under all readings (a minute more)", for_all=True)
"""For papers whose readings are readings of one arm, with masses in print."""


@dataclass(frozen=True, slots=True)
class Study:
    """How a paper is reproduced; `run`, `formulas`, `proofs` are "module:attribute", imported when they are used."""

    order: int
    """Place among the papers."""
    run: str
    """(place, arm, progress, **options) -> `Reproduction`: computes, and writes its files into the folder `place`."""
    formulas: str
    """Name in `results.toml` -> `PaperFormula`."""
    proofs: str = ""
    """Id of an erratum -> its proof; empty for a paper without errata."""
    options: tuple[StudyOption, ...] = ()
    conventions: Literal["", "tensors", "zero"] = ""
    """What the tables leave open: conventions of the inertia tensors, or zero and signs of the joints."""
    failing_readings: tuple[str, ...] = ()
    """Readings whose models fail some checks, as errata of the paper explain."""

    def load(self, part: str) -> Any:
        """The object that `part` ("run", "formulas", "proofs") names; raises `MissingPackageError`."""
        module, _, attribute = getattr(self, part).partition(":")
        with needs_extra("all"):
            return getattr(import_module(module), attribute)


@cache
def studies() -> Mapping[str, Study]:
    """Paper -> study, in their order; adding a paper is adding a folder."""
    folders = [f for f in resources.files(__package__).iterdir() if f.joinpath("results.toml").is_file()]
    known = {f.name: import_module(f"{__package__}.{f.name}").STUDY for f in folders}
    return dict(sorted(known.items(), key=lambda item: item[1].order))


def study_of(paper: str) -> Study:
    """The study of a paper; raises `UnknownNameError` for a paper that is not reproduced."""
    if paper not in studies():
        raise UnknownNameError("paper to reproduce", paper, (*studies(), ALL, "a path to a .toml with [[result]]"))
    return studies()[paper]


def takers(keyword: str) -> dict[str, StudyOption]:
    """Paper -> option of that keyword, for the papers that take it."""
    return {paper: o for paper, study in studies().items() for o in study.options if o.keyword == keyword}


def check_options(paper: str, options: Mapping[str, Any]) -> None:
    """Raise `OptionError` for options that a paper (or "all") does not take, or for a value that is not allowed."""
    for keyword, value in options.items():
        by_paper = takers(keyword)
        if not by_paper:
            raise OptionError("option", repr(keyword), ", ".join(sorted(option_keywords())))
        option = by_paper.get(paper, next(iter(by_paper.values())))
        allowed = [*by_paper, ALL] if option.for_all else [*by_paper]
        if paper not in allowed:
            raise OptionError(f"--{option.name}", f"given for {paper}", f"only for {', '.join(allowed)}")
        if option.values and value not in option.values:
            raise OptionError(f"--{option.name}", repr(value), ", ".join(option.values))


def option_keywords() -> tuple[str, ...]:
    """Keywords of all options, in the order of the papers."""
    return tuple(dict.fromkeys(o.keyword for study in studies().values() for o in study.options))


SCHEMA = 1

FORMS = ("table", "figure", "text", "equation", "derived")


@dataclass(frozen=True, slots=True)
class PrintedCell:
    """One printed result: its text, place in the block, unit, and for a figure the range in which it can be read."""

    path: str
    """"results.table_iv.b[0]", as errata name it."""
    row: str
    column: str
    printed: str
    unit: str
    span: tuple[str, str] | None = None
    step: str = ""
    """The last digit that is meant where fewer are printed: a bare 0 among decimals."""


@dataclass(frozen=True, slots=True, eq=False)
class ResultBlock:
    """A table, a figure, an equation or a sentence with results."""

    name: str
    where: str
    form: str
    compute: str
    """Name of the function that recomputes it; empty when there can be none, for lack of `needs`."""
    cells: tuple[PrintedCell, ...]
    printed: Mapping[str, Any]
    """Cells and `given` by name, as parsed."""
    needs: tuple[str, ...] = ()
    """What a recomputation needs beyond the tables: "gains.kp" must be printed in the paper's data file; a text with
    spaces names something that is in no data file."""
    errata: tuple[str, ...] = ()
    """Errata beyond those of the paper's reading (`Results.reading`) that may explain a difference."""
    reading: str = ""
    """The reading that derived numbers are of; `Results.reading` if empty."""
    note: str = ""
    range_of: tuple[str, ...] = ()
    """Columns that span a row's range, in which "near" is meant where conditions are assumed."""

    def range_cells(self, cell: PrintedCell) -> list[PrintedCell]:
        """The cells of `range_of` in the row and unit of a cell."""
        return [c for c in self.cells if c.column in self.range_of and (c.row, c.unit) == (cell.row, cell.unit)]

    @property
    def derived(self) -> bool:
        """Stated by us, not printed by the paper."""
        return self.form == "derived"


@dataclass(frozen=True, slots=True, eq=False)
class Results:
    """All blocks of a paper by name."""

    paper: str
    file: str
    blocks: Mapping[str, ResultBlock]
    reading: str | None
    """The reading under which the authors' numbers are recomputed, which need not be the arm most likely."""
    raw: Mapping[str, Any] = field(default_factory=dict)


def results_text(paper: str, file: str = "results") -> str:
    """The text of a data file of a paper's folder."""
    return resources.files(f"{__package__}.{paper}").joinpath(f"{file}.toml").read_text(encoding="utf-8")


def printed_tables(paper: str, file: str = "results") -> dict[str, Any]:
    """A data file of a paper's folder as parsed: block -> its cells and the values printed beside them, by name."""
    blocks = parse_toml(results_text(paper, file), f"{file}.toml").items()
    return {name: x | x.get("given", {}) | x.get("cells", {}) if isinstance(x, dict) else x for name, x in blocks}


def read_results(text: str, file: str) -> Results:
    """`results.toml` -> `Results`; raises `PaperError` with file and field for whatever breaks the schema."""
    return results_of_tables(parse_toml(text, file), file)


def results_of_tables(raw: Mapping[str, Any], file: str) -> Results:
    """`read_results` on parsed TOML; raises as it does."""
    top = Fields(raw, file)
    if top.take("schema", int) != SCHEMA:
        raise top.refuse("schema", str(raw["schema"]), str(SCHEMA))
    paper, reading = top.text("paper"), top.text("reading", default="") or None
    return Results(paper, file, {name: _block(name, top.table(name)) for name in top.unread()}, reading, raw)


def _block(name: str, fields: Fields) -> ResultBlock:
    where, form = fields.text("where"), fields.choice("form", FORMS)
    units = fields.take("unit", object)
    rows = [str(r) for r in fields.take("rows", list, default=[])]
    cells, given = fields.take("cells", dict), fields.take("given", dict, default={})
    spans = fields.take("ranges", dict, default={})
    compute = fields.text("compute", default="")
    lists = {key: tuple(str(x) for x in fields.take(key, list, default=[])) for key in ("needs", "errata", "range_of")}
    reading, note, step = fields.text("reading", default=""), fields.text("note", default=""), _step(fields)
    fields.refuse_unknown()
    if not (compute or lists["needs"]):
        raise fields.refuse("compute", "missing", "a recomputing function, or needs that say what is missing")
    if bool(spans) != (form == "figure"):
        raise fields.refuse("ranges", "given" if spans else "missing", "ranges for figures, and only for them")
    if lists["needs"] and compute and form != "figure" and not set(lists["range_of"]) & set(cells):
        raise fields.refuse("range_of", repr(list(lists["range_of"])), f"some of {', '.join(cells)}")
    for twice in set(cells) & set(given):
        raise fields.refuse(f"given.{twice}", "also a column of cells", "each name once")
    for unknown in set(spans) - set(cells):
        raise fields.refuse(f"ranges.{unknown}", "no such column", ", ".join(cells))
    printed: list[PrintedCell] = []
    for column, entries in cells.items():
        unit = units.get(column) if isinstance(units, dict) else units
        if not isinstance(unit, str):
            raise fields.refuse("unit", repr(unit), f"text, or a table with text for {column}")
        printed += [replace(c, step=step) for c in _column(fields, column, entries, unit, rows, spans.get(column))]
    return ResultBlock(
        name, where, form, compute, tuple(printed), dict(cells) | dict(given), lists["needs"], lists["errata"],
        reading, note, lists["range_of"],
    )  # fmt: skip


def _step(fields: Fields) -> str:
    text: str = fields.text("step", default="")
    if text and not (text.startswith("0.") and set(text[2:]) <= {"0", "1"} and text.endswith("1")):
        raise fields.refuse("step", repr(text), 'a digit such as "0.01"')
    return text


def _column(fields: Fields, column: str, entries: Any, unit: str, rows: list[str], spans: Any) -> Iterator[PrintedCell]:
    name = f"cells.{column}"
    if not isinstance(entries, list) or not entries:
        raise fields.refuse(name, repr(entries), "a list of texts, one per row")
    nested = isinstance(entries[0], list)
    if rows and len(rows) != len(entries):
        raise fields.refuse(name, f"{len(entries)} entries", f"{len(rows)}, one per row")
    labels = rows or [str(i + 1) for i in range(len(entries))]
    flat = [
        (f"{labels[i]},{j + 1}" if nested else labels[i], f"[{i}][{j}]" if nested else f"[{i}]", text)
        for i, row in enumerate(entries)
        for j, text in enumerate(row if nested and isinstance(row, list) else [row])
    ]
    if spans is not None and (not isinstance(spans, list) or len(spans) != len(flat)):
        raise fields.refuse(f"ranges.{column}", repr(spans), f"{len(flat)} pairs of texts")
    for k, (row, place, text) in enumerate(flat):
        if not isinstance(text, str) or not text.strip():
            raise fields.refuse(f"{name}{place}", repr(text), "text, digit for digit as printed")
        span = None if spans is None else _span(fields, f"ranges.{column}[{k}]", text, spans[k])
        yield PrintedCell(f"results.{fields.path}.{column}{place}", row, column, text, unit, span)


def _span(fields: Fields, name: str, text: str, span: Any) -> tuple[str, str]:
    if not isinstance(span, list) or len(span) != 2 or not all(isinstance(x, str) for x in span):
        raise fields.refuse(name, repr(span), "two texts, least and most")
    try:
        least, value, most = Decimal(span[0]), Decimal(text), Decimal(span[1])
    except InvalidOperation:
        raise fields.refuse(name, f"{text!r} in {span}", "numbers") from None
    if not least <= value <= most:
        allowed = f"a value within {span[0]} to {span[1]}"
        raise fields.refuse(name, f"the value read, {text}, lies outside", allowed)
    return span[0], span[1]
