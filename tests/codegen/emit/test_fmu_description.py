"""Variables of an FMU: names of scalars, dimensions, and indices that point at each other in both versions."""

from xml.etree import ElementTree

import numpy as np

from lwr_dyn.codegen.emit.fmu_description import PLACES, FmuVariable, build_description, model_description

ROWS = (
    FmuVariable("u", "input", "continuous", np.zeros(1), "N.m"),
    FmuVariable("x", "output", "continuous", np.zeros(2), "rad", 'says <&> "much"', calculated=True),
    FmuVariable("rate", "local", "continuous", np.zeros(2), "rad/s", calculated=True).derived_from("x"),
    FmuVariable("pose", "output", "continuous", np.zeros(4), calculated=True, shape=(2, 2)),
)


def described(version, sample=None):
    return ElementTree.fromstring(model_description(version, "m", "t", "a", ROWS, ("a.c",), sample))


def test_structure_of_version_2_counts_scalars():
    assert [x.scalar_names() for x in ROWS if x.name in "ux"] == [["u"], ["x[1]", "x[2]"]]
    assert ROWS[3].scalar_names() == ["pose[1,1]", "pose[1,2]", "pose[2,1]", "pose[2,2]"]
    tree = described("2")
    variables = list(tree.find("ModelVariables"))
    assert [int(x.attrib["valueReference"]) for x in variables] == [0, 1000, 1001, 2000, 2001, 3000, 3001, 3002, 3003]
    assert PLACES == 1000
    assert [x.find("Real").attrib.get("derivative") for x in variables] == [None] * 3 + ["2", "3"] + [None] * 4
    listed = {x.tag: [int(y.attrib["index"]) for y in x] for x in tree.find("ModelStructure")}
    assert listed == {"Outputs": [2, 3, 6, 7, 8, 9], "Derivatives": [4, 5], "InitialUnknowns": [2, 3, 4, 5, 6, 7, 8, 9]}
    assert variables[1].attrib["description"] == 'says <&> "much"'


def test_structure_of_version_3_points_at_arrays():
    tree = described("3")
    dimensions = [[d.attrib["start"] for d in x.findall("Dimension")] for x in tree.find("ModelVariables")]
    assert dimensions == [[], ["2"], ["2"], ["2", "2"], []]
    listed = [(x.tag, x.attrib["valueReference"]) for x in tree.find("ModelStructure")]
    assert listed[:3] == [("Output", "1"), ("Output", "3"), ("ContinuousStateDerivative", "2")]
    assert [x for tag, x in listed if tag == "InitialUnknown"] == ["1", "2", "3"]


def test_a_controller_has_a_sample_and_no_model_exchange():
    assert described("3").find("ModelExchange") is not None
    sampled = described("3", 0.002)
    assert sampled.find("ModelExchange") is None
    assert sampled.find("CoSimulation").attrib["fixedInternalStepSize"] == "0.002"
    assert 'modelIdentifier="m"' in build_description("m", ("a.c",))
