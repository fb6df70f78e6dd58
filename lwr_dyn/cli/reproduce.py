"""`lwr-dyn reproduce`: everything a paper prints, recomputed, into a folder."""

import sys
from pathlib import Path
from typing import Any

import click

from lwr_dyn.arms.papers.catalog import published
from lwr_dyn.cli.options import OneOf, show
from lwr_dyn.cli.vocabulary import FOLDER, with_shared
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.foundation.progress import progress
from lwr_dyn.reproduction.papers import ALL, OWN, option_keywords, studies, takers


def _options() -> list[click.Parameter]:
    """The options of all studies; the help of each names its papers."""
    out: list[click.Parameter] = []
    for keyword in option_keywords():
        papers = takers(keyword)
        option = next(iter(papers.values()))
        about = f"{', '.join(papers)}: {option.about}."
        kind = {"type": OneOf(option.values)} if option.values else {"is_flag": True}
        out.append(click.Option([f"--{option.name}"], help=about, **kind))
    return out


@click.command(
    "reproduce",
    params=_options(),
    help=f"""Recompute what PAPER prints ({", ".join(studies())}, {ALL}, or your own .toml with [[result]]);
exit 1 when a number that the paper lets recompute differs, or a check or a proof fails. Of a robot of published
sets (panda, puma560, ...) it shows the errata with their proofs.""",
)
@click.argument("paper")
@with_shared("--out", " the results: out/PAPER if not given (of a file its name), out for all", form=FOLDER)
@with_shared("--json as_json", " instead of the tables")
def command(paper: str, out: str | None, as_json: bool, **options: Any) -> None:
    """Recompute a paper into a folder; the options are those of the studies."""
    from lwr_dyn.reproduction.reproduce import reproduce

    folder = out or ("out" if paper == ALL else f"out/{Path(paper).stem if ends_in(paper, OWN) else paper}")
    with progress(f"reproducing {paper}") as report:
        reproduction = reproduce(paper, folder, report, **options)
    show(reproduction.document, as_json)
    if not as_json:
        page = "" if paper == ALL or paper in published() else f"; open it: xdg-open {Path(folder) / 'report.html'}"
        click.echo(f"\nwrote {folder}{page}")
    sys.exit(0 if reproduction.holds else 1)
