"""`lwr-dyn sweep`: a study carried out, its cost stated ahead; killed at any point, the same command goes on."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import click

from lwr_dyn.cli.options import print_json
from lwr_dyn.foundation.progress import CLEAR, progress
from lwr_dyn.studies.sweep.read_study import read_study
from lwr_dyn.studies.sweep.report_page import FinishedSweep, finish
from lwr_dyn.studies.sweep.running.cost import SweepCost, duration
from lwr_dyn.studies.sweep.running.sweep import SweepOutcome, sweep
from lwr_dyn.studies.sweep.running.sweep_folder import SweepResults
from lwr_dyn.studies.sweep.summary_text import summary_record, summary_text
from lwr_dyn.studies.sweep.sweep_study import SweepStudy


@click.command("sweep")
@click.argument("study", metavar="STUDY.toml")
@click.option("--out", required=True, metavar="DIR", help="Folder of the results: made, or of this sweep and gone on.")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="A Dask scheduler, tcp://HOST:PORT; threads here if not given. Files that the study names must lie under the "
    "same path on every worker.",
)
@click.option(
    "--threads", type=int, metavar="N", help="Threads, and processes for controllers in Python; all if not given."
)
@click.option("--runs", type=int, metavar="N", help="Runs of each controller, in place of the study's.")
@click.option("--no-report", is_flag=True, help="Only the files of results: no figures, no page, no worst runs.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def command(
    study: str,
    out: str,
    scheduler: str | None,
    threads: int | None,
    runs: int | None,
    no_report: bool,
    as_json: bool,
) -> None:
    """Carry out a study: many closed loops, each with its own parameters, by kernels, in files of results.

    Stopped or killed at any point, the same command goes on; chunks of runs that are there are not made again. Exit
    code 1: some chunks failed, the rest is there.
    """
    read = read_study(study)
    if runs is not None:
        read = replace(read, runs=runs)

    def state(cost: SweepCost) -> None:
        if sys.stderr.isatty():
            click.echo(CLEAR, nl=False, err=True)
        click.echo(cost.table().text(), err=as_json)

    with progress("sweeping") as report:
        done = sweep(read, out, scheduler=scheduler, threads=threads, report=report, state=state)
        report("the report")
        finished = None if no_report else finish(read, SweepResults.load(out))
    if as_json:
        print_json(_record(read, done, finished))
    else:
        click.echo("\n".join(_lines(done, finished)))
    sys.exit(0 if done.is_complete else 1)


def _lines(done: SweepOutcome, finished: FinishedSweep | None) -> list[str]:
    """What became of the sweep."""
    made, kept, failed = (sum(x) for x in (done.made.values(), done.kept.values(), map(len, done.failures.values())))
    there = f", {kept} were there" if kept else ""
    lines = [f"made {made} chunks in {duration(done.seconds)}{there}: {done.folder}"]
    if not made + failed:
        lines = [f"all {kept} chunks were there: {done.folder}"]
    for text, each in done.failures.items():
        lines += [f"FAILED: {text}, chunk {number}, {why}" for number, why in sorted(each.items())]
    if failed:
        lines.append(f"{failed} chunk{'s' if failed > 1 else ''} failed; the same command tries again")
    if finished is not None:
        lines += ["", summary_text(finished.summary), "", f"wrote {finished.page}"]
        lines += [f"wrote {path}" for path in finished.worst]
    return lines


def _record(study: SweepStudy, done: SweepOutcome, finished: FinishedSweep | None) -> dict[str, Any]:
    """The result as JSON values."""
    controllers = [
        {
            "controller": text, "made": done.made[text], "kept": done.kept[text],
            "failures": [{"chunk": k, "why": why} for k, why in sorted(done.failures[text].items())],
        }
        for text in study.controllers
    ]  # fmt: skip
    return {
        "study": study.name, "folder": str(done.folder), "runs": study.count, "complete": done.is_complete,
        "seconds": done.seconds, "cost": done.cost.record(), "controllers": controllers,
        "report": None if finished is None else str(finished.page),
        "worst": [] if finished is None else [str(path) for path in finished.worst],
        "summary": None if finished is None else summary_record(finished.summary),
    }  # fmt: skip
