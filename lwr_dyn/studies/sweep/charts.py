"""The charts of a study's page as HTML: how a metric is distributed, what each parameter does, lines of runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.pages.figures.figure import Axis, axis_of, frequency_axis
from lwr_dyn.pages.plotting.line_plane import HEIGHT, WIDTH, grid_path, marks, plane_html, tick_marks
from lwr_dyn.studies.sweep.influence import Influence, SobolIndices, is_by_name
from lwr_dyn.studies.sweep.intervals import hundredths, index_text, percent
from lwr_dyn.studies.sweep.outwards import OutwardSearch
from lwr_dyn.studies.sweep.summary import TORNADO, ControllerFigures, MetricFigures, SweepSummary, draw_columns
from lwr_dyn.studies.sweep.summary_document import part_words, quantile_text, value_text

BINS = 60
POINTS = 240
"""Of a curve."""
WIDE = 20.0
"""A metric that spans more than this factor has a logarithmic axis."""
NEAR = 2.0
"""A limit is inside the axis where it is at most so many times as large as the worst runs drawn."""
MOST_BARS = 10
"""Parameters in a chart of bars; those below have less effect."""
MOST_AXES = 10
MOST_LINES = 150
"""Of the runs that keep all limits, and again of those that do not: the first by number, which are drawn at random."""
ROW = 100
"""Height of a row of the lines, in the plane's units."""


# ---- how a metric is distributed over the runs


def values_axis(figures: Sequence[MetricFigures]) -> Axis:
    """The axis of a metric over all controllers: nearly all runs, and the limit where it is near."""
    parts = []
    for one in figures:
        finite = one.sample[np.isfinite(one.sample)]
        shown = one.words.shown(finite)
        parts.append(np.quantile(shown, [0.001, 0.999]) if finite.size else np.array([0.0, 1.0]))
    ends, bound = np.concatenate(parts), figures[0].bound
    if bound is not None and np.isfinite(bound):
        limit = figures[0].words.factor * bound
        if ends.min() / NEAR <= limit <= NEAR * ends.max():
            ends = np.append(ends, [limit, 1.04 * limit])
    if ends.min() > 0.0 and ends.max() > WIDE * ends.min():
        return frequency_axis(ends)
    return axis_of(ends, most=8, padding=0.02)


def same_words(figures: Sequence[MetricFigures]) -> str:
    """In place of a picture, where all runs have one value: that, in a sentence; empty where they differ."""
    first, every = figures[0], np.concatenate([one.sample for one in figures])
    if not np.isfinite(every[0]) or (every != every[0]).any():
        return ""
    of = f"all {every.size} runs" + (f" of {len(figures)} controllers" if len(figures) > 1 else "")
    return f"{value_text(first.words, float(every[0]))} {first.words.unit} in {of}; {_limit_text(first)}."


def limit_words(figures: Sequence[MetricFigures]) -> str:
    """The limit in words, and whether it is drawn."""
    far = figures[0].bound is not None and not limit_mark(figures[0], values_axis(figures))
    return _limit_text(figures[0]) + (", beyond the axis" if far else "")


def _limit_text(one: MetricFigures) -> str:
    if one.bound is None:
        return "no limit set"
    return f"limit {value_text(one.words, one.words.worse * one.bound)} {one.words.unit}"


def limit_mark(one: MetricFigures, axis: Axis) -> str:
    """The limit as a line over a plane; nothing where it is far away or not given."""
    if one.bound is None:
        return ""
    at = float(axis.share(one.words.factor * one.bound))
    return f'<i class="limit" style="left:{100 * at:.2f}%"></i>' if 0.0 <= at <= 1.0 else ""


def histograms_html(figures: Mapping[str, MetricFigures], inks: Mapping[str, str]) -> str:
    """A row a controller: its histogram over one axis, the limit, and its median and worst quantiles as numbers."""
    axis = values_axis(list(figures.values()))
    rows = "".join(_histogram(name, one, axis, inks[name]) for name, one in figures.items())
    ticks = tick_marks(axis, "xt", "left", next(iter(figures.values())).words.unit)
    return f'<div class="rows">{rows}<div class="row last"><div></div>{ticks}<div></div></div></div>'


