"""References from legs: on their lines, exact derivatives, speeds kept, rests between legs."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.model.spatial import rot_z
from lwr_dyn.trajectory.cartesian import tracking
from lwr_dyn.trajectory.cartesian.legs import OFF_CURVE, SHORTEST, LegsReference, Pace, joint_legs, smooth_curve
from lwr_dyn.trajectory.motion_files import WaypointError, read_waypoints
from lwr_dyn.trajectory.pose_path import straight
from tests.random_arms import random_arm
from tests.trajectory.differences import check_derivatives

START = np.array([0.2, 0.6, -0.3, -1.2, 0.4, 0.9, 0.1])
KR30_START = np.radians([0.0, -90.0, 90.0, 0.0, 30.0, 0.0])


@pytest.fixture(scope="module", params=["lwr4plus", "kr30ha"])
def moved(request):
    """The arm, the line's two ends, its reference, and its motion at 801 times."""
    arm = lwr_dyn.load(request.param)
    q = START if request.param == "lwr4plus" else KR30_START
    T = lwr_dyn.forward_kinematics(arm, q)
    end = T[:3, 3] + [0.08, 0.1, -0.06]
    reference = lwr_dyn.reference("line", arm, start=q, to_xyz=end, speed=0.1)
    return arm, T, end, reference, reference.sample(np.linspace(-0.1, reference.duration + 0.1, 801))


def test_the_tip_is_on_its_line_with_its_orientation_and_speed(moved):
    arm, T, end, _, motion = moved
    poses = lwr_dyn.forward_kinematics(arm, motion.q)
    along = end - T[:3, 3]
    share = (poses[:, :3, 3] - T[:3, 3]) @ along / (along @ along)
    off = poses[:, :3, 3] - T[:3, 3] - np.outer(share, along)
    assert max(np.abs(off).max(), np.abs(poses[:, :3, :3] - T[:3, :3]).max()) < 2.0 * OFF_CURVE
    assert -1e-9 < share.min() < 1e-9 < 1.0 - 1e-6 < share.max() < 1.0 + 1e-9
    speed = np.einsum("kij,kj->ki", jacobian(arm.chain, motion.q), motion.dq)[:, :3]
    assert np.linalg.norm(speed, axis=1).max() == pytest.approx(0.1, rel=1e-4)
    assert (np.abs(motion.dq) <= arm.velocity).all()
    assert not motion.dq[[0, -1]].any()


def test_rates_are_the_derivatives_of_the_positions(moved):
    reference = moved[3]
    t = np.linspace(0.05, reference.duration - 0.05, 40)
    check_derivatives(reference.sample, t, 1e-3, ("q", "dq", "ddq"), atol=1e-6)


def test_a_duration_that_a_joint_cannot_keep_is_refused_with_the_least_one():
    arm = lwr_dyn.load("kr30ha")
    line = {"start": KR30_START, "to_xyz": lwr_dyn.forward_kinematics(arm, KR30_START)[:3, 3] + [0.0, 0.5, 0.0]}
    words = r"duration of the line: 0.1 s, in which A\d needs .* times its speed"
    with pytest.raises(OptionError, match=words) as caught:
        lwr_dyn.reference("line", arm, **line, duration=0.1)
    least = float(str(caught.value).split("at least ")[1].split()[0])
    reference = lwr_dyn.reference("line", arm, **line, duration=least * 1.001)
    used = np.abs(reference.sample(np.linspace(0.0, reference.duration, 2001)).dq) / arm.velocity
    assert used.max() == pytest.approx(1.0, abs=2e-3)


@pytest.fixture
def legs_of(tmp_path):
    """Legs through joint positions of a two-joint arm, from a file's text."""

    def made(rows, start=None, smooth=False, times=None, **limits):
        path = tmp_path / "w.csv"
        head = "q1 [rad],q2 [rad]" if times is None else "time [s],q1 [rad],q2 [rad]"
        cells = [row if times is None else (times[k], *row) for k, row in enumerate(rows)]
        path.write_text(head + "\n" + "\n".join(",".join(map(repr, row)) for row in cells) + "\n")
        arm = random_arm(4, "RR")
        arm = replace(arm, limits=(JointLimits(**{"lower": -2.0, "upper": 2.0, "velocity": 2.0, **limits}),) * 2)
        return joint_legs(arm, "w.csv", read_waypoints(path), None if start is None else np.array(start), smooth)

    return made


def test_legs_through_joint_positions_take_their_share_of_the_speed_or_their_times(legs_of):
    """A quintic's largest speed is 15/8 of the mean one; 95 % of the limits are used."""
    rows, pace = [(0.0, 0.0), (1.0, -0.2), (1.0, 0.6)], 15 / 8 / (0.95 * 2.0)

    def durations(*given, **options):
        return [leg.duration for leg in legs_of(*given, **options)]

    assert durations(rows) == pytest.approx([pace, 0.8 * pace], rel=1e-6)
    assert durations(rows, times=[0.0, 3.0, 4.5]) == [3.0, 1.5]
    assert durations(rows, start=(0.0, 0.5), times=[1.0, 3.0, 4.5]) == [1.0, 2.0, 1.5]
    assert durations(rows, start=(0.0, 0.0), times=[1.0, 3.0, 4.5]) == [2.0, 1.5]
    assert durations([(0.0, 0.0), (1e-9, 0.0)]) == [SHORTEST]
    least = 1.0 * 15 / 8 / 2.0
    assert durations(rows[:2], times=[0.0, least * (1 - 5e-10)])[0] < least
    words = r"duration of the leg to row 2 of the joint positions: 0.9 s, in which .*_1 needs 1.04 times its speed"
    with pytest.raises(OptionError, match=words + rf" limit; allowed: at least {least:.4g} s"):
        legs_of(rows[:2], times=[0.0, 0.9])


