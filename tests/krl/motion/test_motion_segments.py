"""Motions whose time and place are worked out by hand; a blend stays within its distance and saves time."""

import math
from itertools import pairwise

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.krl.motion.motion_segments import PtpSegment
from lwr_dyn.krl.motion.timeline import _share_near
from lwr_dyn.krl.robot.kuka_pose import kuka_pose
from tests.krl.short_programs import HOME, run_of

SPEEDS = ("$VEL.CP = 0.5", "$ACC.CP = 2")
CORNER = ("$APO.CDIS = 50", "LIN_REL {Y 300} C_DIS", "LIN_REL {Z -300}")


def test_ptp_of_60_deg_and_lin_of_400_and_of_50_mm(arm):
    """60 deg at 140 deg/s, and 0.4 s for the ramps; 0.4 m at 0.5 m/s with ramps of 0.25 s, then a triangle of 0.05 m at
    2 m/s^2."""
    assert run_of(arm, HOME, "PTP_REL {A1 60, A2 5}").cycle_time == pytest.approx(60 / 140 + 0.4, abs=1e-9)
    run = run_of(arm, HOME, *SPEEDS, "LIN_REL {Y 400}", "LIN_REL {Z -50}")
    assert run.cycle_time == pytest.approx(1.05 + 2 * math.sqrt(0.05 / 2), abs=1e-9)


@pytest.mark.parametrize("at_end", [False, True])
def test_the_share_of_a_turn_about_axis_1_within_a_distance_is_that_of_the_chord(arm, at_end):
    q = np.radians([[0.0, -90.0, 90.0, 0.0, 30.0, 0.0], [60.0, -90.0, 90.0, 0.0, 30.0, 0.0]])
    radius = np.linalg.norm(lwr_dyn.forward_kinematics(arm, q[0])[:2, 3])
    share = _share_near(PtpSegment(arm, *q, None, None), np.eye(4), 0.1, at_end)
    assert share == pytest.approx(2.0 * math.asin(0.05 / radius) / math.radians(60.0), rel=1e-6)


@pytest.mark.parametrize("turn", [360, -90])
def test_circ_of_radius_150(arm, turn):
    run = run_of(arm, HOME, *SPEEDS, f"CIRC_REL {{Y 150, Z 150}}, {{Z 300}}, CA {turn}")
    T = lwr_dyn.forward_kinematics(arm, run.timeline.sample(np.linspace(0.0, run.cycle_time, 200)).q)
    away = T[:, :3, 3] - (T[0, :3, 3] + [0, 0, 0.15])
    assert np.abs(np.linalg.norm(away, axis=1) - 0.15).max() < 1e-11
    # from below the centre a right angle against the auxiliary point's side ends at its -Y
    end = {360: [0, 0, -0.15], -90: [0, -0.15, 0]}[turn]
    assert np.abs(away[-1] - end).max() < 1e-9


def test_base_and_tool(arm):
    """The point lies (0, 70.711, 0) from (950, 300, 800); the tool, 150 long, points down and forward at 45 deg."""
    run = run_of(arm, "$BASE = {X 950, Y 300, Z 800, A 45, B 0, C 0}", "$TOOL = {X 0, Y 0, Z 150, A 0, B 0, C 0}",
                 HOME, "PTP {X 50, Y 50, Z 0, A -135, B 45, C 180}")  # fmt: skip
    p = kuka_pose(arm, run.executed[-1].q)
    assert [p.x_mm, p.y_mm, p.z_mm] == pytest.approx([950.0, 264.645, 906.066], abs=1e-3)
    assert [p.a_deg, p.b_deg, abs(p.c_deg)] == pytest.approx([-90, 45, 180], abs=1e-9)


def test_c_dis_at_a_right_angle(arm):
    """The two ramps share sqrt(2 d/a), and the corner is passed at d/(2 sqrt(2))."""
    run = run_of(arm, HOME, *SPEEDS, *CORNER)
    assert run.cycle_time == pytest.approx(2 * 0.85 - math.sqrt(2 * 0.05 / 2), abs=1e-9)
    corner = lwr_dyn.forward_kinematics(arm, run.executed[1].q)[:3, 3]
    item = run.timeline.items[-1]
    t = item.begin + item.overlap * np.linspace(0.0, 1.0, 201)
    p = lwr_dyn.forward_kinematics(arm, run.timeline.sample(t).q)[:, :3, 3]
    assert np.linalg.norm(p - corner, axis=1).min() == pytest.approx(0.05 / (2 * math.sqrt(2)), abs=1e-9)


