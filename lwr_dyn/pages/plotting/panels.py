"""One figure's heading and panels, drawn by Matplotlib: names instead of legends, gauges for far limits, scale bars.

Places are in inches: heading, names of the lines, panels with their captions.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lwr_dyn.foundation.number_text import raised, short
from lwr_dyn.pages.figures.figure import Figure, apart, round_length
from lwr_dyn.pages.plotting.drawn_panel import DrawnCurve, DrawnPanel, drawn_panels, widest_first
from lwr_dyn.pages.replay.look import tokens
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

WIDTH = 9.0
"""Of a figure over time or of numbers."""

SQUARE = 5.2
"""Side of a panel whose axes have one scale."""

LETTER = 0.072
"""Width of a letter of a name, about."""

SOFT_LETTER = 0.066
"""Of the lines below the title."""

TITLE, LINE, EDGE = 0.32, 0.2, 0.16

CAPTION, TICKS, LABELS = 0.34, 0.3, 0.55
"""Room above a panel, below it, and at its left."""

_CAPTION: dict[str, Any] = {"y": 1.0, "pad": 9}
"""Where it stands: said, so that Matplotlib does not measure all labels at every drawing to find the same place."""

NO_CAPTION = 0.1
"""Room above a lone panel of which nothing is said."""

_LONGEST_END = 36
"""Letters of a name that may stand at the end of a line."""


@dataclass(frozen=True, slots=True, eq=False)
class FigureLayout:
    """A figure with its panels ready to draw and the room for each part; `names` stand above the panels in rows."""

    figure: Figure
    panels: tuple[DrawnPanel, ...]
    about: tuple[str, ...]
    names: tuple[tuple[DrawnCurve, ...], ...]
    columns: int
    has_ends: bool
    right: float
    width: float
    height: float
    panel_height: float
    caption: float

    @property
    def header(self) -> float:
        """Height of title, explanation and names."""
        lines = len(self.about) + len(self.names)
        return EDGE + TITLE + LINE * lines + 0.06

    def box(self, k: int) -> tuple[float, float, float, float]:
        """Left, bottom, width and height of a panel's axes, as shares of the picture."""
        row, column = places_of(self.panels, self.columns)[k]
        cell = (self.width - self.right - EDGE) / self.columns
        left = EDGE + column * cell + LABELS
        top = self.header + row * (self.caption + self.panel_height + TICKS) + self.caption
        wide = cell - LABELS - EDGE
        bottom = self.height - top - self.panel_height
        return left / self.width, bottom / self.height, wide / self.width, self.panel_height / self.height


def layout_of(figure: Figure, runs: Sequence[ReplayedRun]) -> FigureLayout:
    """The layout of a figure of these runs; raises `OptionError` as `Curve.points`."""
    panels = drawn_panels(figure, runs)
    columns = min(figure.columns, len(panels))
    rows = places_of(panels, columns)[-1][0] + 1
    named = _named(panels)
    ends = len(panels) == 1 and figure.over_time and 1 < len(panels[0].curves) == len(named)
    ends = ends and max(len(one.curve.label) for one in named) <= _LONGEST_END
    right = LETTER * max(len(one.curve.label) for one in named) + 0.1 if ends else 0.0
    width = EDGE + columns * (SQUARE + LABELS + EDGE) if figure.equal_aspect else WIDTH
    tall = SQUARE if figure.equal_aspect else 2.6 if rows == 1 else 1.25 if columns > 1 or rows > 3 else 1.7
    lone = len(named) == 1 and named[0].ink in ("ink", "soft") and not named[0].curve.text
    names = () if ends or lone or not named else _rows(named, width)
    about = tuple(textwrap.wrap(about_text(figure, panels), int((width - 2 * EDGE) / SOFT_LETTER)))
    bare = len(panels) == 1 and not panels[0].panel.title and (figure.equal_aspect or len(panels[0].curves) > 1)
    caption = NO_CAPTION if bare and panels[0].limit is None and not panels[0].far else CAPTION
    laid = FigureLayout(figure, panels, about, names, columns, ends, right, width, 0.0, tall, caption)
    below = LINE if panels[0].magnified > 1 else 0.0
    return replace(laid, height=laid.header + rows * (caption + tall + TICKS) + below + EDGE / 2)