def test_legs_one_after_another_stand_still_before_and_after(legs_of):
    reference = LegsReference(legs_of([(0.0, 0.0), (1.0, -0.2), (1.0, 0.6)], times=[0.0, 3.0, 4.5]))
    assert reference.duration == 4.5
    motion = reference.sample([-1.0, 0.0, 1.5, 3.0, 3.75, 4.5, 9.0])
    np.testing.assert_allclose(motion.q[:, 1], [0.0, 0.0, -0.1, -0.2, 0.2, 0.6, 0.6], atol=1e-14)
    assert not motion.dq[[0, 1, 3, 5, 6]].any()
    assert motion.dq[4, 1] == pytest.approx(0.8 * 15 / 8 / 1.5)


def test_a_smooth_curve_through_joint_positions_is_scipys_spline(legs_of):
    rows = np.array([(0.0, 0.0), (1.0, -0.2), (1.0, 0.6), (0.7, 0.7)])
    (leg,) = legs_of(rows.tolist(), smooth=True)
    u = np.array([0.0, 1.0, 1.8, 2.1]) / 2.1
    x = np.linspace(0.0, 1.0, 9)
    np.testing.assert_allclose(leg.spline(x), CubicSpline(u, rows, bc_type="not-a-knot")(x), atol=1e-13)
    speed = np.abs(leg.at(np.linspace(0.0, leg.duration, 20001)).dq).max()
    assert speed == pytest.approx(0.95 * 2.0, rel=1e-6)
    assert len(legs_of(rows[:2].tolist(), smooth=True)) == 1


UNTIMED = "columns: no times, and .* has joints without speed limits; allowed: a column time"
SAME = [(0.0, 0.0), (1.0, 1.0), (1.0, 1.0)]
WIDE = [(0.0, 0.0), (1.99, 0.0), (1.99, 0.5), (0.0, 0.5)]


@pytest.mark.parametrize(
    ("rows", "options", "message"),
    [([(0.0, 0.0), (0.0, 2.1)], {}, "waypoint 2: .* outside its limits; allowed: -2 to 2 rad"),
     ([(0.0, 0.0), (1.0, 0.0)], {"velocity": None}, UNTIMED),
     (SAME, {"smooth": True}, "waypoints: two neighbours are the same; allowed: waypoints apart from each other"),
     (WIDE, {"smooth": True}, "the smooth curve: .*, or stops at the waypoints")],
)  # fmt: skip
def test_joint_positions_that_cannot_be_followed_are_refused(legs_of, rows, options, message):
    with pytest.raises(WaypointError, match=f"w.csv: {message}"):
        legs_of(rows, **options)


@pytest.mark.parametrize(("turning", "seconds"), [(True, 1.2 * 15 / 8 / 0.3), (False, 0.5 * 15 / 8 / 0.2)])
def test_the_least_time_is_that_of_the_slower_of_way_and_turn(turning, seconds):
    begin, end = np.eye(4), np.eye(4)
    end[:3, :3], end[:3, 3] = rot_z(1.2), [0.3, 0.0, 0.4]
    curve = straight(begin, end, "waypoint 2")
    assert Pace(0.2, 0.3, turning).least(curve) == pytest.approx(seconds, rel=1e-6)
    assert Pace(0.02, 0.3, True).least(curve) == pytest.approx(0.5 * 15 / 8 / 0.02, rel=1e-6)


def test_more_places_are_found_where_the_spline_leaves_the_curve():
    arm = lwr_dyn.load("lwr4plus")
    T = lwr_dyn.forward_kinematics(arm, START)
    end = T.copy()
    end[:3, 3] += [0.1, 0.1, -0.1]
    curve = straight(T, end, "waypoint 2")
    tracked = next(iter(tracking.attempts(arm, curve, START, True)))
    whole = smooth_curve(arm, curve, tracked, True)
    half = sorted({*range(0, len(tracked.u), 2), len(tracked.u) - 1})
    coarse = smooth_curve(arm, curve, replace(tracked, u=tracked.u[half], q=tracked.q[half]), True)
    x = np.linspace(0.0, 1.0, 33)
    np.testing.assert_allclose(coarse.spline(x), whole.spline(x), atol=1e-6)
    assert max(coarse.off, whole.off) <= OFF_CURVE
    narrow = replace(
        arm, limits=tuple(replace(x, upper=float(tracked.q[:, i].max()) - 1e-3) for i, x in enumerate(arm.limits))
    )
    assert smooth_curve(narrow, curve, tracked, True) is None
