"""The report page of a paper: printed numbers beside ours, errata with proofs, checks, audits, files.

How many numbers got which verdict and on what basis, and how many errata are proven: as records, tables, a text.
"""

import hashlib
import platform
from collections.abc import Collection, Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any, cast

from lwr_dyn.arms.papers.schema import SEVERITIES
from lwr_dyn.checks.arm.run_checks import CheckReport
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.printed_number import last_digit
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.case import (
    COMPUTED,
    CONTRADICTION,
    REPEATED,
    STRUCTURAL,
    ComparedExpression,
    LedgerEntry,
)
from lwr_dyn.reproduction.compare import AFTER, ASSUMED, DIFFERS, NEAR, NOT, REPRODUCED, ComparedNumber, Verdicts
from lwr_dyn.reproduction.paper_study import PaperStudy, Reproduction
from lwr_dyn.reproduction.papers import ResultBlock
from lwr_dyn.reproduction.report import content
from lwr_dyn.simulation.audit import inverse_dynamics_words
from lwr_dyn.simulation.metrics import stop_contacts
from lwr_dyn.simulation.setup import versions

NEARNESS = f"near: within the digits or axes printed, or {NEAR:.0%} of the range printed in the row"
"""What "near" means, for tables and texts."""

COUNTED: Mapping[str, tuple[str, ...]] = {
    "printed": ("printed", "all"),
    COMPUTED: ("printed", COMPUTED, "all"),
    REPRODUCED: ("printed", COMPUTED, REPRODUCED),
    AFTER: ("printed", COMPUTED, AFTER),
    DIFFERS: ("printed", DIFFERS),
    STRUCTURAL: ("printed", STRUCTURAL, "all"),
    "repeated": ("printed", REPEATED, "all"),
    "assumed": ("printed", ASSUMED, "all"),
    "of them near": ("printed", ASSUMED, "near"),
    "no value": ("printed", NOT),
    "derived": ("derived", "all"),
    "of them computed": ("derived", COMPUTED, "all"),
    "errata": ("errata", "all"),
    "proven": ("errata", "proofs that hold"),
}
"""Heading -> place in the record of counts."""

COUNT_NOTE = f"""\
computed: from other numbers; of them reproduced as printed, or after an erratum; differs: of all kinds
structural: 0, +-1 and entries that stay whatever the numbers are
repeated: one number in print twice, a count, a place, or what an erratum was fitted to: compared, not computed
assumed: recomputed under conditions that are not printed; {NEARNESS}"""


def counts(verdicts: Verdicts, entries: Sequence[LedgerEntry]) -> dict[str, Any]:
    """Printed and derived numbers apart, by basis and verdict; errata by status."""
    proven = [e for e in entries if e.erratum.status == "proven"]
    return {
        **{
            kind: _counted([n for n in verdicts.numbers if n.block.derived == derived])
            for kind, derived in (("printed", False), ("derived", True))
        },
        "errata": {
            "all": len(entries), "proven": len(proven), "proofs that hold": sum(e.holds for e in proven),
            CONTRADICTION: sum(e.proof is not None and e.proof.kind == CONTRADICTION for e in proven),
            **{weight: sum(e.erratum.severity == weight for e in proven) for weight in SEVERITIES},
        },
    }  # fmt: skip


def _counted(numbers: Sequence[ComparedNumber]) -> dict[str, Any]:
    out: dict[str, Any] = {"all": len(numbers)}
    for basis in (COMPUTED, STRUCTURAL, REPEATED):
        mine = [n.verdict for n in numbers if n.basis == basis]
        out[basis] = {"all": len(mine), **{verdict: mine.count(verdict) for verdict in (REPRODUCED, AFTER, DIFFERS)}}
    near = [n.near for n in numbers if n.verdict == ASSUMED]
    out[ASSUMED] = {"all": len(near), "near": near.count(True), "not near": near.count(False)}
    return out | {verdict: sum(n.verdict == verdict for n in numbers) for verdict in (DIFFERS, NOT)}


