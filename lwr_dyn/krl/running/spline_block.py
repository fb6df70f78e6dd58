"""The motions between SPLINE and ENDSPLINE: collected as the program runs, planned together at its end."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.diagnostics import ExecutionError, Report, SourcePosition
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.motion.corner import append_segment
from lwr_dyn.krl.motion.motion_segments import AxisSplineSegment, CartesianSegment
from lwr_dyn.krl.motion.path_axes import inside_limits
from lwr_dyn.krl.motion.path_speed import seconds_at
from lwr_dyn.krl.motion.planner import tool_pose
from lwr_dyn.krl.motion.settings import Speeds
from lwr_dyn.krl.motion.spline_path import SplinePoint, spline_pieces
from lwr_dyn.krl.motion.spline_plan import axis_spline_segment, spline_segment
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.evaluate import Environment, number_of
from lwr_dyn.krl.running.motions import ExecutedMotion, Motions
from lwr_dyn.krl.running.orientation_mode import led_pose
from lwr_dyn.krl.running.targets import axes_of_point, point_in_world
from lwr_dyn.krl.running.values import StructValue, Value, is_axes
from lwr_dyn.krl.running.with_settings import WithSettings

OF_BLOCK = {"SPLINE": {"SPL": "SPL", "SLIN": "LIN", "SCIRC": "CIRC"}, "PTP_SPLINE": {"SPTP": "PTP"}}
"""The motions that a block takes, without _REL, and their kinds of path."""

CURVE = "planned whole on a cubic curve through its points; KUKA's own curve is not published"


@dataclass(frozen=True, slots=True, eq=False)
class PlannedPiece:
    """A segment of a block, the motions of the block in it, and the time [s] in it at which each of them ends."""

    segment: CartesianSegment | AxisSplineSegment
    motions: tuple[int, ...]
    ends: Array


@dataclass(slots=True, eq=False)
class OpenBlock:
    """A block that is being collected; `settings` are those after its WITH, which hold until it ends."""

    kind: str
    position: SourcePosition
    settings: WithSettings
    pose: Array | None = None
    """(4, 4) [m] Where the last motion of SPLINE ends."""
    q: Array | None = None
    """(n,) [rad] Where the last motion of PTP_SPLINE ends."""
    points: list[SplinePoint] = field(default_factory=list)
    axes: list[Array] = field(default_factory=list)
    speeds: list[Speeds] = field(default_factory=list)
    positions: list[SourcePosition] = field(default_factory=list)
    kinds: list[str] = field(default_factory=list)
    faulty: bool = False
    """Whether a motion has no point, which was reported."""

    def begin(self, c: ControllerState) -> None:
        """At the place where the arm stands."""
        if c.q is not None:
            self.q, self.pose = c.q, tool_pose(c.arm, c.q, c.tool)

    def check_kind(self, kind: str) -> None:
        """Raises `ExecutionError` for a motion that the block does not take."""
        allowed = OF_BLOCK[self.kind]
        if kind.removesuffix("_REL") not in allowed:
            raise ExecutionError("spline", f"{kind} inside {self.kind}", ", ".join(allowed))

    def add(self, kind: str, position: SourcePosition, speeds: Speeds, point: SplinePoint | Array) -> None:
        """Add a motion to a pose, or to axes (n,) [rad]."""
        self.kinds.append(kind)
        self.positions.append(position)
        self.speeds.append(speeds)
        if isinstance(point, SplinePoint):
            self.points.append(point)
            self.pose = point.pose
        else:
            self.axes.append(point)
            self.q = point

    def plan(self, c: ControllerState, report: Report) -> list[PlannedPiece] | None:
        """The pieces from stop to stop; None with a fault that is reported."""
        if c.q is None or self.faulty:
            return None
        if self.kind == "PTP_SPLINE":
            return self._plan_axes(c.q, c, report)
        start, planned = tool_pose(c.arm, c.q, c.tool), []
        q = c.q
        for piece in spline_pieces(start, self.points):
            speeds = [self.points[k].speeds for k in piece.motions]
            segment = spline_segment(c.arm, q, c.tool, piece, speeds, report)
            if segment is None:
                return None
            planned.append(PlannedPiece(segment, piece.motions, seconds_at(segment.profile, piece.ends)))
            q = segment.end
        return planned

    def _plan_axes(self, start: Array, c: ControllerState, report: Report) -> list[PlannedPiece] | None:
        planned = axis_spline_segment(c.arm, np.array([start, *self.axes]), self.speeds) if self.axes else None
        if planned is None:
            return []
        segment, ends = planned
        if not inside_limits(c.arm, segment.axes_at(np.linspace(0.0, 1.0, 20 * len(ends) + 1)), report):
            return None
        return [PlannedPiece(segment, tuple(range(len(self.axes))), seconds_at(segment.profile, ends))]


def begin_block(m: Motions, block: OpenBlock) -> None:
    """SPLINE: the motions that follow are planned when the block ends."""
    if m.controller.q is None:
        m.report("error", "first-motion", "the first motion is not a PTP", "begin with PTP to a full position")
    block.begin(m.controller)
    m.block = block


def collect(m: Motions, env: Environment, x: s.Move, position: SourcePosition) -> None:
    """Add a motion to the open block; raises `ExecutionError`."""
    block, c = m.block, m.controller
    assert block is not None
    block.check_kind(x.kind)
    m.count += 1
    m.check_speed_set(x)
    # a motion whose point has a fault leaves the block unplanned
    before, block.faulty = block.faulty, True
    point = m.point(env, x.target, x)
    end: SplinePoint | Array | None
    if block.kind == "PTP_SPLINE":
        end = axes_of_point(m.robot(), point, False, m.report)
    else:
        via = None if x.auxiliary is None else _place(m, m.point(env, x.auxiliary, x))
        angle = None if x.angle is None else float(np.radians(number_of(env, x.angle, "CA")))
        place = _place(m, point)
        place = place if block.pose is None else led_pose(c, block.pose, place)
        end = SplinePoint(OF_BLOCK["SPLINE"][x.kind.removesuffix("_REL")], place, c.speeds(), via, angle)
    if end is not None:
        block.add(x.kind, position, c.speeds(), end)
        block.faulty = before


def _place(m: Motions, point: Value) -> Array:
    """The pose (4, 4) [m] of a point of a path; raises `ExecutionError`."""
    if not isinstance(point, StructValue):
        raise ExecutionError("type", "the target is no structure", "a FRAME, POS or E6POS")
    if is_axes(point):
        raise ExecutionError("type", "a path goes to poses, not to axes", "a FRAME, POS or E6POS")
    return point_in_world(m.robot(), point)


def end_block(m: Motions, blends: tuple[str, ...]) -> None:
    """ENDSPLINE: plan the block, whose settings still hold; raises `ExecutionError`."""
    block, m.block = m.block, None
    pieces = None if block is None else block.plan(m.controller, m.report)
    if block is None or pieces is None:
        return
    if pieces:
        m.controller.assumptions.note(block.kind, "", CURVE)
    blend = m.blend_into(block.kind)
    for piece in pieces:
        item = append_segment(m.timeline, piece.segment, blend, m.controller.tool)
        begin, overlap, blend = item.begin, item.overlap, None
        ends = piece.segment.axes(piece.ends).q
        for k, end, q in zip(piece.motions, item.begin + piece.ends, ends, strict=True):
            m.executed.append(ExecutedMotion(block.positions[k], block.kinds[k], begin, float(end), q, overlap))
            begin, overlap = float(end), 0.0
        m.controller.q = piece.segment.end
    m.blend, m.advance = m.controller.blend(blends), True
