"""Runs as lines over all parameters at once: parallel coordinates, turned, an axis a row and the metric at the end."""

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.pages.plotting.charts import WIDTH
from lwr_dyn.studies.sweep.report.distribution_charts import limit_mark, values_axis
from lwr_dyn.studies.sweep.statistics.influence import is_by_name
from lwr_dyn.studies.sweep.statistics.summary import ControllerFigures, MetricFigures, SweepSummary, draw_columns
from lwr_dyn.studies.sweep.statistics.summary_tables import part_words

MOST_AXES = 10
MOST_LINES = 150
"""Of the runs that keep all limits, and again of those that do not: the first by number, which are drawn at random."""
ROW = 100
"""Height of a row in the plane's units."""


@dataclass(frozen=True, slots=True, eq=False)
class LineAxis:
    """A row: its name, the texts at its ends, and where each run stands, 0 to 1 (k,)."""

    name: str
    ends: tuple[str, str]
    places: Array


def parallel_html(summary: SweepSummary, name: str, ink: str, units: Mapping[str, str]) -> str:
    """The lines of one controller; the worst runs in its colour, above all others."""
    figures = summary.controllers[name]
    one = figures.metrics[summary.focus[0].name]
    axes = [*parameter_axes(summary, figures, one, units), metric_axis(one, list_of(summary))]
    places = np.array([axis.places for axis in axes])
    kept, broken = (np.flatnonzero(rows)[:MOST_LINES] for rows in (figures.kept, ~figures.kept))
    worst = figures.worst[: max(1, summary.study.keep)]
    groups = ((kept, "kept"), (broken, "broken"), (worst, f"{ink} worst"))
    paths = "".join(f'<path class="{kind}" d="{_lines(places[:, rows])}"/>' for rows, kind in groups if rows.size)
    height = ROW * len(axes)
    grid = "".join(f"M0,{ROW * k + ROW // 2}H{WIDTH}" for k in range(len(axes)))
    names = "".join(
        f"<div><b>{escape(axis.name)}</b><span>{escape(axis.ends[0])}</span><span>{escape(axis.ends[1])}</span></div>"
        for axis in axes
    )
    said = [
        f"{kept.size} of {int(figures.kept.sum())} that keep all limits",
        f"{broken.size} of {int((~figures.kept).sum())} that do not", f"the {worst.size} worst",
    ]  # fmt: skip
    label = escape(f"{name}: runs, {', '.join(said)}, as lines over {', '.join(axis.name for axis in axes)}")
    limit = limit_mark(one, values_axis(list_of(summary)))
    below = f'<div class="last-axis" style="height:{100 / len(axes):.3f}%">{limit}</div>'
    return (
        f'<div class="parallel" style="--rows:{len(axes)}"><div class="axes" aria-hidden="true">{names}</div>'
        f'<div class="plane" role="img" aria-label="{label}"><svg viewBox="0 0 {WIDTH} {height}" '
        f'preserveAspectRatio="none" aria-hidden="true"><path class="grid" d="{grid}"/>{paths}</svg>{below}</div></div>'
        f'<ul class="key"><li><i class="line kept"></i>{said[0]}</li><li><i class="line broken"></i>{said[1]}</li>'
        f'<li><i class="line {ink}"></i>{said[2]}</li></ul>'
    )


def list_of(summary: SweepSummary) -> list[MetricFigures]:
    """The first metric of every controller, which share its axis."""
    return [one.metrics[summary.focus[0].name] for one in summary.controllers.values()]


def parameter_axes(
    summary: SweepSummary, figures: ControllerFigures, one: MetricFigures, units: Mapping[str, str]
) -> list[LineAxis]:
    """The parameters with the largest influence, in the study's order; all that vary where none could be judged."""
    drawn = draw_columns(summary.study, figures.runs)
    chosen = [each.path for each in one.influence[:MOST_AXES]] or list(drawn)[:MOST_AXES]
    return [_axis(path, column, units.get(path, "")) for path, column in drawn.items() if path in chosen]


def _axis(path: str, column: NDArray[Any], unit: str) -> LineAxis:
    if is_by_name(column):
        names, place = np.unique(column, return_inverse=True)
        places = place / max(names.size - 1, 1)
        return LineAxis(path, (str(names[0]), str(names[-1])), np.asarray(places, dtype=np.float64))
    low, high = float(column.min()), float(column.max())
    places = (column - low) / (high - low) if high > low else np.full(column.size, 0.5)
    whole = high - low
    texts = part_words(low, low, whole), f"{part_words(high, high, whole)}{unit and f' {unit}'}"
    return LineAxis(path, texts, np.asarray(places, dtype=np.float64))


def metric_axis(one: MetricFigures, others: list[MetricFigures]) -> LineAxis:
    """The metric on the axis that all controllers share; runs that diverged stand at its end."""
    axis = values_axis(others)
    shown = np.where(np.isposinf(one.badness), np.nan, one.words.factor * one.words.worse * one.badness)
    end = 1.0 if one.words.worse > 0 else 0.0
    places = np.where(np.isnan(shown), end, np.clip(axis.share(shown), 0.0, 1.0))
    return LineAxis(one.words.title, (f"{axis.low:.3g}", f"{axis.high:.3g} {one.words.unit}"), places)


def _lines(places: Array) -> str:
    across = np.rint(WIDTH * places).astype(int).T
    down = ROW * np.arange(places.shape[0]) + ROW // 2
    return "".join("M" + " ".join(f"{x},{y}" for x, y in zip(row, down, strict=True)) for row in across.tolist())
