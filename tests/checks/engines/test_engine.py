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


def variants_of(text, *joints):
    return variants(parse_xml(text.encode(), "two.urdf"), ArmInFile(joints or SCOPE.joints, "tool", SCOPE.gravity))


@pytest.mark.parametrize("name", GONE)
def test_a_change_takes_away_its_own_words(name):
    whole, changed = xml_of(TREE), xml_of(variants(TREE, SCOPE)[name])
    assert [(words in whole, words in changed) for words in GONE[name]] == [(True, False)] * len(GONE[name])
    bounds = [limit.attrib for limit in variants(TREE, SCOPE)["continuous joints"].iterfind("joint/limit")]
    assert [(x["lower"], x["upper"], x["effort"]) for x in bounds if x["lower"] == "-9"] == [("-9", "9", "20")]
    others = [x for feature, words in GONE.items() if feature != name for x in words]
    assert name == "continuous joints" or all(other in changed for other in others)


def test_features_are_those_that_the_file_has():
    """All but inertials without mass; not of joints beside the arm, not a rotor of zero."""
    assert set(variants(TREE, SCOPE)) == set(GONE)
    assert {feature.name for feature in FEATURES} == {*GONE, "zero inertials", "moments without mass"}
    assert "viscous friction" not in variants_of(TWO, "j2")
    assert "rotor inertia" not in variants_of(TWO.replace(ROTOR, ROTOR.replace("1e-5", "0")))


def test_zeros_are_taken_out_and_moments_without_mass_become_zeros():
    zeros = '<link name="base"><inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0"/></inertial></link>'
    found = variants_of(TWO.replace('<link name="base"/>', zeros))
    assert xml_of(found["zero inertials"]) == xml_of(TREE)
    assert "moments without mass" not in found
    light = TWO.replace('<mass value="1"/>', '<mass value="0"/>')
    turning, still = (parse_xml(x.encode(), "two.urdf").find("link[@name='lower']/inertial/inertia").attrib
                      for x in (light, xml_of(variants_of(light)["moments without mass"])))  # fmt: skip
    assert (turning["izz"], set(turning), {*map(float, still.values())}) == ("0.01", set(still), {0.0})


def test_meshes_go_and_boxes_stay():
    mesh = '<visual><geometry><mesh filename="x.dae"/></geometry></visual>'
    tree = parse_xml(TWO.replace("<visual>", f"{mesh}<visual>").encode(), "two.urdf")
    assert xml_of(without_meshes(tree)) == xml_of(TREE)
    assert ("box" in xml_of(without_shapes(tree)), "mesh" in xml_of(tree)) == (False, True)
