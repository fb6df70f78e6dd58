"""How a metric is distributed over the runs, as HTML: a histogram a controller, and the shares of the worst runs."""

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.pages.plotting.axes import Axis, axis_of, frequency_axis
from lwr_dyn.pages.plotting.charts import HEIGHT, WIDTH, marks, tick_marks
from lwr_dyn.studies.sweep.statistics.intervals import QuantileEstimate
from lwr_dyn.studies.sweep.statistics.metric_words import MetricWords
from lwr_dyn.studies.sweep.statistics.summary import MetricFigures
from lwr_dyn.studies.sweep.statistics.summary_words import percent, quantile_text, value_text

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