def count_table(records: Mapping[str, Mapping[str, Any]]) -> Table:
    """A row a paper, from `counts`, and a sum where there are several."""
    rows = [(paper, *(_at(record, place) for place in COUNTED.values())) for paper, record in records.items()]
    if len(rows) > 1:
        rows.append(("all", *map(sum, zip(*(row[1:] for row in rows), strict=True))))
    return Table("", ("paper", *COUNTED), rows, COUNT_NOTE)


def _at(record: Any, place: Sequence[str]) -> int:
    for key in place:
        record = record[key]
    return int(record)


def summary_text(verdicts: Verdicts, entries: Sequence[LedgerEntry], holds: bool) -> str:
    """The outcome in words: what is computed first, what is only assumed and not explained last."""
    counted = counts(verdicts, entries)
    printed, derived = counted["printed"], counted["derived"]
    mine = printed[COMPUTED]
    parts = [
        f"Of {printed['all']} printed numbers {_are(mine['all'])} computed from other numbers:"
        f" {_are(mine[REPRODUCED])} reproduced as printed, {mine[AFTER]} after an erratum, {mine[DIFFERS]}"
        f" differ{'s' * (mine[DIFFERS] == 1)}.",
        f"{_are(printed[STRUCTURAL]['all'])} structural and {printed[REPEATED]['all']} repeated in print: compared, not"
        f" computed; {printed[STRUCTURAL][DIFFERS] + printed[REPEATED][DIFFERS]} of them differ.",
    ]
    if printed[NOT]:
        parts.append(f"{printed[NOT]} cannot be computed: {_missing(verdicts, NOT)} not printed.")
    if assumed := printed[ASSUMED]["all"]:
        near, far = (printed[ASSUMED][key] for key in ("near", "not near"))
        parts.append(
            f"{_are(assumed)} recomputed under assumed conditions ({_missing(verdicts, ASSUMED)} not printed):"
            f" {near} near, {far} not near ({NEARNESS})."
        )
        parts += [f"It is not explained why {_are(far)} not near."] if far else []
    if derived["all"]:
        parts.append(f"Of {derived['all']} derived numbers {_are(derived[COMPUTED]['all'])} computed.")
    if counted["errata"]["all"]:
        parts += errata_words(counted["errata"])
    if not holds:
        parts.append("Something computed, checked or claimed is NOT explained.")
    return " ".join(parts)


def _are(count: int) -> str:
    """The number with its verb: 1 is, 2 are."""
    return f"{count} {'is' if count == 1 else 'are'}"


def errata_words(counted: Mapping[str, int]) -> list[str]:
    """How many errata are proven, what they change, and how many are contradictions; from `counts`."""
    word = "erratum" if counted["all"] == 1 else "errata"
    out = [f"Of {counted['all']} {word} {_are(counted['proofs that hold'])} proven."]
    if counted["proven"]:
        model, text = counted["model"], counted["text"]
        slips = f"{_are(text)} {'a slip' if text == 1 else 'slips'} of the text"
        out.append(f"Of these {model} change{'s' * (model == 1)} the model, {counted['result']} a result, {slips}.")
    if both := counted[CONTRADICTION]:
        which = f"{both} {'erratum' if both == 1 else 'errata'}"
        out.append(f"In {which} two statements exclude each other; which one is wrong is not shown.")
    return out


