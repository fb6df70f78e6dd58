"""Figures -> PNG and SVG by Matplotlib, which is imported when a figure is drawn.

pyplot is not used; what stays of a drawing is only that Matplotlib knows our fonts. A figure gives the same bytes
whatever the user's settings are. Colours, type and the light scheme are those of `lwr_dyn.pages.replay.look`.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lwr_dyn.foundation.errors import FileAccessError, MissingPackageError, OptionError
from lwr_dyn.foundation.files import check_writable, write_file
from lwr_dyn.pages.plotting.layout import layout_of
from lwr_dyn.pages.plotting.panels import draw_header, draw_panel
from lwr_dyn.pages.replay.figures import Figure
from lwr_dyn.pages.replay.look import tokens
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

Runs = Sequence[ReplayedRun]
_FONT, _OTHERS = "Plex Sans", "other letters"
_STYLE = {
    "svg.hashsalt": "lwr_dyn",
    "svg.fonttype": "path",
    "font.family": [_FONT, _OTHERS],
    "font.size": 9.0,
    "lines.linewidth": 1.3,
    "lines.markersize": 4.0,
    "lines.solid_joinstyle": "round",
    "lines.solid_capstyle": "round",
    "axes.grid": False,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "text.color": tokens()["ink"],
    "xtick.color": tokens()["zero"],
    "ytick.color": tokens()["zero"],
    "xtick.labelcolor": tokens()["soft"],
    "ytick.labelcolor": tokens()["soft"],
    "figure.facecolor": tokens()["card"],
    "axes.facecolor": tokens()["card"],
}
_DPI = 150


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
    with drawing_class():
        pass


def figure_bytes(figures: Figure | Sequence[Figure], kind: str, runs: Runs = ()) -> bytes:
    """One figure, or several side by side, as "png" or "svg"; raises as `draw`, and `OptionError` for another kind."""
    if kind not in ("png", "svg"):
        raise OptionError("kind", repr(kind), "png, svg")
    drawing, out = draw(figures, runs), io.BytesIO()
    metadata = {"Software": None} if kind == "png" else {"Date": None, "Creator": None}
    with drawing_class():
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
    with drawing_class() as drawn_by:
        laid = [layout_of(figure, runs) for figure in parts]
        size = sum(one.width for one in laid), max(one.height for one in laid)
        drawing: Drawing = drawn_by(figsize=size)
        ratios = [one.width for one in laid]
        places = drawing.subfigures(1, len(parts), squeeze=False, wspace=0.0, width_ratios=ratios)[0]
        for place, one in zip(places, laid, strict=True):
            one = replace(one, height=size[1])
            draw_header(place, one)
            for k in range(len(one.panels)):
                draw_panel(place, one, k)
    return drawing


@contextmanager
def drawing_class() -> Iterator[Any]:
    """Matplotlib's class of figures, under its own defaults and ours."""
    try:
        from matplotlib import style
        from matplotlib.figure import Figure as Drawing
    except ModuleNotFoundError as fault:
        raise MissingPackageError(fault.name or "matplotlib", "plots") from None
    _add_fonts()
    with style.context(["default", _STYLE]):
        yield Drawing


def _add_fonts() -> None:
    """Plex Sans of this package, and for letters that it lacks Matplotlib's own, under names of our own, once."""
    from matplotlib import font_manager, ft2font, get_data_path

    known = font_manager.fontManager.ttflist
    if any(entry.name == _FONT for entry in known):
        return
    ours, theirs = Path(str(files("lwr_dyn.pages.replay").joinpath("fonts"))), Path(get_data_path()) / "fonts" / "ttf"
    for weight, other in ((400, "DejaVuSans.ttf"), (600, "DejaVuSans-Bold.ttf")):
        for name, path in ((_FONT, ours / f"plex-sans-{weight}.ttf"), (_OTHERS, theirs / other)):
            entry: Any = font_manager.ttfFontProperty(ft2font.FT2Font(str(path)))
            known.append(replace(entry, name=name, weight=weight))
