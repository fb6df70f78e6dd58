"""An arm as meshcat commands: each shape once, links where forward kinematics has them, colours of the runs."""

import numpy as np
import pytest

from lwr_dyn.arms.urdf.geometry import primitives
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.look import tokens
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from tests.random_arms import random_arm


def replayed(arm, q):
    """The arm at q, in as much of a run as the scene needs."""
    pose = np.eye(4)[None]
    return ReplayedRun(type("R", (), {"q": np.array([q])})(), arm, "x", 1, pose, pose)


@pytest.mark.parametrize("seed", range(4))
def test_scene_names_each_shape_once(seed):
    arm = random_arm(seed)
    paths = [
        c["path"] for c in replay_page.arm_commands(replayed(arm, np.zeros(arm.n)), 0) if c["type"] == "set_object"
    ]
    assert len(paths) == len(set(paths)) == len(primitives(arm))


def test_transforms_of_the_links_multiply_to_the_pose_of_the_flange(arm):
    q = np.linspace(-1.0, 1.0, arm.n)
    pose = np.eye(4)
    for i, command in enumerate(replay_page.pose_commands(arm, q, 2), start=1):
        assert command["path"] == replay_page.link_path(2, i)
        pose = pose @ np.reshape(command["matrix"], (4, 4)).T
    np.testing.assert_allclose(pose, flange_pose(arm.chain, q), atol=1e-12)


def test_bodies_are_grey_and_only_bands_have_the_colour_of_their_run(arm):
    shapes = [
        c["object"] for c in replay_page.arm_commands(replayed(arm, np.zeros(arm.n)), 0) if c["type"] == "set_object"
    ]
    worn = [one["object"]["userData"]["token"] for one in shapes]
    bands = [s.colour == "dark" and s.link != "base" and s.length <= 0.7 * s.radius for s in primitives(arm)]
    assert [token == "run2" for token in worn] == bands
    assert sum(bands) >= 2
    assert {token for token, band in zip(worn, bands, strict=True) if not band} == {"housing", "limb", "joint"}
    assert [f"#{one['materials'][0]['color']:06x}" for one in shapes] == [tokens()[token] for token in worn]
