"""Moves the arm of a running program: plans one motion after another onto the timeline, and lists them.

The motions between SPLINE and ENDSPLINE are collected as the program runs, and planned together at its end.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.diagnostics import ExecutionError, Report, Severity, SourcePosition
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.motion import motion_segments
from lwr_dyn.krl.motion.motion_segments import AxisSplineSegment, CartesianSegment, MotionSegment, tool_pose
from lwr_dyn.krl.motion.pose_paths import Blend, Speeds, inside_limits, path_between, seconds_at
from lwr_dyn.krl.motion.splines import SplinePoint, axis_spline_segment, spline_pieces, spline_segment
from lwr_dyn.krl.motion.timeline import Pause, Timeline, append_segment
from lwr_dyn.krl.robot.kuka_pose import status
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.evaluate import Environment, number_of, value_of
from lwr_dyn.krl.running.targets import RobotState, absolute_point, axes_of_point, led_pose, point_in_world
from lwr_dyn.krl.running.values import StructValue, Value, axes_value, pose_value

LONGEST_WAIT = 1e7
"""[s]"""
PASSED = "the ramps of two motions overlap, which gives sqrt(a L) at points L apart; no KUKA figure tests it"
ACROSS = "slower than $VEL.CP, so that v^2 / radius <= $ACC.CP across its path; no KUKA figure tests it"


@dataclass(frozen=True, slots=True, eq=False)
class ExecutedMotion:
    """A motion or pause of a run: the position of its statement, its kind, begin and end [s], the axes at its end."""

    position: SourcePosition
    kind: str
    begin: float
    end: float
    q: Array
    tcp: Array
    """(4, 4) [m] The tool centre point at its end, in the base that is active then."""
    overlap: float = 0.0
    """[s] At its beginning, while the motion before it still ends."""


@dataclass(slots=True, eq=False)
class OpenBlock:
    """A block that is being collected; `settings` are those after its WITH, which hold until it ends."""

    kind: str
    position: SourcePosition
    settings: AbstractContextManager[None]
    pose: Array | None = None
    """(4, 4) [m] Where the last motion of SPLINE ends."""
    q: Array | None = None
    """(n,) [rad] Where the last motion of PTP_SPLINE ends."""
    points: list[SplinePoint] = field(default_factory=list)
    axes: list[Array] = field(default_factory=list)
    speeds: list[Speeds] = field(default_factory=list)
    motions: list[tuple[SourcePosition, str]] = field(default_factory=list)
    """Of each motion its statement's position and its kind."""
    faulty: bool = False
    """Whether a motion has no point, which was reported."""

    def plan(self, c: ControllerState, report: Report) -> list[PlannedPiece] | None:
        """The pieces from stop to stop; None with a fault that is reported."""
        if c.q is None or self.faulty:
            return None
        if self.kind == "PTP_SPLINE":
            return self._plan_axes(c.q, c, report)
        start, planned = tool_pose(c.arm, c.q, c.tool), []
        q = c.q
        for piece in spline_pieces(start, self.points):
            speeds = [self.speeds[k] for k in piece.motions]
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


