"""A figure as HTML: a grid of small panels, each with its own axes; lines are SVG, every text is text of the page."""

from collections.abc import Sequence

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.number_text import power_of_ten, raised, short
from lwr_dyn.pages.figures.figure import Axis, Figure, Level, apart, round_length
from lwr_dyn.pages.markup import Html, anchor, element, joined
from lwr_dyn.pages.plotting.drawn_panel import DrawnCurve, DrawnPanel, drawn_panels, widest_first
from lwr_dyn.pages.plotting.line_plane import HEIGHT, WIDTH, grid_path, plane_svg, tick_marks
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun

TOLERANCE = 1.5
"""Largest distance between a curve and its drawn path, in these units: half a pixel."""


def line_path(x: Axis, y: Axis, points: tuple[Array, Array]) -> str:
    """The path of a curve: straight pieces, gaps where there is no number."""
    placed = _placed(x, y, points)
    finite = np.isfinite(placed).all(axis=1)
    pieces = []
    for part in np.split(placed, np.flatnonzero(np.diff(finite)) + 1):
        if not np.isfinite(part[0]).all():
            continue
        written = np.rint(simplified(part, TOLERANCE)).astype(int)
        fresh = np.concatenate([[True], (np.diff(written, axis=0) != 0).any(axis=1)])
        pieces.append("M" + " ".join(f"{a},{b}" for a, b in written[fresh].tolist()))
        if fresh.sum() == 1:
            pieces[-1] += "h0"
    return "".join(pieces)


def dots_path(x: Axis, y: Axis, points: tuple[Array, Array]) -> str:
    """The path of single points: pieces without length, which a round line end makes dots."""
    placed = np.rint(_placed(x, y, points))
    return "".join(f"M{a:.0f},{b:.0f}h0" for a, b in placed if np.isfinite(a + b))


def _placed(x: Axis, y: Axis, points: tuple[Array, Array]) -> Array:
    """Points in the units of the plane, (k, 2)."""
    return np.column_stack([WIDTH * x.share(points[0]), HEIGHT * (1.0 - y.share(points[1]))])


def simplified(points: Array, tolerance: float) -> Array:
    """The fewest of the points (k, 2), in their order, from whose path none is farther than about `tolerance`.

    References
    ----------
    Douglas and Peucker, "Algorithms for the reduction of the number of points required to represent a digitized line",
    Cartographica 10 (1973).

    >>> simplified(np.array([[0.0, 0.0], [1.0, 0.01], [2.0, 0.0], [2.0, 5.0]]), 0.1).tolist()
    [[0.0, 0.0], [2.0, 0.0], [2.0, 5.0]]
    """
    kept = np.zeros(len(points), dtype=bool)
    kept[[0, -1]] = True
    stretches = [(0, len(points) - 1)]
    while stretches:
        first, last = stretches.pop()
        if last - first < 2:
            continue
        away = _distances(points[first : last + 1])
        worst = int(away.argmax())
        if away[worst] > tolerance:
            kept[first + worst] = True
            stretches += [(first, first + worst), (first + worst, last)]
    return points[kept]


def _distances(points: Array) -> Array:
    """Of points (k, 2) from the piece between the first and the last."""
    start, along = points[0], points[-1] - points[0]
    offset = points - start
    square = float(along @ along)
    if square == 0.0:
        return np.asarray(np.hypot(*offset.T))
    part = np.clip(offset @ along / square, 0.0, 1.0)
    return np.asarray(np.hypot(*(offset - part[:, None] * along).T))


_MOST_COLUMNS = 7
"""In a row where there is room stand the most panels that fill whole rows."""

_WIDE_NAME, _HIGH_NAME = 20.0, 5.0
"""Percent of the plane that the name of a point takes."""

_APART = 0.085
"""Least distance of names at the ends of lines, of the plane's height."""


