"""A paper reproduced in a folder: its study, every number with its verdict, the errata with their proofs, the page.

What audits show about a paper's tables, as sections of its page: lint, conventions, sensitivity to the reading.
"""

import re
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any, TypedDict

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper, open_readings, published, readings
from lwr_dyn.arms.urdf.model_files import model_files, model_stem
from lwr_dyn.checks.arm.run_checks import CheckReport, check_arm
from lwr_dyn.checks.conventions.evidence import packaged_evidence
from lwr_dyn.checks.conventions.printed_table import printed_table
from lwr_dyn.checks.conventions.ranking import rank_readings
from lwr_dyn.checks.conventions.ranking_text import ranking_text
from lwr_dyn.checks.datasheet.datasheet import zero_readings, zero_text
from lwr_dyn.checks.sensitivity.analysis import error_table, errors_text, gains_table, notes, sensitivity, survival
from lwr_dyn.checks.sensitivity.study_tasks import printed_task
from lwr_dyn.checks.tables.rules import lint, sheet_of_file, sheets_of_robot
from lwr_dyn.checks.tables.sheet import SheetRecord
from lwr_dyn.foundation.document import Document, Fact, Note, Part, Section
from lwr_dyn.foundation.files import ends_in, make_folder, write_folder
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.reproduction.basis import with_bases
from lwr_dyn.reproduction.case import LedgerRecord, ledger
from lwr_dyn.reproduction.compare import NumberRecord, compare_numbers
from lwr_dyn.reproduction.own_paper import own_study
from lwr_dyn.reproduction.paper_page import (
    REPORT,
    count_table,
    counts,
    difference_table,
    number_table,
    paper_page,
    summary_text,
)
from lwr_dyn.reproduction.paper_study import PaperStudy, Progress, Reproduction, paper_study
from lwr_dyn.reproduction.papers import ALL, OWN, SENSITIVITY, check_options, studies, takers
from lwr_dyn.reproduction.published_sets import reproduced_sets
from lwr_dyn.reproduction.report.content import ReportSection
from lwr_dyn.reproduction.report.page import write_report

Audit = tuple[ReportSection, Any]
"""A section of the page, and the same as JSON values."""


def lint_section(paper: str) -> Audit:
    """Faults that show without a model, in the data file and in the printed results."""
    sheets = (sheet_of_file(paper),) if ends_in(paper, OWN) else sheets_of_robot(paper)
    findings = [finding for sheet in sheets for finding in lint(sheet)]
    text = "\n".join(finding.line() for finding in findings) or "nothing found"
    return ReportSection("lint", "Lint", text), [finding.record() for finding in findings]


def convention_section(paper: str, of_tensors: bool) -> Audit:
    """How tables of inertia, or else zero and signs of the joints, may be read where no convention is stated.

    The file's own errata are not used for the tables of inertia.
    """
    own = open_paper(paper)
    if of_tensors:
        table = printed_table(own)
        lines = ranking_text(rank_readings(table, packaged_evidence(paper, table)))
    else:
        lines = zero_text(zero_readings(own))
    return ReportSection("resolver", "Conventions", "\n".join(lines)), lines


def sensitivity_section(paper: str, own: str) -> Audit:
    """The paper's task under all readings, `own` first: the controller's model is one of them, the plant another."""
    task = printed_task(paper)
    names = dict.fromkeys((own, *readings(paper)))
    result = sensitivity({name: arm_from_paper(open_paper(paper, name)) for name in names}, task)
    labels = list(result.study.labels.values())
    tables = (*(error_table(result, name) for name in labels), gains_table(result), survival(result))
    text = "\n".join([f"{result.study.task.about}; {errors_text(result)}", *notes(result)])
    record = {
        "rms_mm": {name: result.tip_rms_mm(name) for name in labels},
        "conclusions": {c.text: c.verdict() for c in result.conclusions},
    }
    return ReportSection("spread", "Readings", text, tables), record