def verdict_sentence(verdicts: Verdicts, entries: Sequence[LedgerEntry], holds: bool) -> tuple[tuple[str, bool], ...]:
    """The outcome for the head of a page, with its reasons: pieces of text, each with whether it stands out."""
    printed = counts(verdicts, entries)["printed"]
    mine, same = printed[COMPUTED], printed[STRUCTURAL]["all"] + printed[REPEATED]["all"]
    good = mine[REPRODUCED] + mine[AFTER]
    ways = [f"{mine[REPRODUCED]} as printed", *([f"{mine[AFTER]} after an erratum"] if mine[AFTER] else [])]
    out = [(f"{good} of {printed['all']}", True), (f" printed numbers come out: {', '.join(ways)}.", False)]
    if agree := same - printed[STRUCTURAL][DIFFERS] - printed[REPEATED][DIFFERS]:
        after = printed[STRUCTURAL][AFTER] + printed[REPEATED][AFTER]
        of_them = f", {after} of them after an erratum" if after else ""
        out.append((f" {agree} more agree{of_them}, but are structural or repeated in print.", False))
    if assumed := printed[ASSUMED]["all"]:
        near, far = (printed[ASSUMED][key] for key in ("near", "not near"))
        needs = _missing(verdicts, ASSUMED).replace(".", " ")
        why = f" For {assumed} the paper leaves out {needs}: with assumed values {near} come near"
        out.append((f"{why}; why {far} do not is not explained." if far else f"{why}.", False))
    if printed[NOT]:
        out.append((f" {printed[NOT]} cannot be computed: {_missing(verdicts, NOT)} not printed.", False))
    if differ := printed[DIFFERS]:
        out.append((f" {differ} differ.", True))
    return (*out, *([] if holds else [(" Something computed, checked or claimed is NOT explained.", True)]))


def _missing(verdicts: Verdicts, verdict: str) -> str:
    """What numbers with a verdict need and the paper does not print."""
    needs = dict.fromkeys(need for n in verdicts.numbers if n.verdict == verdict for need in n.missing)
    return ", ".join(needs)


def difference_table(verdicts: Verdicts) -> Table:
    """Every number that differs, with D in its unit and in last digits."""
    differing = [number for number in verdicts.numbers if number.verdict == DIFFERS]
    rows = [(n.cell.path.removeprefix("results."), n.cell.printed, n.value, n.miss, n.digits) for n in differing]
    recomputed = Heading("recomputed", format=lambda x: x.text if isinstance(x, ComparedExpression) else f"{x:.8g}")
    sizes = (Heading(name, format="+.3g") for name in ("D", "in last digits"))
    return Table("", ("cell", "printed", recomputed, *sizes), rows)


def number_table(verdicts: Verdicts, entries: Sequence[LedgerEntry]) -> Table:
    """Every number of a user's own paper beside ours, and the errata that nothing shows."""
    rows = [
        (_named(n), n.cell.printed, _ours(n), n.cell.unit, verdict_words(n), n.block.where) for n in verdicts.numbers
    ]
    failed = [f"erratum {e.erratum.id}: {e.proof.statement}" for e in entries if e.proof and not e.proof.holds]
    return Table("", ("number", "printed", "recomputed", "unit", "verdict", "where"), rows, "\n".join(failed))


def _named(number: ComparedNumber) -> str:
    """The id of a result; of an entry of several with its place, counted from 1."""
    block, row = number.block, number.cell.row
    return row if row.partition("[")[0] == block.name else f"{block.name}[{row}]"


def verdict_words(number: ComparedNumber) -> str:
    """The verdict of a number with what belongs to it: errata, D, what is assumed, what it rests on."""
    words = number.verdict
    if number.errata:
        words = f"after erratum {', '.join(number.errata)}"
    if number.verdict == DIFFERS and number.miss is not None:
        words = f"differs by {number.miss:+.3g}, {number.digits:+.3g} last digits"
    if number.verdict == ASSUMED:
        words = f"{'near' if number.near else 'not near'}, assumed: {', '.join(number.missing)}"
    return f"{words}, {number.basis}" if number.outcome in BASIS_NOTES else words


REPORT = "report.html"

BASIS_NOTES = {
    STRUCTURAL: "stays whatever the numbers of the paper are",
    REPEATED: "compared, not computed: printed elsewhere too, or fitted to",
}
"""Class of a number -> what its cell adds."""