def places_of(panels: Sequence[DrawnPanel], columns: int) -> list[tuple[int, int]]:
    """Row and column of each panel; where the first title comes again (joints of another run), a row begins."""
    first, places = panels[0].panel.title, list[tuple[int, int]]()
    row, column = 0, 0
    for k, one in enumerate(panels):
        if column == columns or (k > 0 and first and one.panel.title == first):
            row, column = row + 1, 0
        places.append((row, column))
        column += 1
    return places


def about_text(figure: Figure, panels: Sequence[DrawnPanel]) -> str:
    """What is drawn and in which units, once for all panels; that an axis is logarithmic, errors are enlarged."""
    units = {(one.panel.y_label, one.panel.y_unit) for one in panels}
    parts = [figure.where] if figure.where else []
    if figure.equal_aspect:
        parts += [f"{panels[0].panel.y_label} over {_with_unit(figure.x_label, figure.x_unit)}"]
    else:
        parts += [_with_unit(*next(iter(units)))] if len(units) == 1 else []
        parts += [] if figure.over_time else [f"over {_with_unit(figure.x_label, figure.x_unit)}"]
    parts += ["logarithmic"] if panels[0].y.is_logarithmic else []
    parts += [f"errors drawn {panels[0].magnified} times as large"] if panels[0].magnified > 1 else []
    return raised("; ".join([*parts, *([figure.note] if figure.note else [])]))


def _with_unit(label: str, unit: str) -> str:
    return f"{label}, {unit}" if unit else label


def _named(panels: Sequence[DrawnPanel]) -> list[DrawnCurve]:
    """One curve for each name and colour."""
    found = {(one.ink, one.curve.label): one for panel in reversed(panels) for one in reversed(panel.curves)}
    return list(reversed(found.values()))


def _rows(named: Sequence[DrawnCurve], width: float) -> tuple[tuple[DrawnCurve, ...], ...]:
    rows: list[list[DrawnCurve]] = [[]]
    for one in named:
        if rows[-1] and sum(map(name_width, [*rows[-1], one])) > width - 2 * EDGE:
            rows.append([])
        rows[-1].append(one)
    return tuple(map(tuple, rows))


def name_width(one: DrawnCurve) -> float:
    """Room of a name with its mark."""
    return 0.55 + LETTER * len(one.curve.label)


_NAMES_APART, _CROWDED = 0.075, 0.06
"""Least distance of names at the ends of lines; a point so near below another one has its name below. Both are shares
of the panel."""


def colour_of(ink: str) -> str:
    """The colour of a curve: "r1" to "r5" are those of runs, others are tokens."""
    return tokens()[f"run{ink[1]}" if ink[:1] == "r" and ink[1:].isdigit() else ink]


def _name_colour(ink: str) -> str:
    """The colour of a curve's name: pale curves have theirs in ink."""
    return colour_of("ink" if ink in ("ref", "soft", "r5") else ink)


def draw_header(place: SubFigure, laid: FigureLayout) -> None:
    """Title, what is drawn, and the names of the lines."""
    down = EDGE + 0.5 * TITLE
    place.text(
        EDGE / laid.width, 1.0 - down / laid.height, laid.figure.title, fontsize=12.5, fontweight=600, va="center"
    )
    down += 0.5 * TITLE + 0.5 * LINE
    for text in laid.about:
        at = EDGE / laid.width, 1.0 - down / laid.height
        place.text(*at, text, color=tokens()["soft"], fontsize=9.5, va="center")
        down += LINE
    for row in laid.names:
        _draw_names(place, laid, row, 1.0 - down / laid.height)
        down += LINE


def _draw_names(place: SubFigure, laid: FigureLayout, row: tuple[DrawnCurve, ...], y: float) -> None:
    from matplotlib.lines import Line2D

    left = EDGE
    for one in row:
        mark = [(left + 0.02) / laid.width, (left + 0.26) / laid.width]
        if one.curve.style == "points":
            mark = [sum(mark) / 2]
        place.add_artist(Line2D(mark, [y] * len(mark), transform=place.transSubfigure, **_look(one)))
        name = place.text((left + 0.34) / laid.width, y, one.curve.label, color=_name_colour(one.ink), va="center")
        name.set_fontweight(600)
        left += name_width(one)


