"""The whole of a paper in a folder: its room's report, every number with its verdict, the errata with their proofs."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from lwr_dyn.errors import OptionError, UnknownNameError
from lwr_dyn.files import make_folder, write_folder
from lwr_dyn.reproduction.audit_sections import SPREAD, sections_of
from lwr_dyn.reproduction.compare import DIFFERS
from lwr_dyn.reproduction.ledger import ledger
from lwr_dyn.reproduction.outcome import Reproduction
from lwr_dyn.reproduction.pages import REPORT, page_of
from lwr_dyn.reproduction.report.page import write_report
from lwr_dyn.reproduction.rooms import PAPERS, room
from lwr_dyn.reproduction.summary import counts, counts_text, differing_text, entry_record
from lwr_dyn.reproduction.verdicts import compare_numbers
from lwr_dyn.tables import json_text

Progress = Callable[[str], None]
ALL = "all"
INCOMPLETE = "INCOMPLETE.txt"
"""Lies in a folder that an interrupt or an error left before it was whole."""
PROCESSES = 2
LONGEST_FIRST = ("wam7", "lwr4plus", "kr30ha", "lwr4")


def reproduce(
    paper: str,
    folder: str | Path,
    timing: str | None = None,
    fit: bool = False,
    with_spread: bool = False,
    progress: Progress = lambda _: None,
) -> Reproduction:
    """Recompute a paper, or all of them side by side, and write `folder` (with "all": a folder a paper inside it).

    Parameters
    ----------
    paper : str
        One of `rooms.PAPERS`, or "all".
    folder : path
        Made if missing.
    timing, fit
        Of the LWR 4+ paper alone, see `lwr4plus.report.reproduce`.
    with_spread : bool
        Also simulate the task under all readings (papers in `readings.SPREAD`), half a minute for the LWR 4+.
    say : callable
        Told what is being done.

    Raises
    ------
    UnknownNameError
        A paper that is not reproduced.
    OptionError
        A timing that does not exist; timing, fit or spread for another paper.
    FileAccessError
        The folder cannot be written.
    """
    if paper not in (*PAPERS, ALL):
        raise UnknownNameError("paper to reproduce", paper, (*PAPERS, ALL))
    if paper != "lwr4plus":
        for option, given in (("timing", timing), ("fit-arm-angle", fit or None)):
            if given is not None:
                raise OptionError(option, f"given for {paper}", "only for lwr4plus")
    if with_spread and paper not in (*SPREAD, ALL):
        raise OptionError("spread", f"given for {paper}", f"only for {', '.join(SPREAD)}, {ALL}")
    if paper == ALL:
        return _all(make_folder(folder), with_spread, progress)
    return _one(paper, folder, timing, fit, with_spread, progress)


def _all(place: Path, with_spread: bool, progress: Progress) -> Reproduction:
    """Each paper in a process of its own, two at a time."""
    with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
        begun = {paper: pool.submit(_quiet, paper, place / paper, with_spread) for paper in LONGEST_FIRST}
        done: dict[str, Reproduction] = {}
        for paper in LONGEST_FIRST:
            done[paper] = begun[paper].result()
            progress(paper)
    record = {paper: done[paper].record["counts"] for paper in PAPERS}
    holds = all(outcome.holds for outcome in done.values())
    write_folder(place, {"results.json": json_text({"papers": record, "holds": holds}) + "\n"})
    return Reproduction(holds, counts_text(record), {"papers": record, "holds": holds})


def _quiet(paper: str, folder: Path, with_spread: bool) -> Reproduction:
    """One paper in a process of its own; what is sent back is small."""
    found = _one(paper, folder, None, False, with_spread, lambda _: None)
    return Reproduction(found.holds, "", {"counts": found.record["counts"]})


def _one(
    paper: str, folder: str | Path, timing: str | None, fit: bool, with_spread: bool, progress: Progress
) -> Reproduction:
    place = Path(folder)  # made by the room, once it knows its options
    try:
        done = _written(paper, place, timing, fit, with_spread, progress)
    except BaseException:
        if place.is_dir():
            (place / INCOMPLETE).write_text("This folder was left before it was whole: run the command again.\n")
        raise
    (place / INCOMPLETE).unlink(missing_ok=True)
    return done


def _written(
    paper: str, place: Path, timing: str | None, fit: bool, with_spread: bool, progress: Progress
) -> Reproduction:
    found = _report(paper, place, timing, fit, progress)
    progress("verdicts and proofs")
    here = room(paper)
    judgement, entries = compare_numbers(paper, slow=True, known=found.known), ledger(here)
    progress("readings")
    parts, read = sections_of(here, with_spread)
    summary = counts(judgement, entries)
    explained = not judgement.counts()[DIFFERS] and not judgement.counts(True)[DIFFERS]
    holds = found.holds and explained and all(entry.holds for entry in entries)
    record: dict[str, Any] = {
        "paper": paper, "counts": summary, "numbers": [j.to_json() for j in judgement.data],
        "errata": [entry_record(entry) for entry in entries], **found.record, **read, "holds": holds,
    }  # fmt: skip
    text = "\n\n".join(x for x in (counts_text({paper: summary}), differing_text(judgement), found.text) if x)
    write_folder(place, {"results.json": json_text(record) + "\n"})
    shown = replace(found.shown, sections=(*found.shown.sections, *parts))
    done = Reproduction(holds, text, record, found.known, shown)
    progress("report page")
    write_report(place / REPORT, page_of(here, done, judgement, entries, place))
    return done


def _report(paper: str, place: Path, timing: str | None, fit: bool, progress: Progress) -> Reproduction:
    """What the paper's room makes of it."""
    if paper == "lwr4plus":
        from lwr_dyn.reproduction.lwr4plus import study as lwr4plus

        return lwr4plus.reproduce(place, timing or lwr4plus.DEFAULT_TIMING, fit, progress)
    if paper == "lwr4":
        from lwr_dyn.reproduction.lwr4 import study as lwr4

        return lwr4.reproduce(place)
    if paper == "wam7":
        from lwr_dyn.reproduction.wam7 import study as wam7

        return wam7.reproduce(place, progress)
    from lwr_dyn.reproduction.kr30ha import study as kr30ha

    return kr30ha.reproduce(place, progress)