@dataclass(slots=True, eq=False)
class Motions:
    """The motions of a run; `advance` is whether the next one may begin before the last one has ended."""

    controller: ControllerState
    report: Report
    timeline: Timeline = field(init=False)
    executed: list[ExecutedMotion] = field(default_factory=list)
    still: list[SourcePosition] = field(default_factory=list)
    """Of motions to where the arm stands."""
    blend: Blend | None = None
    advance: bool = True
    kept: bool = False
    """Whether CONTINUE keeps the advance run for this statement."""
    count: int = 0
    spline: bool = False
    """Whether the last motion is one of the spline planner's, which takes SPTP, SLIN, SCIRC and blocks."""
    block: OpenBlock | None = None
    """A spline block that is not ended."""
    idle: float = 0.0
    """[s] Waited before the arm stood anywhere: no part of the timeline."""
    unmodelled: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.timeline = Timeline(self.controller.arm)
        if self.controller.q is not None:  # the routine is called where the arm stands
            self.timeline.add(Pause(self.controller.q, 0.0))

    def move(self, env: Environment, x: s.Move, position: SourcePosition) -> None:
        """Plan one motion; raises `ExecutionError`."""
        first = self.count == 0 and self.controller.cell.called_at_deg is None
        self.count += 1
        self.check_speed_set(x)
        kind = x.kind.removeprefix("S").removesuffix("_REL")
        if kind not in ("PTP", "LIN", "CIRC"):
            raise ExecutionError("not-modelled", f"{x.kind} is not modelled", "PTP, LIN, CIRC, SPTP, SLIN, SCIRC are")
        point = self.point(env, x.target, x)
        if kind == "PTP":
            segment, q = self._ptp(point, first)
        else:
            through = None if x.auxiliary is None else self.point(env, x.auxiliary, x)
            angle = None if x.angle is None else float(np.radians(number_of(env, x.angle, "CA")))
            segment, q = self._cartesian(point, through, angle, first)
        if q is not None:
            self._append(x, position, segment, q)

    def blend_now(self) -> Blend | None:
        """How the next motion may begin before the last one has ended."""
        return self.blend if self.advance and self.controller.advance > 0 else None

    def blend_into(self, kind: str) -> Blend | None:
        """The same for a motion of this kind: a spline is never passed into another kind, nor the other way."""
        before, self.spline = self.spline, kind.startswith("S") or kind == "PTP_SPLINE"
        return self.blend_now() if before == self.spline else None

    @property
    def now(self) -> float:
        """[s] From the start of the program to the end of the motions that are planned."""
        return self.idle + self.timeline.duration

    @property
    def fixed(self) -> float:
        """[s] Until when the motions can no longer change: the last one may still pass into the next."""
        if self.blend_now() is None or not self.timeline.items:
            return self.now
        return self.idle + self.timeline.items[-1].begin

    def axes_at(self, time: float) -> Array | None:
        """Where the arm is at a time [s] (n,) [rad]; None before it stands anywhere."""
        if not self.timeline.items:
            return None
        return np.asarray(self.timeline.sample(np.array([time - self.idle])).q[0])

    def wait(self, seconds: float, position: SourcePosition, kind: str = "WAIT") -> None:
        """Add a pause; raises `ExecutionError` for one that is too long."""
        self.stop_advance()
        if not seconds <= LONGEST_WAIT:
            raise ExecutionError("number-range", f"WAIT SEC {seconds:g}", f"at most {LONGEST_WAIT:g} s")
        q = self.controller.q
        if seconds > 0.0 and q is None:
            self.idle += seconds
        elif seconds > 0.0 and q is not None:
            item = self.timeline.add(Pause(q, seconds))
            last = self.executed[-1] if self.executed else None
            if last is not None and last.kind == kind and last.position == position and kind != "WAIT":
                self.executed[-1] = replace(last, end=item.end)
            else:
                self.note(position, kind, item.begin, item.end, q)

    def note(
        self, position: SourcePosition, kind: str, begin: float, end: float, q: Array, overlap: float = 0.0
    ) -> None:
        """Add a motion or pause to those that are executed."""
        tcp = self.controller.tcp_in_base(q)
        self.executed.append(ExecutedMotion(position, kind, begin, end, q, tcp, overlap))

    def stop_advance(self) -> None:
        """Let the motion end before the program goes on, unless CONTINUE stands before the statement."""
        if not self.kept:
            self.advance = False

    def note_unmodelled(self, name: str) -> None:
        """Report, once, a subprogram of the controller that is not modelled."""
        if name not in self.unmodelled and not name.startswith("IR_STOP"):
            self.unmodelled.add(name)
            self.report("note", "not-modelled", f"{name} is not carried out", "")

    def point(self, env: Environment, target: e.Expression, x: s.Move) -> Value:
        """The point of a motion; that of a relative one made absolute."""
        value = value_of(env, target)
        if not x.kind.endswith("_REL"):
            return value
        return absolute_point(value, self._now(axes=isinstance(value, StructValue) and value.is_axes), x.frame)

    def _now(self, axes: bool) -> StructValue:
        now = self._position("$AXIS_ACT" if axes else "$POS_ACT")
        if self.controller.q is None or not isinstance(now, StructValue):
            message = "a relative motion before the arm stands anywhere"
            raise ExecutionError("first-motion", message, "begin with a full PTP")
        return now

    def _position(self, name: str) -> Value | None:
        """Where the last motion ends; in a spline block that is not planned yet, where its last one does."""
        c = self.controller
        if self.block is None or self.block.q is None or self.block.pose is None:
            return c.position(name)
        if name == "$AXIS_ACT":
            return axes_value(self.block.q)
        pose = self.block.pose if self.block.kind == "SPLINE" else tool_pose(c.arm, self.block.q, c.tool)
        return pose_value(np.linalg.inv(c.base) @ pose, "E6POS")

    def robot(self) -> RobotState:
        """Where the next motion begins."""
        c = self.controller
        pose = None if c.q is None else self._position("$POS_ACT")
        q = c.q if self.block is None else self.block.q
        known = pose if isinstance(pose, StructValue) else None
        return RobotState(c.arm, q, c.base, c.tool, known, c.cell.ignore_turn)

    def _ptp(self, point: Value, first: bool) -> tuple[MotionSegment | None, Array | None]:
        """The segment (None without motion) and the axes at its end (None where they are unknown)."""
        c = self.controller
        q = axes_of_point(self.robot(), point, first, self.report)
        if q is None or c.q is None:
            return None, q
        if isinstance(point, StructValue) and not point.is_axes:
            motion_segments.warn_of_flip(c.arm, c.q, q, self.report)
        return motion_segments.ptp_segment(c.arm, c.q, q, c.speeds()), q

    def _cartesian(
        self, point: Value, through: Value | None, angle: float | None, first: bool
    ) -> tuple[MotionSegment | None, Array | None]:
        """The segment (None without motion) and the axes at its end (None where they are unknown)."""
        c = self.controller
        if first:
            self.report("error", "first-motion", "the first motion is not a PTP", "begin with PTP to a full position")
        if not isinstance(point, StructValue) or (through is not None and not isinstance(through, StructValue)):
            raise ExecutionError("type", "the target is no structure", "a FRAME, POS or E6POS")
        if point.is_axes:
            raise ExecutionError("type", "LIN and CIRC go to poses, not to axes", "a FRAME, POS or E6POS")
        robot = self.robot()
        if c.q is None:
            # the beginning of the path is not known, but its end can be checked
            axes_of_point(robot, StructValue("FRAME", dict(point.parts)), False, self._report_errors)
            return None, None
        self._check_status(point, status(c.arm, c.q))
        via = None if through is None else point_in_world(robot, through)
        start = tool_pose(c.arm, c.q, c.tool)
        path = path_between(start, led_pose(c, start, point_in_world(robot, point)), via, angle)
        segment = motion_segments.cartesian_segment(c.arm, c.q, c.tool, path, c.speeds(), self.report)
        if segment is None:
            return None, c.q if path.is_still else None
        if motion_segments.is_held_back(segment):
            c.assume("CIRC", "", ACROSS)
        return segment, segment.end

    def _report_errors(self, severity: Severity, code: str, message: str, hint: str) -> None:
        if severity == "error":
            self.report(severity, code, message, hint)

    def _check_status(self, point: StructValue, now: int) -> None:
        wanted = point.parts.get("S")
        if isinstance(wanted, int) and wanted & 7 != now:
            message = f"the point has S {wanted}, the path keeps S {now}: LIN and CIRC do not change it"
            self.report("warning", "status-turn", message, "go there by PTP, or teach the point again")

    def _append(self, x: s.Move, position: SourcePosition, segment: MotionSegment | None, q: Array) -> None:
        c = self.controller
        blend = self.blend_into(x.kind)
        if c.q is None:
            # the first motion (KUKA's block coincidence) begins anywhere: it only sets the axes
            self.timeline.add(Pause(q, 0.0))
            self.note(position, f"{x.kind} (start)", 0.0, 0.0, q)
        elif segment is not None:
            item = append_segment(self.timeline, segment, blend, c.tool)
            if item.overlap > 0.0:
                c.assume("points passed without a stop", "", PASSED)
            self.note(position, x.kind, item.begin, item.end, q, item.overlap)
        else:
            self.still.append(position)
        c.q = q
        self.blend, self.advance = c.blend(x.blends), True

    def check_speed_set(self, x: s.Move) -> None:
        """Warn, once, of a motion before any velocity was set."""
        kind = "PTP" if "PTP" in x.kind else "CP"
        if kind in self.controller.speeds_set:
            return
        self.controller.speeds_set.add(kind)
        if "INITMOV" in self.controller.speeds_set:
            if kind == "CP":
                name, speed = "$VEL.CP after BAS(#INITMOV, 0)", f"{self.controller.machine.vel_cp:g} m/s"
                self.controller.assume(name, speed, "no velocity is set after it")
            return
        hint, motions, assumed = "BAS(#VEL_PTP, 100)", "PTP", "100 % of each axis"
        if kind == "CP":
            hint, motions, assumed = "$VEL.CP = 0.2", "LIN or CIRC", f"{self.controller.machine.vel_cp:g} m/s"
        message = f"no velocity is set before the first {motions}: {assumed} is assumed"
        self.report("warning", "no-velocity", message, f"set it: {hint}")


