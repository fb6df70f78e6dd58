"""The page's own kinematics against the package's, in headless Chromium, from the page's data alone."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.forward import frames
from lwr_dyn.model.spatial import Pose, from_rpy, to_rpy
from lwr_dyn.pages.explorer.page_data import arm_record
from lwr_dyn.pages.replay.replay_page import column_major, resource_text
from tests.pages.explorer.explored import NAMES, explored_arm
from tests.tolerances import METRES

CONFIGURATIONS = 40
SCRIPT = resource_text("kinematics.js", "lwr_dyn.pages.explorer")


def random_positions(arm, seed):
    """Inside the limits, within half a turn (a metre) where they are unknown; some at multiples of 90 deg."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(np.maximum(arm.lower, -3.2), np.minimum(arm.upper, 3.2), (CONFIGURATIONS, arm.n))
    q[::4] = np.round(q[::4] / (np.pi / 2)) * (np.pi / 2)
    return q


def computed(browser, arm, q, what):
    record = json.loads(json.dumps(arm_record(arm)))
    return np.array(browser.execute_script(f"{SCRIPT}; const [arm, qs] = arguments; return {what}", record, q.tolist()))


@pytest.fixture(scope="module")
def blank(browser):
    browser.get("about:blank")
    return browser


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_flange_and_links_are_where_forward_kinematics_puts_them(blank, name):
    arm = explored_arm(name)
    q = random_positions(arm, 7)
    flange = computed(blank, arm, q, "qs.map((q) => armKinematics.rows(armKinematics.flange(arm, q)))")
    np.testing.assert_allclose(flange, lwr_dyn.forward_kinematics(arm, q), rtol=0, atol=METRES)
    found = computed(blank, arm, q, "qs.map((q) => armKinematics.frames(arm, q).map(armKinematics.rows))")
    to_urdf = np.stack([*(link.after.inverse().matrix() for link in arm.chain.links), np.eye(4)])
    np.testing.assert_allclose(found, frames(arm.chain, q) @ to_urdf, rtol=0, atol=METRES)


def test_roll_pitch_yaw_are_those_of_the_package_also_at_a_pitch_of_90_degrees(blank):
    upright = [Pose(from_rpy((0.4, pitch, 0.1)), np.zeros(3)) for pitch in (np.pi / 2, -np.pi / 2, 1.570796325, 0.3)]
    poses = [column_major(pose) for pose in upright]
    found = blank.execute_script(f"{SCRIPT}; return arguments[0].map(armKinematics.rollPitchYaw)", poses)
    np.testing.assert_allclose(found, [to_rpy(pose.rotation) for pose in upright], rtol=0, atol=METRES)
    assert [found[0][0], found[1][0]] == [0.0, 0.0]  # where only a combination with the yaw is determined
    arm = lwr_dyn.load("kr30ha")
    q = random_positions(arm, 11)
    angles = computed(blank, arm, q, "qs.map((q) => armKinematics.rollPitchYaw(armKinematics.flange(arm, q)))")
    rotations = np.array([from_rpy(each) for each in angles])
    np.testing.assert_allclose(rotations, lwr_dyn.forward_kinematics(arm, q)[:, :3, :3], rtol=0, atol=METRES)


def test_degrees_are_read_as_the_command_reads_them(blank):
    arm = explored_arm("tiago")
    shown = np.array([0.123, *np.linspace(-170.0, 169.9, 7)])
    found = computed(blank, arm, shown[None], "qs[0].map((x, i) => armKinematics.meant(arm.joints[i], x))")
    assert found.tolist() == [0.123, *np.radians(shown[1:]).tolist()]
