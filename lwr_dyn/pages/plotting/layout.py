"""Where the parts of a figure stand on its picture [inch]: heading, names of the lines, panels with their captions."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace

from lwr_dyn.pages.plotting.axes import raised
from lwr_dyn.pages.plotting.drawn_panel import DrawnCurve, DrawnPanel, drawn_panels
from lwr_dyn.pages.replay.figures import Figure
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun

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
    used = 0.0
    for one in named:
        wide = name_width(one)
        if rows[-1] and used + wide > width - 2 * EDGE:
            rows.append([])
            used = 0.0
        rows[-1].append(one)
        used += wide
    return tuple(map(tuple, rows))


def name_width(one: DrawnCurve) -> float:
    """Room of a name with its mark."""
    return 0.55 + LETTER * len(one.curve.label)
