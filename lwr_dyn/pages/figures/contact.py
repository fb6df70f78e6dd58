"""The force of a wall over runs, as a figure: how hard the tip presses, and how hard it is dragged."""

from collections.abc import Sequence

import numpy as np

from lwr_dyn.control.protocol import label_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay.figures import Curve, Figure, Panel
from lwr_dyn.simulation.environment.wall import Wall


def pressing_and_drag(run: Run, wall: Wall) -> tuple[Array, Array]:
    """The force along the wall's normal (k,) and the size of that along the wall (k,) [N]; raises `ShapeError`."""
    force = wall.forces(run.q, run.dq)
    pressing = force @ wall.normal
    return pressing, np.linalg.norm(force - pressing[:, None] * wall.normal, axis=1)


def contact_figure(runs: Run | Sequence[Run], wall: Wall, labels: Sequence[str] | None = None) -> Figure:
    """A figure that `lwr_dyn.pages.plotting.plots.save_figure` writes.

    Parameters
    ----------
    runs : Run or sequence of Run
        Of the wall's arm.
    wall : Wall
    labels : sequence of str, optional
        One a run; the names of their controllers if not given.

    Raises
    ------
    OptionError
        No run, or another number of labels.
    ShapeError
        A run of an arm with another number of joints.
    """
    several = [runs] if isinstance(runs, Run) else list(runs)
    names = [_label(run) for run in several] if labels is None else list(labels)
    if not several or len(names) != len(several):
        raise OptionError("labels", f"{len(names)} for {len(several)} runs", "one for each run, at least one run")
    forces = [pressing_and_drag(run, wall) for run in several]
    panels = [
        Panel(
            title, "force", "N",
            tuple(
                Curve(name, both[which], x=run.t, colour=place)
                for place, (name, run, both) in enumerate(zip(names, several, forces, strict=True))
            ),
        )
        for which, title in enumerate(("Into the wall", "Along the wall"))
    ]  # fmt: skip
    return Figure("contact", "Force of the wall on the tip", "", "time", "s", tuple(panels))


def _label(run: Run) -> str:
    controller = run.meta.get("controller", {})
    return str(controller.get("label", "run")) if run.setup is None else label_of(run.setup.controller)
