"""How a metric is distributed over the runs, as HTML: a histogram a controller, and the shares of the worst runs.

What each parameter does, as HTML: a tornado of quantiles, Sobol indices, how far each goes before a limit breaks.

Runs as lines over all parameters at once: parallel coordinates, turned, an axis a row and the metric at the end.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.pages.figures.figure import Axis, axis_of, frequency_axis
from lwr_dyn.pages.plotting.drawn_panel import HEIGHT, WIDTH, marks, tick_marks
from lwr_dyn.studies.sweep.influence import Influence, SobolIndices, is_by_name
from lwr_dyn.studies.sweep.intervals import QuantileEstimate
from lwr_dyn.studies.sweep.outwards import FirstBreak, OutwardSearch
from lwr_dyn.studies.sweep.summary import TORNADO, ControllerFigures, MetricFigures, SweepSummary, draw_columns
from lwr_dyn.studies.sweep.summary_text import hundredths, part_words, percent, quantile_text, value_text
from lwr_dyn.studies.sweep.vocabulary import MetricWords

BINS = 60

POINTS = 240
"""Of a curve."""

WIDE = 20.0
"""A metric that spans more than this factor has a logarithmic axis."""

NEAR = 2.0
"""A limit is inside the axis where it is at most so many times as large as the worst runs drawn."""


def values_axis(figures: Sequence[MetricFigures]) -> Axis:
    """The axis of a metric over all controllers: nearly all runs, and the limit where it is near."""
    words, parts = figures[0].words, []
    for one in figures:
        shown = shown_values(one)
        finite = shown[np.isfinite(shown)]
        parts.append(np.quantile(finite, [0.001, 0.999]) if finite.size else np.array([0.0, 1.0]))
    ends = np.concatenate(parts)
    bound = figures[0].bound
    if bound is not None and np.isfinite(bound):
        limit = words.factor * bound
        if ends.min() / NEAR <= limit <= NEAR * ends.max():
            ends = np.append(ends, [limit, 1.04 * limit])
    if ends.min() > 0.0 and ends.max() > WIDE * ends.min():
        return frequency_axis(ends)
    return axis_of(ends, most=8, padding=0.02)


def shown_values(one: MetricFigures) -> Array:
    """The metric of the runs of the sample (m,) in the unit for people."""
    return np.asarray(one.words.factor * one.words.worse * one.sample)


def same_words(figures: Sequence[MetricFigures]) -> str:
    """In place of a picture, where all runs have one value: that, in a sentence; empty where they differ."""
    first, every = figures[0], np.concatenate([one.sample for one in figures])
    if not np.isfinite(every[0]) or (every != every[0]).any():
        return ""
    of = f"all {every.size} runs" if len(figures) == 1 else f"all {every.size} runs of {len(figures)} controllers"
    bound = "no limit set" if first.bound is None else f"limit {_limit(first)}"
    return f"{value_text(first.words, float(every[0]))} {first.words.unit} in {of}; {bound}."


def _limit(one: MetricFigures) -> str:
    return f"{value_text(one.words, one.words.worse * (one.bound or 0.0))} {one.words.unit}"


def histograms_html(figures: Mapping[str, MetricFigures], inks: Mapping[str, str]) -> str:
    """A row a controller: its histogram over one axis, the limit, and its median and worst quantiles as numbers."""
    axis = values_axis(list(figures.values()))
    rows = "".join(_row(name, one, axis, inks[name]) for name, one in figures.items())
    words = next(iter(figures.values())).words
    return f'<div class="rows">{rows}<div class="row last"><div></div>{_across(axis, words)}<div></div></div></div>'


def _row(name: str, one: MetricFigures, axis: Axis, ink: str) -> str:
    shown = shown_values(one)
    inside = shown[np.isfinite(shown)]
    share = np.asarray(axis.share(inside))
    counts, _ = np.histogram(share, bins=BINS, range=(0.0, 1.0))
    top = max(int(counts.max(initial=0)), 1)
    step = WIDTH / BINS
    steps = "".join(f"V{HEIGHT - round(HEIGHT * c / top)}H{round((k + 1) * step)}" for k, c in enumerate(counts))
    beyond = int((share > 1.0).sum() + np.isposinf(one.sample).sum() + (share < 0.0).sum())
    out = f"<small>{beyond} of {shown.size} beyond the axis</small>" if beyond else ""
    numbers = "".join(f"<li>{_share_name(found.share)} {_value(one, found)}</li>" for found in one.quantiles)
    label = f"Histogram of {one.words.title}, {name}: {shown.size} runs"
    return (
        f'<div class="row {ink}"><div class="who"><i class="sw {ink}"></i>{escape(name)}{out}</div>'
        f'<div class="plane low" role="img" aria-label="{escape(label)}"><svg viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'preserveAspectRatio="none" aria-hidden="true"><path class="bars" d="M0,{HEIGHT}{steps}V{HEIGHT}Z"/></svg>'
        f'{limit_mark(one, axis)}</div><ul class="figures">{numbers}</ul></div>'
    )


def _value(one: MetricFigures, found: QuantileEstimate) -> str:
    value, bracket, interval = quantile_text(one.words, found).partition(" [")
    return f"<b>{escape(value)}</b><small>{escape(bracket.strip() + interval)}</small>"


def _share_name(share: float) -> str:
    return "median" if share == 0.5 else f"{100 * share:g} %"


def limit_mark(one: MetricFigures, axis: Axis) -> str:
    """The limit as a line over a plane; nothing where it is far away or not given."""
    if one.bound is None:
        return ""
    at = float(axis.share(one.words.factor * one.bound))
    return f'<i class="limit" style="left:{100 * at:.2f}%"></i>' if 0.0 <= at <= 1.0 else ""


def limit_words(figures: Sequence[MetricFigures]) -> str:
    """The limit in words, and whether it is drawn."""
    one = figures[0]
    if one.bound is None:
        return "no limit set"
    far = "" if limit_mark(one, values_axis(figures)) else ", beyond the axis"
    return f"limit {_limit(one)}{far}"


def _across(axis: Axis, words: MetricWords) -> str:
    return tick_marks(axis, "xt", "left", words.unit)


def worst_share_html(figures: Mapping[str, MetricFigures], inks: Mapping[str, str], with_interval: bool) -> str:
    """The share of the runs that are worse than a value, logarithmic, and quantiles with their intervals."""
    axis = values_axis(list(figures.values()))
    least = min(1.0 / one.sample.size for one in figures.values())
    up = Axis(least, 1.0, tuple(10.0**-k for k in range(int(-np.log10(least)) + 1)), True)
    lines = "".join(f'<path class="{inks[name]}" d="{_curve(one, axis, up)}"/>' for name, one in figures.items())
    bars = "".join(f'<path class="{inks[name]} bar" d="{_bars(one, axis, up)}"/>' for name, one in figures.items())
    grid = "".join(f"M0,{_down(up, tick)}H{WIDTH}" for tick in up.ticks)
    first = next(iter(figures.values()))
    label = escape(f"{first.words.title}: share of the runs that are worse; {', '.join(figures)}")
    plane = (
        f'<div class="plane" role="img" aria-label="{label}"><svg viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'preserveAspectRatio="none" aria-hidden="true"><path class="grid" d="{grid}"/>'
        f"{bars if with_interval else ''}{lines}</svg>{limit_mark(first, axis)}</div>"
    )
    left = marks([float(up.share(tick)) for tick in up.ticks], [f"{percent(t)} %" for t in up.ticks], "yt", "top")
    names = "".join(f'<li><i class="sw {inks[name]}"></i>{escape(name)}</li>' for name in figures)
    return f'<div class="area">{left}{plane}<div></div>{_across(axis, first.words)}</div><ul class="names">{names}</ul>'


def _down(up: Axis, share: float) -> int:
    return round(HEIGHT * (1.0 - float(up.share(share))))


def _curve(one: MetricFigures, axis: Axis, up: Axis) -> str:
    """From all runs to the worst one: at a value, the share of the runs at least as bad."""
    ordered = np.sort(one.sample)
    n = ordered.size
    index = np.unique(np.rint(n - np.geomspace(1.0, n, POINTS)).astype(int).clip(0, n - 1))
    worse = one.words.worse
    across = np.where(
        np.isposinf(ordered[index]), worse * np.inf, axis.share(one.words.factor * worse * ordered[index])
    )
    shares, end = (n - index) / n, 1.0 if worse > 0 else 0.0
    beyond = np.flatnonzero(worse * (across - end) > 0.0)
    if beyond.size:  # the curve leaves the plane at the share of the runs that are beyond it
        across, shares = across[: beyond[0] + 1], shares[: beyond[0] + 1]
    return "M" + " ".join(
        f"{round(WIDTH * x)},{_down(up, float(y))}" for x, y in zip(across.clip(0.0, 1.0), shares, strict=True)
    )


def _bars(one: MetricFigures, axis: Axis, up: Axis) -> str:
    """The intervals of the quantiles, at the shares that they leave."""
    out = []
    for found in one.quantiles:
        ends = [one.words.factor * one.words.worse * end for end in (found.low, found.high)]
        a, b = (round(WIDTH * float(np.clip(axis.share(end), 0.0, 1.0))) for end in ends)
        down = _down(up, max(1.0 - found.share, up.low))
        out.append(f"M{a},{down}H{b}")
    return "".join(out)


MOST = 10
"""Parameters in a chart; those below have less effect."""


def tornado_html(one: MetricFigures, units: Mapping[str, str]) -> str:
    """A bar a parameter, from the quantile of its best part of the runs to that of its worst; `units` by its name."""
    shown = one.influence[:MOST]
    if not shown:
        return '<p class="note">Too few runs, or nothing varies: no parameter can be judged.</p>'
    words = one.words
    ends = np.array([words.shown(end) for each in shown for end in (_low(each), _high(each))])
    middle = words.shown(next(found.value for found in one.quantiles if found.share == TORNADO))
    axis = axis_of(np.append(ends, middle), most=5)
    rows = "".join(_bar(each, one, axis, units.get(each.path, "")) for each in shown)
    scale = _scale(tick_marks(axis, "xt", "left", words.unit))
    rest = len(one.influence) - len(shown)
    more = f'<p class="note">{rest} more, with less effect.</p>' if rest else ""
    return f'<div class="bars-of tornado" style="--centre:{_percent(axis, middle)}">{rows}{scale}</div>{more}'


def _scale(ticks: str) -> str:
    return f'<div class="bars-scale"><div></div><div class="track">{ticks}</div></div>'


def _low(each: Influence) -> float:
    return each.best.estimate.value


def _high(each: Influence) -> float:
    return each.worst.estimate.value


def _percent(axis: Axis, value: float) -> str:
    return f"{100 * float(np.clip(axis.share(value), 0.0, 1.0)):.2f}%" if not np.isnan(value) else "0%"


def _bar(each: Influence, one: MetricFigures, axis: Axis, unit: str) -> str:
    words = one.words
    a, b = _places(one, axis, _low(each), _high(each))
    c, d = _places(one, axis, each.worst.estimate.low, each.worst.estimate.high)
    rho = (
        ""
        if each.correlation is None
        else f"; rank correlation {hundredths(words.worse * each.correlation.value, '+')}"
    )
    clear = "" if each.is_clear else "; could be chance"
    clear += f"; may be the effect of {', '.join(each.along)}, which it follows in these runs" if each.along else ""
    parts = [
        f"{value_text(words, part.estimate.value)} at {part_words(part.low, part.high, each.extent)} {unit}".rstrip()
        for part in (each.best, each.worst)
    ]
    about = escape(f"{parts[0]}, {parts[1]}{rho}{clear}")
    hollow = "" if each.is_clear else " hollow"
    return (
        f'<div class="bar-row"><div class="what">{escape(each.path)}</div><div class="track">'
        f'<i class="bar{hollow}" style="left:{100 * a:.2f}%;width:{100 * (b - a):.2f}%"></i>'
        f'<i class="whisker" style="left:{100 * c:.2f}%;width:{100 * (d - c):.2f}%"></i></div>'
        f'<div class="about">{about}</div></div>'
    )


def _places(one: MetricFigures, axis: Axis, *ends: float) -> list[float]:
    """Where values of the badness stand on an axis, from the left."""
    return sorted(float(np.clip(axis.share(one.words.shown(end)), 0.0, 1.0)) for end in ends)


def indices_html(found: SobolIndices) -> str:
    """Two bars a parameter: its own share of the variance, and with interactions; each with its interval."""
    order = sorted(found.total, key=lambda path: -found.total[path].value)
    axis = Axis(0.0, 1.0, (0.0, 0.25, 0.5, 0.75, 1.0))
    rows = ""
    for path in order[:MOST]:
        bars, texts = "", []
        for kind, name in (("first", "alone"), ("total", "with interactions")):
            one = getattr(found, kind)[path]
            left, right = (float(np.clip(end, 0.0, 1.0)) for end in (one.low, one.high))
            width = 100 * float(np.clip(one.value, 0.0, 1.0))
            bars += (
                f'<i class="bar {"" if kind == "first" else "hollow "}{kind}" style="left:0;width:{width:.2f}%"></i>'
            )
            bars += f'<i class="whisker {kind}" style="left:{100 * left:.2f}%;width:{100 * (right - left):.2f}%"></i>'
            texts.append(f"{name} {hundredths(one.value)} [{hundredths(one.low)} to {hundredths(one.high)}]")
        about = escape(", ".join(texts))
        rows += f'<div class="bar-row two"><div class="what">{escape(path)}</div><div class="track">{bars}</div>'
        rows += f'<div class="about">{about}</div></div>'
    scale = _scale(tick_marks(axis, "xt", "left"))
    left_out = f", {found.left_out} left out" if found.left_out else ""
    note = f'<p class="note">{found.groups} groups of runs{left_out}; intervals of 95 % by bootstrap.</p>'
    return f'<div class="bars-of">{rows}{scale}</div>{note}'


def outwards_html(search: OutwardSearch) -> str:
    """A gauge a way: how far a parameter alone goes before a limit breaks."""
    if search.at_nominal:
        broken = escape(", ".join(search.at_nominal))
        return f'<p class="note bad">Broken with every parameter at its nominal value: {broken}.</p>'
    rows = "".join(_gauge(line) for line in search.lines if line.share is not None)
    kept = [f"{line.path} to {line.end:.4g}" for line in search.lines if line.share is None]
    said = f"Keep every limit alone: {', '.join(kept)}." if kept else ""
    about = f"{said} {search.runs} runs of their own.".strip()
    return f'<div class="bars-of">{rows}</div><p class="note">{escape(about)}</p>'


def _gauge(line: FirstBreak) -> str:
    share = 100 * (line.share or 0.0)
    ends = f"kept at {line.kept:.4g}, broken at {line.broken:.4g}"
    said = f"{line.metric} {ends}, {share:.0f} % of the way to {line.end:.4g}"
    return (
        f'<div class="bar-row"><div class="what">{escape(line.path)}</div>'
        f'<div class="track"><i class="bar" style="left:0;width:{share:.2f}%"></i>'
        f'<i class="limit" style="left:{share:.2f}%"></i></div><div class="about">{escape(said)}</div></div>'
    )


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
