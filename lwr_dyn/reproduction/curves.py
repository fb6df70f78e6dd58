"""Plots of a report page that several papers have: errors, speeds and torques of a run's joints, the path drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lwr_dyn.model.arm import Arm
from lwr_dyn.viewer.figures import Curve, Figure, Level, Panel, Quantity, Series


def joints_plot(
    name: str, title: str, figure: str, runs: Sequence[tuple[str, int]], arm: Arm, quantity: Quantity, unit: str,
    note: str = "",
) -> Figure:  # fmt: skip
    """A joint quantity of runs (label, index on the page) times 1000, a panel a run, a curve a joint."""
    panels = tuple(
        Panel(
            label,
            quantity,
            unit,
            tuple(Curve(joint, Series(run, quantity, j, 1e3)) for j, joint in enumerate(arm.joint_names)),
        )
        for label, run in runs
    )
    return Figure(name, title, figure, "time", "s", panels, over_time=True, note=note)


def torque_plot(name: str, title: str, runs: Sequence[tuple[str, int]], arm: Arm) -> Figure:
    """Applied torques, a panel a joint, with the limits that are known [N m]."""
    panels = []
    for j, joint in enumerate(arm.joint_names):
        curves = tuple(Curve(label, Series(run, "torque", j)) for label, run in runs)
        limit = float(arm.effort[j])
        levels = (Level("limit", limit), Level("limit", -limit)) if np.isfinite(limit) else ()
        panels.append(Panel(joint, "torque", "N m", curves, levels))
    return Figure(name, title, "", "time", "s", tuple(panels), over_time=True, columns=2)


def path_plot(name: str, title: str, figure: str, runs: Sequence[tuple[str, int]], note: str = "") -> Figure:
    """The path of the flange in the y-z plane of the base beside what was asked [m]."""
    run = runs[0][1]
    asked = Curve("reference", Series(run, "reference z"), Series(run, "reference y"), dashed=True)
    drawn = tuple(Curve(label, Series(r, "flange z"), Series(r, "flange y")) for label, r in runs)
    panel = Panel("", "z", "m", (asked, *drawn))
    return Figure(name, title, figure, "y", "m", (panel,), equal_aspect=True, note=note)
