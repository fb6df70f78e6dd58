"""`lwr-dyn conventions`: the possible conventions of a table that states none, ranked, with the reasons."""

from collections.abc import Iterator
from typing import Annotated, TypedDict

import click

from lwr_dyn.arms.loading import ONE_READING
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.checks.conventions.candidates import ReadingRecord
from lwr_dyn.checks.conventions.evidence import packaged_evidence, read_evidence
from lwr_dyn.checks.conventions.printed_table import printed_table
from lwr_dyn.checks.conventions.ranking import DecisionRecord, RankedReadings, rank_readings
from lwr_dyn.checks.conventions.ranking_text import judged_rankings, ranking_text
from lwr_dyn.checks.datasheet.datasheet import ZeroReadings, ZeroRecord, zero_readings, zero_text
from lwr_dyn.cli.options import show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.foundation.progress import progress

RECORDED = 10
"""Readings of each ranking in the JSON record."""


class ZeroFound(TypedDict):
    """Zero and signs of the joints by the data sheet's poses."""

    readings: Annotated[list[ZeroRecord], "Those that fail least and change least."]
    statements: Annotated[list[str], "The result in sentences."]


@click.command("conventions")
@click.argument("robot")
@click.option("--evidence", help="TOML file: what the source publishes beside its table.")
@with_shared("--json as_json")
def command(robot: str, evidence: str | None, as_json: bool) -> None:
    """Read a table whose conventions are not stated: every reading, ranked, and what decides it.

    Readings differ by the point the tensors are about, the sign of the products, the order of axes, the end of the
    link that centres of mass are measured from, the DH convention, and rows that belong elsewhere. The file's own
    errata are not used. Built-in robots bring their evidence along; for your own arm write it as a file, in the form
    that lwr_dyn/checks/conventions/evidence.py shows.
    """
    if ends_in(robot, *ONE_READING):
        raise OptionError("ROBOT", robot, "a robot's name or a .toml file; a URDF states its conventions, as MJCF does")
    paper = open_paper(robot)
    zero = zero_readings(paper) if "poses.axis" in paper.columns else None
    result, kind = None, _own_kind(paper)
    if not kind and (zero is None or "inertial.inertia" in paper.columns):
        table = printed_table(paper)
        with progress("trying all readings"):
            known = packaged_evidence(robot, table) if evidence is None else read_evidence(evidence, table)
            result = rank_readings(table, known)
    if evidence is not None and result is None:
        raise OptionError("--evidence", evidence, f"a robot whose inertias are printed; {paper.name} has none to read")
    show(document(robot, paper, result, zero), as_json)


def _own_kind(paper: Paper) -> str:
    """The kind of the tensors where no source prints them; empty otherwise."""
    column = paper.columns.get("inertial.inertia")
    return column.kind if column is not None and column.kind in ("estimated", "assumed") else ""


def document(robot: str, paper: Paper, result: RankedReadings | None, zero: ZeroReadings | None) -> Document:
    """What the data sheet's poses and the table's inertias say, either of which may be missing."""
    kind = _own_kind(paper)
    own = f"its inertias are {kind}, not printed: their conventions are this package's own"
    found = None if zero is None else {"readings": [r.record() for r in zero.best], "statements": zero_text(zero)}
    says = "Zero and signs of the joints by the data sheet's poses; left out without."
    poses = Section("", [
        Fact("zero", found, says, kind=ZeroFound), Note([] if zero is None else zero_text(zero)),
    ], there=zero is not None)  # fmt: skip
    return Document(
        f"{paper.name}: {paper.title}, cells as printed; errata and stated conventions are not used",
        "",
        [poses, Section("", [Note(own, bool(kind))]), *_rankings(result)],
        "lwr-dyn conventions",
        "conventions",
        [Fact("robot", robot, "Name of the robot.")],
    )


def _rankings(result: RankedReadings | None) -> Iterator[Section]:
    judged = {} if result is None else judged_rankings(result)
    decisions = {name: [d.record() for d in j.decisions] for name, j in judged.items()}
    says = {
        "computed": "Readings that give every published number, the plainest first; no more than 10.",
        "physical": "Readings whose links can be bodies, whose repeated links agree, and that give the second tensors.",
        "both": "Readings that are both.",
    }
    best = None if result is None or result.best is None else result.best.record()
    yield Section("", [
        *(Fact(name, [c.record() for c in getattr(result, name, ())[:RECORDED]], what, kind=list[ReadingRecord])
          for name, what in says.items()),
        Fact("agree", result is not None and result.agree,
             "Whether a reading that gives the numbers has bodies as good as any."),
        Fact("best", best, "The reading to take for the arm.", kind=ReadingRecord | None),
        Fact("decisions", decisions, "Choice by choice, of what the authors computed with and of the arm.",
             kind=dict[str, list[DecisionRecord]]),
        Note([] if result is None else ranking_text(result), key="statements", says="The result in sentences."),
    ], there=result is not None)  # fmt: skip
    for one in judged.values():
        yield Section("", [one.table()])
