"""`lwr-dyn resolve`: how a table whose conventions nobody states may be read, and what decides it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from lwr_dyn.audit.conventions.candidates import Candidate
from lwr_dyn.audit.conventions.decisions import decisions
from lwr_dyn.audit.conventions.evidence import Evidence
from lwr_dyn.audit.conventions.evidence_file import read_evidence, room_evidence
from lwr_dyn.audit.conventions.printed import PrintedTable, printed_table
from lwr_dyn.audit.conventions.resolve import Resolution, resolve
from lwr_dyn.audit.conventions.statements import ranking_rows, rankings, statements
from lwr_dyn.audit.conventions.zero import ZeroResolution, resolve_zero, zero_statements
from lwr_dyn.cli.options import print_json
from lwr_dyn.errors import OptionError
from lwr_dyn.papers.catalog import open_paper, robots
from lwr_dyn.papers.schema import Paper
from lwr_dyn.tables import aligned

HEAD = ("#", "DH", "about", "com from", "products", "axes moved", "cells", "apart", "repeated differ", "fullness")


@click.command("resolve")
@click.argument("robot")
@click.option("--evidence", help="TOML file: what the source publishes beside its table.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def command(robot: str, evidence: str | None, as_json: bool) -> None:
    """Read a table whose conventions nobody states: every reading, ranked, with what decides it.

    Readings differ by the point the tensors are about, the sign of the products, the order of axes, the end of the
    link that centres of mass are measured from, the DH convention, and rows that belong elsewhere. The file's own
    errata are not looked at. Built-in robots bring their evidence along; for your own arm write it as a file, in the
    form that lwr_dyn/audit/conventions/evidence_file.py shows.
    """
    if robot.endswith(".urdf"):
        raise OptionError("ROBOT", robot, "a robot's name or a .toml file; a URDF states its conventions")
    paper = open_paper(robot)
    zero = resolve_zero(paper) if "poses.axis" in paper.columns else None
    found = None
    ours = _ours(paper)
    if not ours and (zero is None or "inertial.inertia" in paper.columns):
        table = printed_table(paper)
        found = resolve(table, _evidence(robot, evidence, table))
    if evidence is not None and found is None:
        raise OptionError("--evidence", evidence, f"a robot whose inertias are printed; {paper.name} has none to read")
    if as_json:
        print_json(_record(robot, found, zero))
        return
    click.echo(f"{paper.name}: {paper.title}, cells as printed, errata and stated conventions not looked at")
    for line in zero_statements(zero) if zero else ():
        click.echo(line)
    if ours:
        click.echo(f"its inertias are {ours}, not printed: their conventions are this package's own")
    if found:
        _print(found)


def _ours(paper: Paper) -> str:
    """The kind of the tensors where no source prints them, else nothing."""
    column = paper.columns.get("inertial.inertia")
    return column.kind if column is not None and column.kind in ("estimated", "assumed") else ""


def _evidence(robot: str, path: str | None, table: PrintedTable) -> Evidence:
    if path is not None:
        return read_evidence(path, table)
    if robot in robots():
        return room_evidence(robot, table) or Evidence()
    return Evidence()


def _print(found: Resolution) -> None:
    for line in statements(found):
        click.echo(line)
    titles = {"computed": "what the authors computed with", "arm": "what the arm is"}
    for name, (ranking, _) in rankings(found).items():
        if ranking:
            click.echo(f"\nreadings, best first: {titles[name]} (t tensor entries, i +integral, link by link)")
            click.echo(aligned(ranking_rows(ranking), HEAD))


def _record(robot: str, found: Resolution | None, zero: ZeroResolution | None) -> dict[str, Any]:
    record: dict[str, Any] = {"robot": robot}
    if zero is not None:
        record["zero"] = {
            "readings": [
                {"convention": r.convention.value, "signs": r.signs, "offsets_deg": r.offsets_deg, "failed": r.failed}
                for r in zero.best
            ],
            "statements": zero_statements(zero),
        }
    if found is not None:
        names = ("computed", "physical", "both")
        record |= {name: [_reading(c) for c in getattr(found, name)[:10]] for name in names}
        record |= {"agree": found.agree, "best": None if found.best is None else _reading(found.best)}
        record |= {"decisions": {name: _decided(found, *how) for name, how in rankings(found).items()}}
        record |= {"statements": statements(found)}
    return record


def _decided(found: Resolution, ranking: Sequence[Candidate], criteria: Sequence[str]) -> list[dict[str, Any]]:
    return [
        {"question": d.question, "link": None if d.link is None else d.link + 1, "answer": d.answer,
         "decided": d.decided, "others": d.others, "by": d.by}
        for d in decisions(found, ranking, criteria)
    ]  # fmt: skip


def _reading(c: Candidate) -> dict[str, Any]:
    r = c.reading
    return {
        "convention": r.table.convention.value, "about": r.table.about, "com_from": r.table.com_from,
        "products": [x.products for x in r.links], "axes": [x.axes for x in r.links],
        "axes_move": [x.moves for x in r.links], "rows_lower": r.shift,
        "cells": {x.name: {"printed": x.printed, "read": x.value} for x in r.cells},
        "exceptions": c.exceptions, "mirror_miss": c.mirror_miss, "infeasible": c.infeasible, "fullness": c.fullness,
    }  # fmt: skip
