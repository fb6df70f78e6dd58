"""The motions of a running program, put on the clock one after the other, and the table of what each of them was."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.kuka_pose import status
from lwr_dyn.krl import statements as s
from lwr_dyn.krl.controller import Controller
from lwr_dyn.krl.diagnosis import Place
from lwr_dyn.krl.evaluate import Environment, number_of, value_of
from lwr_dyn.krl.legs import Leg, track_between
from lwr_dyn.krl.planner import Blend, appended, joint_leg, pose_leg, ptp_flip, tool_pose
from lwr_dyn.krl.targets import Where, axes_of_point, point_in_world
from lwr_dyn.krl.timeline import Rest, Timeline
from lwr_dyn.krl.values import HaltError, Struct, Value, is_axes, pose_matrix, pose_value

LONGEST_WAIT = 1e7
"""[s]"""


@dataclass(frozen=True, slots=True, eq=False)
class Done:
    """One motion or pause that was carried out: where it stands, what it was, from when to when, where it ended."""

    place: Place
    kind: str
    begin: float
    end: float
    q: Array
    overlap: float = 0.0
    """[s] at its beginning, in which the motion before still ended."""


@dataclass(slots=True, eq=False)
class Motions:
    """Where the arm goes; `advance` says whether the next motion may be begun before the last one has ended."""

    controller: Controller
    say: Callable[[str, str, str, str], None]
    timeline: Timeline = field(init=False)
    done: list[Done] = field(default_factory=list)
    blend: Blend | None = None
    advance: bool = True
    kept: bool = False
    count: int = 0
    unmodelled: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.timeline = Timeline(self.controller.arm)

    def move(self, env: Environment, x: s.Move, place: Place) -> None:
        """Plan one motion; raises `HaltError`."""
        first = self.count == 0
        self.count += 1
        self._speed_set(x, first)
        kind = x.kind.removeprefix("S").removesuffix("_REL")
        if kind not in ("PTP", "LIN", "CIRC"):
            raise HaltError("not-modelled", f"{x.kind} is not modelled", "PTP, LIN, CIRC, SPTP, SLIN, SCIRC are")
        point = self._point(env, x.target, x)
        if kind == "PTP":
            leg, q = self._ptp(point, first)
        else:
            through = None if x.auxiliary is None else self._point(env, x.auxiliary, x)
            angle = None if x.angle is None else float(np.radians(number_of(env, x.angle, "CA")))
            leg, q = self._in_space(point, through, angle, first)
        if q is not None:
            self._put(x, place, leg, q)

    def wait(self, seconds: float, place: Place) -> None:
        """Stand still; raises `HaltError` for a time that makes no sense."""
        self.stop_advance()
        if not seconds <= LONGEST_WAIT:
            raise HaltError("number-range", f"WAIT SEC {seconds:g}", f"at most {LONGEST_WAIT:g} s")
        q = self.controller.q
        if seconds > 0.0 and q is not None:
            entry = self.timeline.add(Rest(q, seconds))
            self.done.append(Done(place, "WAIT", entry.begin, entry.end, q))

    def stop_advance(self) -> None:
        """The program looks at the world: what is moving ends first, unless CONTINUE stands before."""
        if not self.kept:
            self.advance = False

    def keep_advance(self) -> None:
        """CONTINUE: the next statement does not stop the advance run."""
        self.kept = True

    def note_unmodelled(self, name: str) -> None:
        """A subprogram of the controller that moves nothing here."""
        if name not in self.unmodelled and not name.startswith("IR_STOP"):
            self.unmodelled.add(name)
            self.say("note", "not-modelled", f"{name} is not carried out", "")

    def _point(self, env: Environment, target: object, x: s.Move) -> Value:
        value = value_of(env, target)  # type: ignore[arg-type]
        return self._relative(value, x) if x.kind.endswith("_REL") else value

    def _relative(self, value: Value, x: s.Move) -> Value:
        """The absolute point of a relative one: axes and components add to where the arm stands, #TOOL composes."""
        now = self._now(axes=isinstance(value, Struct) and is_axes(value))
        if not isinstance(value, Struct):
            raise HaltError("type", "a relative motion to what is no structure", "{X 10} or {A1 10}")
        if not is_axes(value) and x.frame is not None and x.frame.upper() == "TOOL":
            step = Struct("FRAME", {**dict.fromkeys("XYZABC", 0.0), **value.parts})
            return pose_value(pose_matrix(now, "where the arm stands") @ pose_matrix(step, "the step"), "FRAME")
        parts = dict(now.parts)
        for name, step_ in value.parts.items():
            before = parts.get(name, 0.0)
            if isinstance(before, int | float) and isinstance(step_, int | float):
                parts[name] = before + step_
        if not is_axes(value):
            parts = {name: parts[name] for name in "XYZABC"}
        return Struct(now.type if is_axes(value) else "FRAME", parts)

    def _now(self, axes: bool) -> Struct:
        found = self.controller.position("$AXIS_ACT" if axes else "$POS_ACT")
        if self.controller.q is None or not isinstance(found, Struct):
            raise HaltError("first-motion", "a relative motion before the arm stands anywhere", "begin with a full PTP")
        return found

    def _where(self) -> Where:
        c = self.controller
        pose = None if c.q is None else c.position("$POS_ACT")
        return Where(c.arm, c.q, c.base, c.tool, pose if isinstance(pose, Struct) else None)

    def _ptp(self, point: Value, first: bool) -> tuple[Leg | None, Array | None]:
        c = self.controller
        q = axes_of_point(self._where(), point, first, self.say)
        if q is None:
            return None, None
        if c.q is None:
            return None, q
        if isinstance(point, Struct) and not is_axes(point):
            ptp_flip(c.arm, c.q, q, self.say)
        return joint_leg(c.arm, c.q, q, c.speeds()), q

    def _in_space(
        self, point: Value, through: Value | None, angle: float | None, first: bool
    ) -> tuple[Leg | None, Array | None]:
        c = self.controller
        if first:
            self.say("error", "first-motion", "the first motion is not a PTP", "begin with PTP to a full position")
        if not isinstance(point, Struct) or (through is not None and not isinstance(through, Struct)):
            raise HaltError("type", "the target is no structure", "a FRAME, POS or E6POS")
        if is_axes(point):
            raise HaltError("type", "LIN and CIRC go to poses, not to axes", "a FRAME, POS or E6POS")
        where = self._where()
        if c.q is None:
            # where the path begins is not known; whether its end can be reached is
            axes_of_point(where, Struct("FRAME", dict(point.parts)), False, self._only_errors)
            return None, None
        self._status(point)
        via = None if through is None else point_in_world(where, through)
        track = track_between(tool_pose(c.arm, c.q, c.tool), point_in_world(where, point), via, angle)
        leg = pose_leg(c.arm, c.q, c.tool, track, c.speeds(), self.say)
        if leg is None:
            still = track.length < 1e-9 and track.angle < 1e-9
            return None, c.q if still else None
        return leg, leg.end

    def _only_errors(self, severity: str, code: str, message: str, hint: str) -> None:
        if severity == "error":
            self.say(severity, code, message, hint)

    def _status(self, point: Struct) -> None:
        c = self.controller
        asked = point.parts.get("S")
        assert c.q is not None
        now = status(c.arm, c.q)
        if isinstance(asked, int) and asked & 7 != now:
            message = f"the point has S {asked}, the path keeps S {now}: LIN and CIRC do not change it"
            self.say("warning", "status-turn", message, "go there by PTP, or teach the point again")

    def _put(self, x: s.Move, place: Place, leg: Leg | None, q: Array) -> None:
        c = self.controller
        blend = self.blend if self.advance else None
        if c.q is None:
            # block coincidence: where the arm comes from is not the program's
            self.timeline.add(Rest(q, 0.0))
            self.done.append(Done(place, f"{x.kind} (start)", 0.0, 0.0, q))
        elif leg is not None:
            entry = appended(self.timeline, leg, blend, c.tool)
            self.done.append(Done(place, x.kind, entry.begin, entry.end, q, entry.overlap))
        c.q = q
        self.blend, self.advance = c.blend(x.blends), True

    def _speed_set(self, x: s.Move, first: bool) -> None:
        which = "PTP" if "PTP" in x.kind else "CP"
        if which in self.controller.speed_set:
            return
        self.controller.speed_set.add(which)
        name = "BAS(#VEL_PTP, 100)" if which == "PTP" else "$VEL.CP = 0.2"
        assumed = "100 % of each axis" if which == "PTP" else f"{self.controller.settings.vel_cp:g} m/s"
        message = (
            f"no velocity is set before the first {'PTP' if which == 'PTP' else 'LIN or CIRC'}: {assumed} is assumed"
        )
        self.say("warning", "no-velocity", message, f"set it: {name}")
