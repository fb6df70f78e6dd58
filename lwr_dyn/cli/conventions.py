"""`lwr-dyn conventions`: the possible conventions of a table that states none, ranked, with the reasons."""

from typing import Any

import click

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.checks.conventions.evidence import Evidence, packaged_evidence, read_evidence
from lwr_dyn.checks.conventions.printed_table import PrintedTable, printed_table
from lwr_dyn.checks.conventions.ranking import RankedReadings, rank_readings
from lwr_dyn.checks.conventions.ranking_text import judged_rankings, ranking_text
from lwr_dyn.checks.datasheet.datasheet import ZeroReadings, zero_readings, zero_text
from lwr_dyn.cli.options import print_json
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.foundation.progress import progress

RECORDED = 10
"""Readings of each ranking in the JSON record."""


@click.command("conventions")
@click.argument("robot")
@click.option("--evidence", help="TOML file: what the source publishes beside its table.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def command(robot: str, evidence: str | None, as_json: bool) -> None:
    """Read a table whose conventions are not stated: every reading, ranked, and what decides it.

    Readings differ by the point the tensors are about, the sign of the products, the order of axes, the end of the
    link that centres of mass are measured from, the DH convention, and rows that belong elsewhere. The file's own
    errata are not used. Built-in robots bring their evidence along; for your own arm write it as a file, in the form
    that lwr_dyn/checks/conventions/evidence.py shows.
    """
    if ends_in(robot, ".urdf", ".xacro"):
        raise OptionError("ROBOT", robot, "a robot's name or a .toml file; a URDF states its conventions")
    paper = open_paper(robot)
    zero = zero_readings(paper) if "poses.axis" in paper.columns else None
    result, kind = None, _own_kind(paper)
    if not kind and (zero is None or "inertial.inertia" in paper.columns):
        table = printed_table(paper)
        with progress("trying all readings"):
            result = rank_readings(table, _evidence(robot, evidence, table))
    if evidence is not None and result is None:
        raise OptionError("--evidence", evidence, f"a robot whose inertias are printed; {paper.name} has none to read")
    if as_json:
        print_json(_record(robot, result, zero))
        return
    click.echo(f"{paper.name}: {paper.title}, cells as printed; errata and stated conventions are not used")
    for line in zero_text(zero) if zero else ():
        click.echo(line)
    if kind:
        click.echo(f"its inertias are {kind}, not printed: their conventions are this package's own")
    if result:
        _print(result)


def _own_kind(paper: Paper) -> str:
    """The kind of the tensors where no source prints them; empty otherwise."""
    column = paper.columns.get("inertial.inertia")
    return column.kind if column is not None and column.kind in ("estimated", "assumed") else ""


def _evidence(robot: str, path: str | None, table: PrintedTable) -> Evidence:
    return packaged_evidence(robot, table) if path is None else read_evidence(path, table)


def _print(result: RankedReadings) -> None:
    for line in ranking_text(result):
        click.echo(line)
    for judged in judged_rankings(result).values():
        if judged.ranking:
            click.echo(f"\n{judged.table().text()}")


def _record(robot: str, result: RankedReadings | None, zero: ZeroReadings | None) -> dict[str, Any]:
    record: dict[str, Any] = {"robot": robot}
    if zero is not None:
        readings = [
            {"convention": r.convention.value, "signs": r.signs, "offsets_deg": r.offsets_deg, "failed": r.failed}
            for r in zero.best
        ]
        record["zero"] = {"readings": readings, "statements": zero_text(zero)}
    if result is not None:
        rankings = {"computed": result.computed, "physical": result.physical, "both": result.both}
        record |= {name: [c.record() for c in ranking[:RECORDED]] for name, ranking in rankings.items()}
        judged = judged_rankings(result).items()
        record |= {
            "agree": result.agree,
            "best": None if result.best is None else result.best.record(),
            "decisions": {name: [d.record() for d in j.decisions] for name, j in judged},
            "statements": ranking_text(result),
        }
    return record
