"""Published sets: a reading takes a set's tables in place of the file's, with the errata of that set on top."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.export.data_file import data_file_text
from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.foundation.errors import PaperError
from tests.tolerances import EXACT

SET = """
[[set]]
name = "maker"
about = "the maker's numbers"
where = "data sheet, page 3"
frames = "dh"
[set.inertial]
mass = { values = [3.0, 1.5], unit = "kg", where = "page 3", kind = "datasheet" }
com = { values = [[0, 0, 0.02], [0.01, 0, 0]], unit = "m", where = "page 3", kind = "datasheet" }
inertia = { values = [
    [[0.02, 0, 0], [0, 0.02, 0], [0, 0, 0.01]],
    [[0.03, 0, 0], [0, 0.03, 0], [0, 0, 0.01]],
], unit = "kg m^2", about = "origin", axes = "frame", products = "tensor", where = "page 3", kind = "datasheet" }

[[erratum]]
id = "mass-2"
set = "maker"
where = "page 3"
printed = "1.5"
read_as = "2.5"
why = "the total is printed too"
effect = "torques"
status = "proven"
severity = "model"
patch = [{ at = "inertial.mass.values[1]", printed = 1.5, read = 2.5 }]

[[erratum]]
id = "own-mass"
where = "Table 1"
printed = "2.0"
read_as = "4.0"
why = "as the sum says"
effect = "torques"
status = "proven"
severity = "model"
patch = [{ at = "inertial.mass.values[0]", printed = 2.0, read = 4.0 }]

[reading.printed]
about = "the file's own tables"
errata = ["own-mass"]

[reading.maker]
about = "the maker's set as printed"
set = "maker"

[reading.maker_mended]
about = "the maker's set, second mass mended"
set = "maker"
errata = ["mass-2"]
"""
OWN = template("own.toml", "own", "RR", "modified")
SHIFT = 3.0 * 0.02**2
"""[kg m^2] Of link 1 of the set, from the origin to its centre of mass."""


def read(reading):
    return parse_paper(OWN + SET, "own.toml", reading)


def test_a_reading_takes_the_tables_of_its_set_a_motor_map_too_and_the_errata_on_top():
    masses = {name: read(name).columns["inertial.mass"].si().tolist() for name in read("printed").reading_names}
    assert masses == {"printed": [4.0, 2.0], "maker": [3.0, 1.5], "maker_mended": [3.0, 2.5]}
    assert read("maker").printed["inertial"]["mass"]["values"] == [3.0, 1.5]
    mended = read("maker_mended").columns["inertial.mass"]
    assert mended.errata == {1: ("mass-2",)}
    assert mended.where == "page 3"
    arm = arm_of(OWN + SET.replace("[[erratum]]", COUPLED + "[[erratum]]", 1))
    assert arm.transmission.motor_velocity([0.1, 0.2]).round(12).tolist() == [4.5, 9.6]
    written = parse_paper(data_file_text(arm), "out.toml")
    assert arm_from_paper(written).transmission.matrix.tolist() == [[45.0, 0.0], [32.0, 32.0]]


def test_what_a_reading_leaves_in_place_is_of_the_tables_it_uses_and_where_torques_are_measured_is_said():
    paper = read("printed")
    left = {name: paper.left_in_place(name) for name in paper.reading_names}
    assert left == {"printed": (), "maker": ("mass-2",), "maker_mended": ()}
    about_com = np.diag([0.02 - SHIFT, 0.02 - SHIFT, 0.01])
    tensor = arm_from_paper(read("maker")).chain.bodies[0].inertia_com
    np.testing.assert_allclose(tensor, about_com, rtol=0, atol=1e-15)
    assert read("printed").torques == ""
    said = OWN.replace('kinds = ["revolute", "revolute"]', 'kinds = ["revolute", "revolute"]\ntorques = "link"')
    assert parse_paper(said, "own.toml").torques == "link"
    with pytest.raises(PaperError, match=r"joints.torques: 'both'; allowed: one of motor, link"):
        parse_paper(said.replace('"link"', '"both"'), "own.toml")


FAULTS = {
    "two sets of one name": (SET[: SET.index("[[erratum]]")], SET[: SET.index("[[erratum]]")] * 2, "'maker' twice"),
    "frames not stated": ('frames = "dh"\n', "", r"set\[0\].frames: missing"),
    "frames of a URDF without its joints": ('"dh"', '"urdf"', "frames: 'urdf' without origins"),
    "frames of no kind": ('frames = "dh"', 'frames = "world"', r"set\[0\].frames: 'world'; allowed: one of dh"),
    "a set without tables": ("[set.inertial]", "[inertials]", r"set\[0\]: no table; allowed: one or more of base, dh"),
    "unknown table": ("[set.inertial]", "[set.inertials]", r"set\[0\].inertials: unknown field"),
    "a set that is not there": ('set = "maker"\nerrata', 'set = "made"\nerrata', "set: 'made'; allowed: one of maker"),
    "an erratum of another set": ('errata = ["own-mass"]', 'errata = ["mass-2"]', "errata: 'mass-2', of set maker"),
    "an erratum of a table that the set brings": (
        'errata = ["mass-2"]', 'errata = ["own-mass"]', "'own-mass', of the file's own inertial",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_a_breach_is_refused(name):
    old, new, message = FAULTS[name]
    assert old in SET, "the fault does not touch the text any more"
    with pytest.raises(PaperError, match=message):
        parse_paper(OWN + SET.replace(old, new, 1), "own.toml", "maker_mended")


ORIGINS = """[set.origins]
xyz = { values = [[0, 0, 0.3], [0, 0, 0]], unit = "m", where = "urdf", kind = "printed" }
rpy = { values = [[0, 0, 30], [90, 0, -30]], unit = "deg", where = "urdf", kind = "printed" }
axis = { values = [[0, 0, 1], [0, 0, 1]], unit = "1", where = "urdf", kind = "printed" }
"""
STANDARD = OWN.replace('"modified"', '"standard"')
OF_URDF = SET.replace('"dh"', '"urdf"').replace("[[erratum]]", ORIGINS + "[[erratum]]", 1)


def arm_of(text, reading="maker"):
    return arm_from_paper(parse_paper(text, "own.toml", reading))


def test_bodies_in_frames_of_a_urdf_stand_where_its_joints_place_them(tmp_path):
    """The second road: the URDF of those joints, read by the reader of URDFs."""
    joint = """<joint name="joint_{0}" type="revolute"><parent link="{1}"/><child link="link_{0}"/>
        <origin xyz="{2}" rpy="{3}"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""
    link = """<link name="link_{0}"><inertial><origin xyz="{1}"/><mass value="{2}"/>
        <inertia ixx="{3}" ixy="0" ixz="0" iyy="{4}" iyz="0" izz="{5}"/></inertial></link>"""
    elements = [
        link.format(1, "0 0 0.02", 3.0, 0.0188, 0.0188, 0.01), link.format(2, "0.01 0 0", 1.5, 0.03, 0.02985, 0.00985),
        joint.format(1, "base", "0 0 0.3", f"0 0 {np.pi / 6}"),
        joint.format(2, "link_1", "0 0 0", f"{np.pi / 2} 0 {-np.pi / 6}"),
    ]  # fmt: skip
    path = tmp_path / "own.urdf"
    path.write_text(f'<robot name="own"><link name="base"/>{"".join(elements)}</robot>')
    arm, foreign = arm_of(STANDARD + OF_URDF), lwr_dyn.load(path)
    q, dq, ddq = np.random.default_rng(3).uniform(-1.0, 1.0, (3, 2))
    ours, theirs = (lwr_dyn.dynamics_of(x).inverse_dynamics(q, dq, ddq) for x in (arm, foreign))
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=EXACT)


