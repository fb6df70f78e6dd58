"""Figures -> PNG and SVG by Matplotlib, imported when one is drawn; `lwr_dyn.plot`, a picture of runs.

pyplot is not used; what stays of a drawing is only that Matplotlib knows our fonts. A figure gives the same bytes
whatever the user's settings are. Colours, type and the light scheme are those of `lwr_dyn.pages.replay.look`.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.foundation.errors import FileAccessError, MissingPackageError, OptionError, ShapeError
from lwr_dyn.foundation.files import check_writable, write_file
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.figures.figure import Figure
from lwr_dyn.pages.figures.run_figures import QUANTITIES, Runs, quantity_named
from lwr_dyn.pages.plotting.panels import draw_header, draw_panel, layout_of
from lwr_dyn.pages.replay.look import tokens
from lwr_dyn.pages.replay.replayed_runs import replayed_runs

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

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

SUFFIXES = (".png", ".svg")


def save_figure(figures: Figure | Sequence[Figure], path: str | Path, runs: Runs = ()) -> tuple[Path, Path]:
    """Write `path`.png and `path`.svg and return both; raises as `draw`, `write_file`, `check_figure`."""
    targets, drawing = figure_paths(path), draw(figures, runs)
    with drawing_class():
        for target in targets:
            write_file(target, drawing_bytes(drawing, target.suffix[1:]))
    return targets


def figure_paths(path: str | Path) -> tuple[Path, Path]:
    """The .png and the .svg of a figure; `path` ends in one of them or has no suffix, else `FileAccessError`."""
    if Path(path).name in ("", ".."):
        raise FileAccessError(str(path), "is a directory", "a file's name: .png and .svg are written")
    if Path(path).suffix not in ("", *SUFFIXES):
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
    drawing = draw(figures, runs)
    with drawing_class():
        return drawing_bytes(drawing, kind)


def drawing_bytes(drawing: Drawing, kind: str) -> bytes:
    """A figure of Matplotlib as "png" or "svg", without dates and names of programs; within `drawing_class`."""
    out = io.BytesIO()
    metadata = {"Software": None} if kind == "png" else {"Date": None, "Creator": None}
    drawing.savefig(out, format=kind, dpi=150, metadata=metadata)
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
        widths, height = [one.width for one in laid], max(one.height for one in laid)
        drawing: Drawing = drawn_by(figsize=(sum(widths), height))
        places = drawing.subfigures(1, len(parts), squeeze=False, wspace=0.0, width_ratios=widths)[0]
        for place, one in zip(places, laid, strict=True):
            one = replace(one, height=height)
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


@dataclass(frozen=True, slots=True, eq=False)
class RunPlot:
    """A picture of one quantity of some runs.

    A notebook draws it as PNG and SVG, whatever backend Matplotlib has; `save` writes it.
    """

    quantity: str
    figures: tuple[Figure, ...]
    runs: Runs

    def __repr__(self) -> str:
        names = ", ".join(one.label for one in self.runs)
        return f"RunPlot({self.quantity!r} of {names}); .save('x.png') writes it, .figure is Matplotlib's"

    @property
    def figure(self) -> Any:
        """A new `matplotlib.figure.Figure` of it, to be changed at will."""
        return draw(self.figures, self.runs)

    def _repr_png_(self) -> bytes:
        return figure_bytes(self.figures, "png", self.runs)

    def _repr_svg_(self) -> str:
        return figure_bytes(self.figures, "svg", self.runs).decode()

    def save(self, path: str | Path) -> None:
        """Write as .png or .svg; raises `FileAccessError` for another ending or where nothing can be written."""
        suffix = Path(path).suffix.lower()
        if suffix not in SUFFIXES:
            raise FileAccessError(str(path), f"ends in {suffix or 'nothing'!r}", "a path that ends in .png or .svg")
        write_file(path, figure_bytes(self.figures, suffix[1:], self.runs))


def plot(runs: Run | Sequence[Run], quantity: str = "overview", labels: Sequence[str] | None = None) -> RunPlot:
    """A picture of one quantity of a run, or of several in one picture; a notebook draws it, `save` writes it.

    Parameters
    ----------
    runs : Run or sequence of Run
    quantity : str
        overview, tip error, path, torque, position error, velocity error, position, velocity, friction, energy, or
        response (of a step or a chirp).
    labels : sequence of str, optional
        One per run; the controllers' names if not given.

    Raises
    ------
    UnknownNameError
        Another quantity, or a run of an unknown robot.
    OptionError, ShapeError
        No runs, labels of another number, arms with different numbers of joints.
    """
    several = [runs] if isinstance(runs, Run) else list(runs)
    chosen = quantity_named(quantity)
    shown = replayed_runs(several, arms_of(several), labels)
    if len({one.run.n for one in shown}) > 1:
        raise ShapeError("runs", "arms with different numbers of joints", "runs of arms with as many joints")
    return RunPlot(chosen, (QUANTITIES[chosen](shown),), shown)


def arms_of(runs: Sequence[Run]) -> list[Arm]:
    """The arm of each run; raises as `lwr_dyn.arms.loading.arm_of`."""
    if not all(isinstance(run, Run) for run in runs):
        raise OptionError("runs", repr(runs)[:80], "runs, as simulate or Run.load give them")
    return [arm_of(run) for run in runs]


def plot_writer(wish: str) -> Callable[[Run], Path]:
    """What `--plot` means, checked before the work: a function that draws a run into a file, whose path it returns.

    A path that ends in .png or .svg is drawn in, with the quantity it is named after, else the overview; another text
    is the name of a quantity, drawn in a .png of its name.

    Raises
    ------
    UnknownNameError
        Neither such a path nor a quantity.
    FileAccessError, MissingPackageError
        Nothing can be written there; Matplotlib is not installed.
    """
    path = Path(wish) if wish.lower().endswith(SUFFIXES) else Path(f"{quantity_named(wish).replace(' ', '-')}.png")
    plain = path.stem.lower().replace("-", " ").replace("_", " ")
    quantity = plain if plain in QUANTITIES else "overview"
    check_figure(path)

    def write(run: Run) -> Path:
        plot(run, quantity).save(path)
        return path

    return write
