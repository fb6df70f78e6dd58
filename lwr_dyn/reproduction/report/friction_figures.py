"""Figures of movements with friction: laws over speed, a timing law, a joint's register, errors joint by joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lwr_dyn.errors import OptionError
from lwr_dyn.model.friction.models import FRICTIONLESS, JointFriction
from lwr_dyn.model.run import Reference, Run
from lwr_dyn.viewer.plots import in_house_style

_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
_POINTS = 401


def _grid(count: int, height: float = 2.1) -> tuple[Figure, list[Axes]]:
    """`count` panels in two columns."""
    rows = -(-count // 2)
    figure = Figure(figsize=(9.0, 0.8 + height * rows), layout="constrained")
    panels = list(figure.subplots(rows, 2, squeeze=False).ravel())
    for panel in panels[count:]:
        panel.set_visible(False)
    return figure, panels[:count]


def _dress(panel: Axes, x: str, y: str, title: str) -> None:
    panel.set_title(title, fontsize=10, loc="left")
    panel.set_xlabel(x)
    panel.set_ylabel(y)
    panel.grid(True, color="#dee2e6", linewidth=0.6)
    panel.axhline(0.0, color="#868e96", linewidth=0.6)


@in_house_style
def friction_law_figure(models: Sequence[JointFriction | None], names: Sequence[str], speed: float = 0.4) -> Figure:
    """tau_friction over speeds from -`speed` to `speed` [rad/s], a panel a joint, with the interval at rest."""
    figure, panels = _grid(len(models))
    v = np.linspace(0.0, speed, _POINTS)[1:]
    for panel, model, name in zip(panels, models, names, strict=True):
        law = model or FRICTIONLESS
        for side in (-1.0, 1.0):
            panel.plot(side * v, law.torque(side * v), color=_COLOURS[0], linewidth=1.4)
        panel.plot([0.0, 0.0], law.breakaway, color=_COLOURS[1], linewidth=1.4)
        _dress(panel, "velocity [rad/s]", "friction [N m]", name)
    figure.suptitle("friction of each joint; at rest anything on the upright line")
    return figure


@in_house_style
def timing_figure(reference: Reference, joint: int, title: str) -> Figure:
    """Position, velocity and acceleration of one joint of a reference, as the WAM paper's Figure 4."""
    figure = Figure(figsize=(6.4, 6.0), layout="constrained")
    t = np.linspace(0.0, reference.duration, _POINTS)
    motion = reference.sample(t)
    rows = (("position", motion.q, "rad"), ("velocity", motion.dq, "rad/s"), ("acceleration", motion.ddq, "rad/s^2"))
    for panel, (name, values, unit) in zip(figure.subplots(3, 1, sharex=True), rows, strict=True):
        panel.plot(t, values[:, joint], color=_COLOURS[0], linewidth=1.3)
        _dress(panel, "", f"[{unit}]", name)
    figure.supxlabel("time [s]", fontsize=9)
    figure.suptitle(title)
    return figure


@in_house_style
def register_figure(run: Run, joint: int, title: str) -> Figure:
    """Position, velocity and torque of one joint of a run, as the WAM paper's Figure 5."""
    figure = Figure(figsize=(6.4, 6.0), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    top.plot(run.t, run.q[:, joint], color=_COLOURS[0], linewidth=1.3)
    middle.plot(run.t, run.dq[:, joint], color=_COLOURS[0], linewidth=1.3)
    bottom.plot(run.t, run.tau_applied[:, joint], color=_COLOURS[0], linewidth=1.3, label="motor")
    bottom.plot(run.t, run.tau_friction[:, joint], color=_COLOURS[1], linewidth=1.0, label="friction")
    bottom.legend(frameon=False, fontsize=8)
    for panel, name, unit in ((top, "position", "rad"), (middle, "velocity", "rad/s"), (bottom, "torque", "N m")):
        _dress(panel, "", f"[{unit}]", name)
    figure.supxlabel("time [s]", fontsize=9)
    figure.suptitle(title)
    return figure


@in_house_style
def joint_error_figure(series: Mapping[str, Sequence[Run]], names: Sequence[str], title: str) -> Figure:
    """Position errors q_ref - q [mrad], a panel a joint, as the WAM paper's Figures 7 and 8.

    Parameters
    ----------
    series : mapping from label to runs
        One run per joint, of which that joint is shown.
    names : sequence of str
        Of the joints.

    Raises
    ------
    OptionError
        Another number of runs than joints.
    """
    figure, panels = _grid(len(names))
    for label, runs in series.items():
        if len(runs) != len(names):
            raise OptionError("runs", f"{len(runs)} of {label}", f"{len(names)}, one a joint")
    for j, (panel, name) in enumerate(zip(panels, names, strict=True)):
        for colour, (label, runs) in zip(_COLOURS, series.items(), strict=False):
            run = runs[j]
            panel.plot(run.t, 1e3 * (run.q_ref - run.q)[:, j], color=colour, linewidth=1.0, label=label)
        _dress(panel, "time [s]", "position error [mrad]", name)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(series), frameon=False)
    figure.suptitle(title)
    return figure