def audit_sections(study: PaperStudy, with_sensitivity: bool) -> tuple[list[ReportSection], dict[str, Any]]:
    """All of these sections that the paper has, and their record."""
    paper = study.robot
    audits = {"lint": lint_section(paper)}
    if study.study.conventions:
        audits["resolver"] = convention_section(paper, study.study.conventions == "tensors")
    if with_sensitivity:
        audits["spread"] = sensitivity_section(paper, study.data.paper.reading.name)
    return [section for section, _ in audits.values()], {name: record for name, (_, record) in audits.items()}


INCOMPLETE = "INCOMPLETE.txt"
"""A note in a folder that an interrupt or an error left incomplete."""

PROCESSES = 2

RESULTS = "results.json"


class CheckRecord(TypedDict):
    """A verdict on a model."""

    value: float
    holds: bool


class ReadingsRecord(TypedDict):
    """The task of a paper under all its readings."""

    rms_mm: Annotated[dict[str, list[list[float]]], "Controller -> errors of the tip, a row a model, a column a plant."]
    conclusions: Annotated[dict[str, str], "What the paper concludes -> whether that survives."]


AUDITS = (
    Fact("lint", None, "Faults of tables that show without a model.", kind=list[SheetRecord]),
    Fact("resolver", None, "How the tables may be read, where no convention is stated, in lines.", kind=list[str]),
    Fact("spread", None, "The paper's task under all readings, where that was asked for.", kind=ReadingsRecord),
)
"""What audits record, where the paper has them."""


def reproduce(paper: str, folder: str | Path, progress: Progress = lambda _: None, **options: Any) -> Reproduction:
    """Recompute a paper, or all of them side by side, and write `folder` (with "all": a folder a paper inside it).

    Parameters
    ----------
    paper : str
        One of `studies()`, "all", the path of a user's own `.toml` with printed results (`own_paper`), or a robot of
        published sets, whose errata are shown with their proofs (`published_sets`).
    folder : path
        Made if missing.
    progress : callable
        Called with the name of each step as it begins.
    options
        Those of the paper's study, by keyword; None and False count as not given.

    Raises
    ------
    UnknownNameError
        A paper that is not reproduced.
    PaperError
        A user's own file breaks its schema, or gives a result that cannot be computed.
    OptionError
        An option that the paper does not take, or a value that is not allowed.
    FileAccessError
        A user's own file cannot be read, or the folder cannot be written.
    """
    given = {keyword: value for keyword, value in options.items() if value not in (None, False)}
    check_options(paper, given)
    if paper == ALL:
        return _all(make_folder(folder), given, progress)
    if paper in published():
        return reproduced_sets(paper, Path(folder))
    study = own_study(paper) if ends_in(paper, OWN) else paper_study(paper)
    return _one(study, Path(folder), given, progress)


def _all(place: Path, options: Mapping[str, Any], progress: Progress) -> Reproduction:
    """Each paper in a process of its own, two at a time."""
    with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
        running = {}
        for paper in studies():
            own = {keyword: value for keyword, value in options.items() if paper in takers(keyword)}
            running[paper] = pool.submit(_holds_and_counts, paper, place / paper, own)
        done = {}
        for paper, future in running.items():
            done[paper] = future.result()
            progress(paper)
    counted = {paper: one for paper, (_, one) in done.items()}
    holds = all(paper_holds for paper_holds, _ in done.values())
    sections = [_papers(counted), Section("", [count_table(counted), _held(holds)])]
    document = Document("", "", sections, "lwr-dyn reproduce")
    write_folder(place, {RESULTS: json_text(document.record()) + "\n"})
    return Reproduction(holds, document)


def _papers(counted: Mapping[str, Any] | None = None) -> Section:
    about = "With all: the counts of each paper."
    return Section("", [Fact("papers", counted, about, kind=dict[str, dict[str, Any]])], there=counted is not None)


def _held(holds: bool) -> Fact:
    return Fact("holds", holds, "Whether it holds; the exit code is 0 then.")


def _holds_and_counts(paper: str, folder: Path, options: Mapping[str, Any]) -> tuple[bool, dict[str, Any]]:
    """One paper in a process of its own; what is sent back is small."""
    reproduction = _one(paper_study(paper), folder, options, lambda _: None)
    return reproduction.holds, reproduction.document.record()["counts"]


