"""`lwr-dyn reproduce`: what a paper prints beside what comes out."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import click

from lwr_dyn.cli.options import print_json, table
from lwr_dyn.errors import UnknownNameError

if TYPE_CHECKING:
    from lwr_dyn.control.worst_case_inertia import WorstCase


@click.command("reproduce")
@click.argument("paper")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def command(paper: str, as_json: bool) -> None:
    """Recompute what PAPER (lwr4, lwr4plus) prints; exit 1 when a number has neither match nor explanation."""
    papers = {"lwr4": _lwr4, "lwr4plus": _lwr4plus}
    if paper not in papers:
        raise UnknownNameError("paper to reproduce", paper, papers)
    sys.exit(0 if papers[paper](as_json) else 1)


def _lwr4(as_json: bool) -> bool:
    from lwr_dyn.reproduction.lwr4 import exercise

    e = exercise()
    if as_json:
        routes = {
            name: {"value": [str(x) for x in route.value], "products": route.multiplications, "sums": route.additions}
            for name, route in (("full_product", e.wrist_full), ("vector_route", e.wrist_short))
        }
        record = {"matrices": [str(m.tolist()) for m in e.matrices], "identical_to_printed": list(e.identical)}
        print_json({**record, "wrist": routes, "routes_agree": e.routes_agree, "tool": e.tool})
        return e.holds
    for i, same in enumerate(e.identical, start=1):
        click.echo(f"A{i}: {'identical to the printed matrix' if same else 'DIFFERS from the printed matrix'}")
    full, short = e.wrist_full, e.wrist_short
    click.echo(f"wrist by A1...A7 (0,0,0,1): {full.multiplications} products, {full.additions} sums")
    click.echo(f"wrist by A1..A4 (0,0,M,1):  {short.multiplications} products, {short.additions} sums")
    click.echo(f"both routes give one expression: {e.routes_agree}")
    for axis, expression in zip("xyz", short.value, strict=False):
        click.echo(f"  p_W,{axis} = {expression}")
    tool = " ".join(f"{round(x, 12) + 0.0:g}" for x in e.tool)
    click.echo(f"tool point {e.tool_in_flange} at q = {e.q_deg} deg: {tool} m")
    return e.holds


def _lwr4plus(as_json: bool) -> bool:
    from lwr_dyn.reproduction.lwr4plus import errata_that_matter, table_iv, table_vi

    inertias, gains = table_iv(), table_vi()
    holds = all(r.reproduced("computed") for r in inertias) and all(g.reproduced or g.fits for g in gains)
    if as_json:
        rows = [
            {"joint": r.joint + 1, "printed": r.printed, "values": dict(r.values), "search": r.worst.statement()}
            | {"reproduced": {name: r.reproduced(name) for name in r.values}, "at_printed_q": list(r.at_printed)}
            | {"maximisers": r.worst.maximisers, "distinct_maximisers": r.worst.distinct}
            for r in inertias
        ]
        cells = [
            {"cell": f"{g.name}_{g.joint + 1}", "printed": g.printed, "value": g.value, "reproduced": g.reproduced}
            | {"fits": g.fits or None}
            for g in gains
        ]
        print_json({"table_iv": rows, "table_vi": cells, "errata_that_matter": errata_that_matter(), "holds": holds})
        return holds
    _print_table_iv()
    _print_table_vi()
    return holds


def _print_table_iv() -> None:
    from lwr_dyn.reproduction.lwr4plus import errata_that_matter, table_iv

    rows, names = table_iv(), ("printed", "computed", "physical")
    text = []
    for r in rows:
        values = [f"{r.values[n]:.6g}{' =' if r.reproduced(n) else ''}" for n in names]
        text.append(
            (
                str(r.joint + 1),
                r.printed,
                *values,
                " ".join(r.printed_q),
                f"{r.at_printed[1]:.5g}",
                _maximisers(r.worst),
            )
        )
    head = ("joint", "Table IV", *names, "printed q [deg]", "B_ii there, at most", "maximisers [deg]")
    click.echo(
        "Table IV, worst-case inertia [kg m^2]; = reproduced to the printed digits; * any; q2 from the horizontal"
    )
    click.echo(table(text, head))
    for r in rows:
        click.echo(f"b{r.joint + 1}{r.joint + 1}: {r.worst.statement()}")
    errata = " and ".join(errata_that_matter())
    click.echo(f"what makes the difference between printed and computed: {errata}")


def _maximisers(worst: WorstCase) -> str:
    from lwr_dyn.reproduction.lwr4plus import in_paper_angles

    shown = in_paper_angles(worst)
    more = worst.distinct - len(shown)
    return " | ".join(" ".join(q) for q in shown) + (f" | and {more} more" if more > 0 else "")


def _print_table_vi() -> None:
    from lwr_dyn.reproduction.lwr4plus import table_vi

    rows = []
    for cell in table_vi():
        verdict = (
            "reproduced" if cell.reproduced else f"printed here: the value of {cell.fits}" if cell.fits else "open"
        )
        rows.append((f"{cell.name}_{cell.joint + 1}", cell.printed, f"{cell.value:.6g}", verdict))
    click.echo("\nTable VI, gains from omega_n = 50 rad/s, xi = 1 and the printed b")
    click.echo(table(rows, ("cell", "printed", "recomputed", "verdict")))
