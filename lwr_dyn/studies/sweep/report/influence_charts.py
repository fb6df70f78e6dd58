"""What each parameter does, as HTML: a tornado of quantiles, Sobol indices, how far each goes before a limit breaks."""

from collections.abc import Mapping
from html import escape

import numpy as np

from lwr_dyn.pages.plotting.axes import Axis, axis_of
from lwr_dyn.pages.plotting.charts import tick_marks
from lwr_dyn.studies.sweep.statistics.influence import Influence
from lwr_dyn.studies.sweep.statistics.outwards import FirstBreak, OutwardSearch
from lwr_dyn.studies.sweep.statistics.sobol_indices import SobolIndices
from lwr_dyn.studies.sweep.statistics.summary import TORNADO, MetricFigures
from lwr_dyn.studies.sweep.statistics.summary_tables import part_words
from lwr_dyn.studies.sweep.statistics.summary_words import hundredths, value_text

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
