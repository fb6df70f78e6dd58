"""The report page of a paper: printed numbers beside ours, errata with proofs, checks, audits, files."""

import hashlib
import platform
from collections import Counter
from collections.abc import Collection, Sequence
from decimal import Decimal
from pathlib import Path
from typing import cast

from lwr_dyn.checks.arm.verdict import CheckReport
from lwr_dyn.model.printed_number import last_digit
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.case import REPEATED, STRUCTURAL, ComparedExpression
from lwr_dyn.reproduction.compare import ASSUMED, DIFFERS, ComparedNumber
from lwr_dyn.reproduction.ledger import LedgerEntry
from lwr_dyn.reproduction.paper_study import PaperStudy, Reproduction
from lwr_dyn.reproduction.report.content import (
    CellVerdict,
    Check,
    FileFact,
    Page,
    Replay,
    ReportCell,
    ReportRow,
    ReportTable,
    Section,
)
from lwr_dyn.reproduction.summary import NEARNESS, verdict_sentence
from lwr_dyn.reproduction.verdicts import Verdicts
from lwr_dyn.simulation.audit import inverse_dynamics_words
from lwr_dyn.simulation.setup import versions
from lwr_dyn.simulation.stop_contacts import stop_contacts

MORE = 2
"""Digits of ours beyond the last printed one."""
LARGEST_WRITTEN = 1e9
"""Larger numbers are written with an exponent."""
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
) -> Page:
    """The whole page of a paper, with the files that lie in its folder by then."""
    paper, pictures = study.data.paper, result.pictures
    printed, derived = (tuple(x for x in verdicts.numbers if x.block.derived == d) for d in (False, True))
    counted = Counter(number.outcome for number in printed)
    title, _, about = paper.title.partition(" (")
    makers = [about.rstrip(")"), *(paper.document.get(key, "") for key in ("authors", "origin"))]
    return Page(
        title=title,
        subtitle=paper.document.get("title", ""),
        byline=" \u00b7 ".join([*(text for text in makers if text), f"reading {paper.default_reading}"]),
        verdict=verdict_sentence(verdicts, entries, result.holds),
        words=result.record["summary"],
        document=tuple(paper.document.items()),
        counts={cast(CellVerdict, verdict): count for verdict, count in counted.items()},
        tables=tuple(_tables(printed)),
        derived=tuple(_tables(derived)),
        errata=tuple(entries),
        figures=tuple(figure for figures in pictures.figures.values() for figure in figures if figure.id),
        replay=Replay(pictures.shown, pictures.stills) if pictures.shown or pictures.stills else None,
        checks=_checks(reports, study.study.failing_readings),
        audit=tuple(check for name, _, run in pictures.simulated for check in _audit(name, run)),
        sections=(Section("text", "As text", result.text), *pictures.sections),
        files=_files(place),
        versions=(("Python", platform.python_version()), *versions().items()),
    )


def _tables(numbers: Sequence[ComparedNumber]) -> list[ReportTable]:
    """A table for each block, in the order of the paper."""
    blocks: dict[str, list[ComparedNumber]] = {}
    for number in numbers:
        blocks.setdefault(number.block.name, []).append(number)
    return list(map(_table, blocks.values()))


def _table(numbers: Sequence[ComparedNumber]) -> ReportTable:
    block = numbers[0].block
    cells = {_place(number): _cell(number) for number in numbers}
    rows, columns = (dict.fromkeys(place[k] for place in cells) for k in (0, 1))
    units = list(dict.fromkeys(number.cell.unit for number in numbers))
    title = block.where.split(",")[0].split(":")[0].split(";")[0].strip("'")
    heading = f"derived: {title}" if block.derived else title
    return ReportTable(
        id=block.name,
        title=heading,
        where=block.where.strip("'").removeprefix(title).lstrip("',:; "),
        columns=tuple(columns),
        rows=tuple(ReportRow(row, tuple(cells.get((row, name), ReportCell("")) for name in columns)) for row in rows),
        unit="" if units == ["1"] else ", ".join(units),
        note=block.note,
    )


def _place(number: ComparedNumber) -> tuple[str, str]:
    """Row and column of a number; of a matrix among several the row has its name."""
    cell = number.cell
    if "][" not in cell.path:
        return cell.row, cell.column
    row, column = cell.row.rsplit(",", 1)
    return f"{cell.column}: {row}", column


def _cell(number: ComparedNumber) -> ReportCell:
    cell, verdict = number.cell, number.verdict
    notes, word = [], {None: "", True: "assumed, near", False: "assumed, not near"}[number.near]
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
    return ReportCell(
        printed=cell.printed,
        ours=_ours(number),
        verdict=cast(CellVerdict, number.outcome),
        source=f"{number.block.where} ({cell.path})",
        formula=number.formula,
        conversion=f"{unit}; by {number.block.compute}" if number.block.compute else unit,
        note="; ".join(notes),
        errata=number.errata,
        word=word,
        digits=number.digits,
        near=number.near,
    )


def _ours(number: ComparedNumber) -> str:
    """Ours with a few digits more than printed."""
    value = number.value
    if value is None:
        return ""
    if isinstance(value, ComparedExpression):
        return value.text
    if abs(value - round(value)) < 1e-9 and last_digit(number.cell.printed) == 1:
        return f"{round(value):d}"
    least = last_digit(number.cell.printed).scaleb(-MORE)
    if "e" in number.cell.printed or least < Decimal("1e-14") or abs(value) > LARGEST_WRITTEN:
        return f"{value:.6g}"
    shown = Decimal(value).quantize(least)
    return f"{abs(shown) if shown == 0 else shown:f}"


def _checks(reports: Sequence[CheckReport], failing: Collection[str]) -> tuple[Check, ...]:
    """The checks on a robot's models, reading by reading; under `failing` readings some are known to fail."""
    return tuple(
        Check(
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


def _audit(name: str, run: Run) -> tuple[Check, ...]:
    """The audit of a run: energy against work, with the stops that joints met; motion against torques."""
    audit, road = run.audit, run.audit["inverse_dynamics"]
    work = ", ".join(f"{channel} {value:.4g} J" for channel, value in audit["channels"].items())
    stops = stop_contacts(run, run.setup.plant.arm).sentence()
    note = "; ".join(text for text in (work, stops) if text)
    limit = f"at most {audit['tolerance']:.0e} J"
    energy = Check(name, f"{audit['residual']:.1e} J", limit, audit["residual"] <= audit["tolerance"], note)
    if road is None:
        return (energy,)
    value, allowed = f"{road['residual']:.1e} N m", f"at most {road['tolerance']:.1e} N m"
    return energy, Check(f"{name}, inverse dynamics", value, allowed, road["closed"], inverse_dynamics_words(audit))


def _files(place: Path) -> tuple[FileFact, ...]:
    paths = sorted(path for path in place.rglob("*") if path.is_file() and path.name not in (REPORT, "replay.html"))
    return tuple(
        FileFact(
            path.relative_to(place).as_posix(),
            path.stat().st_size,
            hashlib.sha256(path.read_bytes()).hexdigest(),
            _KINDS.get(path.suffix, ""),
        )
        for path in paths
    )
