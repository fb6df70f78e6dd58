"""References from legs: on their lines, exact derivatives, speeds kept, rests between legs."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.trajectory.cartesian.legs import OFF_CURVE

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


def test_the_tip_is_on_its_line_and_keeps_its_orientation(moved):
    arm, T, end, _, motion = moved
    poses = lwr_dyn.forward_kinematics(arm, motion.q)
    along = end - T[:3, 3]
    share = (poses[:, :3, 3] - T[:3, 3]) @ along / (along @ along)
    off = poses[:, :3, 3] - T[:3, 3] - np.outer(share, along)
    assert np.abs(off).max() < 2.0 * OFF_CURVE
    assert np.abs(poses[:, :3, :3] - T[:3, :3]).max() < 2.0 * OFF_CURVE
    assert share.min() > -1e-9
    assert share.max() < 1.0 + 1e-9
    np.testing.assert_allclose(poses[-1, :3, 3], end, atol=OFF_CURVE)


def test_rates_are_the_derivatives_of_the_positions(moved):
    _, _, _, reference, _ = moved
    t, h = np.linspace(0.05, reference.duration - 0.05, 40), 1e-5
    before, at, after = (reference.sample(x) for x in (t - h, t, t + h))
    np.testing.assert_allclose((after.q - before.q) / (2.0 * h), at.dq, atol=1e-7)
    np.testing.assert_allclose((after.dq - before.dq) / (2.0 * h), at.ddq, atol=1e-6)


def test_the_tip_keeps_its_speed_and_the_joints_their_limits(moved):
    arm, _, _, _, motion = moved
    speed = np.einsum("kij,kj->ki", jacobian(arm.chain, motion.q), motion.dq)[:, :3]
    assert np.linalg.norm(speed, axis=1).max() == pytest.approx(0.1, rel=1e-4)
    assert (np.abs(motion.dq) <= arm.velocity).all()
    assert not motion.dq[[0, -1]].any()


@pytest.mark.slow
def test_a_duration_that_a_joint_cannot_keep_is_refused_with_the_least_one():
    arm = lwr_dyn.load("kr30ha")
    end = lwr_dyn.forward_kinematics(arm, KR30_START)[:3, 3] + [0.0, 0.5, 0.0]
    with pytest.raises(
        OptionError, match=r"duration of the line: 0.1 s, in which A\d needs .* times its speed"
    ) as caught:
        lwr_dyn.reference("line", arm, start=KR30_START, to_xyz=end, duration=0.1)
    least = float(str(caught.value).split("at least ")[1].split()[0])
    reference = lwr_dyn.reference("line", arm, start=KR30_START, to_xyz=end, duration=least * 1.001)
    used = np.abs(reference.sample(np.linspace(0.0, reference.duration, 2001)).dq) / arm.velocity
    assert used.max() == pytest.approx(1.0, abs=2e-3)
