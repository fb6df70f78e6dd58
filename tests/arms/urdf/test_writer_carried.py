"""A foreign URDF written again: engines read the same robot in it, down to names, axes, motors and mesh files."""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.arms.urdf.model_files import provenance_text
from lwr_dyn.arms.urdf.reader import read_urdf
from lwr_dyn.arms.urdf.writer import carried_xml
from lwr_dyn.model.spatial import Pose
from tests.agreement.test_foreign_arms import ARMS, Foreign
from tests.arms.urdf.small_files import written
from tests.tolerances import EXACT, METRES

FOREIGN = {name: ARMS[name] for name in ("panda", "xarm7", "ur5")} | {
    "kinova": Foreign("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector"),
    "z1": Foreign("z1_description/urdf/z1.urdf", "gripperMover", {"jointGripper": -0.2}),
}


def meshes(root):
    return sorted(sorted(x.attrib.items()) for x in root.iter("mesh"))


def held_model(path, lock):
    whole = pin.buildModelFromUrdf(str(path))
    held = pin.neutral(whole)
    for name, value in lock.items():
        held[whole.joints[whole.getJointId(name)].idx_q] = value
    return pin.buildReducedModel(whole, [whole.getJointId(name) for name in lock], held) if lock else whole


@pytest.fixture(params=FOREIGN, scope="module")
def pair(request, tmp_path_factory):
    """The original, and what we write of it."""
    foreign = FOREIGN[request.param]
    path = tmp_path_factory.mktemp(request.param) / "again.urdf"
    path.write_text(lwr_dyn.urdf_text(foreign.load()), encoding="utf-8")
    return foreign, path


def test_an_engine_reads_the_same_robot(pair):
    foreign, path = pair
    one, two = held_model(foreign.path, foreign.lock), held_model(path, {})
    assert list(one.names) == list(two.names)
    assert [j.shortname() for j in one.joints] == [j.shortname() for j in two.joints]
    links = {f.name for f in one.frames if f.type == pin.FrameType.BODY} - {"universe"}
    assert links == {f.name for f in two.frames if f.type == pin.FrameType.BODY} - {"universe"}
    data = one.createData(), two.createData()
    rng = np.random.default_rng(2)
    for _ in range(10):
        q, dq = pin.integrate(one, pin.neutral(one), rng.uniform(-2, 2, one.nv)), rng.uniform(-2, 2, one.nv)
        for what in (
            lambda m, d, q=q: pin.crba(m, d, q).copy(),
            lambda m, d, q=q: pin.computeGeneralizedGravity(m, d, q),
            lambda m, d, q=q, dq=dq: pin.nonLinearEffects(m, d, q, dq),
        ):
            a, b = what(one, data[0]), what(two, data[1])
            assert np.abs(a - b).max() <= EXACT * np.abs(a).max()
        for model, d in zip((one, two), data, strict=True):
            pin.framesForwardKinematics(model, d, q)
        for link in links:
            a, b = (d.oMf[m.getFrameId(link, pin.FrameType.BODY)] for m, d in zip((one, two), data, strict=True))
            assert np.abs(a.homogeneous - b.homogeneous).max() <= METRES


def test_limits_masses_and_mesh_files_stay_and_every_number_has_its_source_or_word(pair):
    foreign, path = pair
    one, two = (ElementTree.parse(x).getroot() for x in (foreign.path, path))
    assert meshes(one) == meshes(two)
    weights = [sum(float(x.get("value")) for x in root.iterfind("link/inertial/mass")) for root in (one, two)]
    assert weights[0] == pytest.approx(weights[1], rel=EXACT)
    back = lwr_dyn.load(path, tip=foreign.tip)
    assert back.limits == foreign.load().limits
    origins = [{x.get("name"): [o.attrib for o in x.iterfind("visual/origin")] for x in root.findall("link")}
               for root in (one, two)]  # fmt: skip
    assert origins[0] == origins[1]
    foreign, path = pair
    numbers = provenance_text(foreign.load()).count('"written"')
    assert numbers == sum(
        bool(re.fullmatch(r"[-+.\deE\s]*\d[-+.\deE\s]*", text))
        for element in ElementTree.parse(path).getroot().iter()
        for text in element.attrib.values()
    )