OF_BLOCK = {"SPLINE": {"SPL": "SPL", "SLIN": "LIN", "SCIRC": "CIRC"}, "PTP_SPLINE": {"SPTP": "PTP"}}
"""The motions that a block takes, without _REL, and their kinds of path."""
CURVE = "planned whole on a cubic curve through its points; KUKA's own curve is not published"


@dataclass(frozen=True, slots=True, eq=False)
class PlannedPiece:
    """A segment of a block, the motions of the block in it, and the time [s] in it at which each of them ends."""

    segment: CartesianSegment | AxisSplineSegment
    motions: tuple[int, ...]
    ends: Array


def begin_block(m: Motions, block: OpenBlock) -> None:
    """SPLINE: the motions that follow are planned when the block ends."""
    c = m.controller
    if c.q is None:
        m.report("error", "first-motion", "the first motion is not a PTP", "begin with PTP to a full position")
    else:
        block.q, block.pose = c.q, tool_pose(c.arm, c.q, c.tool)
    m.block = block


def collect(m: Motions, env: Environment, x: s.Move, position: SourcePosition) -> None:
    """Add a motion to the open block; raises `ExecutionError`."""
    block, c = m.block, m.controller
    assert block is not None
    allowed = OF_BLOCK[block.kind]
    if x.kind.removesuffix("_REL") not in allowed:
        raise ExecutionError("spline", f"{x.kind} inside {block.kind}", ", ".join(allowed))
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
        end = SplinePoint(OF_BLOCK["SPLINE"][x.kind.removesuffix("_REL")], place, via, angle)
    if end is None:
        return
    block.speeds.append(c.speeds())
    block.motions.append((position, x.kind))
    if isinstance(end, SplinePoint):
        block.points.append(end)
        block.pose = end.pose
    else:
        block.axes.append(end)
        block.q = end
    block.faulty = before


