"""What the report page of the KR 30 HA shows beside its numbers: its movement, its envelope, its frames."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lwr_dyn.checks.verdict import Report
from lwr_dyn.kinematics.envelope import Envelope
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.curves import torque_plot
from lwr_dyn.reproduction.kr30ha.points import RightPoint
from lwr_dyn.reproduction.outcome import PageExtras
from lwr_dyn.reproduction.pages import audit_of, checks_of
from lwr_dyn.reproduction.report.content import Replay, Still
from lwr_dyn.reproduction.report.envelope_plot import closed_outlines
from lwr_dyn.viewer.figures import Curve, Figure, Panel, Series


def shown(
    arm: Arm,
    right: Sequence[RightPoint],
    envelope: Envelope,
    runs: Sequence[tuple[str, Run]],
    reports: Sequence[Report],
) -> PageExtras:
    """Figures 3 and 4 (envelope), 5 (frames) and 6 (elbow up) of the report, axes and torques of the movement."""
    numbered = [(label, i) for i, (label, _) in enumerate(runs)]
    plots = (
        _side(right, envelope),
        _top(arm, right, envelope),
        _axes(arm, numbered[0][1]),
        torque_plot("torque", "Torques of the movement, estimated masses", numbered[:1], arm),
    )
    stills = (
        Still("Figure 5: DH frames, A = 0", arm, np.zeros(arm.n), "the arm stretched out, KUKA's zero"),
        Still("mastering", arm, np.array(arm.mastering), "A = (0, -90, 90, 0, 0, 0) deg"),
        *(Still(f"Figure 6: {p.name}, elbow up", arm, p.q, "flange there with A = B = C = 0") for p in right[:2]),
    )
    replay = Replay(tuple(r for _, r in runs), (arm,) * len(runs), tuple(label for label, _ in runs), stills)
    return PageExtras(plots, replay, checks_of(reports), audit_of(runs))


def _side(right: Sequence[RightPoint], envelope: Envelope) -> Figure:
    edges = [Curve("envelope", loop[:, 1], loop[:, 0], colour=0) for loop in closed_outlines(envelope)]
    places = np.array([[np.hypot(*p.wrist_mm[:2]), p.wrist_mm[2]] for p in right]) / 1e3
    points = Curve("wrist centre", places[:, 1], places[:, 0], "points", text=tuple(p.name for p in right))
    panel = Panel("section at any A1", "z", "m", (*edges, points))
    note = f"reach {1e3 * envelope.reach:.1f} mm, volume {envelope.volume:.3f} m^3"
    return Figure("figure-3", "Working envelope, side view", "Figure 3", "distance from axis 1", "m", (panel,),
                equal_aspect=True, note=note)  # fmt: skip


def _top(arm: Arm, right: Sequence[RightPoint], envelope: Envelope) -> Figure:
    turn = np.linspace(arm.lower[0], arm.upper[0], 181)
    ring = Curve("reach", -envelope.reach * np.sin(turn), envelope.reach * np.cos(turn))
    places = np.array([p.wrist_mm[:2] for p in right]) / 1e3
    points = Curve("wrist centre", places[:, 1], places[:, 0], "points", text=tuple(p.name for p in right))
    panel = Panel("", "y", "m", (ring, points))
    return Figure("figure-4", "Working envelope, top view", "Figure 4", "x", "m", (panel,), equal_aspect=True)


def _axes(arm: Arm, run: int) -> Figure:
    curves = tuple(Curve(name, Series(run, "q", j, 180.0 / np.pi)) for j, name in enumerate(arm.joint_names))
    return Figure(
        "movement", "Axes over the movement", "", "time", "s", (Panel("", "axis", "deg", curves),), over_time=True
    )
