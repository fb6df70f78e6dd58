"""Pinocchio's flange pose and Jacobian are those of the native chain; it reads files, with rotors from an .srdf."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.pinocchio_engine import (
    file_model,
    flange_and_jacobian,
    flange_poses,
    pinocchio_model,
    rotation_vector,
)
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.model.spatial import turn_about
from tests.random_arms import random_arm
from tests.tolerances import EXACT, METRES

INSTALLED = lwr_dyn.load(
    "lwr4plus", mount="wall", tool={"xyz": [0.05, 0.02, 0.15], "rpy": [0.1, 0.4, 0.2], "mass": 0.5}
)


@pytest.mark.parametrize(
    "arm",
    [lwr_dyn.load("lwr4plus"), INSTALLED, random_arm(3, "RPRR"), random_arm(4, "R")],
    ids=["lwr4plus", "with mount and tool", "RPRR", "R"],
)
def test_flange_and_jacobian_are_those_of_the_chain(arm):
    pose_and_jacobian = flange_and_jacobian(arm)
    there = pickle.loads(pickle.dumps(pose_and_jacobian))
    for q in np.random.default_rng(0).uniform(-1, 1, (5, arm.n)):
        pose, J = pose_and_jacobian(q)
        assert np.abs(pose - lwr_dyn.forward_kinematics(arm, q)).max() < METRES
        assert np.abs(J - jacobian(arm.chain, q)).max() < METRES
        assert all(map(np.array_equal, there(q), (pose, J)))


MODELS = Path(__file__).resolve().parents[2] / "models" / "lwr4plus"


def test_a_rotation_is_an_axis_times_its_angle():
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    np.testing.assert_allclose(rotation_vector(turn_about(axis, np.array([0.7]))[0]), 0.7 * axis, atol=1e-15)


def test_a_file_has_rotors_only_with_its_srdf():
    arm = lwr_dyn.load("lwr4plus")
    bare = file_model(MODELS / "lwr4plus.urdf")
    full = file_model(MODELS / "lwr4plus.urdf", MODELS / "lwr4plus.srdf")
    assert not np.array(bare.armature).any()
    assert np.array(full.armature) == pytest.approx(arm.armature, rel=EXACT)


def test_a_link_is_found_by_name_and_the_last_one_without():
    arm = lwr_dyn.load("lwr4plus")
    model, q = pinocchio_model(arm), np.linspace(-1.0, 1.0, 7)[None]
    T = lwr_dyn.forward_kinematics(arm, q)
    assert np.abs(flange_poses(model, q) - T).max() <= METRES
    assert np.abs(flange_poses(model, q, "flange") - T).max() <= METRES
    assert np.abs(flange_poses(model, q, "link_3") - T).max() > 0.1


def test_a_file_that_is_no_urdf_is_refused_in_pinocchio_s_words(tmp_path):
    path = tmp_path / "x.urdf"
    path.write_text("<robot/>", encoding="utf-8")
    with pytest.raises(ValueError, match="does not contain a valid URDF"):
        file_model(path)