@pytest.mark.parametrize(("setting", "keyword", "distance"), [
    ("$APO.CDIS = 20", "C_DIS", 20.0),
    ("$APO.CDIS = 400", "C_DIS", 62.5),  # the whole ramp: v^2/(2 a)
    ("$APO.CVEL = 50", "C_VEL", 15.625),  # half the speed: a quarter of the ramp's way
    ("$APO.CVEL = 100", "C_VEL", 62.5),
    ("$APO.CORI = 2", "C_ORI", 20.0),  # 2 of 30 deg on 300 mm
])  # fmt: skip
def test_where_a_corner_begins(arm, setting, keyword, distance):
    """Both motions turn by 30 deg on 300 mm, so the three kinds can be compared."""
    run = run_of(arm, HOME, *SPEEDS, setting, f"LIN_REL {{Y 300, C 30}} {keyword}", "LIN_REL {Z -300, C -30}")
    assert run.executed[-1].overlap == pytest.approx(math.sqrt(2 * distance / 1e3 / 2), rel=1e-9)


def test_a_corner_passed_backwards_has_the_same_shares(arm):
    """Of motions of the axes: the tool's way near the corner is not that near the other ends."""
    at = (-60, 20), (-90, 90), (-60, 60)
    points = [f"PTP {{A1 0, A2 {a2}, A3 {a3}, A4 0, A5 30, A6 0}} C_DIS" for a2, a3 in at]
    corners = []
    for way in (points, points[::-1]):
        run = run_of(arm, *SPEEDS, "$APO.CDIS = 90", *way)
        corners.append(run.timeline.items[-1].corner)
    there, back = corners
    assert (back.before, back.after) == pytest.approx((there.after, there.before), rel=1e-6)
    assert there.before != pytest.approx(there.after, rel=0.1)


def test_c_ptp_takes_its_share_of_half_the_way(arm):
    for percent, share in ((100, 0.5), (20, 0.1)):
        run = run_of(arm, HOME, f"$APO.CPTP = {percent}", "PTP_REL {A1 20} C_PTP", "PTP_REL {A1 20}")
        # 20 deg is a triangle: 350 deg/s^2
        assert run.executed[-1].overlap == pytest.approx(math.sqrt(2 * share * 20 / 350), rel=1e-9)


def test_a_constant_orientation_is_kept_and_what_is_assumed_is_listed(arm):
    block = ("SPLINE", "SLIN_REL {Y -50, B -20}", "SPL_REL {Y -50, B -20}", "ENDSPLINE")
    run = run_of(arm, HOME, "$ORI_TYPE = #CONSTANT", "LIN_REL {Y 100, C 20}", *block)
    R = lwr_dyn.forward_kinematics(arm, np.array([x.q for x in run.executed]))[:, :3, :3]
    assert (len(R), np.abs(R - R[0]).max() < 1e-9) == (4, True)

    def assumed(*lines):
        return {x.name for x in run_of(arm, HOME, *SPEEDS, *lines).assumptions}

    assert {"points passed without a stop", "SPLINE"} <= assumed(*CORNER, "SPLINE", "SLIN_REL {Y 20}", "ENDSPLINE")
    plain = assumed("LIN_REL {Y 20}")
    assert not any("points" in x for x in plain)
    turned = {"$ORI_TYPE": "JOINT", "$CIRC_TYPE": "PATH", "$IPO_MODE": "TCP"}
    for name, value in turned.items():
        assert assumed(f"{name} = #{value}", "LIN_REL {Y 20}") == plain | {f"{name} #{value}"}
        assert assumed(f"{name} = #BASE", "LIN_REL {Y 20}") == plain


@pytest.mark.parametrize(
    ("kind", "radius", "across"), [("CIRC", 10, 1.0), ("CIRC", 50, 0.8), ("SCIRC", 10, 1.0), ("SPLINE", 10, 1.0)]
)
def test_what_acts_across_an_arc(arm, kind, radius, across):
    """v^2 / radius at 0.2 m/s: $ACC.CP of 1 m/s^2 bounds it, and the run of a CIRC that is slower for it tells."""
    arc = f"{kind.replace('SPLINE', 'SCIRC')}_REL {{X {radius}, Y {radius}}}, {{X {2 * radius}, Y 0}}, CA 340"
    run = run_of(arm, HOME, "$ACC.CP = 1", *((kind, arc, "ENDSPLINE") if kind == "SPLINE" else (arc,)))
    t = np.linspace(0.3, 0.7, 4001) * run.timeline.duration
    places = lwr_dyn.forward_kinematics(arm, run.timeline.sample(t).q)[:, :3, 3]
    speed = np.linalg.norm(np.diff(places, axis=0), axis=1) / (t[1] - t[0])
    assert 1e3 * speed.max() ** 2 / radius == pytest.approx(across, rel=2e-2)
    assert ("CIRC" in [x.name for x in run.assumptions]) == (across == 1.0 and kind != "SPLINE")


