"""Figures -> PNG and SVG by Matplotlib, which is imported when a figure is drawn.

pyplot is not used, so nothing global changes; a figure gives the same bytes whatever the user's settings are.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lwr_dyn.errors import FileAccessError, MissingPackageError, OptionError
from lwr_dyn.files import check_writable, write_file
from lwr_dyn.viewer.figures import PALETTE, Curve, Figure, Panel
from lwr_dyn.viewer.replayed_runs import ReplayedRun

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing
    from matplotlib.figure import FigureBase

Runs = Sequence[ReplayedRun]
_STYLE = {
    "svg.hashsalt": "lwr_dyn",
    "svg.fonttype": "path",
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "lines.linewidth": 1.1,
    "lines.markersize": 4.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#dee2e6",
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "legend.frameon": False,
}
_ZERO: dict[str, Any] = {"color": "#868e96", "linewidth": 0.6, "zorder": 0.9}
_LEVEL: dict[str, Any] = {"color": "#c92a2a", "linewidth": 0.9, "linestyle": "--"}
_REFERENCE: dict[str, Any] = {"color": "#343a40", "linewidth": 2.6, "alpha": 0.35}
_MARKS = {"line": "-", "points": "o", "both": "-o"}
_DPI = 150
_AT_THE_SIDE = 5
"""With this many curves or more the legend is at the side."""
_LETTERS = 12
"""Letters per inch of a legend."""


def save_figure(figures: Figure | Sequence[Figure], path: str | Path, runs: Runs = ()) -> tuple[Path, Path]:
    """Write `path`.png and `path`.svg and return both; raises as `draw`, `write_file`, `check_figure`."""
    targets = figure_paths(path)
    for target in targets:
        write_file(target, figure_bytes(figures, target.suffix[1:], runs))
    return targets


def figure_paths(path: str | Path) -> tuple[Path, Path]:
    """The .png and the .svg of a figure; `path` ends in one of them or has no suffix, else `FileAccessError`."""
    if Path(path).suffix not in ("", ".png", ".svg"):
        raise FileAccessError(str(path), f"ends in {Path(path).suffix}", "no suffix, .png or .svg: both are written")
    return Path(path).with_suffix(".png"), Path(path).with_suffix(".svg")


def check_figure(path: str | Path) -> None:
    """Raise before the work what `save_figure` would raise after it.

    Raises
    ------
    FileAccessError
        Another suffix, or a folder where nothing can be written.
    MissingPackageError
        Matplotlib is not installed.
    """
    for target in figure_paths(path):
        check_writable(target)
    with _drawing_class():
        pass


def figure_bytes(figures: Figure | Sequence[Figure], kind: str, runs: Runs = ()) -> bytes:
    """One figure, or several side by side, as "png" or "svg"; raises as `draw`, and `OptionError` for another kind."""
    if kind not in ("png", "svg"):
        raise OptionError("kind", repr(kind), "png, svg")
    drawing, out = draw(figures, runs), io.BytesIO()
    metadata = {"Software": None} if kind == "png" else {"Date": None, "Creator": None}
    with _drawing_class():
        drawing.savefig(out, format=kind, dpi=_DPI, metadata=metadata)
    return out.getvalue()


def draw(figures: Figure | Sequence[Figure], runs: Runs = ()) -> Drawing:
    """One figure, or several side by side, as a figure of Matplotlib; its series refer to `runs` by number.

    Raises
    ------
    OptionError
        A series of a run or joint that is not there.
    MissingPackageError
        Matplotlib is not installed.
    """
    parts = [figures] if isinstance(figures, Figure) else list(figures)
    widths, heights = zip(*map(_size, parts), strict=True)
    with _drawing_class() as drawing_class:
        drawing: Drawing = drawing_class(figsize=(sum(widths), max(heights)), layout="constrained")
        places = drawing.subfigures(1, len(parts), squeeze=False)[0]
        for place, figure in zip(places, parts, strict=True):
            _draw_figure(place, figure, runs)
    return drawing


@contextmanager
def _drawing_class() -> Iterator[Any]:
    """Matplotlib's class of figures, under its own defaults and ours."""
    try:
        from matplotlib import style
        from matplotlib.figure import Figure as Drawing
    except ModuleNotFoundError as fault:
        raise MissingPackageError(fault.name or "matplotlib", "plots") from None
    with style.context(["default", _STYLE]):
        yield Drawing


