"""A figure with one panel as HTML: lines are SVG that stretches with the page, every text is text of the page."""

from collections.abc import Sequence
from html import escape

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.pages.plotting.axes import Axis, apart, round_length, short
from lwr_dyn.pages.plotting.drawn_panel import DrawnCurve, DrawnPanel, drawn_panels, run_ink, widest_first
from lwr_dyn.pages.replay.figures import Figure
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun

WIDTH, HEIGHT = 2000, 1000
"""Of the plane of the lines, in its own units."""
POINTS = 400
"""Stretches of a line; of each its lowest and highest point are drawn."""
_APART = 0.09
"""Least distance of names at the ends of lines, of the plane's height."""


def chart_html(figure: Figure, runs: Sequence[ReplayedRun]) -> str:
    """A figure with its heading, axes, lines and the names of the lines."""
    (panel,) = drawn_panels(figure, runs)
    about = [panel.panel.y_unit] if figure.over_time else [_errors(panel)]
    about += ["logarithmic"] if panel.y.is_logarithmic else []
    head = f"<figcaption><h3>{escape(figure.title)} <small>{escape(', '.join(about))}</small></h3></figcaption>"
    lines = "".join(f'<path class="{one.ink}" d="{_line(panel, one)}"/>' for one in widest_first(panel))
    label = escape(_description(figure, panel))
    plane = (
        f'<div class="plane" role="img" aria-label="{label}"><svg viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'preserveAspectRatio="none" aria-hidden="true">{_grid(panel) if figure.over_time else ""}{lines}</svg></div>'
    )
    if not figure.over_time:
        return f'<figure class="path">{head}{plane}{_scale(panel)}</figure>'
    up, across = tick_marks(panel.y, "yt", "top"), tick_marks(panel.x, "xt", "left", "s")
    return f'<figure>{head}<div class="area">{up}{plane}{_ends(panel)}{across}</div>{_names(panel)}</figure>'


def swatch(run: ReplayedRun) -> str:
    """A run's colour, before its name."""
    return f'<i class="sw {run_ink(run)}"></i>'


def _errors(panel: DrawnPanel) -> str:
    return f"errors \u00d7 {panel.magnified}" if panel.magnified > 1 else "true to scale"


def _line(panel: DrawnPanel, one: DrawnCurve) -> str:
    keep = _extremes(one.y) | _extremes(one.x)
    across = np.rint(WIDTH * panel.x.share(one.x[keep])).astype(int)
    down = np.rint(HEIGHT * (1.0 - panel.y.share(one.y[keep]))).astype(int)
    return "M" + " ".join(f"{a},{b}" for a, b in zip(across.tolist(), down.tolist(), strict=True))


def _extremes(values: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """The points (k,) to draw: the ends, and of each stretch the lowest and the highest."""
    keep = np.zeros(values.size, dtype=bool)
    keep[[0, -1]] = True
    for part in np.array_split(np.arange(values.size), min(POINTS, values.size)):
        keep[[part[np.argmin(values[part])], part[np.argmax(values[part])]]] = True
    return keep


def _grid(panel: DrawnPanel) -> str:
    downs = [round(HEIGHT * (1.0 - float(panel.y.share(tick)))) for tick in panel.y.ticks]
    return f'<path class="grid" d="{"".join(f"M0,{down}H{WIDTH}" for down in downs)}"/>'


def tick_marks(axis: Axis, kind: str, side: str, unit: str = "") -> str:
    """The ticks of an axis as texts at the "left" or "top" side of their places; `kind` is their class."""
    labels = list(axis.labels)
    labels[-1] += f" {unit}" if unit else ""
    return marks([float(axis.share(tick)) for tick in axis.ticks], labels, kind, side)


def marks(places: Sequence[float], labels: Sequence[str], kind: str, side: str) -> str:
    """Texts at shares of an axis, from its left or from its lower end."""
    shares = places if side == "left" else [1.0 - place for place in places]
    spans = "".join(
        f'<span style="{side}:{100 * at:.1f}%">{escape(text)}</span>' for at, text in zip(shares, labels, strict=True)
    )
    return f'<div class="{kind}" aria-hidden="true">{spans}</div>'


def _ends(panel: DrawnPanel) -> str:
    """The names of lines at their ends, moved apart where they would overlap."""
    ends = sorted((1.0 - float(panel.y.share(float(one.y[-1]))), one.ink, one.curve.label) for one in panel.curves)
    names = "".join(
        f'<span style="top:{100 * at:.1f}%"><i class="sw {ink}"></i>{escape(label)}</span>'
        for at, (_, ink, label) in zip(apart([end[0] for end in ends], _APART), ends, strict=True)
    )
    return f'<div class="ends">{names}</div>'


def _names(panel: DrawnPanel) -> str:
    items = "".join(f'<li><i class="sw {one.ink}"></i>{escape(one.curve.label)}</li>' for one in panel.curves)
    return f'<ul class="names">{items}</ul>'


def _scale(panel: DrawnPanel) -> str:
    """A length on the path, and a length of its errors."""
    whole = panel.x.high - panel.x.low
    items = []
    for what, factor in (("path", 1), ("error", panel.magnified))[: 1 + (panel.magnified > 1)]:
        length = round_length(0.25 * whole / factor)
        bar = f'<i style="width:{100 * factor * length / whole:.2f}%"></i>'
        items.append(f"<li>{bar}{what} {short(1e3 * length)} mm</li>")
    return f'<ul class="scale">{"".join(items)}</ul>'


def _description(figure: Figure, panel: DrawnPanel) -> str:
    if not figure.over_time:
        return f"{figure.title}, {_errors(panel)}: {', '.join(one.curve.label for one in panel.curves)}"
    said = [f"{one.curve.label} at most {short(float(one.y.max()))} {panel.panel.y_unit}" for one in panel.curves]
    return f"{figure.title}: {'; '.join(said)}"