def draw_panel(place: SubFigure, laid: FigureLayout, k: int) -> None:
    """The panel `k` of a figure at its place."""
    one, figure = laid.panels[k], laid.figure
    axes: Axes = place.add_axes(laid.box(k))
    for side in axes.spines.values():
        side.set_visible(False)
    _set_axes(axes, laid, one)
    for c, drawn in enumerate(one.curves):
        _draw_curve(axes, drawn, f"{figure.id or 'figure'}-{k}-{c}", widest_first(one).index(drawn))
    _draw_levels(axes, one)
    caption = one.panel.title or ("" if figure.equal_aspect or laid.about else one.panel.y_label)
    axes.set_title(caption, **_CAPTION, loc="left", fontsize=9.5, fontweight=600)
    _draw_fact(axes, laid, one)
    if laid.has_ends:
        _draw_ends(axes, one)
    if one.magnified > 1:
        _draw_scale_bars(axes, one)


def _set_axes(axes: Axes, laid: FigureLayout, one: DrawnPanel) -> None:
    axes.set_xlim(one.x.low, one.x.high)
    axes.set_ylim(one.y.low, one.y.high)
    if one.x.is_logarithmic:
        axes.set_xscale("log")
    if one.y.is_logarithmic:
        axes.set_yscale("log")
    if one.magnified > 1:
        axes.set_axis_off()
        return
    labels = list(one.x.labels)
    labels[-1] += f" {laid.figure.x_unit}" if laid.figure.x_unit else ""
    axes.set_xticks(one.x.ticks, labels)
    axes.set_yticks(one.y.ticks, one.y.labels)
    axes.minorticks_off()
    if one.y.power:
        power = short(10.0**one.y.power) if abs(one.y.power) > 4 else f"{10.0**one.y.power:g}"
        at: dict[str, Any] = {"xycoords": "axes fraction", "xytext": (-4, 0), "textcoords": "offset points"}
        at |= {"ha": "right", "va": "center", "fontsize": 8.5, "color": tokens()["soft"]}
        axes.annotate(f"\u00d7 {power}", (0.0, 1.0), **at)
    axes.tick_params(length=0, labelsize=8.5, pad=4)
    axes.grid(axis="both" if laid.figure.equal_aspect else "y", color=tokens()["line"], linewidth=0.7)
    zero: dict[str, Any] = {"color": tokens()["zero"], "linewidth": 0.8, "zorder": 0.9}
    if not one.y.is_logarithmic and one.y.low <= 0.0 <= one.y.high:
        axes.axhline(0.0, **zero)
    if not laid.figure.over_time and one.x.low <= 0.0 <= one.x.high:
        axes.axvline(0.0, **zero)


def _look(one: DrawnCurve) -> dict[str, Any]:
    """How a curve is drawn: a reference as a broad pale band, below all others."""
    if one.ink == "ref":
        return {"color": colour_of("ref"), "linewidth": 4.5, "linestyle": "-", "solid_capstyle": "round"}
    line = "None" if one.curve.style == "points" else "--" if one.curve.dashed else "-"
    look = {"color": colour_of(one.ink), "linestyle": line}
    return look | ({} if one.curve.style == "line" else {"marker": "o"})


def _draw_curve(axes: Axes, one: DrawnCurve, name: str, order: int) -> None:
    if one.curve.is_filled:
        axes.fill(one.x, one.y, color=colour_of(one.ink), alpha=0.12, linewidth=0.0)
    (line,) = axes.plot(one.x, one.y, label=one.curve.label, zorder=2.0 + 0.01 * order, **_look(one))
    line.set_gid(name)  # names the curve in SVG
    if not one.curve.text:
        return
    to_share = axes.transData + axes.transAxes.inverted()
    points = [(float(x), float(y)) for x, y in to_share.transform(np.column_stack([one.x, one.y]))]
    for k, text in enumerate(one.curve.text):
        near = [p for p in points if p != points[k] and np.hypot(p[0] - points[k][0], p[1] - points[k][1]) < _CROWDED]
        below = any(p[1] > points[k][1] for p in near)
        words: dict[str, Any] = {"textcoords": "offset points", "fontsize": 8.5, "va": "top" if below else "bottom"}
        axes.annotate(text, (float(one.x[k]), float(one.y[k])), xytext=(5, -3 if below else 3), **words)


