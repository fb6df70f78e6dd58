"""The KR 30 HA's working envelope (Figures 3 and 4) and its movement."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.checks.datasheet.envelope import Envelope, working_envelope
from lwr_dyn.checks.datasheet.envelope_arcs import EnvelopeArc
from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.plotting.run_figures import torque_figure
from lwr_dyn.pages.replay.figures import Curve, Figure, Panel, Series
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.reproduction.kr30ha.points import RightPoint
from lwr_dyn.reproduction.paper_study import Pictures
from lwr_dyn.reproduction.report.content import Still

TOUCH = 1e-6
"""[m] Ends of arcs this near to each other are one corner of the outline."""


def pictures(arm: Arm, right: Sequence[RightPoint], movement: Run, program: Run) -> Pictures:
    """Both views of the envelope, axes and torques of the movement; frames (Figure 5) and elbow up (Figure 6)."""
    label = str(movement.meta["controller"]["label"])
    shown = replayed_runs([movement, program], arm, [label, "KRL program, corrected"])
    panels = tuple(
        Panel(name, "axis", "deg", (Curve(label, Series(0, "q", j, 180.0 / np.pi)),))
        for j, name in enumerate(arm.joint_names)
    )
    return Pictures(
        simulated=((label, "mastering_p1_p2_mastering.npz", movement),),
        shown=shown,
        figures={
            "envelope": envelope_figures(arm, {p.name: p.wrist_mm / 1e3 for p in right}),
            "movement": [
                Figure("movement", "Axes over the movement", "", "time", "s", panels, over_time=True, columns=3)
            ],
            "torque": [replace(torque_figure(shown, (0,)), title="Torques of the movement, estimated masses")],
        },
        stills=(
            Still("Figure 5: DH frames, A = 0", arm, np.zeros(arm.n), "the arm stretched out, KUKA's zero"),
            Still("mastering", arm, np.array(arm.mastering), "A = (0, -90, 90, 0, 0, 0) deg"),
            *(Still(f"Figure 6: {p.name}, elbow up", arm, p.q, "flange there with A = B = C = 0") for p in right[:2]),
        ),
        title="KUKA KR 30 HA: mastering, Point 1, Point 2, mastering",
        replayed=1,
    )


def envelope_figures(arm: Arm, points: Mapping[str, ArrayLike] | None = None) -> tuple[Figure, Figure]:
    """Where the wrist centre can stand, side and top view [m], with points of the base.

    Parameters
    ----------
    arm : Arm
        Standing on its axis 1; raises as `working_envelope`.
    points : mapping of name to (3,) array_like, optional
        Wrist centres in the base [m]; in the side view at their distance from axis 1. Raises `ShapeError`.
    """
    envelope = working_envelope(arm)
    names = tuple(points or {})
    places = np.array([fixed_array(name, (points or {})[name], (3,)) for name in names]).reshape(-1, 3)
    edges = [Curve("envelope", loop[:, 1], loop[:, 0], colour=0, is_filled=True) for loop in closed_outlines(envelope)]
    turn = np.linspace(arm.lower[0], arm.upper[0], 181)
    ring = Curve("reach", -envelope.reach * np.sin(turn), envelope.reach * np.cos(turn), is_filled=True)
    low, up = np.degrees(turn[[0, -1]])

    def view(title: str, height: str, outline: Sequence[Curve], x: Array, y: Array) -> tuple[Panel]:
        centres = [Curve("wrist centre", y, x, "points", text=names)] if names else []
        return (Panel(title, height, "m", (*outline, *centres)),)

    side = view("section at any A1", "z", edges, np.hypot(*places[:, :2].T), places[:, 2])
    top = view(f"{arm.joint_names[0]} from {low:g} to {up:g} deg", "y", [ring], places[:, 0], places[:, 1])
    note = f"reach {1e3 * envelope.reach:.1f} mm, volume {envelope.volume:.3f} m^3 ahead of axis 1"
    note += f" ({envelope.volume_with_overhead:.3f} with overhead)"
    return (
        Figure("figure-3", "Working envelope, side view", "Figure 3", "distance from axis 1", "m", side,
               equal_aspect=True, note=note),
        Figure("figure-4", "Working envelope, top view", "Figure 4", "x", "m", top, equal_aspect=True),
    )  # fmt: skip


def closed_outlines(envelope: Envelope) -> tuple[Array, ...]:
    """The outline as closed polygons (m, 2) of (r, z) [m], joined along axis 1 where it is open there."""
    left = list(envelope.outline)
    loops: list[Array] = []
    while left:
        arc: EnvelopeArc | None = next((each for each in left if abs(each.point(each.start)[0]) < TOUCH), left[0])
        points: list[Array] = []
        while arc is not None:
            left.remove(arc)
            points.append(arc.points())
            arc = _next(arc, left)
        loops.append(np.concatenate([*points, points[0][:1]]))
    return tuple(loops)


def _next(arc: EnvelopeArc, others: Sequence[EnvelopeArc]) -> EnvelopeArc | None:
    """The arc that starts where this one ends."""
    end = arc.point(arc.end)
    return next((other for other in others if math.dist(other.point(other.start), end) < TOUCH), None)
