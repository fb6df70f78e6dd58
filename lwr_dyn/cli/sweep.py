"""`lwr-dyn sweep`: a study carried out, its cost stated ahead; killed at any point, the same command goes on."""

import sys
from dataclasses import replace
from typing import Annotated, TypedDict

import click

from lwr_dyn.cli.options import NO_CODE, check_code, show
from lwr_dyn.cli.vocabulary import FOLDER, with_shared
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.progress import CLEAR, progress
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.studies.sweep.read_study import read_study
from lwr_dyn.studies.sweep.report_page import FinishedSweep, finish
from lwr_dyn.studies.sweep.running.cost import SweepCost, duration
from lwr_dyn.studies.sweep.running.sweep import SweepOutcome, sweep
from lwr_dyn.studies.sweep.running.sweep_folder import SweepResults
from lwr_dyn.studies.sweep.summary_document import summary_sections
from lwr_dyn.studies.sweep.sweep_study import SweepStudy, study_caveats


@click.command("sweep")
@click.argument("study", metavar="STUDY.toml")
@with_shared(
    "--out", " the results there, in a new folder or in that of this sweep, which goes on", form=FOLDER, required=True
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="A Dask scheduler, tcp://HOST:PORT; threads here if not given. Files that the study names must lie under the "
    "same path on every worker.",
)
@with_shared("--jobs", "; all processors if not given")
@with_shared("--runs", ", in place of the study's; more than its folder holds are added", form="N")
@click.option("--no-report", is_flag=True, help="Only the files of results: no figures, no page, no worst runs.")
@click.option("--no-code", is_flag=True, help=NO_CODE.help)
@with_shared("--json as_json")
def command(
    study: str,
    out: str,
    scheduler: str | None,
    jobs: int | None,
    runs: int | None,
    no_report: bool,
    no_code: bool,
    as_json: bool,
) -> None:
    """Carry out a study: many closed loops, each with its own parameters, by kernels, in files of results.

    Stopped or killed at any point, the same command goes on; chunks of runs that are there are not made again. Exit
    code 1: some chunks failed, the rest is there.
    """
    read = read_study(study, lambda path: check_code([path], no_code, typed=False))
    if runs is not None:
        read = replace(read, runs=runs)
    said = study_caveats(read)
    click.echo("".join(f"{line}\n" for line in said if not as_json), nl=False)

    def state(cost: SweepCost) -> None:
        if sys.stderr.isatty():
            click.echo(CLEAR, nl=False, err=True)
        click.echo(cost.table().text(), err=as_json)
        for one in cost.controllers:
            if one.step_words:
                click.echo(one.step_words, err=as_json)

    with progress("sweeping") as report:
        done = sweep(read, out, scheduler=scheduler, threads=jobs, report=report, state=state)
        report("the report")
        finished = None if no_report else finish(read, SweepResults.load(out))
    show(replace(sweep_document(read, done, finished), caveats=said if as_json else ()), as_json)
    sys.exit(0 if done.is_complete else 1)


class ChunkFailure(TypedDict):
    """A chunk that is missing."""

    chunk: Annotated[int, "Its number."]
    why: Annotated[str, "In a line."]


def sweep_document(study: SweepStudy, done: SweepOutcome, finished: FinishedSweep | None) -> Document:
    """What became of a sweep, and what its runs say."""
    made, kept, failed = (sum(x) for x in (done.made.values(), done.kept.values(), map(len, done.failures.values())))
    there = f", {kept} were there" if kept else ""
    became = f"made {made} chunk{'s' if made != 1 else ''} in {duration(done.seconds)}{there}: {done.folder}"
    failures = {text: sorted(each.items()) for text, each in done.failures.items()}
    columns = (
        Heading(key="controller", says="As the study has it."), Heading(key="made", says="Chunks that were made now."),
        Heading(key="kept", says="Chunks that were there."),
        Heading(key="failures", says="Chunks that are missing.", kind=list[ChunkFailure]),
    )  # fmt: skip
    rows = [
        (text, done.made[text], done.kept[text], [{"chunk": k, "why": why} for k, why in failures[text]])
        for text in study.controllers
    ]
    files = [] if finished is None else [str(path) for path in (finished.page, *finished.worst)]
    outcome = Section("", [
        Fact("study", study.name, "Name of the study."), Fact("folder", str(done.folder), "Of the results."),
        Fact("runs", study.runs, "Of each controller."),
        Fact("complete", done.is_complete, "Whether all chunks are there; if not, the exit code is 1."),
        Fact("seconds", done.seconds, "That this sweep took, s."),
        Table("", columns, rows, key="controllers", says="One record a controller."),
        Note(became if made + failed else f"all {kept} chunks were there: {done.folder}"),
        Note(list(done.refused)),
        Note([f"FAILED: {text}, chunk {k}, {why}" for text, each in failures.items() for k, why in each]),
        Note(f"{failed} chunk{'s' if failed > 1 else ''} failed; the same command tries again", failed > 0),
        Fact("report", files[0] if files else None, "The page; null without a run and with --no-report.",
             kind=str | None),
        Fact("worst", files[1:], "Files of the worst runs.", kind=list[str]),
    ])  # fmt: skip
    summary = summary_sections(None if finished is None else finished.summary)
    written = Section("", [Note([f"wrote {path}" for path in files])])
    return Document("", "", [outcome, done.cost.section(), *summary, written], "lwr-dyn sweep", "sweep")
