"""The IST path and its timings, without an arm."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError, OptionError, PathLimitError, ShapeError, UnknownNameError
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.model.run import Event
from lwr_dyn.model.spatial import rot_z
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.trajectory.references.ist import (
    CLEAR_SHIFT,
    POINTS,
    TOOL,
    Twice,
    ist_clear_reference,
    ist_path,
    ist_reference,
    part_of,
    timed_ist,
)
from lwr_dyn.trajectory.references.joint_moves import point_to_point
from lwr_dyn.trajectory.timings import MOTION_PROFILES, SmoothTiming
from tests.trajectory.differences import check_derivatives

ROUNDING = 1e-12


def test_the_path_is_the_one_of_the_drawing():
    """Lines .3 + .1 + .15 + .05 + .3, two half circles of radius .075; S bulges to +y below and to -y above."""
    path = ist_path()
    assert path.length == pytest.approx(0.9 + 2 * math.pi * 0.075, abs=ROUNDING)
    assert [round(math.degrees(c.turn)) for c in path.corners()] == [90, 180, 90]
    assert [round(j.bend, 3) for j in path.joints() if j.is_bend] == [13.333, 26.667, 13.333]
    bulges = path.at([0.4 + 0.0375 * math.pi, 0.4 + 0.1125 * math.pi]).p
    np.testing.assert_allclose(bulges, [[-0.05, -0.275, 0.325], [-0.05, -0.425, 0.475]], atol=ROUNDING)


def test_the_pen_passes_every_point_of_table_v_but_the_two_centres():
    drawn = ist_path().at(np.linspace(0.0, ist_path().length, 137_125)).p
    away = np.array([np.linalg.norm(drawn - p, axis=1).min() for p in POINTS.si()])
    np.testing.assert_allclose(away, [0, 0, 0, 0.075, 0.075, 0, 0, 0, 0], atol=2e-5)  # half a step of the sampling
    assert (POINTS.kind, POINTS.where) == ("printed", "lwr4plus, Table V, columns X, Y, Z, rows 1 to 9")


@pytest.mark.parametrize("timing", MOTION_PROFILES.rows)
def test_every_timing_goes_from_point_1_to_point_9_in_14_s_with_the_tool_along_y(timing):
    poses = timed_ist(timing)
    assert poses.duration == 14.0
    T = poses.at([0.0, 14.0]).T
    np.testing.assert_allclose(T[:, :3, 3], POINTS.si()[[0, 8]], atol=ROUNDING)
    np.testing.assert_allclose(T[:, :3, :3], [TOOL, TOOL])
    np.testing.assert_allclose(T[:, :3, 2], [[0, 1, 0]] * 2)
    assert MOTION_PROFILES[timing].about


@pytest.mark.parametrize("timing", ["smooth", "smooth-blended"])
def test_smooth_timings_bound_acceleration_and_jerk_in_space(timing):
    keep, poses = SmoothTiming(), timed_ist(timing)
    peaks = poses.profile.peaks()
    assert peaks.acceleration <= keep.acceleration * (1 + 1e-9)
    assert peaks.jerk <= keep.jerk * (1 + 1e-9)
    t = np.linspace(0.0, 14.0, 28_001)
    a = poses.at(t).acceleration[:, :3]
    jerk = np.linalg.norm(np.diff(a, axis=0), axis=1).max() / (t[1] - t[0])
    assert jerk < 2.0 * keep.jerk  # along the path plus across it; an uneased bend gives 260 at this step
    assert np.linalg.norm(a, axis=1).max() < 2.0 * keep.acceleration


def test_smooth_stops_at_the_three_corners_only_and_stays_within_a_hundredth_of_a_millimetre():
    """Of the two full circles inside the S, where the eased bends are."""
    moving = timed_ist("smooth").at(np.linspace(0.0, 14.0, 28_001)[1:-1])
    slow = moving.profile.ds < 1e-3
    assert 1 + np.count_nonzero(np.diff(np.flatnonzero(slow)) > 1) == 3 + 2  # and the two ends
    p = moving.T[(moving.profile.s > 0.41) & (moving.profile.s < 0.86), :3, 3]
    off = np.min([np.abs(np.hypot(p[:, 1] + 0.35, p[:, 2] - z) - 0.075) for z in (0.325, 0.475)], axis=0)
    assert off.max() < 1e-5


def test_without_easing_the_path_is_table_v_to_the_letter_and_the_acceleration_jumps_at_the_bends():
    poses, t = timed_ist("smooth", smoothness=SmoothTiming(ease=0.0)), np.linspace(0, 14, 28_001)
    assert poses.length == pytest.approx(ist_path().length, abs=ROUNDING)
    k = int(np.argmin(np.abs(poses.profile.at(t).s - 0.4)))
    sides = poses.at(t[[k - 1, k + 1]])
    jump = np.linalg.norm(np.diff(sides.acceleration[:, :3], axis=0))
    assert jump == pytest.approx(sides.profile.ds[0] ** 2 / 0.075, rel=1e-3)


ARM = lwr_dyn.load("lwr4plus")
TIMES = np.linspace(0.0, 14.0, 1401)


def margin_and_speed(reference):
    """Least distance of a joint to its limits [deg], and the largest share of a speed limit, sample by sample."""
    motion = reference.sample(TIMES)
    margin = np.minimum(motion.q - ARM.lower, ARM.upper - motion.q).min()
    return math.degrees(margin), float((np.abs(motion.dq).max(axis=0) / ARM.velocity).max())


def test_every_joint_keeps_50_degrees_and_a_fifth_of_its_speed():
    for reference, wanted in ((ist_clear_reference(ARM), (50.9, 0.18)), (ist_reference(ARM), (1.2, 0.29))):
        margin, speed = margin_and_speed(reference)
        assert (round(margin, 1), round(speed, 2)) == wanted


def test_the_letters_and_the_tool_are_those_of_ist_or_a_tool_of_ones_own():
    T, there = (reference.poses.at(TIMES).T for reference in (ist_clear_reference(ARM), ist_reference(ARM)))
    np.testing.assert_allclose(T[:, :3, 3] - there[:, :3, 3], np.tile(CLEAR_SHIFT, (len(TIMES), 1)), atol=1e-12)
    np.testing.assert_allclose(T[0, :3, 3], POINTS.si()[0] + CLEAR_SHIFT, atol=1e-12)
    np.testing.assert_array_equal(T[:, :3, :3], np.broadcast_to(TOOL, (len(TIMES), 3, 3)))
    R = rot_z(0.3) @ np.array(TOOL)
    np.testing.assert_allclose(timed_ist("quintic", R_07=R).at([3.0]).T[0, :3, :3], R)


NEIGHBOURS = [tuple(np.add(CLEAR_SHIFT, step * axis).round(9)) for axis in np.eye(3) for step in (-0.1, 0.1)]


@pytest.mark.slow
@pytest.mark.parametrize("shift", [*NEIGHBOURS, (0.4, -0.1, -0.15), (0.05, 0.12, 0.12)])
def test_other_shifts_come_nearer_to_a_limit_or_are_out_of_reach(shift):
    """The last is the best that was known before; all of the grid: scripts/ist_clear.py."""
    try:
        margin, _ = margin_and_speed(ist_reference(ARM, shift=shift))
    except LwrDynError:
        return
    assert margin < 50.0


@pytest.mark.slow
def test_3_kg_that_no_controller_knows_bring_no_joint_to_its_stop():
    """On IST joint 6 falls on its stop within 0.03 s, where the rotors are as light as the authors had them."""
    arm = lwr_dyn.load("lwr4plus", "computed")
    controller, plant = lwr_dyn.controller("inverse-dynamics", arm), arm_with_payload(arm, 3.0)
    figures = {
        name: metrics(lwr_dyn.simulate(arm, controller, lwr_dyn.reference(name, arm), plant=plant, duration=3.0), arm)
        for name in ("ist", "ist-clear")
    }
    assert figures["ist"].stops.sentence() == "joint_6 on its stop for 1.4 s"
    assert figures["ist-clear"].within_limits
    assert np.degrees(figures["ist-clear"].limit_margin).min() > 45.0


@pytest.mark.slow
def test_a_run_names_the_shift(lwr_dyn_command):
    def about(*options):
        code, out, _ = lwr_dyn_command("simulate", "lwr4plus", *options, "--json")
        assert code == 0
        record = json.loads(out)["meta"]
        return record["note"]["task"], record["reference"]["about"].get("shift", {}).get("value")

    assert about("--task", "ist-clear") == about("--task", "ist", "--shift", "0.7,0.6,-0.3")
    assert about("--task", "ist-clear") == ("ist-clear", list(CLEAR_SHIFT))
    assert about("--task", "ist", "--shift", "0.7,0.5,-0.3") == ("ist, moved", [0.7, 0.5, -0.3])


BAD = [
    ({"timing": "cubic"}, UnknownNameError, "known: constant, quintic, smooth, smooth-blended"),
    ({"duration": 0.0}, OptionError, "duration: 0.0"),
    ({"duration": -14.0, "timing": "constant"}, OptionError, "duration: -14.0"),
    ({"duration": 5.0}, OptionError, r"duration: 5 s; allowed: at least 6\.549\d+ s with 4 stops"),
    ({"R_07": np.diag([1.0, 1.0, -1.0])}, OptionError, "R_07: left-handed"),
    ({"R_07": np.eye(4)}, ShapeError, "R_07: an array of 4 x 4 numbers"),
    ({"smoothness": SmoothTiming(ease=0.2)}, OptionError, "blend"),
    ({"smoothness": SmoothTiming(jerk=-1.0)}, OptionError, "jerk: -1.0"),
    ({"shift": (1.0, 2.0)}, ShapeError, "shift: 2 numbers; allowed: 3 numbers"),
    ({"shift": (0.1, float("nan"), 0.0)}, ShapeError, "shift: nan"),
    ({"shift": (2.0, 0.0, 0.0)}, PathLimitError, "1.3 m out of reach"),
    ({"arm_angle": float("nan")}, OptionError, "arm_angle: nan; allowed: a finite number of radians"),
]


@pytest.mark.parametrize(("options", "error", "says"), BAD, ids=[says for *_, says in BAD])
def test_what_cannot_be_is_refused(options, error, says):
    with pytest.raises(error, match=says):
        ist_reference(ARM, **options)


ONCE = point_to_point(ARM, [np.zeros(7), np.linspace(0.2, 0.8, 7)], [2.0])
MOVE = Twice(ONCE, 1.5)


def test_both_passes_are_the_reference():
    t = np.linspace(0.0, 2.0, 41)
    once = ONCE.sample(t)
    for start in (0.0, MOVE.second):
        again = MOVE.sample(t + start)
        for name in ("q", "dq", "ddq"):
            np.testing.assert_allclose(getattr(again, name), getattr(once, name), rtol=0, atol=1e-13)
    assert (MOVE.second, MOVE.duration) == (3.5, 5.5)
    move = lwr_dyn.reference("ist-clear-twice", ARM, back=2.0)
    about = {name: move.about[name] for name in ("task", "back", "second")}
    assert (move.duration, about) == (30.0, {"task": "ist-clear-twice", "back": 2.0, "second": 16.0})
    with pytest.raises(OptionError, match="back"):
        Twice(ONCE, 0.0)


def test_the_way_back_is_a_quintic_with_true_derivatives():
    t, way = np.linspace(2.05, 3.45, 141), np.linspace(0.2, 0.8, 7)
    check_derivatives(MOVE.sample, t, 1e-2, ("q", "dq", "ddq"), atol=1e-11)
    ends, middle = MOVE.sample(np.array([2.0 + 1e-12, 3.5 - 1e-12])), MOVE.sample(np.array([2.75]))
    np.testing.assert_allclose([*middle.q, *middle.dq], [way / 2, -1.875 * way / 1.5], atol=1e-12)
    np.testing.assert_allclose(ends.q, [way, 0 * way], atol=1e-11)
    np.testing.assert_allclose([ends.dq, ends.ddq], 0.0, atol=1e-10)


@pytest.mark.slow
def test_a_part_of_a_run_is_a_run():
    run = lwr_dyn.simulate(ARM, lwr_dyn.controller("adaptive", ARM), MOVE, payload=1.0)
    second = part_of(run, MOVE.second)
    assert (second.t[0], second.t[-1], second.t.size) == (0.0, pytest.approx(2.0), 2001)
    np.testing.assert_array_equal(second.q, run.q[3500:])
    np.testing.assert_array_equal(second.signals["adapted_payload"], run.signals["adapted_payload"][3500:])
    np.testing.assert_array_equal(second.work["actuator"], run.work["actuator"][3500:] - run.work["actuator"][3500])
    assert metrics(second, ARM).tip_rms_mm > 0.0
    assert part_of(run, 0.0, 2.0).t.size == 2001
    eventful = replace(run, events=(Event(1.0, "slip", 2), Event(4.5, "stick", 3)))
    assert part_of(eventful, MOVE.second).events == (Event(1.0, "stick", 3),)  # counted from the part's own start
    with pytest.raises(OptionError, match="part of a run"):
        part_of(run, 9.0)