_KINDS = {".npz": "run", ".urdf": "model", ".xml": "model", ".srdf": "model", ".png": "plot", ".svg": "plot"}


def paper_page(
    study: PaperStudy,
    result: Reproduction,
    verdicts: Verdicts,
    entries: Sequence[LedgerEntry],
    reports: Sequence[CheckReport],
    place: Path,
) -> content.Page:
    """The whole page of a paper, with the files that lie in its folder by then."""
    paper, pictures = study.data.paper, result.pictures
    printed, derived = (tuple(x for x in verdicts.numbers if x.block.derived == d) for d in (False, True))
    title, _, about = paper.title.partition(" (")
    makers = [about.rstrip(")"), *(paper.document.get(key, "") for key in ("authors", "origin"))]
    return content.Page(
        title=title,
        subtitle=paper.document.get("title", ""),
        byline=" \u00b7 ".join([*(text for text in makers if text), f"reading {paper.reading.name}"]),
        verdict=verdict_sentence(verdicts, entries, result.holds),
        words=result.document.record()["summary"],
        document=tuple(paper.document.items()),
        tables=tuple(_tables(printed)),
        derived=tuple(_tables(derived)),
        errata=tuple(entries),
        figures=tuple(figure for figures in pictures.figures.values() for figure in figures if figure.id),
        replay=content.Replay(pictures.shown, pictures.stills) if pictures.shown or pictures.stills else None,
        checks=_checks(reports, study.study.failing_readings),
        audit=tuple(check for name, _, run in pictures.simulated for check in _audit(name, run)),
        sections=(content.ReportSection("text", "As text", result.document.text()), *pictures.sections),
        files=_files(place),
        versions=(("Python", platform.python_version()), *versions().items()),
    )


def _tables(numbers: Sequence[ComparedNumber]) -> list[content.ReportTable]:
    """A table for each block, in the order of the paper; rows that bear its name share a table a place."""
    blocks: dict[tuple[bool, str], list[ComparedNumber]] = {}
    for number in numbers:
        named = number.cell.row.partition("[")[0] == number.block.name  # of a user's own paper, see `own_paper`
        key = named, _title(number.block) if named else number.block.name
        blocks.setdefault(key, []).append(number)
    return list(map(_table, blocks.values()))


def _title(block: ResultBlock) -> str:
    """Where a block stands, up to the first comma or the like: "Table IV"."""
    return block.where.split(",")[0].split(":")[0].split(";")[0].strip("'")


def _table(numbers: Sequence[ComparedNumber]) -> content.ReportTable:
    block = numbers[0].block
    cells, empty = {_place(number): _cell(number) for number in numbers}, content.ReportCell("")
    rows, columns = (dict.fromkeys(place[k] for place in cells) for k in (0, 1))
    units = list(dict.fromkeys(number.cell.unit for number in numbers))
    title, several = _title(block), any(number.block is not block for number in numbers)
    heading = f"derived: {title}" if block.derived else title
    return content.ReportTable(
        id=block.name,
        title=heading,
        where="" if several else block.where.strip("'").removeprefix(title).lstrip("',:; "),
        columns=tuple(columns),
        rows=tuple(content.ReportRow(row, tuple(cells.get((row, name), empty) for name in columns)) for row in rows),
        unit="" if units == ["1"] else ", ".join(units),
        note="; ".join(dict.fromkeys(number.block.note for number in numbers if number.block.note)),
    )


def _place(number: ComparedNumber) -> tuple[str, str]:
    """Row and column of a number; of a matrix among several the row has its name."""
    cell = number.cell
    if "][" not in cell.path:
        return cell.row, cell.column
    row, column = cell.row.rsplit(",", 1)
    return f"{cell.column}: {row}", column