def _grid(figure: Figure) -> tuple[int, int]:
    """Rows and columns of panels."""
    columns = min(figure.columns, len(figure.panels))
    return -(-len(figure.panels) // columns), columns


def _size(figure: Figure) -> tuple[float, float]:
    """Width and height [inch]."""
    rows, columns = _grid(figure)
    if figure.equal_aspect:
        return 6.4 * columns, 6.4 * rows
    if columns > 1:
        return 9.0, 1.0 + 2.05 * rows
    return 9.0 if len(figure.labels) >= _AT_THE_SIDE else 6.4, 1.1 + (2.5 if rows < 3 else 1.65) * rows


def _draw_figure(place: FigureBase, figure: Figure, runs: Runs) -> None:
    rows, columns = _grid(figure)
    axes: list[Axes] = list(place.subplots(rows, columns, sharex=figure.over_time, squeeze=False).flat)
    count = len(figure.panels)
    for p, (one, panel) in enumerate(zip(axes, figure.panels, strict=False)):
        _draw_panel(one, figure, panel, runs)
        for c, line in enumerate(line for line in one.lines if not str(line.get_label()).startswith("_")):
            line.set_gid(f"{figure.id or 'figure'}-{p}-{c}")  # names the curve in SVG
    for one in axes[count:]:
        one.set_visible(False)
    for one in axes[max(0, count - columns) if figure.over_time else 0 : count]:
        one.tick_params(labelbottom=True)
        one.set_xlabel(_with_unit(figure.x_label, figure.x_unit))
    place.suptitle("\n".join(text for text in (figure.title, figure.note) if text))
    named = {name: mark for one in axes for mark, name in zip(*one.get_legend_handles_labels(), strict=True)}
    in_a_row = min(len(named), int(_LETTERS * _size(figure)[0] / (max(map(len, named)) + 8)))
    where: dict[str, Any] = {"loc": "outside lower center", "ncols": in_a_row}
    if len(named) >= _AT_THE_SIDE:
        where = {"loc": "outside right upper"}
    place.legend(list(named.values()), list(named), **where)


def _draw_panel(axes: Axes, figure: Figure, panel: Panel, runs: Runs) -> None:
    for curve in panel.curves:
        _draw_curve(axes, figure, curve, runs)
    for level in panel.levels:
        (axes.axhline if level.axis == "y" else axes.axvline)(level.value, **_LEVEL)
    if figure.equal_aspect:
        axes.set_aspect("equal", adjustable="datalim")
    if axes.get_ylim()[0] <= 0.0 <= axes.get_ylim()[1]:
        axes.axhline(0.0, **_ZERO)
    if axes.get_xlim()[0] <= 0.0 <= axes.get_xlim()[1] and not figure.over_time:
        axes.axvline(0.0, **_ZERO)
    axes.set_title(f"{panel.title} ({panel.note})" if panel.note else panel.title)
    axes.set_ylabel(_with_unit("" if panel.y_label == panel.title else panel.y_label, panel.y_unit))


def _draw_curve(axes: Axes, figure: Figure, curve: Curve, runs: Runs) -> None:
    x, y = curve.points(runs)
    if curve.text:  # on paper nothing can be pointed at: each point has a colour and a name of its own
        for k, name in enumerate(curve.text):
            axes.plot(x[k], y[k], "o", color=PALETTE[k % len(PALETTE)], label=f"{name}, {curve.label}")
        return
    place = figure.colour(curve)
    colour = runs[curve.series[0].run].colour if place is None else PALETTE[place % len(PALETTE)]
    if curve.is_filled:
        axes.fill(x, y, color=colour, alpha=0.15, linewidth=0.0)
    marks = "--" if curve.dashed else _MARKS[curve.style]
    if curve.is_reference:
        axes.plot(x, y, label=curve.label, **_REFERENCE)
    else:
        axes.plot(x, y, marks, color=colour, label=curve.label)


def _with_unit(label: str, unit: str) -> str:
    return f"{label} [{unit}]".strip() if unit else label
