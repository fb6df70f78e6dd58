"""What readings differ in: the errata of the paper, and exactly the numbers that they change."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.pages.explorer.page import differing_numbers, slips_record


@pytest.mark.parametrize("robot", ["lwr4plus", "wam7", "kr30ha"])
def test_each_reading_has_the_errata_that_not_all_apply(robot):
    arms = [lwr_dyn.load(robot, reading) for reading in lwr_dyn.readings(robot)]
    record, paper = slips_record(arms), open_paper(robot)
    readings = [set(paper.readings[arm.reading].errata) for arm in arms]
    for i, mine in enumerate(readings):
        for k, other in enumerate(readings):
            assert set(record["applied"][i]) - set(record["applied"][k]) == mine - other
    assert set(record["errata"]) == set.union(*readings) - set.intersection(*readings)
    for erratum in paper.errata:
        if erratum.id in record["errata"]:
            assert record["errata"][erratum.id][:2] == [erratum.where, erratum.printed]
    assert record["about"] == [paper.readings[arm.reading].about for arm in arms]


def test_numbers_that_differ_are_those_that_differ():
    arm = lwr_dyn.load("lwr4plus", "computed")
    assert differing_numbers([arm, arm]) == {}
    physical = lwr_dyn.load("lwr4plus", "physical")
    numbers = differing_numbers([arm, physical])
    rotors = [name for name in numbers if "rotor inertia" in name]
    assert len(rotors) == (arm.armature != physical.armature).sum() == 7
    assert not any("origin" in name or "limit" in name for name in numbers)


def test_axes_that_are_exchanged_are_seen_in_the_tensor():
    numbers = differing_numbers([lwr_dyn.load("lwr4plus", "computed"), lwr_dyn.load("lwr4plus", "printed")])
    changed = [name for name in numbers if "xx, yy, zz" in name]
    assert [name.split(",")[0] for name in changed] == ["link_2", "link_4"]
    mine, other = ([float(x) for x in text.split(",")] for text in numbers[changed[0]])
    np.testing.assert_allclose(np.sort(mine[:3]), np.sort(other[:3]), rtol=1e-4)


def test_other_kinematics_are_seen_in_the_frames():
    kuka, printed = (lwr_dyn.load("kr30ha", reading) for reading in ("kuka", "printed"))
    numbers = differing_numbers([kuka, printed])
    moved = [
        joint.name
        for joint, other in zip(kuka.joints(), printed.joints(), strict=True)
        if not np.allclose(joint.origin.matrix(), other.origin.matrix())
    ]
    assert moved
    assert all(any(name.startswith(f"{joint}, ") for name in numbers) for joint in moved)
    assert [float(x) for x in numbers["A1, roll, pitch, yaw, deg"][0].split(",")] == pytest.approx([180.0, 0.0, 0.0])
