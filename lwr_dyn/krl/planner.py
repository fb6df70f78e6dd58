"""Motions as a controller plans them: laws under the speeds that are set, tracks on one branch, blends, and faults."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.kinematics.forward import forward_kinematics
from lwr_dyn.kinematics.jacobian import jacobian_at, joint_axes
from lwr_dyn.kinematics.kuka_pose import status
from lwr_dyn.kinematics.spherical_wrist import all_branches
from lwr_dyn.krl.legs import TURN, JointLeg, Leg, PoseLeg, Track, steps_of
from lwr_dyn.krl.targets import Say
from lwr_dyn.krl.timeline import Entry, Rest, Timeline, ramp_seconds, seconds_near, seconds_within
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.lspb import trapezoid

NEAR = np.radians(1.0)
"""[rad] A5 this near to 0 on a track in space: axes 4 and 6 are in line."""
FLIP = np.radians(90.0)
"""[rad] A4 or A6 turning by more between two places 5 mm or 1 deg apart has flipped."""
STILL = 1e-9
"""[rad] A move this small is none."""


@dataclass(frozen=True, slots=True, eq=False)
class Speeds:
    """What is set when a motion is planned: axes (n,) [rad/s, rad/s^2], path [m/s, m/s^2], orientation [rad/s ...]."""

    axis: Array
    axis_ramp: Array
    cp: float
    cp_ramp: float
    ori: float
    ori_ramp: float


@dataclass(frozen=True, slots=True)
class Blend:
    """How a point may be passed: the words of the statement, and the distances that hold when it is planned."""

    kinds: tuple[str, ...]
    cdis: float
    """[m]"""
    cptp: float
    """[%]"""
    cori: float
    """[rad]"""
    cvel: float
    """[%]"""


def joint_leg(arm: Arm, start: Array, end: Array, speeds: Speeds) -> JointLeg | None:
    """PTP: all axes begin and end together, the slowest sets the law; None when nothing moves."""
    way = np.abs(end - start)
    moved = way > STILL
    if not moved.any():
        return None
    speed = float(np.min(speeds.axis[moved] / way[moved]))
    ramp = float(np.min(speeds.axis_ramp[moved] / way[moved]))
    return JointLeg(arm, start, end, trapezoid(1.0, speed, ramp))


def pose_leg(arm: Arm, start: Array, tool: Array, track: Track, speeds: Speeds, say: Say) -> PoseLeg | None:
    """LIN or CIRC from axes `start` (n,): None when nothing moves, or when the track leaves reach or limits (said)."""
    if track.length < 1e-9 and track.angle < STILL:
        return None
    parts = [(track.length, speeds.cp, speeds.cp_ramp), (track.angle, speeds.ori, speeds.ori_ramp)]
    moving = [(way, v, a) for way, v, a in parts if way > 1e-9]
    law = trapezoid(1.0, min(v / way for way, v, _ in moving), min(a / way for way, _, a in moving))
    table = _table(arm, start, tool, track, say)
    if table is None:
        return None
    branch, q = table
    leg = PoseLeg(arm, tool, track, law, branch, q)
    return leg if _limits(arm, q, say) and _speeds(leg, say) else None


def _table(arm: Arm, start: Array, tool: Array, track: Track, say: Say) -> tuple[int, Array] | None:
    s = np.linspace(0.0, 1.0, steps_of(track))
    still = np.zeros_like(s)
    poses = track.at(s, still, still)
    T = np.zeros((len(s), 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = poses.R, poses.p, 1.0
    found = all_branches(arm, T @ np.linalg.inv(tool))
    away = np.abs((found.q[0] - start + np.pi) % TURN - np.pi).max(axis=-1)
    branch = int(np.nanargmin(np.where(np.isnan(away), np.inf, away)))
    excess = found.reach_excess[:, branch]
    if (excess > 0.0).any():
        k = int(np.argmax(excess))
        message = f"the path is out of reach by {1e3 * excess[k]:.4g} mm, {100 * s[k]:.0f} % along"
        say("error", "out-of-reach", message, "move the points nearer, or go there by PTP")
        return None
    wrist = found.clearance[:, branch, 2]
    passed = int(np.argmin(wrist))
    q = np.unwrap(np.vstack([start, found.q[:, branch]]), axis=0)[1:]
    if wrist[passed] < NEAR:
        message = f"the path passes the wrist singularity {100 * s[passed]:.0f} % along (A5 {_deg(q[passed, 4])} deg)"
        say("error", "singularity", message, "go there by PTP, or tilt the tool")
    if np.abs(q[0] - start).max() > 1e-6:
        if wrist[passed] >= NEAR:
            say("error", "singularity", "the path begins where axes are not determined", "leave the place by PTP")
        return None
    return (branch, q) if _no_flip(q, s, say) else None


def _no_flip(q: Array, s: Array, say: Say) -> bool:
    step = np.abs(np.diff(q[:, [3, 5]], axis=0))
    k, axis = np.unravel_index(int(np.argmax(step)), step.shape)
    if step[k, axis] <= FLIP:
        return True
    name = ("A4", "A6")[int(axis)]
    message = f"the wrist flips: {name} turns by {_deg(step[k, axis])} deg at once, {100 * s[k]:.0f} % along"
    say("error", "wrist-flip", message, "go there by PTP, or keep A5 away from 0")
    return False


def _limits(arm: Arm, q: Array, say: Say) -> bool:
    over = np.maximum(q - arm.upper, arm.lower - q)
    k, i = np.unravel_index(int(np.argmax(over)), over.shape)
    if over[k, i] <= 1e-9:
        return True
    along = 100.0 * k / max(len(q) - 1, 1)
    message = f"{arm.joint_names[int(i)]} leaves its range by {_deg(over[k, i])} deg, {along:.0f} % along the path"
    say("error", "outside-limits", message, "another Status at the start, or a PTP")
    return False


def _speeds(leg: PoseLeg, say: Say) -> bool:
    """Axis speeds on the track against what the axes can do."""
    arm, s = leg.arm, np.linspace(0.0, 1.0, len(leg.table))
    half = float(leg.law.coefficients[0, 2])  # half the acceleration
    rate = np.minimum(np.sqrt(4.0 * half * np.minimum(s, 1.0 - s)), 2.0 * half * leg.law.knots[1])
    poses = leg.track.at(s, rate, np.zeros_like(s))
    axes = joint_axes(arm.chain, leg.table)
    try:
        J = jacobian_at(axes, poses.p)
        dq = np.linalg.solve(J, np.hstack([poses.v, poses.w])[..., None])[..., 0]
    except np.linalg.LinAlgError:
        say("error", "singularity", "the path meets a singularity", "go there by PTP")
        return False
    use = np.abs(dq) / arm.velocity
    k, i = np.unravel_index(int(np.argmax(use)), use.shape)
    if use[k, i] > 1.0 + 1e-9:
        name, along = arm.joint_names[int(i)], 100 * s[k]
        asked, allowed = _deg(abs(dq[k, i])), _deg(arm.velocity[i])
        message = f"{name} would have to turn at {asked} deg/s, {along:.0f} % along; it can do {allowed} deg/s"
        say("error", "axis-speed", message, f"slower by the factor {use[k, i]:.3g} ($VEL.CP, $ACC.CP), or a PTP")
    return True


def ptp_flip(arm: Arm, start: Array, end: Array, say: Say) -> None:
    """Say so when a PTP between two poses turns the wrist over: A5 changes its sign and A4 turns far."""
    if (status(arm, start) ^ status(arm, end)) & 4 and abs(end[3] - start[3]) > FLIP:
        message = (
            f"the wrist turns over: A5 from {_deg(start[4])} to {_deg(end[4])} deg, A4 by {_deg(end[3] - start[3])} deg"
        )
        say("warning", "wrist-flip", message, "S with the same bit 2 as the point before keeps the wrist")


def appended(timeline: Timeline, leg: Leg, blend: Blend | None, tool: Array) -> Entry:
    """The leg on the clock, begun before the one before it ends where a blend allows it."""
    before = timeline.entries[-1].part if timeline.entries else None
    if blend is None or before is None or isinstance(before, Rest):
        return timeline.add(leg)
    overlap = min(_tail(before, blend, tool, True), _tail(leg, blend, tool, False))
    return timeline.add(leg, overlap if overlap > 1e-9 else 0.0)


def _tail(leg: Leg, blend: Blend, tool: Array, tail: bool) -> float:
    """How long [s] before its end (or after its begin) a leg is inside what the blend allows."""
    kind = blend.kinds[0]
    if kind == "C_PTP" and isinstance(leg, JointLeg):
        return seconds_within(leg, 0.5 * min(blend.cptp, 100.0) / 100.0, tail)
    kind = _in_space(blend.kinds)
    if kind == "C_VEL":
        return ramp_seconds(leg, tail) * min(blend.cvel, 100.0) / 100.0
    if kind == "C_ORI" and isinstance(leg, PoseLeg) and leg.track.angle > 0.0:
        return seconds_within(leg, blend.cori / leg.track.angle, tail)
    return seconds_near(leg, tool, blend.cdis, tail)


def _in_space(kinds: Sequence[str]) -> str:
    return next((kind for kind in reversed(kinds) if kind != "C_PTP"), "C_DIS")


def tool_pose(arm: Arm, q: Array, tool: Array) -> Array:
    """T_{base,tcp} (4, 4) [m] at q (n,)."""
    return np.asarray(forward_kinematics(arm.chain, q) @ tool)


def _deg(x: float) -> str:
    return f"{np.degrees(x):.4g}"
