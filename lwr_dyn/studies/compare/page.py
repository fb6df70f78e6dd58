"""A comparison as one HTML file: the table, then for each plant the path with its errors magnified, and the tip error.

There is no script, and nothing is loaded; light and dark follow the reader's system.
"""

from collections.abc import Sequence
from html import escape

from lwr_dyn.pages.notebook.quantities import path, tip_error
from lwr_dyn.pages.plotting.charts import chart_html, swatch
from lwr_dyn.pages.plotting.document import document_html
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, replayed_runs
from lwr_dyn.studies.compare.compared_run import ComparedRun
from lwr_dyn.studies.compare.comparison import BEST, UNSTABLE, RunComparison


def comparison_html(compared: RunComparison) -> str:
    """The page; the same runs give the same text."""
    sections = "".join(_section(plant, runs) for plant, runs in compared.plants.items())
    table = f'<div class="scroll" tabindex="0" role="region" aria-label="Runs">{_table(compared)}</div>'
    notes = "".join(f'<p class="note">{escape(note)}</p>' for note in page_notes(compared))
    said = "".join(f"<li>{sentence}</li>" for sentence in _sentences(compared))
    main = (
        f'<h1>{escape(compared.title)}</h1><ul class="say">{said}</ul>'
        f'<section class="card">{table}{notes}</section>{sections}'
    )
    return document_html(compared.title, "comparison", main, "lwr-dyn compare")


def page_notes(compared: RunComparison) -> list[str]:
    """The notes, where the best is bold and not marked."""
    return [f"bold: {note[2:]}" if note.startswith(BEST.strip()) else note for note in compared.notes]


def table_rows(compared: RunComparison) -> str:
    """The table for a notebook: plain, the best of each plant in bold."""
    head = "".join(f'<th scope="col">{escape(h.title)}</th>' for h in compared.table.columns)
    rows = "".join(
        f'<tr><th scope="row">{escape(one.controller)}</th><td>{escape(one.plant)}</td>{_cells(compared, one)}</tr>'
        for one in compared.runs
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def _table(compared: RunComparison) -> str:
    """One group of rows a plant, under its name."""
    words, numbers = compared.table.columns[:1], compared.table.columns[2:]
    head = "".join(f'<th scope="col">{escape(h.head)}</th>' for h in words)
    head += "".join(f'<th scope="col" class="n">{escape(h.head)} <small>{escape(h.unit)}</small></th>' for h in numbers)
    width = len(words) + len(numbers)
    groups = ""
    for plant, runs in compared.plants.items():
        name = f'<tr><th scope="rowgroup" colspan="{width}">{escape(plant)}</th></tr>'
        rows = "".join(
            f'<tr><th scope="row">{swatch(shown)}{escape(one.controller)}</th>{_cells(compared, one)}</tr>'
            for one, shown in zip(runs, _alone(runs), strict=True)
        )
        groups += f'<tbody class="plant">{name}{rows}</tbody>'
    return f"<table><thead><tr>{head}</tr></thead>{groups}</table>"


def _cells(compared: RunComparison, one: ComparedRun) -> str:
    return "".join(map(_cell, compared.cells(one)))


def _cell(text: str) -> str:
    if text.endswith(BEST):
        return f'<td class="n"><b>{escape(text.removesuffix(BEST))}</b></td>'
    return f'<td class="n{" bad" if text.startswith("NOT") or text.endswith(UNSTABLE) else ""}">{escape(text)}</td>'


def _sentences(compared: RunComparison) -> list[str]:
    """Of each plant with several runs, which controller has the smallest RMS error."""
    out = []
    for plant, all_runs in compared.plants.items():
        runs = [one for one in all_runs if not one.shakes]
        if len(runs) > 1:
            best, *_, worst = sorted(runs, key=lambda one: one.figures.tip_rms_mm)
            near = f"{escape(best.controller)} is nearest to the path, {best.figures.tip_rms_mm:.3g} mm RMS"
            far = f"{escape(worst.controller)} farthest, {worst.figures.tip_rms_mm:.3g} mm"
            out.append(f"<b>{escape(plant)}</b>: {near}; {far}.")
    return out


def _section(plant: str, runs: Sequence[ComparedRun]) -> str:
    shown = _alone(runs)
    charts = "".join(chart_html(figure, shown) for figure in (*path(shown), *tip_error(shown)))
    return f'<section class="card"><h2>{escape(plant)}</h2><div class="charts">{charts}</div></section>'


def _alone(runs: Sequence[ComparedRun]) -> tuple[ReplayedRun, ...]:
    """The runs of one plant, named by their controllers, with the colours that they have among themselves."""
    shown = [one.shown for one in runs]
    return replayed_runs([one.run for one in shown], [one.arm for one in shown], [one.controller for one in runs])