def _histogram(name: str, one: MetricFigures, axis: Axis, ink: str) -> str:
    share = np.asarray(axis.share(one.words.shown(one.sample[np.isfinite(one.sample)])))
    counts, _ = np.histogram(share, bins=BINS, range=(0.0, 1.0))
    top, step = max(int(counts.max(initial=0)), 1), WIDTH / BINS
    steps = "".join(f"V{HEIGHT - round(HEIGHT * c / top)}H{round((k + 1) * step)}" for k, c in enumerate(counts))
    beyond = int((share > 1.0).sum() + np.isposinf(one.sample).sum() + (share < 0.0).sum())
    out = f"<small>{beyond} of {one.sample.size} beyond the axis</small>" if beyond else ""
    numbers = ""
    for found in one.quantiles:
        of = "median" if found.share == 0.5 else f"{100 * found.share:g} %"
        value, bracket, interval = quantile_text(one.words, found).partition(" [")
        interval = escape(bracket.strip() + interval)
        numbers += f"<li>{of} <b>{escape(value)}</b><small>{interval}</small></li>"
    bars = f'<path class="bars" d="M0,{HEIGHT}{steps}V{HEIGHT}Z"/>'
    label = f"Histogram of {one.words.title}, {name}: {one.sample.size} runs"
    return (
        f'<div class="row {ink}"><div class="who"><i class="sw {ink}"></i>{escape(name)}{out}</div>'
        f'{plane_html(label, [bars], "low", limit_mark(one, axis))}<ul class="figures">{numbers}</ul></div>'
    )


def worst_share_html(figures: Mapping[str, MetricFigures], inks: Mapping[str, str], with_interval: bool) -> str:
    """The share of the runs that are worse than a value, logarithmic, and quantiles with their intervals."""
    first, axis = next(iter(figures.values())), values_axis(list(figures.values()))
    least = min(1.0 / one.sample.size for one in figures.values())
    up = Axis(least, 1.0, tuple(10.0**-k for k in range(int(-np.log10(least)) + 1)), True)
    paths = grid_path(None, up)
    for name, one in figures.items() if with_interval else ():
        paths += f'<path class="{inks[name]} bar" d="{_intervals(one, axis, up)}"/>'
    for name, one in figures.items():
        paths += f'<path class="{inks[name]}" d="{_curve(one, axis, up)}"/>'
    label = f"{first.words.title}: share of the runs that are worse; {', '.join(figures)}"
    plane = plane_html(label, [paths], inside=limit_mark(first, axis))
    left = marks([float(up.share(tick)) for tick in up.ticks], [f"{percent(t)} %" for t in up.ticks], "yt", "top")
    below = tick_marks(axis, "xt", "left", first.words.unit)
    names = "".join(f'<li><i class="sw {inks[name]}"></i>{escape(name)}</li>' for name in figures)
    return f'<div class="area">{left}{plane}<div></div>{below}</div><ul class="names">{names}</ul>'


def _down(up: Axis, share: float) -> int:
    return round(HEIGHT * (1.0 - float(up.share(share))))


def _curve(one: MetricFigures, axis: Axis, up: Axis) -> str:
    """From all runs to the worst one: at a value, the share of the runs at least as bad."""
    ordered, n, worse = np.sort(one.sample), one.sample.size, one.words.worse
    index = np.unique(np.rint(n - np.geomspace(1.0, n, POINTS)).astype(int))
    across = np.where(np.isposinf(ordered[index]), worse * np.inf, axis.share(one.words.shown(ordered[index])))
    shares, end = (n - index) / n, 1.0 if worse > 0 else 0.0
    beyond = np.flatnonzero(worse * (across - end) > 0.0)
    if beyond.size:  # the curve leaves the plane at the share of the runs that are beyond it
        across, shares = across[: beyond[0] + 1], shares[: beyond[0] + 1]
    points = zip((WIDTH * across.clip(0.0, 1.0)).tolist(), shares.tolist(), strict=True)
    return "M" + " ".join(f"{round(x)},{_down(up, y)}" for x, y in points)


def _intervals(one: MetricFigures, axis: Axis, up: Axis) -> str:
    """The intervals of the quantiles, at the shares that they leave."""
    out = ""
    for found in one.quantiles:
        low, high = (round(WIDTH * _place(one, axis, end)) for end in (found.low, found.high))
        out += f"M{low},{_down(up, max(1.0 - found.share, up.low))}H{high}"
    return out


def _place(one: MetricFigures, axis: Axis, badness: float) -> float:
    """Where a value of the badness stands on an axis, from the left."""
    return float(np.clip(axis.share(one.words.shown(badness)), 0.0, 1.0))


