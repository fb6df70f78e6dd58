"""`lwr-dyn reproduce`: everything a paper prints, recomputed, into a folder."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import click

from lwr_dyn.cli.options import print_json
from lwr_dyn.errors import UnknownNameError

if TYPE_CHECKING:
    from lwr_dyn.reproduction.outcome import Outcome

PAPERS = ("lwr4", "lwr4plus", "wam7", "kr30ha")


@click.command("reproduce")
@click.argument("paper")
@click.option("--out", help="The folder to write; out/PAPER if not given.")
@click.option("--timing", default="smooth", show_default=True, help="lwr4plus: constant, quintic or smooth.")
@click.option("--fit-arm-angle", is_flag=True, help="lwr4plus: also fit the arm angle to Table VIII.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of the tables.")
def command(paper: str, out: str | None, timing: str, fit_arm_angle: bool, as_json: bool) -> None:
    """Recompute what PAPER (lwr4, lwr4plus, wam7, kr30ha) prints; exit 1 when a number is neither met nor explained."""
    if paper not in PAPERS:
        raise UnknownNameError("paper to reproduce", paper, PAPERS)
    folder = out or f"out/{paper}"
    if paper == "lwr4plus":
        outcome = _lwr4plus(folder, timing, fit_arm_angle)
    else:
        outcome = {"lwr4": _exercise, "wam7": _wam7, "kr30ha": _kr30ha}[paper](folder)
    if as_json:
        print_json(outcome.record)
    else:
        click.echo(outcome.text)
        click.echo(f"\nwrote {folder}")
    sys.exit(0 if outcome.holds else 1)


def _exercise(folder: str) -> Outcome:
    from lwr_dyn.reproduction.lwr4.report import reproduce

    return reproduce(folder)


def _kr30ha(folder: str) -> Outcome:
    from lwr_dyn.reproduction.kr30ha.report import reproduce

    return reproduce(folder, _say)


def _lwr4plus(folder: str, timing: str, fit: bool) -> Outcome:
    from lwr_dyn.reproduction.lwr4plus.report import reproduce

    return reproduce(folder, timing, fit, say=_say)


def _wam7(folder: str) -> Outcome:
    from lwr_dyn.reproduction.wam7.report import reproduce

    return reproduce(folder, say=_say)


def _say(step: str) -> None:
    """What is being done, on a terminal; quiet in a pipe."""
    if sys.stderr.isatty():
        click.echo(f"... {step}", err=True)
