"""What comes of a sweep once its runs are there: its figures, the worst runs again and whole, and the page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from lwr_dyn.foundation.errors import DivergenceError
from lwr_dyn.foundation.files import make_folder
from lwr_dyn.studies.sweep.report.report_page import write_report
from lwr_dyn.studies.sweep.report.worst_runs import WorstRun
from lwr_dyn.studies.sweep.running.manifest import folder_names
from lwr_dyn.studies.sweep.running.results import SweepResults
from lwr_dyn.studies.sweep.running.workshop import SweepWorkshop
from lwr_dyn.studies.sweep.statistics.summary import SweepSummary, summarise
from lwr_dyn.studies.sweep.study.study_file import SweepStudy

PAGE, WORST = "report.html", "worst"
NO_KERNEL = "it has no kernel form"
"""Why a controller's parameters are not moved alone."""


@dataclass(frozen=True, slots=True, eq=False)
class FinishedSweep:
    """Figures, the page, and the files of the worst runs, which `lwr-dyn replay` shows; None without any run."""

    summary: SweepSummary
    page: Path
    worst: tuple[Path, ...]


def finish(study: SweepStudy, results: SweepResults) -> FinishedSweep | None:
    """Write the page and the worst runs into the folder of a sweep; None where it has no run.

    Which parameter breaks a limit first takes some hundred runs more of each controller; it is left out, and said, for
    one without a kernel. A worst run that diverges when it is made again is left out of the page.

    Raises `FileAccessError` for a folder that cannot be written.
    """
    if not results.controllers:
        return None
    workshop = SweepWorkshop(study)
    slow = {text: NO_KERNEL for text in results.controllers if workshop.is_slow(text)}
    evaluate = partial(workshop.evaluate, hand_over=True)
    summary = summarise(study, results.controllers, evaluate, workshop.arm, slow, results.failures)
    worst = list(_again(workshop, summary))
    place, names = results.folder / WORST, dict(zip(study.controllers, folder_names(study.controllers), strict=True))
    files = []
    for one in worst:
        files.append(make_folder(place) / f"{names[one.controller]}-run-{one.number}.npz")
        one.run.save(files[-1])
    return FinishedSweep(summary, write_report(results.folder / PAGE, summary, worst), tuple(files))


def _again(workshop: SweepWorkshop, summary: SweepSummary) -> Iterator[WorstRun]:
    for text, number in summary.worst():
        try:
            run = workshop.run(text, number)
        except DivergenceError:
            continue
        yield WorstRun(text, number, run, workshop.arm if run.setup is None else run.setup.plant.arm)
