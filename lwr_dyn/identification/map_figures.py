"""Friction-velocity maps as a figure: the averages of the cruises, and what was fitted to them."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lwr_dyn.errors import OptionError
from lwr_dyn.identification.direction_fit import DirectionFit
from lwr_dyn.identification.friction import FrictionIdentification
from lwr_dyn.viewer.plots import in_house_style

_COLUMNS = 2
_CURVE = 200
_DATA, _FIT = "#0072b2", "#d55e00"


@in_house_style
def friction_map_figure(result: FrictionIdentification, title: str = "friction-velocity maps") -> Figure:
    """One panel a joint, as the WAM paper's Figure 6: measured points, fitted curves over the speeds they cover.

    Raises
    ------
    OptionError
        Nothing was measured.
    """
    joints = result.joints
    if not joints:
        raise OptionError("friction map", "without a point", "at least one cruise")
    columns = min(_COLUMNS, len(joints))
    rows = -(-len(joints) // columns)
    figure = Figure(figsize=(4.6 * columns, 1.0 + 2.3 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for panel, joint in zip(panels, joints, strict=False):
        points = [p for p in result.points if p.joint == joint]
        panel.plot(
            [p.velocity for p in points], [p.torque for p in points], "o", color=_DATA, markersize=3.5,
            label="mean of a cruise",
        )  # fmt: skip
        for fit in (f for f in result.fits if f.joint == joint):
            _draw(panel, fit)
        panel.set_title(f"joint {joint}", fontsize=10, loc="left")
        panel.set_xlabel("velocity [rad/s]")
        panel.set_ylabel("friction [N m]")
        panel.axhline(0.0, color="#868e96", linewidth=0.6)
        panel.axvline(0.0, color="#868e96", linewidth=0.6)
        panel.grid(True, color="#dee2e6", linewidth=0.6)
    for panel in panels[len(joints) :]:
        panel.set_visible(False)
    handles, names = panels[0].get_legend_handles_labels()
    unique = dict(zip(names, handles, strict=True))
    figure.legend(unique.values(), unique.keys(), loc="outside lower center", ncols=len(unique), frameon=False)
    figure.suptitle(title)
    return figure


def _draw(panel: Axes, fit: DirectionFit) -> None:
    """The fitted curve, full over the speeds that were measured, broken from there to rest."""
    for start, end, line in ((0.0, fit.slowest, ":"), (fit.slowest, fit.fastest, "-")):
        speed = np.linspace(start, end, _CURVE)
        name = f"fit, {fit.model}" if line == "-" else "fit, beyond the data"
        panel.plot(fit.sign * speed, fit.sign * fit.magnitude(speed), line, color=_FIT, linewidth=1.3, label=name)