def _place(m: Motions, point: Value) -> Array:
    """The pose (4, 4) [m] of a point of a path; raises `ExecutionError`."""
    if not isinstance(point, StructValue):
        raise ExecutionError("type", "the target is no structure", "a FRAME, POS or E6POS")
    if point.is_axes:
        raise ExecutionError("type", "a path goes to poses, not to axes", "a FRAME, POS or E6POS")
    return point_in_world(m.robot(), point)


def end_block(m: Motions, blends: tuple[str, ...]) -> None:
    """ENDSPLINE: plan the block, whose settings still hold; raises `ExecutionError`."""
    block, m.block = m.block, None
    pieces = None if block is None else block.plan(m.controller, m.report)
    if block is None or pieces is None:
        return
    if pieces:
        m.controller.assume(block.kind, "", CURVE)
    blend = m.blend_into(block.kind)
    for piece in pieces:
        item = append_segment(m.timeline, piece.segment, blend, m.controller.tool)
        begin, overlap, blend = item.begin, item.overlap, None
        ends = piece.segment.axes(piece.ends).q
        for k, end, q in zip(piece.motions, item.begin + piece.ends, ends, strict=True):
            m.note(*block.motions[k], begin, float(end), q, overlap)
            begin, overlap = float(end), 0.0
        m.controller.q = piece.segment.end
    m.blend, m.advance = m.controller.blend(blends), True