# ---- what each parameter does


def _bar_row(path: str, track: str, about: str, kind: str = "bar-row") -> str:
    return (
        f'<div class="{kind}"><div class="what">{escape(path)}</div><div class="track">{track}</div>'
        f'<div class="about">{escape(about)}</div></div>'
    )


def _span(kind: str, low: float, high: float) -> str:
    """A bar over shares of the track."""
    return f'<i class="{kind}" style="left:{100 * low:.2f}%;width:{100 * (high - low):.2f}%"></i>'


def _scale(ticks: str) -> str:
    return f'<div class="bars-scale"><div></div><div class="track">{ticks}</div></div>'


def tornado_html(one: MetricFigures, units: Mapping[str, str]) -> str:
    """A bar a parameter, from the quantile of its best part of the runs to that of its worst; `units` by its name."""
    shown, words = one.influence[:MOST_BARS], one.words
    if not shown:
        return '<p class="note">Too few runs, or nothing varies: no parameter can be judged.</p>'
    ends = [words.shown(part.estimate.value) for each in shown for part in (each.best, each.worst)]
    middle = next(found.value for found in one.quantiles if found.share == TORNADO)
    axis = axis_of(np.array([*ends, words.shown(middle)]), most=5)
    rows = "".join(_tornado_bar(each, one, axis, units.get(each.path, "")) for each in shown)
    scale = _scale(tick_marks(axis, "xt", "left", words.unit))
    centre = f"{100 * _place(one, axis, middle):.2f}%" if not np.isnan(middle) else "0%"
    rest = len(one.influence) - len(shown)
    more = f'<p class="note">{rest} more, with less effect.</p>' if rest else ""
    return f'<div class="bars-of tornado" style="--centre:{centre}">{rows}{scale}</div>{more}'


def _tornado_bar(each: Influence, one: MetricFigures, axis: Axis, unit: str) -> str:
    words, worst = one.words, each.worst.estimate
    bar = sorted(_place(one, axis, end) for end in (each.best.estimate.value, worst.value))
    whisker = sorted(_place(one, axis, end) for end in (worst.low, worst.high))
    track = _span("bar" if each.is_clear else "bar hollow", *bar) + _span("whisker", *whisker)
    about = ", ".join(
        f"{value_text(words, part.estimate.value)} at {part_words(part.low, part.high, each.extent)} {unit}".rstrip()
        for part in (each.best, each.worst)
    )
    if each.correlation is not None:
        about += f"; rank correlation {hundredths(words.worse * each.correlation.value, '+')}"
    if not each.is_clear:
        about += "; could be chance"
    if each.along:
        about += f"; may be the effect of {', '.join(each.along)}, which it follows in these runs"
    return _bar_row(each.path, track, about)


def indices_html(found: SobolIndices | None) -> str:
    """Two bars a parameter: its own share of the variance, and with interactions; each with its interval."""
    if found is None:
        return '<p class="note">Too few complete groups.</p>'
    rows = ""
    for path in sorted(found.total, key=lambda path: -found.total[path].value)[:MOST_BARS]:
        track, about = "", []
        for kind, ink, words in (("first", "", "alone"), ("total", "hollow ", "with interactions")):
            one = getattr(found, kind)[path]
            value, low, high = np.clip((one.value, one.low, one.high), 0.0, 1.0).tolist()
            track += f'<i class="bar {ink}{kind}" style="left:0;width:{100 * value:.2f}%"></i>'
            track += _span(f"whisker {kind}", low, high)
            about.append(f"{words} {index_text(one)}")
        rows += _bar_row(path, track, ", ".join(about), "bar-row two")
    scale = _scale(tick_marks(Axis(0.0, 1.0, (0.0, 0.25, 0.5, 0.75, 1.0)), "xt", "left"))
    left_out = f", {found.left_out} left out" if found.left_out else ""
    note = f'<p class="note">{found.groups} groups of runs{left_out}; intervals of 95 % by bootstrap.</p>'
    return f'<div class="bars-of">{rows}{scale}</div>{note}'