def test_a_urdf_whose_axes_are_not_those_of_the_table_is_refused():
    for old, new, found in (
        ("[[0, 0, 0.3]", "[[0, 0.001, 0.3]", "joint_1 at zero is 0.001 m and 0 rad"),
        ("[90, 0, -30]", "[-90, 0, -30]", "joint_2"),
        ("[90, 0, -30]", "[91, 0, -30]", "joint_2 at zero is 0 m and 0.0175 rad"),
        ("[[0, 0, 0.3]", "[[0, 1.1e-6, 0.3]", "joint_1 at zero is 1.1e-06 m and 0 rad"),
        ("[90, 0, -30]", f"[{90 + np.degrees(1.1e-6)}, 0, -30]", "joint_2 at zero is 0 m and 1.1e-06 rad"),
    ):
        with pytest.raises(PaperError, match=f"origins: the axis of {found}"):
            arm_of(STANDARD + OF_URDF.replace(old, new, 1))
    for old, new in (("[[0, 0, 0.3]", "[[0, 9e-7, 0.3]"), ("[90, 0, -30]", f"[{90 + np.degrees(9e-7)}, 0, -30]")):
        arm_of(STANDARD + OF_URDF.replace(old, new, 1))  # rounded pi and lengths


def test_a_tensor_in_its_own_axes_is_turned_as_the_origin_of_an_inertial():
    turned = SET.replace("0.02, 0, 0], [0, 0.02", "0.02, 0, 0], [0, 0.03", 1).replace('axes = "frame"', 'axes = "rpy"')
    rpy = 'rpy = { values = [[0, 0, 90], [0, 0, 0]], unit = "deg", where = "p", kind = "datasheet" }\ncom ='
    tensor = arm_of(OWN + turned.replace("com =", rpy, 1)).chain.bodies[0].inertia_com
    np.testing.assert_allclose(tensor, np.diag([0.03 - SHIFT, 0.02 - SHIFT, 0.01]), rtol=0, atol=1e-15)
    for text, words in ((turned, "axes: 'rpy'; allowed: one of frame"),
                        (SET.replace("com =", rpy, 1), "axes: 'frame'; allowed: one of rpy")):  # fmt: skip
        with pytest.raises(PaperError, match=words):
            arm_of(OWN + text)


COUPLED = """[set.transmission]
matrix = { values = [[45, 0], [32, 32]], unit = "1", where = "p", kind = "printed" }
"""
