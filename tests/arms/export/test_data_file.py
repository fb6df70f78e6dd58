"""An arm written as a data file loads as the same arm: poses, torques, limits, rotors, friction; sources are named."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.arms.export.data_file import ColumnText, data_file_text, literal, quoted, table_text
from lwr_dyn.arms.papers.catalog import open_paper, studied
from lwr_dyn.arms.urdf.model_files import provenance_text
from lwr_dyn.dynamics.newton_euler import newton_euler_dynamics
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.model.chain import Convention, Rotor
from lwr_dyn.model.spatial import Pose, from_rpy
from tests.agreement.test_foreign_arms import ROBOTS
from tests.arms.export.test_dh_table import changed
from tests.random_arms import random_arm
from tests.tolerances import EXACT, METRES

FOREIGN = {
    "panda": ("panda_description/urdf/panda.urdf", "panda_hand", {"panda_finger_joint1": 0.0}),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", "tool0", {}),
    "z1": ("z1_description/urdf/z1.urdf", None, {}),
    "kinova": ("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector", {}),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", "link_eef", {}),
}
OWN = [(robot, reading) for robot in studied() for reading in lwr_dyn.readings(robot)]


def arm_named(name):
    if name in FOREIGN:
        path, tip, lock = FOREIGN[name]
        return lwr_dyn.load(ROBOTS / path, tip=tip, lock=lock)
    return lwr_dyn.load(*name)


def again(arm, convention, folder):
    path = folder / "again.toml"
    path.write_text(data_file_text(arm, convention), encoding="utf-8")
    return lwr_dyn.load(path)


def assert_same(arm, back):
    rng = np.random.default_rng(2)
    q, dq, ddq = rng.uniform(-3, 3, (3, 20, arm.n))
    poses = [lwr_dyn.forward_kinematics(x, q) for x in (arm, back)]
    assert np.abs(poses[0] - poses[1]).max() <= METRES
    assert back.joint_names == arm.joint_names
    assert back.limits == arm.limits
    assert back.friction_models() == arm.friction_models()
    assert back.armature == pytest.approx(arm.armature, rel=1e-15)
    assert (back.ratings, back.mastering, back.torques) == (arm.ratings, arm.mastering, arm.torques)
    assert (back.drawing.pedestal, back.drawing.radius) == (arm.drawing.pedestal, arm.drawing.radius)
    for one, other in ((arm.elasticity, back.elasticity), (arm.gains, back.gains)):
        for name in ("stiffness", "damping", "Kp", "Kd", "Ki", "effort"):
            assert np.array_equal(getattr(one, name, None), getattr(other, name, None)), name
    if arm.chain.bodies is None:
        assert back.chain.bodies is None
        return
    torques = [newton_euler_dynamics(x.chain).inverse_dynamics(q, dq, ddq) for x in (arm, back)]
    assert np.abs(torques[0] - torques[1]).max() <= EXACT * np.abs(torques[0]).max()


@pytest.mark.slow
@pytest.mark.parametrize("convention", Convention)
@pytest.mark.parametrize("name", [*OWN, *FOREIGN], ids=str)
def test_it_loads_as_the_same_arm(name, convention, tmp_path):
    arm = arm_named(name)
    assert_same(arm, again(arm, convention, tmp_path))


@pytest.mark.parametrize("name", [*range(6), ("lwr4plus",), ("wam7",), ("kr30ha",)], ids=str)
def test_any_arm_comes_back(name, tmp_path):
    """Of the package: one with springs, one with gains and a map of motors, one with a mastering pose and ratings."""
    arm = random_arm(name) if isinstance(name, int) else arm_named(name)
    for convention in Convention:
        assert_same(arm, again(arm, convention, tmp_path))


def test_motors_gains_shares_of_the_load_and_a_contradiction_come_back(tmp_path):
    arm = lwr_dyn.load("wam7")
    grows = replace(arm, friction=(*arm.friction[:6], replace(arm.friction[6], load=0.05)))
    grows = replace(grows, caveats=replace(grows.caveats, contradicted="m_7 is 5 sigma off"))
    back = again(grows, Convention.MODIFIED, tmp_path)
    assert (back.friction, back.caveats.contradicted) == (grows.friction, "m_7 is 5 sigma off")
    links = ", ".join(f"link_{k} is {x.link}" for k, x in enumerate(arm.chain.links, start=1))
    assert f'links = "{links}"' in data_file_text(arm)
    assert np.array_equal(back.transmission.matrix, arm.transmission.matrix)
    columns = [set(tomllib.loads(data_file_text(x))["transmission"]) for x in (arm, lwr_dyn.load("tx40"))]
    assert columns == [{"ratio", "signs"}, {"matrix"}]  # one ratio a joint; two of joint 6
    assert "load" not in data_file_text(arm).partition("[friction]")[2].partition("[gains]")[0]
    blocks = [json.loads(provenance_text(x))["friction"]["joint_7"] for x in (grows, arm)]
    assert [block.get("load") for block in blocks] == [0.05, None]


def test_what_is_not_known_stays_unknown_and_limits_of_no_width_are_said_and_left_open(tmp_path):
    arm = lwr_dyn.load("lwr4plus")
    limits = (JointLimits(lower=-1.0, upper=2.0, viscous=0.5), *(JointLimits() for _ in range(6)))
    rotors = (Rotor(100.0, 1e-5), *[None] * 6)
    links = tuple(replace(link, rotor=rotor) for link, rotor in zip(arm.chain.links, rotors, strict=True))
    bare = replace(arm, limits=limits, chain=replace(arm.chain, links=links))
    back = again(bare, Convention.STANDARD, tmp_path)
    assert back.limits == limits
    assert [link.rotor is None for link in back.chain.links] == [False, *[True] * 6]
    assert '"unknown"' in data_file_text(bare)
    arm = lwr_dyn.load("lwr4plus")
    flat = replace(arm, limits=(JointLimits(lower=0.0, upper=0.0), *arm.limits[1:]))
    assert again(flat, Convention.STANDARD, tmp_path).limits == (JointLimits(), *arm.limits[1:])
    assert 'lacks = "limits of joint_1: 0.0 to 0.0"' in data_file_text(flat)
    links = (replace(arm.chain.links[0], body=None), *arm.chain.links[1:])
    back = again(replace(arm, chain=replace(arm.chain, links=links)), Convention.STANDARD, tmp_path)
    assert [body.unknown for body in back.chain.bodies] == [tuple(range(10)), *[()] * 6]


def test_almost_parallel_axes_come_back(tmp_path):
    arm = changed(2, after=Pose(from_rpy((np.pi - 2.65e-6, 0.0, 0.0)), np.array([0.1, 0.41, 0.1])))
    assert "beta" in tomllib.loads(data_file_text(arm))["dh"]
    assert_same(arm, again(arm, Convention.STANDARD, tmp_path))


def test_each_column_names_file_and_elements_and_an_estimate_stays_one(tmp_path):
    path = tmp_path / "again.toml"
    columns = []
    for name in ("panda", ("kr30ha",)):
        path.write_text(data_file_text(arm_named(name)), encoding="utf-8")
        columns.append(open_paper(str(path)).columns)
    panda, kr30 = columns
    assert {column.kind for column in panda.values()} == {"computed"}
    assert panda["limits.lower"].where == "panda.urdf: /robot/joint/limit/@lower"
    assert "/robot/link[@name='panda_hand']/inertial" in panda["inertial.mass"].where
    assert panda["dh.a"].where.startswith("common normals of the joint axes; panda.urdf: /robot/joint/origin")
    assert kr30["inertial.mass"].kind == "estimated"
    assert 'lacks = "drawn cylinders"' in path.read_text(encoding="utf-8")
    (tmp_path / "l.urdf").write_text(lwr_dyn.urdf_text(lwr_dyn.load("lwr4plus")), encoding="utf-8")
    path.write_text(data_file_text(lwr_dyn.load(tmp_path / "l.urdf")), encoding="utf-8")
    actuator = "/robot/transmission/actuator/drake"
    where = open_paper(str(path)).columns["rotors.gear_ratio"].where
    assert where == f"l.urdf: {actuator}:gear_ratio, {actuator}:rotor_inertia"


@pytest.mark.hypothesis
@given(st.text(st.characters(codec="utf-8")), st.lists(st.floats(allow_nan=False, allow_infinity=False)))
def test_texts_and_numbers_come_back(text, values):
    assert tomllib.loads(f"x = {quoted(text)}\ny = {literal(values)}") == {"x": text, "y": values}


def test_a_table_without_columns_is_left_out():
    assert table_text("limits", []) == []
    column = ColumnText("lower", [1.0, None], ["rad", "m"], "a page")
    text = "\n".join(table_text("limits", [column]))
    assert tomllib.loads(text)["limits"]["lower"]["values"] == [1.0, "unknown"]