def figure_html(figure: Figure, runs: Sequence[ReplayedRun] = ()) -> Html:
    """A figure with its heading; the scripts add cursors, dots and zoom. Raises `OptionError` as `Curve.points`."""
    panels, name = drawn_panels(figure, runs), anchor("plot", figure.id)
    units = {(one.panel.y_label, one.panel.y_unit) for one in panels}
    what = [_with_unit(*next(iter(units)))] if len(units) == 1 and not figure.equal_aspect else []
    what += ["logarithmic"] if panels[0].y.is_logarithmic else []
    what += [f"errors \u00d7 {panels[0].magnified}"] if panels[0].magnified > 1 else []
    if not (figure.over_time or figure.equal_aspect):
        what += [f"over {_with_unit(figure.x_label, figure.x_unit)}"]
    what += [raised(figure.note)] if figure.note else []
    ends = len(panels) == 1 and figure.over_time and len(panels[0].curves) > 1
    title = [figure.title, element("small", figure.where) if figure.where else None]
    head = element(
        "figcaption",
        element("h3", title, id=name),
        element("p", "; ".join(what), class_="about") if what else None,
        None if ends else _legend(panels),
    )
    shown = [_panel_html(figure, one, len(units) > 1, ends) for one in panels]
    most = min(len(panels), _MOST_COLUMNS)
    columns = next((n for n in range(_MOST_COLUMNS, 2, -1) if len(panels) % n == 0), most)
    kind = "paths" if figure.equal_aspect else "times" if figure.over_time else "maps"
    return element(
        "figure",
        head,
        element("div", shown, class_="panels", style=f"--n:{columns}"),
        class_=f"box chart {kind} {'single' if len(panels) == 1 else 'many'}",
        data_plot=figure.id,
        aria_labelledby=name,
    )


def _with_unit(label: str, unit: str) -> str:
    return f"{label}, {raised(unit)}" if unit else label


def _legend(panels: Sequence[DrawnPanel]) -> Html | None:
    """Names with the colours of their lines, each once; none where a single line needs no name."""
    named = {(one.ink, one.curve.label): one for panel in panels for one in panel.curves if not one.curve.text}
    if len(named) == 1 and next(iter(named))[0] in ("ink", "soft"):
        return None
    items = [element("li", element("i", class_=f"sw {_ink(one)}"), label) for (_, label), one in named.items()]
    return element("ul", items, class_="names")


def _ink(one: DrawnCurve) -> str:
    return f"{one.ink} dashed" if one.curve.dashed and one.ink != "ref" else one.ink


def _panel_html(figure: Figure, one: DrawnPanel, own_units: bool, ends: bool) -> Html:
    caption = element(
        "p",
        element("b", one.panel.title or (one.panel.y_label if own_units else "")),
        element("span", _fact(figure, one, own_units), class_="fact"),
        element("output", class_="now"),
        class_="cap",
    )
    plane = element(
        "div",
        plane_svg([_levels(one), *(_curve_path(one, curve) for curve in widest_first(one))], class_="lines"),
        [_level_name(one, level) for level in one.levels],
        _point_names(one),
        class_="plane",
        role="img",
        aria_label=_description(figure, one),
        data_x=f"{one.x.low!r} {one.x.high!r}",
        data_y=f"{one.y.low!r} {one.y.high!r}",
        data_log=one.y.is_logarithmic,
        data_magnified=one.magnified if one.magnified > 1 else None,
    )
    if one.magnified > 1:
        drawn = [element("div", plane, class_="area bare"), _scale_bars(one)]
    else:
        power = element("span", f"\u00d7{power_of_ten(one.y.power)}", class_="power") if one.y.power else ""
        every = 2 if len(figure.panels) > 3 and len(one.x.ticks) > 3 else 1  # so many have room below small panels
        up = tick_marks(one.y, "yt", "top", before=power)
        across = tick_marks(one.x, "xt", "left", raised(figure.x_unit), every)
        drawn = [element("div", up, plane, across, _end_names(one) if ends else None, class_="area")]
    return element("div", caption, drawn, _gauge(one), class_="panel")


def _fact(figure: Figure, one: DrawnPanel, own_units: bool) -> str:
    if figure.equal_aspect or not figure.over_time or len(figure.panels) == 1:
        return ""
    unit = f" {raised(one.panel.y_unit)}" if own_units and one.panel.y_unit else ""
    limit = "" if one.limit is None else f" of {short(one.limit)}"
    return f"peak {short(one.peak)}{limit}{unit}"


def _gauge(one: DrawnPanel) -> Html | None:
    """The share of the limit that is used, where the limit is far beyond the axis; other far levels in words."""
    if one.limit is not None:
        share = 100.0 * one.peak / one.limit if one.limit else 0.0
        broken = " alarm" if share > 100.0 + 1e-6 else ""
        bar = element("div", element("u", style=f"width:{min(share, 100.0):.1f}%"), class_=f"gauge{broken}")
        words = "below 1 %" if share < 1.0 else f"{share:.2g} %" if share < 99.5 else f"{share:.0f} %"
        return joined([bar, element("p", f"{words} of the limit", class_="share")])
    texts = [f"{level.label}: {short(level.value)}" for level in one.far]
    note = [one.panel.note] if one.panel.note and not one.panel.levels else []
    return element("p", "; ".join([*note, *texts]), class_="share") if note or texts else None


