"""A plane of lines and dots as HTML: SVG that stretches with the page, every text is text of the page."""

from collections.abc import Sequence
from html import escape

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.pages.figures.figure import Axis
from lwr_dyn.pages.markup import Html

WIDTH, HEIGHT = 2000, 1000
"""Of the plane, in its own units; a page shows it 150 to 600 px wide."""

POINTS = 500
"""Stretches of a line; of each its lowest and its highest point are drawn."""


def line_path(x: Array, y: Array, across: Axis, up: Axis, kind: str, points: int = POINTS) -> str:
    """A line through (k,) points, with a gap where y is not finite; empty where nothing is to be drawn.

    `kind` is its class; a long line is cut into `points` stretches.
    """
    finite = np.isfinite(y)
    if not finite.any():
        return ""
    keep = finite & extremes(np.where(finite, y, np.nan), points)
    part_of = np.cumsum(finite & np.concatenate([[True], ~finite[:-1]]))[keep]
    steps, before = [], 0
    for (a, b), part in zip(places(x[keep], y[keep], across, up), part_of.tolist(), strict=True):
        steps.append(f"{'M' if part != before else ''}{a},{b}")
        before = part
    return f'<path class="{kind}" d="{" ".join(steps)}"/>'


def band_path(x: Array, low: Array, high: Array, across: Axis, up: Axis, kind: str) -> str:
    """What lies between two lines (k,), as a filled shape."""
    edge = [*places(x, low, across, up), *reversed(places(x, high, across, up))]
    return f'<path class="{kind}" d="M{" ".join(f"{a},{b}" for a, b in edge)}Z"/>'


def dots_path(x: Array, y: Array, across: Axis, up: Axis, kind: str) -> str:
    """Dots (k,): strokes of no length, which a round line cap makes visible."""
    inside = (x >= across.low) & (x <= across.high) & (y >= up.low) & (y <= up.high)
    dots = "".join(f"M{a},{b}h0" for a, b in places(x[inside], y[inside], across, up))
    return f'<path class="{kind}" d="{dots}"/>' if dots else ""


def grid_path(across: Axis | None, up: Axis | None) -> str:
    """Lines at the ticks of the axes that are given."""
    lines = "" if up is None else "".join(f"M0,{round(HEIGHT * (1.0 - float(up.share(t))))}H{WIDTH}" for t in up.ticks)
    if across is not None:
        lines += "".join(f"M{round(WIDTH * float(across.share(tick)))},0V{HEIGHT}" for tick in across.ticks)
    return f'<path class="grid" d="{lines}"/>'


def plane_html(label: str, paths: Sequence[str], kind: str = "", inside: str = "", height: int = HEIGHT) -> str:
    """The plane with its paths, and marks `inside` above them; `label` is what it shows, in words."""
    classes = f"plane {kind}".strip()
    return f'<div class="{classes}" role="img" aria-label="{escape(label)}">{plane_svg(paths, height)}{inside}</div>'


def plane_svg(paths: Sequence[str], height: int = HEIGHT, **attributes: str) -> Html:
    """The paths alone, as SVG; `attributes` as `element` takes them."""
    box = f'viewBox="0 0 {WIDTH} {height}" preserveAspectRatio="none"'
    given = "".join(f'{name.rstrip("_")}="{text}" ' for name, text in attributes.items())
    return Html(f'<svg {given}{box} aria-hidden="true">{"".join(paths)}</svg>')


def tick_marks(axis: Axis, kind: str, side: str, unit: str = "", every: int = 1, before: str = "") -> Html:
    """The ticks of an axis, or one of `every` so many, as texts at the "left" or "top" side of their places.

    `kind` is their class; the last one has the unit; `before` is HTML that stands before them.
    """
    labels = list(axis.labels)
    labels[-1] += f" {unit}" if unit else ""
    shares = [float(axis.share(tick)) for tick in axis.ticks]
    return marks(shares[::every], labels[::every], kind, side, before)


def marks(places: Sequence[float], labels: Sequence[str], kind: str, side: str, before: str = "") -> Html:
    """Texts at shares of an axis, from its left or from its lower end."""
    shares = places if side == "left" else [1.0 - place for place in places]
    spans = "".join(
        f'<span style="{side}:{100 * at:.1f}%">{escape(text)}</span>' for at, text in zip(shares, labels, strict=True)
    )
    return Html(f'<div class="{kind}" aria-hidden="true">{before}{spans}</div>')


def places(x: Array, y: Array, across: Axis, up: Axis) -> list[tuple[int, int]]:
    """Points (k,) in the units of the plane, from its upper left corner."""
    a = np.rint(WIDTH * across.share(x)).astype(int)
    b = np.rint(HEIGHT * (1.0 - up.share(y))).astype(int)
    return list(zip(a.tolist(), b.tolist(), strict=True))


def extremes(values: Array, points: int) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """The points (k,) to draw: the ends, and of each stretch the lowest and the highest."""
    keep = np.zeros(values.size, dtype=bool)
    keep[[0, -1]] = True
    for part in np.array_split(np.arange(values.size), min(points, values.size)):
        inside = part[np.isfinite(values[part])]
        if inside.size:
            keep[[inside[np.argmin(values[inside])], inside[np.argmax(values[inside])]]] = True
    return keep