def _draw_levels(axes: Axes, one: DrawnPanel) -> None:
    style: dict[str, Any] = {"color": tokens()["soft"], "linewidth": 0.9, "linestyle": (0, (4, 3))}
    name: dict[str, Any] = {"color": tokens()["soft"], "fontsize": 8.5, "textcoords": "offset points"}
    for level in one.levels:
        if level.axis == "y":
            axes.axhline(level.value, **style)
            above = float(one.y.share(level.value)) < 0.5
            at: dict[str, Any] = {"xytext": (-3, 3 if above else -3), "va": "bottom" if above else "top", "ha": "right"}
            axes.annotate(level.label, (1.0, level.value), xycoords=("axes fraction", "data"), **at, **name)
        else:
            axes.axvline(level.value, **style)
            at = {"xytext": (3, -3), "va": "top", "ha": "left"}
            axes.annotate(level.label, (level.value, 1.0), xycoords=("data", "axes fraction"), **at, **name)


def _draw_fact(axes: Axes, laid: FigureLayout, one: DrawnPanel) -> None:
    """At the right of the caption: the peak, and of a limit that is far away the share as a gauge."""
    words = fact_text(laid, one)
    broken = one.limit is not None and one.peak > one.limit * (1.0 + 1e-9)
    colour = tokens()["alarm" if broken else "soft"]
    axes.set_title(words, **_CAPTION, loc="right", fontsize=8.5, color=colour)
    if one.limit is None or not one.limit:
        return
    for share, token in ((1.0, "grid"), (min(one.peak / one.limit, 1.0), "alarm" if broken else "soft")):
        axes.add_patch(_rectangle((0.0, 1.03), share, 0.04 / (laid.panel_height), tokens()[token], axes.transAxes))


def _rectangle(corner: tuple[float, float], width: float, height: float, colour: str, transform: Any) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle(corner, width, height, facecolor=colour, linewidth=0.0, clip_on=False, transform=transform)


def fact_text(laid: FigureLayout, one: DrawnPanel) -> str:
    """The peak of a panel over time with its limit, and levels that are too far away to be drawn."""
    own_unit = len({(each.panel.y_label, each.panel.y_unit) for each in laid.panels}) > 1
    unit = f" {one.panel.y_unit}" if own_unit or one.limit is not None else ""
    parts = [f"{level.label} {short(level.value)}" for level in one.far if one.limit is None]
    parts += [one.panel.note] if one.panel.note and one.limit is None else []
    followed = any(drawn.ink == "ref" for drawn in one.curves)
    lone = not followed and (len(laid.panels) > 1 or len(one.curves) == 1)
    if laid.figure.over_time and (lone or one.limit is not None):
        of = f" of {short(one.limit)}" if one.limit is not None else ""
        parts.insert(0, f"peak {short(one.peak)}{of}{unit}")
    return raised("; ".join(parts))


def _draw_ends(axes: Axes, one: DrawnPanel) -> None:
    """The names of lines at their ends, moved apart where they would touch."""
    ends = sorted((float(one.y.share(float(c.y[-1]))), c.ink, c.curve.label) for c in one.curves)
    for at, (_, ink, label) in zip(apart([end[0] for end in ends], _NAMES_APART), ends, strict=True):
        axes.text(1.012, at, label, color=_name_colour(ink), fontweight=600, va="center", transform=axes.transAxes)


def _draw_scale_bars(axes: Axes, one: DrawnPanel) -> None:
    """A length of the path, and one of its errors, below the panel."""
    whole = one.x.high - one.x.low
    for y, what, factor in ((-0.035, "path", 1), (-0.035 - 0.04, "errors", one.magnified)):
        length = round_length(0.22 * whole / factor)
        share = factor * length / whole
        axes.add_patch(_rectangle((0.0, y), share, 0.006, tokens()["soft"], axes.transAxes))
        text = f"{what}: {short(1e3 * length)} mm"
        axes.text(share + 0.02, y, text, color=tokens()["soft"], fontsize=9, va="center", transform=axes.transAxes)