def _one(study: PaperStudy, place: Path, options: Mapping[str, Any], progress: Progress) -> Reproduction:
    """One paper; an error or an interrupt leaves a note in its folder."""
    try:
        reproduction = _written(study, place, options, progress)
    except BaseException:
        if place.is_dir():
            (place / INCOMPLETE).write_text("This folder was left incomplete: run the command again.\n")
        raise
    (place / INCOMPLETE).unlink(missing_ok=True)
    return reproduction


def _written(study: PaperStudy, place: Path, options: Mapping[str, Any], progress: Progress) -> Reproduction:
    own = {keyword: value for keyword, value in options.items() if keyword != SENSITIVITY.keyword}
    progress("models and checks")
    reports = models_and_checks(make_folder(place), study.robot)
    result = study.run(place, arm_from_paper(study.data.paper), progress, **own)
    pictures = result.pictures.write(place)
    progress("verdicts and proofs")
    verdicts = with_bases(study, compare_numbers(study, slow=True, known=result.known))
    entries = ledger(study.data, study.proofs)
    progress("lint and readings")
    sections, audits = audit_sections(study, SENSITIVITY.keyword in options)
    differing = difference_table(verdicts)
    holds = (
        result.holds
        and all(report.holds for report in reports if report.reading not in study.study.failing_readings)
        and not differing.rows
        and all(entry.holds for entry in entries)
    )
    summary, words = counts(verdicts, entries), summary_text(verdicts, entries, holds)
    checked = [Section("", [Note(list(map(check_line, reports)))]), *result.document.sections]
    head: list[Part] = [
        Fact("paper", study.name, "Its name."),
        Fact("summary", words, "The outcome in words."),
        Fact("counts", summary, "How many numbers got which verdict on what basis, and how many errata are proven."),
        Fact("numbers", [number.to_json() for number in verdicts.numbers], "Each printed number with its verdict.",
             kind=list[NumberRecord]),
        Fact("errata", [entry.record() for entry in entries],
             "Slips of the print that are proven or read otherwise.", kind=list[LedgerRecord]),
        Fact("checks", {r.reading: {v.name: {"value": v.value, "holds": v.holds} for v in r.verdicts} for r in reports},
             "Of the models: reading -> check -> its value.", kind=dict[str, dict[str, CheckRecord]]),
        Note(words),
    ]  # fmt: skip
    document = Document("", "", [
        _papers(), Section("", head, there=True), Section("", [count_table({study.name: summary})]),
        Section("", [number_table(verdicts, entries) if study.own else differing]), *checked,
        *(Section("", [replace(one, value=audits.get(str(one.key)))], there=one.key in audits) for one in AUDITS),
        Section("", [_held(holds)]),
    ], "lwr-dyn reproduce")  # fmt: skip
    tables = replace(document, sections=checked).text()
    write_folder(place, {"tables.txt": tables + "\n", RESULTS: json_text(document.record()) + "\n"})
    pictures = replace(pictures, sections=(*pictures.sections, *sections))
    done = Reproduction(holds, document, pictures=pictures)
    progress("report page")
    write_report(place / REPORT, paper_page(study, done, verdicts, entries, reports, place))
    return done


def models_and_checks(place: Path, robot: str) -> list[CheckReport]:
    """Write the models of a robot under each of its readings, and all checks on them; raises `FileAccessError`."""
    reports = []
    for paper in open_readings(robot):
        arm = arm_from_paper(paper)
        stem = re.sub(r"[^\w.-]", "_", model_stem(arm))[:100]  # names in a user's file name no other folder
        write_folder(place / "models", model_files(arm, stem))
        reports.append(check_arm(arm, paper))
    write_folder(place, {"checks.txt": "\n\n".join(report.table().text() for report in reports) + "\n"})
    return reports


def check_line(report: CheckReport) -> str:
    """A report in one line."""
    failed = [v.name for v in report.verdicts if not v.holds]
    faults = f", FAIL: {', '.join(failed)}" if failed else ""
    good = len(report.verdicts) - len(failed)
    return f"check {report.robot}, reading {report.reading}: {good} hold{'s' * (good == 1)}{faults}"
