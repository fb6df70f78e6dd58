"""The working envelope as a figure: section from the side with axis 1 on the left, and the reach from above."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, fixed_array
from lwr_dyn.kinematics.envelope import Envelope, EnvelopeArc, working_envelope
from lwr_dyn.model.arm import Arm
from lwr_dyn.viewer.plots import in_house_style

TOUCH = 1e-6
"""[m] Ends of arcs this near to each other are one corner of the outline."""
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")


@in_house_style
def envelope_figure(arm: Arm, points: Mapping[str, ArrayLike] | None = None) -> Figure:
    """Where the wrist centre can stand, side and top view [m], with points of the base drawn in.

    Parameters
    ----------
    arm : Arm
        Standing on its axis 1; raises as `working_envelope`.
    points : mapping of name to (3,) array_like, optional
        In the base [m]; from the side they stand at their distance from axis 1. Raises `ShapeError`.
    """
    found = working_envelope(arm)
    placed = {name: fixed_array(name, point, (3,)) for name, point in (points or {}).items()}
    figure = Figure(figsize=(10.5, 5.6), layout="constrained")
    side, top = figure.subplots(1, 2)
    _side_view(side, found, placed)
    _top_view(top, arm, found, placed)
    figure.suptitle(f"{arm.title}\nwrist centre: reach {1e3 * found.reach:.1f} mm, envelope {found.volume:.2f} m³")
    if placed:
        figure.legend(*side.get_legend_handles_labels(), loc="outside lower center", ncols=len(placed), frameon=False)
    return figure


def closed_outlines(envelope: Envelope) -> tuple[Array, ...]:
    """The outline as closed polygons (m, 2) of (r, z) [m], joined along axis 1 where it is open there."""
    left = list(envelope.outline)
    loops: list[Array] = []
    while left:
        here: EnvelopeArc | None = next((arc for arc in left if abs(arc.point(arc.start)[0]) < TOUCH), left[0])
        points: list[Array] = []
        while here is not None:
            left.remove(here)
            points.append(here.points())
            here = _next(here, left)
        loops.append(np.concatenate([*points, points[0][:1]]))
    return tuple(loops)


def _next(arc: EnvelopeArc, others: list[EnvelopeArc]) -> EnvelopeArc | None:
    """The arc that goes on where this one ends."""
    r, z = arc.point(arc.end)
    for other in others:
        start = other.point(other.start)
        if np.hypot(start[0] - r, start[1] - z) < TOUCH:
            return other
    return None


def _side_view(panel: Axes, found: Envelope, points: Mapping[str, Array]) -> None:
    for loop in closed_outlines(found):
        panel.add_patch(Polygon(loop, facecolor="#d0ebff", edgecolor="none"))
    for arc in found.outline:
        drawn = arc.points()
        panel.plot(drawn[:, 0], drawn[:, 1], color="#1c7ed6", linewidth=1.4)
    panel.axvline(0.0, color="#495057", linewidth=0.9, linestyle="-.")
    for k, (name, point) in enumerate(points.items()):
        panel.plot(np.hypot(point[0], point[1]), point[2], "o", color=_COLOURS[k % len(_COLOURS)], label=name)
    _dressed(panel, "side: section at any A1", "distance from axis 1 [m]", "z [m]")


def _top_view(panel: Axes, arm: Arm, found: Envelope, points: Mapping[str, Array]) -> None:
    panel.add_patch(Circle((0.0, 0.0), found.reach, facecolor="#d0ebff", edgecolor="#1c7ed6", linewidth=1.4))
    turns = np.linspace(arm.lower[0], arm.upper[0], 181)
    ring = (1.04 + 0.02 * np.abs(turns) / np.pi) * found.reach
    panel.plot(ring * np.cos(turns), ring * np.sin(turns), color="#868e96", linewidth=0.9)
    panel.plot(0.0, 0.0, "+", color="#495057")
    for k, (name, point) in enumerate(points.items()):
        panel.plot(point[0], point[1], "o", color=_COLOURS[k % len(_COLOURS)], label=name)
    low, up = np.degrees([arm.lower[0], arm.upper[0]])
    _dressed(panel, f"top: {arm.joint_names[0]} from {low:g} to {up:g} deg", "x [m]", "y [m]")


def _dressed(panel: Axes, title: str, across: str, up: str) -> None:
    panel.set_title(title, fontsize=10, loc="left")
    panel.set_xlabel(across)
    panel.set_ylabel(up)
    panel.set_aspect("equal")
    panel.autoscale_view()
    panel.grid(True, color="#dee2e6", linewidth=0.6)