@pytest.mark.parametrize(("radius", "acc"), [(5, 0.5), (40, 0.5), (150, 0.5), (5, 2.3), (40, 2.3), (150, 2.3)])
def test_the_time_of_an_arc_is_that_of_its_law(arm, radius, acc):
    """v = min($VEL.CP, sqrt($ACC.CP r)), and v/a more for the ramps; a LIN of that length is faster."""
    v, way = min(0.8, math.sqrt(acc * radius / 1e3)), math.pi * radius / 1e3
    arc = f"CIRC_REL {{X {radius}, Y {radius}}}, {{X {2 * radius}, Y 0}}"
    run = run_of(arm, HOME, "$VEL.CP = 0.8", f"$ACC.CP = {acc}", arc)
    expected = way / v + v / acc if way > v**2 / acc else 2 * math.sqrt(way / acc)
    assert run.duration == pytest.approx(expected, abs=1e-9)


def from_segment(p, a, b):
    along = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(p - a - along[:, None] * (b - a), axis=1)


@pytest.mark.parametrize("distance", [1.0, 10.0, 40.0])
def test_blends_stay_inside_their_distance_and_save_time(arm, distance):
    way = ["LIN_REL {Y 150} C_DIS", "LIN_REL {Z -120} C_DIS", "LIN_REL {X -100, Z 50}"]
    lines = [HOME, f"$APO.CDIS = {distance}", *way]
    run, stops = run_of(arm, *lines), run_of(arm, *(x.replace(" C_DIS", "") for x in lines))
    assert run.cycle_time < stops.cycle_time
    t = np.linspace(0.0, run.cycle_time, 4001)
    p = lwr_dyn.forward_kinematics(arm, run.timeline.sample(t).q)[:, :3, 3]
    # off the polyline only within the distance of a corner, and off it everywhere else by nothing
    nodes = [lwr_dyn.forward_kinematics(arm, d.q)[:3, 3] for d in run.executed]
    off = np.min([from_segment(p, a, b) for a, b in pairwise(nodes)], axis=0)
    near = np.min([np.linalg.norm(p - c, axis=1) for c in nodes[1:-1]], axis=0)
    assert near[off > 1e-8].max() <= distance / 1e3 + 1e-9
    assert off.max() > 0.05 * distance / 1e3
    assert [d.overlap > 0 for d in run.executed] == [False, False, True, True]


def test_ptp_into_lin_is_passed_within_the_distance(arm):
    run = run_of(arm, HOME, "$APO.CDIS = 15", "$APO.CPTP = 100", "PTP_REL {A1 30} C_PTP C_DIS", "LIN_REL {Z -100}")
    entry = run.timeline.items[2]
    assert entry.overlap > 0
    corner = lwr_dyn.forward_kinematics(arm, run.executed[1].q)[:3, 3]
    t = np.linspace(entry.begin, entry.begin + entry.overlap, 50)
    lin = np.linalg.norm(lwr_dyn.forward_kinematics(arm, entry.part.axes(t - entry.begin).q)[:, :3, 3] - corner, axis=1)
    assert lin.max() <= 0.015 + 1e-9


@pytest.mark.parametrize("between", ["WAIT SEC 0.5", "$OUT[1] = TRUE", "WAIT FOR $OUT[1]==FALSE", "HALT"])
def test_a_look_at_the_world_ends_the_blend_unless_continue_stands_before(arm, between):
    head = (HOME, "$APO.CDIS = 20", "LIN_REL {Y 100} C_DIS")
    run = run_of(arm, *head, between, "LIN_REL {Z 50}")
    assert run.executed[-1].overlap == 0.0
    if between == "HALT":
        assert [(x.kind, x.text, x.time) for x in run.events] == [("halt", "HALT", run.executed[1].end)]
        assert "HALT: the program is started again at once" in map(str, run.assumptions)
    if "OUT" in between:
        assert run_of(arm, *head, "CONTINUE", between, "LIN_REL {Z 50}").executed[-1].overlap > 0.0
