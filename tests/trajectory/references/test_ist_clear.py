"""`ist-clear`: far from every limit, as its documentation says; IST and its neighbours on the grid come nearer."""

import json
import math

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError, PathLimitError, ShapeError
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.trajectory.references.ist import CLEAR_SHIFT, POINTS, TOOL, ist_clear_reference, ist_reference

ARM = lwr_dyn.load("lwr4plus")
TIMES = np.linspace(0.0, 14.0, 1401)


def margin_and_speed(reference):
    """Least distance of a joint to its limits [deg], and the largest share of a speed limit, sample by sample."""
    motion = reference.sample(TIMES)
    margin = np.minimum(motion.q - ARM.lower, ARM.upper - motion.q).min()
    return math.degrees(margin), float((np.abs(motion.dq).max(axis=0) / ARM.velocity).max())


def test_every_joint_keeps_50_degrees_and_a_fifth_of_its_speed():
    margin, speed = margin_and_speed(ist_clear_reference(ARM))
    assert (round(margin, 1), round(speed, 2)) == (50.9, 0.18)
    margin, speed = margin_and_speed(ist_reference(ARM))
    assert (round(margin, 1), round(speed, 2)) == (1.2, 0.29)


def test_the_letters_and_the_tool_are_those_of_ist():
    T, there = (reference.poses.at(TIMES).T for reference in (ist_clear_reference(ARM), ist_reference(ARM)))
    np.testing.assert_allclose(T[:, :3, 3] - there[:, :3, 3], np.tile(CLEAR_SHIFT, (len(TIMES), 1)), atol=1e-12)
    np.testing.assert_allclose(T[0, :3, 3], POINTS.si()[0] + CLEAR_SHIFT, atol=1e-12)
    np.testing.assert_array_equal(T[:, :3, :3], np.broadcast_to(TOOL, (len(TIMES), 3, 3)))


NEIGHBOURS = [tuple(np.add(CLEAR_SHIFT, step * axis).round(9)) for axis in np.eye(3) for step in (-0.1, 0.1)]


@pytest.mark.slow
@pytest.mark.parametrize("shift", [*NEIGHBOURS, (0.4, -0.1, -0.15), (0.05, 0.12, 0.12)])
def test_other_shifts_come_nearer_to_a_limit_or_are_out_of_reach(shift):
    """The last is the best that was known before; all of the grid: scripts/ist_clear.py."""
    try:
        margin, _ = margin_and_speed(ist_reference(ARM, shift=shift))
    except LwrDynError:
        return
    assert margin < 50.0


@pytest.mark.slow
def test_3_kg_that_no_controller_knows_bring_no_joint_to_its_stop():
    """On IST joint 6 falls on its stop within 0.03 s."""
    controller, plant = lwr_dyn.controller("inverse-dynamics", ARM), arm_with_payload(ARM, 3.0)
    figures = {
        name: metrics(lwr_dyn.simulate(ARM, controller, lwr_dyn.reference(name, ARM), plant=plant, duration=3.0), ARM)
        for name in ("ist", "ist-clear")
    }
    assert figures["ist"].stops.sentence() == "joint_6 on its stop for 1.4 s"
    assert figures["ist-clear"].within_limits
    assert np.degrees(figures["ist-clear"].limit_margin).min() > 45.0


@pytest.mark.slow
def test_a_run_names_the_shift(lwr_dyn_command):
    def about(*options):
        code, out, _ = lwr_dyn_command("simulate", "lwr4plus", *options, "--json")
        assert code == 0
        record = json.loads(out)["meta"]
        return record["note"]["task"], record["reference"]["about"].get("shift", {}).get("value")

    assert about("--task", "ist-clear") == about("--task", "ist", "--shift", "0.7,0.6,-0.3")
    assert about("--task", "ist-clear") == ("ist-clear", list(CLEAR_SHIFT))
    assert about("--task", "ist", "--shift", "0.7,0.5,-0.3") == ("ist, moved", [0.7, 0.5, -0.3])


@pytest.mark.parametrize(
    ("options", "error", "says"),
    [
        ({"shift": (1.0, 2.0)}, ShapeError, "shift: 2 numbers; allowed: 3 numbers"),
        ({"shift": (0.1, float("nan"), 0.0)}, ShapeError, "shift: nan"),
        ({"shift": (2.0, 0.0, 0.0)}, PathLimitError, "1.3 m out of reach"),
    ],
)
def test_what_cannot_be_is_refused(options, error, says):
    with pytest.raises(error, match=says):
        ist_reference(ARM, **options)