def _curve_path(one: DrawnPanel, drawn: DrawnCurve) -> str:
    curve, points = drawn.curve, (drawn.x, drawn.y)
    place = one.curves.index(drawn)
    out = ""
    if curve.is_filled:
        out += f'<path class="fill {drawn.ink}" d="{line_path(one.x, one.y, points)}Z"/>'
    if curve.style != "points":
        out += f'<path class="l {_ink(drawn)}" data-c="{place}" d="{line_path(one.x, one.y, points)}"/>'
    if curve.style != "line":
        out += f'<path class="dots {drawn.ink}" d="{dots_path(one.x, one.y, points)}"/>'
    return out


def _levels(one: DrawnPanel) -> str:
    """Grid, zero and levels."""
    out = grid_path(None, one.y) if one.magnified == 1 else ""
    if one.magnified == 1 and not one.y.is_logarithmic and one.y.low < 0.0 < one.y.high:
        out += f'<path class="zero" d="M0,{round(HEIGHT * (1.0 - float(one.y.share(0.0))))}H{WIDTH}"/>'
    for level in one.levels:
        at = float((one.y if level.axis == "y" else one.x).share(level.value))
        line = f"M0,{HEIGHT * (1.0 - at):.0f}H{WIDTH}" if level.axis == "y" else f"M{WIDTH * at:.0f},0V{HEIGHT}"
        out += f'<path class="level" d="{line}"/>'
    return out


def _level_name(one: DrawnPanel, level: Level) -> Html:
    at = float((one.y if level.axis == "y" else one.x).share(level.value))
    if level.axis == "y":
        side = "below" if at > 0.5 else "above"
        return element("span", level.label, class_=f"level-name {side}", style=f"top:{100 * (1 - at):.1f}%")
    return element("span", level.label, class_="level-name across", style=f"left:{100 * at:.1f}%")


def _point_names(one: DrawnPanel) -> list[Html]:
    """Names beside their points; below where another name is."""
    out, taken = list[Html](), list[tuple[float, float]]()
    for drawn in one.curves:
        for name, x, y in zip(drawn.curve.text, drawn.x, drawn.y, strict=False):
            left, top = 100 * float(one.x.share(x)), 100 * (1 - float(one.y.share(y)))
            while any(abs(left - a) < _WIDE_NAME and abs(top - b) < _HIGH_NAME for a, b in taken):
                top += 0.5 * _HIGH_NAME
            taken.append((left, top))
            out.append(element("span", name, class_="point-name", style=f"left:{left:.1f}%;top:{top:.1f}%"))
    return out


def _end_names(one: DrawnPanel) -> Html:
    """The names of lines at their ends, moved apart where they would overlap."""
    ends = sorted((1.0 - float(one.y.share(float(c.y[-1]))), c.ink, c.curve.label) for c in one.curves)
    names = [
        element("span", label, class_=f"end {ink}", style=f"top:{100 * at:.1f}%")
        for at, (_, ink, label) in zip(apart([end[0] for end in ends], _APART), ends, strict=True)
    ]
    return element("div", names, class_="ends")


def _scale_bars(one: DrawnPanel) -> Html:
    """One bar for a length on the path and for the tenth (hundredth, ...) of it, a length of its errors."""
    whole = one.x.high - one.x.low
    length = round_length(0.3 * whole)
    text = f"path {short(1e3 * length)} mm, error {short(1e3 * length / one.magnified)} mm"
    return element("div", element("i", style=f"width:{100 * length / whole:.2f}%"), text, class_="scale")


def _description(figure: Figure, one: DrawnPanel) -> str:
    """What the panel shows, in words."""
    unit = f" {raised(one.panel.y_unit)}" if one.panel.y_unit else ""
    name = ", ".join(text for text in (one.panel.title, one.panel.y_label) if text)
    if figure.equal_aspect:
        return f"{name or figure.title}: " + ", ".join(dict.fromkeys(c.curve.label for c in one.curves))
    known = ((c.curve.label, c.y[c.y == c.y]) for c in one.curves)
    said = [f"{label} from {short(float(y.min()))} to {short(float(y.max()))}{unit}" for label, y in known]
    return f"{name}: {'; '.join(said)}"
