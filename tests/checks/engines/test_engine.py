"""Each feature is found in a file that has it, and its change takes away that and nothing else."""

import pytest

from lwr_dyn.arms.urdf.parse import parse_xml
from lwr_dyn.checks.engines.engine import FEATURES, ArmInFile, variants, without_meshes, without_shapes, xml_of
from tests.checks.engines.small_files import ROTOR, TWO

SCOPE = ArmInFile(("j1", "j2"), "tool", (0.0, 0.0, -9.81))
TREE = parse_xml(TWO.encode(), "two.urdf")
GONE = {
    "rotor inertia": ("drake:rotor_inertia",),
    "viscous friction": ('damping="0.7"',),
    "Coulomb friction": ('friction="0.4"',),
    "effort limits": ('effort="50"', 'effort="20"'),
    "velocity limits": ('velocity="3"', 'velocity="4"'),
    "position limits": ('lower="-2"', 'upper="2"'),
    "continuous joints": ('type="continuous"',),
    "inertial rpy": ('rpy="0.3 0.5 0"',),
    "links without inertial": ('<link name="base" />',),
}


def test_the_file_has_all_but_zeros():
    assert set(variants(TREE, SCOPE)) == set(GONE)
    assert {feature.name for feature in FEATURES} == {*GONE, "zero inertials"}


@pytest.mark.parametrize("name", GONE)
def test_a_change_takes_away_its_own_words(name):
    whole, changed = xml_of(TREE), xml_of(variants(TREE, SCOPE)[name])
    for words in GONE[name]:
        assert words in whole
        assert words not in changed
    for other in (x for feature, words in GONE.items() if feature != name for x in words):
        assert other in changed or name == "continuous joints"


def test_zeros_are_found_and_taken_out():
    zeros = '<link name="base"><inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0"/></inertial></link>'
    tree = parse_xml(TWO.replace('<link name="base"/>', zeros).encode(), "two.urdf")
    assert xml_of(variants(tree, SCOPE)["zero inertials"]) == xml_of(TREE)


def test_joints_beside_the_arm_are_left_alone():
    scope = ArmInFile(("j2",), "tool", (0.0, 0.0, -9.81))
    assert "viscous friction" not in variants(TREE, scope)


def test_a_rotor_of_zero_is_none():
    text = TWO.replace(ROTOR, ROTOR.replace("1e-5", "0"))
    assert "rotor inertia" not in variants(parse_xml(text.encode(), "two.urdf"), SCOPE)


def test_meshes_go_and_boxes_stay():
    mesh = '<visual><geometry><mesh filename="x.dae"/></geometry></visual>'
    text = TWO.replace("<visual>", f"{mesh}<visual>")
    tree = parse_xml(text.encode(), "two.urdf")
    assert xml_of(without_meshes(tree)) == xml_of(TREE)
    assert "box" not in xml_of(without_shapes(tree))
    assert "mesh" in xml_of(tree)
