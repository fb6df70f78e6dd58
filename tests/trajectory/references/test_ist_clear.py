"""`ist-clear`: far from every limit, as its documentation says; IST and its neighbours on the grid come nearer."""

import json
import math

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.errors import LwrDynError, OptionError, PathLimitError, ShapeError
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.simulation.plant import arm_with_payload
from lwr_dyn.trajectory.references.ist import CLEAR_SHIFT, CLEAR_TURN, POINTS, TOOL, ist_clear_reference, ist_reference

ARM = lwr_dyn.load("lwr4plus")
TIMES = np.linspace(0.0, 14.0, 1401)


def margin_and_speed(reference):
    """Least distance of a joint to its limits [deg], and the largest share of a speed limit, sample by sample."""
    motion = reference.sample(TIMES)
    margin = np.minimum(motion.q - ARM.lower, ARM.upper - motion.q).min()
    return math.degrees(margin), float((np.abs(motion.dq).max(axis=0) / ARM.velocity).max())


def test_every_joint_keeps_23_degrees_and_a_fifth_of_its_speed():
    margin, speed = margin_and_speed(ist_clear_reference(ARM))
    assert (round(margin, 1), round(speed, 2)) == (23.1, 0.20)
    margin, speed = margin_and_speed(ist_reference(ARM))
    assert (round(margin, 1), round(speed, 2)) == (1.2, 0.29)


def test_the_letters_stay_upright_and_the_tool_alone_turns():
    poses, printed = ist_clear_reference(ARM).poses, ist_reference(ARM).poses
    T, there = poses.at(TIMES).T, printed.at(TIMES).T
    np.testing.assert_allclose(T[:, :3, 3] - there[:, :3, 3], np.broadcast_to(CLEAR_SHIFT, (len(TIMES), 3)), atol=1e-12)
    np.testing.assert_allclose(T[0, :3, 3], POINTS.si()[0] + CLEAR_SHIFT, atol=1e-12)
    x = np.array(TOOL).T @ T[0, :3, :3]  # the turn, in axes of the tool: its x is that of frame 0
    assert math.degrees(math.acos((np.trace(x) - 1) / 2)) == pytest.approx(60.0)
    np.testing.assert_allclose(T[0, :3, 0], [1, 0, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("shift", "turn"),
    [((0.3, -0.1, -0.15), 60), ((0.5, -0.1, -0.15), 60), ((0.4, 0.0, -0.15), 60), ((0.4, -0.2, -0.15), 60),
     ((0.4, -0.1, 0.0), 60), ((0.4, -0.1, -0.3), 60), (CLEAR_SHIFT, 30), (CLEAR_SHIFT, 90), (CLEAR_SHIFT, 0)],
)  # fmt: skip
def test_its_neighbours_come_nearer_to_a_limit_or_are_out_of_reach(shift, turn):
    try:
        margin, _ = margin_and_speed(ist_reference(ARM, shift=shift, tool_turn=math.radians(turn)))
    except LwrDynError:
        return
    assert margin < 18.0


def test_3_kg_that_no_controller_knows_bring_no_joint_to_its_stop():
    """On IST joint 6 falls on its stop within 0.03 s."""
    controller, plant = lwr_dyn.controller("inverse-dynamics", ARM), arm_with_payload(ARM, 3.0)
    figures = {
        name: metrics(lwr_dyn.simulate(ARM, controller, lwr_dyn.reference(name, ARM), plant=plant, duration=3.0), ARM)
        for name in ("ist", "ist-clear")
    }
    assert figures["ist"].stops.sentence() == "joint_6 on its stop for 1.4 s"
    assert figures["ist-clear"].within_limits
    assert np.degrees(figures["ist-clear"].limit_margin).min() > 15.0


def test_a_run_names_the_pose(lwr_dyn_command):
    def about(*options):
        code, out, _ = lwr_dyn_command("simulate", "lwr4plus", *options, "--json")
        assert code == 0
        record = json.loads(out)["meta"]
        return record["note"]["task"], record["reference"]["about"].get("moved", {}).get("shift")

    moved = ("--task", "ist", "--shift", "0.4,-0.1,-0.15", "--tool-turn-deg")
    assert about("--task", "ist-clear") == about(*moved, "60") == ("ist-clear", list(CLEAR_SHIFT))
    assert about(*moved, "70") == ("ist, moved", list(CLEAR_SHIFT))
    assert math.degrees(CLEAR_TURN) == pytest.approx(60.0)


@pytest.mark.parametrize(
    ("options", "error", "says"),
    [
        ({"shift": (1.0, 2.0)}, ShapeError, "shift: 2 numbers; allowed: 3 numbers"),
        ({"shift": (0.1, float("nan"), 0.0)}, ShapeError, "shift: nan"),
        ({"shift": (2.0, 0.0, 0.0)}, PathLimitError, "1.3 m out of reach"),
        ({"tool_turn": float("inf")}, OptionError, "tool_turn: inf; allowed: a finite angle"),
    ],
)
def test_what_cannot_be_is_refused(options, error, says):
    with pytest.raises(error, match=says):
        ist_reference(ARM, **options)