def _cell(number: ComparedNumber) -> content.ReportCell:
    cell, verdict = number.cell, number.verdict
    notes = []
    if number.missing:
        notes.append(f"not printed: {', '.join(number.missing)}; ours is under assumed ones; {NEARNESS}")
    if number.outcome in BASIS_NOTES:
        notes.append(f"{verdict}; {BASIS_NOTES[number.outcome]}")
    if verdict in (DIFFERS, ASSUMED) and number.miss is not None:
        size = "" if number.digits is None else f", {number.digits:+.3g} last digits"
        notes.append(f"ours less printed: {number.miss:+.3g} {cell.unit}{size}")
    if cell.span is not None:
        notes.append(f"can be read within {cell.span[0]} to {cell.span[1]}")
    if number.block.reading:
        notes.append(f"under the reading {number.block.reading}")
    unit = f"in {cell.unit}, as printed" if cell.unit != "1" else "a bare number"
    return content.ReportCell(
        printed=cell.printed,
        ours=_ours(number),
        verdict=cast(content.CellVerdict, number.outcome),
        source=f"{number.block.where} ({cell.path})",
        formula=number.formula,
        conversion=f"{unit}; by {number.block.compute}" if number.block.compute else unit,
        note="; ".join(notes),
        errata=number.errata,
        digits=number.digits,
        near=number.near,
    )


def _ours(number: ComparedNumber) -> str:
    """Ours with two digits more than printed; with an exponent beyond 1e9."""
    value = number.value
    if value is None:
        return ""
    if isinstance(value, ComparedExpression):
        return value.text
    if abs(value - round(value)) < 1e-9 and last_digit(number.cell.printed) == 1:
        return f"{round(value):d}"
    least = last_digit(number.cell.printed).scaleb(-2)
    if "e" in number.cell.printed or least < Decimal("1e-14") or abs(value) > 1e9:
        return f"{value:.6g}"
    shown = Decimal(value).quantize(least)
    return f"{abs(shown) if shown == 0 else shown:f}"


def _checks(reports: Sequence[CheckReport], failing: Collection[str]) -> tuple[content.Check, ...]:
    """The checks on a robot's models, reading by reading; under `failing` readings some are known to fail."""
    return tuple(
        content.Check(
            f"{v.name} ({r.reading})",
            f"{v.value:.3g} {v.unit}",
            f"{v.bound} {v.tolerance:.3g} {v.unit}",
            v.holds,
            "" if v.holds or r.reading not in failing else f"as expected of the reading {r.reading}: errata explain it",
            r.reading in failing,
        )
        for r in reports
        for v in r.verdicts
    )


def _audit(name: str, run: Run) -> tuple[content.Check, ...]:
    """The audit of a run: energy against work, with the stops that joints met; motion against torques."""
    audit, road = run.audit, run.audit["inverse_dynamics"]
    work = ", ".join(f"{channel} {value:.4g} J" for channel, value in audit["channels"].items())
    stops = stop_contacts(run, run.setup.plant.arm).sentence()
    note = "; ".join(text for text in (work, stops) if text)
    limit = f"at most {audit['tolerance']:.0e} J"
    energy = content.Check(name, f"{audit['residual']:.1e} J", limit, audit["residual"] <= audit["tolerance"], note)
    if road is None:
        return (energy,)
    value, allowed = f"{road['residual']:.1e} N m", f"at most {road['tolerance']:.1e} N m"
    words = inverse_dynamics_words(audit)
    return energy, content.Check(f"{name}, inverse dynamics", value, allowed, road["closed"], words)


def _files(place: Path) -> tuple[content.FileFact, ...]:
    paths = sorted(path for path in place.rglob("*") if path.is_file() and path.name not in (REPORT, "replay.html"))
    return tuple(
        content.FileFact(
            path.relative_to(place).as_posix(),
            path.stat().st_size,
            hashlib.sha256(path.read_bytes()).hexdigest(),
            _KINDS.get(path.suffix, ""),
        )
        for path in paths
    )
