"""Figures and pictures of sampled loops -> PNG and SVG by Matplotlib, which is imported when one is drawn.

pyplot is not used; what stays of a drawing is only that Matplotlib knows our fonts. A figure gives the same bytes
whatever the user's settings are. Colours, type and the light scheme are those of `lwr_dyn.pages.replay.look`.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, MissingPackageError, OptionError
from lwr_dyn.foundation.files import check_writable, write_file
from lwr_dyn.pages.figures.figure import Curve, Figure, Level, Panel
from lwr_dyn.pages.plotting.panels import draw_header, draw_panel, layout_of
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


BANDS = (1.2, 1.4, 1.7, 2.5, 5.0)
"""Edges of the shades of a map; beyond the last the loop may still be stable."""

NEAR = 3.0
"""Half the side of the part of the plane that a Nyquist picture shows, about -1."""

OTHERS = "other joints"


@dataclass(frozen=True, slots=True, eq=False)
class LoopPictures:
    """The loops of an arm at one pose, each cut at one joint with all others closed.

    Parameters
    ----------
    hz : (f,) array
        [Hz]
    loops : mapping
        Name of a joint -> L_i (f,), complex.
    shown : str
        The joint that is drawn in ink.
    limit : float
        Of |S_ii|.
    note : str
        What they are loops of, in words.
    """

    hz: Array
    loops: Mapping[str, Any]
    shown: str
    limit: float
    note: str

    def figure(self, kind: str) -> Figure:
        """The figure "bode", "nyquist" or "sensitivity"."""
        return {"bode": self._bode, "nyquist": self._nyquist, "sensitivity": self._sensitivity}[kind]()

    def save(self, kind: str, path: str | Path) -> tuple[Path, Path]:
        """Write a figure as .png and .svg; raises as `save_figure`."""
        return save_figure(self.figure(kind), path)

    @staticmethod
    def check(path: str | Path) -> None:
        """Raise before the work what `save` and `save_map` would raise after it; see `check_figure`."""
        check_figure(path)

    @staticmethod
    def save_map(
        path: str | Path, axes: Sequence[tuple[str, Array]], peaks: Array, here: Sequence[float], words: tuple[str, str]
    ) -> tuple[Path, Path]:
        """Write a map of max |S_ii| over two joints as .png and .svg; raises as `save_figure`.

        Parameters
        ----------
        path : str or path
        axes : two of (label, (m,) array)
            Across and up, with the unit in the label.
        peaks : (up, across) array
            inf where the loop is unstable.
        here : two floats
            The pose that the other joints are of.
        words : (title, note)
        """
        targets = figure_paths(path)
        for target in targets:
            write_file(target, _map_bytes(axes, peaks, here, words, target.suffix[1:]))
        return targets

    def _curves(self, values: Mapping[str, Array], x: Mapping[str, Array] | None = None) -> tuple[Curve, ...]:
        """The curve of the shown joint first, then the others, which share one name."""
        names = [self.shown, *(name for name in self.loops if name != self.shown)]
        return tuple(
            Curve(name if name == self.shown else OTHERS, values[name], self.hz if x is None else x[name])
            for name in names
        )

    def _bode(self) -> Figure:
        size = {name: 20 * np.log10(np.maximum(np.abs(loop), 1e-12)) for name, loop in self.loops.items()}
        phase = {name: np.degrees(np.unwrap(np.angle(loop))) for name, loop in self.loops.items()}
        phase = {name: x - 360 * np.round((x[np.argmin(np.abs(size[name]))] + 180) / 360) for name, x in phase.items()}
        panels = (
            Panel("magnitude, dB", "|L_i|", "dB", self._curves(size), (Level("0 dB", 0.0),)),
            Panel("phase, deg", "phase of L_i", "deg", self._curves(phase), (Level("-180 deg", -180.0),)),
        )
        return Figure("bode", "Bode: the loop cut at one joint", "", "frequency", "Hz", panels, note=self.note)

    def _nyquist(self) -> Figure:
        inside = {name: np.maximum(np.abs(x.real + 1), np.abs(x.imag)) <= NEAR for name, x in self.loops.items()}
        real, imaginary = (
            {name: np.where(inside[name], part(x), np.nan) for name, x in self.loops.items()}
            for part in (np.real, np.imag)
        )
        turn = np.linspace(0, 2 * np.pi, 181)
        radius = 1.0 / self.limit
        circle = Curve(f"|S_ii| = {self.limit:g}", radius * np.sin(turn), radius * np.cos(turn) - 1, colour=0)
        point = Curve("-1", np.array([0.0]), np.array([-1.0]), style="points", colour=0)
        curves = (*self._curves(imaginary, real), circle, point)
        panel = Panel("", "Im L_i", "", curves)
        title = "Nyquist: the loop cut at one joint"
        return Figure("nyquist", title, "", "Re L_i", "", (panel,), equal_aspect=True, note=self.note)

    def _sensitivity(self) -> Figure:
        size = {name: np.abs(1 / (1 + loop)) for name, loop in self.loops.items()}
        levels = (Level(f"margin {self.limit:g}", self.limit),)
        panel = Panel("", "|S_ii|", "", self._curves(size), levels)
        return Figure("sensitivity", "Sensitivity of each joint", "", "frequency", "Hz", (panel,), note=self.note)


def _map_bytes(
    axes: Sequence[tuple[str, Array]], peaks: Array, here: Sequence[float], words: tuple[str, str], kind: str
) -> bytes:
    out = io.BytesIO()
    with drawing_class() as drawing:
        from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap, ListedColormap

        tone = LinearSegmentedColormap.from_list("tone", [tokens()["card"], tokens()["run1"]])
        shades = [tone(x) for x in np.linspace(0.06, 0.85, len(BANDS) + 1)]
        colours = ListedColormap([*shades, tokens()["alarm"]])
        band = np.where(np.isinf(peaks), len(BANDS) + 1, np.digitize(peaks, BANDS))
        picture = drawing(figsize=(6.8, 5.9))
        panel = picture.add_axes((0.1, 0.1, 0.62, 0.715))
        norm = BoundaryNorm(np.arange(-0.5, len(BANDS) + 2), len(BANDS) + 2)
        (across, x), (up, y) = axes
        panel.pcolormesh(x, y, band, cmap=colours, norm=norm, shading="nearest", rasterized=True)
        panel.plot([here[0]], [here[1]], "o", markersize=7, markerfacecolor="none", color=tokens()["ink"])
        for side in panel.spines.values():
            side.set_visible(False)
        panel.tick_params(length=0, labelsize=8.5, pad=4)
        panel.set_xlabel(across, color=tokens()["soft"])
        panel.set_ylabel(up, color=tokens()["soft"])
        picture.text(0.025, 0.955, words[0], fontsize=12.5, fontweight=600, va="center")
        for row, line in enumerate(words[1].split("\n")):
            picture.text(0.025, 0.915 - 0.035 * row, line, color=tokens()["soft"], fontsize=9.0, va="center")
        _legend(picture, [*shades, tokens()["alarm"]])
        metadata = {"Software": None} if kind == "png" else {"Date": None, "Creator": None}
        picture.savefig(out, format=kind, dpi=150, metadata=metadata)
    return out.getvalue()


def _legend(picture: Any, shades: Sequence[Any]) -> None:
    """The bands that the map has, from the best down to the unstable one, and the mark of the pose."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Rectangle

    names = [f"up to {BANDS[0]:g}", *(f"{a:g} to {b:g}" for a, b in pairwise(BANDS))]
    names += [f"over {BANDS[-1]:g}", "unstable"]
    picture.text(0.755, 0.785, "max |S_ii|", fontweight=600, va="center")
    for row, (name, shade) in enumerate(zip(names, shades, strict=True)):
        at = 0.74 - 0.045 * row
        edge: dict[str, Any] = {"edgecolor": tokens()["line"], "linewidth": 0.7}
        picture.add_artist(Rectangle((0.755, at - 0.0125), 0.03, 0.025, facecolor=shade, **edge))
        picture.text(0.8, at, name, va="center")
    at = 0.74 - 0.045 * (len(names) + 0.4)
    picture.add_artist(Line2D([0.77], [at], marker="o", markersize=7, markerfacecolor="none", color=tokens()["ink"]))
    picture.text(0.8, at, "worst pose", va="center")