def outwards_html(search: OutwardSearch) -> str:
    """A gauge a way: how far a parameter alone goes before a limit breaks."""
    if search.at_nominal:
        broken = escape(", ".join(search.at_nominal))
        return f'<p class="note bad">Broken with every parameter at its nominal value: {broken}.</p>'
    rows = ""
    for line in search.broken:
        share = 100 * (line.share or 0.0)
        track = f'<i class="bar" style="left:0;width:{share:.2f}%"></i><i class="limit" style="left:{share:.2f}%"></i>'
        ends = f"kept at {line.kept:.4g}, broken at {line.broken:.4g}"
        rows += _bar_row(line.path, track, f"{line.metric} {ends}, {share:.0f} % of the way to {line.end:.4g}")
    kept = [f"{line.path} to {line.end:.4g}" for line in search.lines if line.share is None]
    said = f"Keep every limit alone: {', '.join(kept)}. " if kept else ""
    return f'<div class="bars-of">{rows}</div><p class="note">{escape(said)}{search.runs} runs of their own.</p>'


# ---- runs over all parameters: parallel coordinates, turned, an axis a row and the metric at the end


@dataclass(frozen=True, slots=True, eq=False)
class LineAxis:
    """A row: its name, the texts at its ends, and where each run stands, 0 to 1 (k,)."""

    name: str
    ends: tuple[str, str]
    places: Array


def parallel_html(summary: SweepSummary, name: str, ink: str, units: Mapping[str, str]) -> str:
    """The lines of one controller; the worst runs in its colour, above all others."""
    figures = summary.controllers[name]
    every = [one.metrics[summary.focus[0].name] for one in summary.controllers.values()]
    one = figures.metrics[summary.focus[0].name]
    axes = [*parameter_axes(summary, figures, one, units), metric_axis(one, every)]
    places, count = np.array([axis.places for axis in axes]), len(axes)
    kept, broken = (np.flatnonzero(rows)[:MOST_LINES] for rows in (figures.kept, ~figures.kept))
    worst = figures.worst[: max(1, summary.study.keep)]
    said = {
        "kept": f"{kept.size} of {int(figures.kept.sum())} that keep all limits",
        "broken": f"{broken.size} of {int((~figures.kept).sum())} that do not",
        ink: f"the {worst.size} worst",
    }
    paths = f'<path class="grid" d="{"".join(f"M0,{ROW * k + ROW // 2}H{WIDTH}" for k in range(count))}"/>'
    across, down = np.rint(WIDTH * places).astype(int).T, ROW * np.arange(count) + ROW // 2
    for rows, kind in ((kept, "kept"), (broken, "broken"), (worst, f"{ink} worst")):
        lines = (" ".join(f"{x},{y}" for x, y in zip(row, down, strict=True)) for row in across[rows].tolist())
        paths += f'<path class="{kind}" d="M{"M".join(lines)}"/>' if rows.size else ""
    label = f"{name}: runs, {', '.join(said.values())}, as lines over {', '.join(axis.name for axis in axes)}"
    limit = limit_mark(one, values_axis(every))
    below = f'<div class="last-axis" style="height:{100 / count:.3f}%">{limit}</div>'
    names = "".join(
        f"<div><b>{escape(axis.name)}</b><span>{escape(axis.ends[0])}</span><span>{escape(axis.ends[1])}</span></div>"
        for axis in axes
    )
    key = "".join(f'<li><i class="line {kind}"></i>{words}</li>' for kind, words in said.items())
    return (
        f'<div class="parallel" style="--rows:{count}"><div class="axes" aria-hidden="true">{names}</div>'
        f'{plane_html(label, [paths], inside=below, height=ROW * count)}</div><ul class="key">{key}</ul>'
    )


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
        return LineAxis(path, (str(names[0]), str(names[-1])), place / max(names.size - 1, 1))
    low, high = float(column.min()), float(column.max())
    places = (column - low) / (high - low) if high > low else np.full(column.size, 0.5)
    texts = part_words(low, low, high - low), f"{part_words(high, high, high - low)} {unit}".rstrip()
    return LineAxis(path, texts, np.asarray(places, dtype=np.float64))


def metric_axis(one: MetricFigures, others: list[MetricFigures]) -> LineAxis:
    """The metric on the axis that all controllers share; runs that diverged stand at its end."""
    axis, words = values_axis(others), one.words
    lost = np.isposinf(one.badness)
    shares = np.clip(axis.share(words.shown(np.where(lost, np.nan, one.badness))), 0.0, 1.0)
    places = np.where(np.isnan(shares), 1.0 if words.worse > 0 else 0.0, shares)
    return LineAxis(words.title, (f"{axis.low:.3g}", f"{axis.high:.3g} {words.unit}"), places)
