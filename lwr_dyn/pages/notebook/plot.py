"""`lwr_dyn.plot`: a picture of runs that any notebook draws, and that `simulate --plot` writes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.foundation.errors import FileAccessError, OptionError, ShapeError
from lwr_dyn.foundation.files import write_file
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.figures.figure import Figure
from lwr_dyn.pages.figures.run_figures import QUANTITIES, quantity_named
from lwr_dyn.pages.plotting.plots import check_figure, draw, figure_bytes
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, replayed_runs

SUFFIXES = (".png", ".svg")


@dataclass(frozen=True, slots=True, eq=False)
class RunPlot:
    """A picture of one quantity of some runs.

    A notebook draws it as PNG and SVG, whatever backend Matplotlib has; `save` writes it.
    """

    quantity: str
    figures: tuple[Figure, ...]
    runs: tuple[ReplayedRun, ...]

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
        write_file(path, figure_bytes(self.figures, _ending(path)[1:], self.runs))


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
    return RunPlot(chosen, QUANTITIES[chosen](shown), shown)


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


def _ending(path: str | Path) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise FileAccessError(str(path), f"ends in {suffix or 'nothing'!r}", "a path that ends in .png or .svg")
    return suffix
