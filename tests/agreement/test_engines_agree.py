"""The files under models/ in three engines that read them on their own: the same B, C dq, g, flange and rotors."""

from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import yourdfpy

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.arms.urdf.geometry import primitives
from lwr_dyn.arms.urdf.model_files import model_files, model_stem
from tests.tolerances import EXACT, METRES

STATES = 50
CASES = [(robot, reading) for robot in studied() for reading in lwr_dyn.readings(robot)]
MOVING = [case for case in CASES if lwr_dyn.load(*case).chain.bodies is not None]


@pytest.fixture(params=CASES, ids="-".join)
def arm(request):
    return lwr_dyn.load(*request.param)


@pytest.fixture(params=MOVING, ids="-".join)
def moving(request):
    return lwr_dyn.load(*request.param)


@pytest.fixture
def stem(request, tmp_path):
    """The arm's files in a folder of their own, so that a stale model cannot hide a fault or make one up."""
    arm = request.getfixturevalue("moving" if "moving" in request.fixturenames else "arm")
    for name, text in model_files(arm).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return str(Path(tmp_path) / model_stem(arm))


def states(n):
    return np.random.default_rng(11).uniform(-2.5, 2.5, (2, STATES, n))


def close(result, expected):
    return np.abs(result - expected).max() <= EXACT * np.abs(expected).max()


def test_pinocchio_reads_urdf_and_srdf(moving, stem):
    model = pin.buildModelFromUrdf(f"{stem}.urdf")
    if moving.armature.any():
        pin.loadRotorParameters(model, f"{stem}.srdf", False)
    assert Path(f"{stem}.srdf").exists() == bool(moving.armature.any())
    model.gravity.linear = np.array(moving.chain.gravity)
    data, q, dq = model.createData(), *states(moving.n)
    flange = model.getFrameId("flange")
    assert np.array_equal(model.armature, moving.armature)
    road_b = lwr_dyn.dynamics_of(moving, engine="newton-euler")
    B = road_b.mass_matrix(q)
    bias, g = road_b.bias_torque(q, dq), road_b.gravity_vector(q)
    T = lwr_dyn.forward_kinematics(moving, q)
    for k in range(STATES):
        assert close(pin.crba(model, data, q[k]), B[k])
        assert close(pin.computeGeneralizedGravity(model, data, q[k]), g[k])
        assert close(pin.nonLinearEffects(model, data, q[k], dq[k]), bias[k])
        pin.framesForwardKinematics(model, data, q[k])
        assert np.abs(data.oMf[flange].homogeneous - T[k]).max() <= METRES


def test_mujoco_reads_mjcf(moving, stem):
    model = mujoco.MjModel.from_xml_path(f"{stem}.xml")
    data, q, dq = mujoco.MjData(model), *states(moving.n)
    road_b = lwr_dyn.dynamics_of(moving, engine="newton-euler")
    B, bias, g = road_b.mass_matrix(q), road_b.bias_torque(q, dq), road_b.gravity_vector(q)
    T = lwr_dyn.forward_kinematics(moving, q)
    result = np.zeros((moving.n, moving.n))
    for k in range(STATES):
        data.qpos[:], data.qvel[:] = q[k], dq[k]
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, result)
        assert close(result, B[k])
        assert close(data.qfrc_bias, bias[k])
        data.qvel[:] = 0.0
        mujoco.mj_forward(model, data)
        assert close(data.qfrc_bias, g[k])
        flange = data.body("flange")
        assert np.abs(flange.xpos - T[k][:3, 3]).max() <= METRES
        assert np.abs(flange.xmat.reshape(3, 3) - T[k][:3, :3]).max() <= METRES


def test_mujoco_has_the_limits_and_the_shapes(moving, stem):
    model = mujoco.MjModel.from_xml_path(f"{stem}.xml")
    for k, limits in enumerate(moving.limits):
        if limits.lower is not None:
            assert tuple(model.jnt_range[k]) == (limits.lower, limits.upper)
        if limits.effort is not None:
            assert tuple(model.actuator_ctrlrange[k]) == (-limits.effort, limits.effort)
        assert model.jnt_limited[k] == (limits.lower is not None)
    assert model.ngeom == len(primitives(moving))
    assert model.nu == moving.n


def test_yourdfpy_finds_the_flange_without_warnings(arm, stem, caplog):
    urdf = yourdfpy.URDF.load(f"{stem}.urdf", load_meshes=False)
    q, _ = states(arm.n)
    T = lwr_dyn.forward_kinematics(arm, q)
    for k in range(STATES):
        urdf.update_cfg(q[k])
        assert np.abs(urdf.get_transform("flange", "base") - T[k]).max() <= METRES
    assert urdf.validate()
    assert not caplog.records


@pytest.mark.parametrize("kind", [pin.GeometryType.VISUAL, pin.GeometryType.COLLISION])
def test_pinocchio_loads_the_shapes(arm, stem, kind):
    model = pin.buildModelFromUrdf(f"{stem}.urdf")
    geometry = pin.buildGeomFromUrdf(model, f"{stem}.urdf", kind)
    assert geometry.ngeoms == len(primitives(arm))


def test_the_armature_is_in_every_diagonal_of_the_mass_matrix(moving):
    q, _ = states(moving.n)
    with_rotors = lwr_dyn.dynamics_of(moving).mass_matrix(q)
    without = lwr_dyn.dynamics_of(moving, engine="newton-euler", rotors="none").mass_matrix(q)
    assert np.abs(with_rotors - without - np.diag(moving.armature)).max() <= EXACT * np.abs(with_rotors).max()
