"""`lwr-dyn reproduce`: everything a paper prints, recomputed, into a folder."""

from __future__ import annotations

import sys

import click

from lwr_dyn.cli.options import print_json


@click.command("reproduce")
@click.argument("paper")
@click.option("--out", help="The folder to write; out/PAPER if not given, out for all.")
@click.option("--timing", help="lwr4plus: constant, quintic or smooth (the one taken if not given).")
@click.option("--fit-arm-angle", is_flag=True, help="lwr4plus: also fit the arm angle to Table VIII.")
@click.option("--spread", is_flag=True, help="lwr4plus, wam7: also the task under all readings (a minute more).")
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of the tables.")
def command(paper: str, out: str | None, timing: str | None, fit_arm_angle: bool, spread: bool, as_json: bool) -> None:
    """Recompute what PAPER prints (lwr4, lwr4plus, wam7, kr30ha, or all); exit 1 when a number is left unexplained."""
    from lwr_dyn.reproduction.reproduce import ALL, reproduce

    folder = out or ("out" if paper == ALL else f"out/{paper}")
    outcome = reproduce(paper, folder, timing, fit_arm_angle, spread, _say)
    if as_json:
        print_json(outcome.record)
    else:
        click.echo(outcome.text)
        click.echo(f"\nwrote {folder}")
    sys.exit(0 if outcome.holds else 1)


def _say(step: str) -> None:
    """What is being done, on a terminal; quiet in a pipe."""
    if sys.stderr.isatty():
        click.echo(f"... {step}", err=True)