MASS = '<inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
SIMPLE = "<type>transmission_interface/SimpleTransmission</type>"
FILE = f"""<robot name="two" xmlns:drake="https://drake.mit.edu/">
<material name="blue"><color rgba="0 0 1 1"/></material>
<link name="ground"/>
<joint name="stand" type="fixed"><parent link="ground"/><child link="base"/><origin xyz="0 0 0.4"/></joint>
<link name="base"><visual><geometry><mesh filename="package://two/a.dae" scale="1 1 0.5"/></geometry></visual></link>
<joint name="j1" type="continuous"><parent link="base"/><child link="flange"/><axis xyz="0 1 0"/></joint>
<link name="flange">{MASS}</link>
<joint name="j2" type="revolute"><parent link="flange"/><child link="arm"/><axis xyz="1 0 0"/>
<limit lower="-6.283185307179586" upper="6.283185307179586" effort="5" velocity="2"/></joint>
<link name="arm">{MASS}</link>
<joint name="tool" type="fixed"><parent link="arm"/><child link="tcp"/><origin xyz="0 0.1 0"/></joint>
<link name="tcp"/>
<transmission name="t1">{SIMPLE}
<joint name="j1"><hardwareInterface>EffortJointInterface</hardwareInterface></joint>
<actuator name="m1"><mechanicalReduction>1</mechanicalReduction>
<drake:gear_ratio value="50"/><drake:rotor_inertia value="1e-5"/></actuator></transmission>
<transmission name="t2">{SIMPLE}<joint name="j2"/><actuator name="m2"/></transmission>
</robot>"""


@pytest.fixture
def two(tmp_path):
    return read_urdf(written(tmp_path, FILE, "two.urdf"))


def test_names_axes_and_motors_stay_and_what_turns_without_end_is_no_stand_in(two, tmp_path):
    carried = carried_xml(ElementTree.fromstring(FILE))
    assert set(carried.transmissions) == {"j1", "j2"}
    assert "rotor" not in carried.transmissions["j1"]
    root = ElementTree.fromstring(lwr_dyn.urdf_text(two))
    assert {x.get("name") for x in root.findall("link")} == {"ground", "base", "flange", "arm", "tcp"}
    assert root.find("joint[@name='j1']").get("type") == "continuous"
    assert root.find("joint[@name='j1']/limit") is None
    assert root.find("joint[@name='j1']/axis").get("xyz") == "0.0 1.0 0.0"
    assert root.find("joint[@name='j2']/limit").get("upper") == "6.283185307179586"
    assert root.find("transmission[@name='t1']/joint/hardwareInterface").text == "EffortJointInterface"
    assert root.find("transmission[@name='t1']/actuator/{https://drake.mit.edu/}gear_ratio").get("value") == "50.0"
    assert root.find("transmission[@name='t1']/actuator/mechanicalReduction").text == "1"
    assert root.find("transmission[@name='t2']/actuator").get("name") == "m2"
    mesh = root.find("link[@name='base']/visual/geometry/mesh")
    assert mesh.attrib == {"filename": "package://two/a.dae", "scale": "1 1 0.5"}
    text = lwr_dyn.urdf_text(two)
    assert "stand-ins: nothing" in text
    back = read_urdf(written(tmp_path, text, "again.urdf"))
    assert (back.limits[0].lower, back.limits[1].upper) == (None, 2 * np.pi)
    assert lwr_dyn.urdf_text(back).partition("-->")[2] == text.partition("-->")[2]


def test_an_arm_changed_in_code_is_written_as_changed(two):
    heavier = two.with_chain(replace(two.chain, links=(replace(two.chain.links[0], rotor=None), two.chain.links[1])))
    assert "<drake:gear_ratio" not in lwr_dyn.urdf_text(heavier)
    moved = two.with_chain(replace(two.chain, flange=Pose(np.eye(3), np.array([0.0, 0.0, 1.0]))))
    for changed in (moved, two.with_locked_joint("j2", 0.3)):
        assert 'child link="flange"' in lwr_dyn.urdf_text(changed)
        assert "tcp" not in lwr_dyn.urdf_text(changed)


def test_drake_finds_the_motors_again(two, tmp_path):
    from lwr_dyn.checks.engines.engine import ArmInFile
    from lwr_dyn.checks.engines.loaders import DrakeFile

    bare = replace(two, layout=replace(two.layout, shapes=dict.fromkeys(two.layout.shapes, ())))
    path = written(tmp_path, lwr_dyn.urdf_text(bare), "bare.urdf")
    assert len(DrakeFile(path, ArmInFile(two.joint_names, "tcp", tuple(two.chain.gravity)), {}).actuators) == 2


@pytest.mark.parametrize("robot", studied())
def test_our_own_file_keeps_its_motors_and_shapes(tmp_path, robot):
    path = written(tmp_path, lwr_dyn.urdf_text(lwr_dyn.load(robot)))
    again = lwr_dyn.urdf_text(lwr_dyn.load(path))
    for tag in ("<transmission ", "<cylinder ", "<drake:rotor_inertia", "<link "):
        assert again.count(tag) == path.read_text(encoding="utf-8").count(tag)
