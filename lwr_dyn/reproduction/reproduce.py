"""A paper reproduced in a folder: its study, every number with its verdict, the errata with their proofs, the page."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from lwr_dyn.files import make_folder, write_folder
from lwr_dyn.papers.assembly import arm_from_paper
from lwr_dyn.papers.catalog import open_paper
from lwr_dyn.reproduction.audit_sections import audit_sections
from lwr_dyn.reproduction.checked_models import check_line, check_record, models_and_checks
from lwr_dyn.reproduction.compare import DIFFERS
from lwr_dyn.reproduction.ledger import ledger
from lwr_dyn.reproduction.paper_page import REPORT, checks_of, paper_page
from lwr_dyn.reproduction.paper_study import PaperStudy, Progress, Reproduction, paper_study
from lwr_dyn.reproduction.report.page import write_report
from lwr_dyn.reproduction.study import ALL, SENSITIVITY, check_options, studies, study_of, takers
from lwr_dyn.reproduction.summary import counts, counts_text, differing_text
from lwr_dyn.reproduction.verdicts import compare_numbers
from lwr_dyn.tables import json_text

INCOMPLETE = "INCOMPLETE.txt"
"""Lies in a folder that an interrupt or an error left incomplete."""
PROCESSES = 2


def reproduce(paper: str, folder: str | Path, progress: Progress = lambda _: None, **options: Any) -> Reproduction:
    """Recompute a paper, or all of them side by side, and write `folder` (with "all": a folder a paper inside it).

    Parameters
    ----------
    paper : str
        One of `studies()`, or "all".
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
    OptionError
        An option that the paper does not take, or a value that is not allowed.
    FileAccessError
        The folder cannot be written.
    """
    given = {keyword: value for keyword, value in options.items() if value not in (None, False)}
    if paper != ALL:
        study_of(paper)
    check_options(paper, given)
    return _all(make_folder(folder), given, progress) if paper == ALL else _one(paper, Path(folder), given, progress)


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
    record = {paper: counted for paper, (_, counted) in done.items()}
    holds = all(paper_holds for paper_holds, _ in done.values())
    write_folder(place, {"results.json": json_text({"papers": record, "holds": holds}) + "\n"})
    return Reproduction(holds, counts_text(record), {"papers": record, "holds": holds})


def _holds_and_counts(paper: str, folder: Path, options: Mapping[str, Any]) -> tuple[bool, dict[str, Any]]:
    """One paper in a process of its own; what is sent back is small."""
    reproduction = _one(paper, folder, options, lambda _: None)
    return reproduction.holds, reproduction.record["counts"]


def _one(paper: str, place: Path, options: Mapping[str, Any], progress: Progress) -> Reproduction:
    """One paper; an error or an interrupt leaves a note in its folder."""
    try:
        reproduction = _written(paper_study(paper), place, options, progress)
    except BaseException:
        if place.is_dir():
            (place / INCOMPLETE).write_text("This folder was left incomplete: run the command again.\n")
        raise
    (place / INCOMPLETE).unlink(missing_ok=True)
    return reproduction


def _written(study: PaperStudy, place: Path, options: Mapping[str, Any], progress: Progress) -> Reproduction:
    own = {keyword: value for keyword, value in options.items() if keyword != SENSITIVITY.keyword}
    progress("models and checks")
    reports = models_and_checks(make_folder(place), study.name)
    result = study.study.load("run")(place, arm_from_paper(open_paper(study.name)), progress, **own)
    progress("verdicts and proofs")
    verdicts = compare_numbers(study, slow=True, known=result.known)
    entries = ledger(study.data, study.proofs)
    progress("lint and readings")
    sections, audits = audit_sections(study, SENSITIVITY.keyword in options)
    holds = (
        result.holds
        and all(report.holds for report in reports if report.reading not in study.study.failing_readings)
        and not verdicts.counts()[DIFFERS]
        and not verdicts.counts(derived=True)[DIFFERS]
        and all(entry.holds for entry in entries)
    )
    summary = counts(verdicts, entries)
    record = {
        "paper": study.name, "counts": summary, "numbers": [number.to_json() for number in verdicts.numbers],
        "errata": [entry.record() for entry in entries], "checks": check_record(reports),
        **result.record, **audits, "holds": holds,
    }  # fmt: skip
    tables = "\n".join(map(check_line, reports)) + "\n\n" + result.text
    write_folder(place, {"tables.txt": tables + "\n", "results.json": json_text(record) + "\n"})
    text = "\n\n".join(x for x in (counts_text({study.name: summary}), differing_text(verdicts), tables) if x)
    extras = replace(result.extras, checks=checks_of(reports), sections=(*result.extras.sections, *sections))
    done = Reproduction(holds, text, record, extras=extras)
    progress("report page")
    write_report(place / REPORT, paper_page(study, done, verdicts, entries, place))
    return done
