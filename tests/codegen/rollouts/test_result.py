"""Metrics from the figures of a kernel and from a run, by hand; flags; what happens to runs that carry one."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.rollouts import result
from lwr_dyn.codegen.rollouts.kernel import Computed
from lwr_dyn.codegen.rollouts.step import FIGURES, Slots
from lwr_dyn.foundation.errors import DivergenceError, OptionError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.simulation.contact import TURN

OF_JOINTS = ("position_squares", "position_worst", "torque_worst", "command_worst", "torque_squares", "speed_worst",
             "saturated", "margin")  # fmt: skip
SLOTS = Slots({"before": 3} | {name: 2 if name in OF_JOINTS else 1 for name in FIGURES})
SETUP = SimpleNamespace(
    samples=4,
    t=np.arange(4.0) / 50.0,
    loop=SimpleNamespace(rate=50.0, substeps=2, position_limits=True),
    plant=SimpleNamespace(effort=np.array([50.0, 60.0])),
)


def computed(*changes):
    """Rows of figures: the numbers of `GOOD`, and those that a run has instead."""
    rows = [np.concatenate([np.ravel((GOOD | change)[name]) for name in FIGURES]) for change in changes]
    return Computed(np.array(rows), np.arange(1.0, 1.0 + 2 * len(rows)).reshape(-1, 2), None)


GOOD = {
    "tip_squares": 36.0, "tip_worst": 25.0, "tip_square": 16.0, "position_squares": [4.0, 16.0],
    "position_worst": [0.5, 0.6], "torque_worst": [7.0, 8.0], "command_worst": [9.0, 10.0],
    "torque_squares": [64.0, 100.0], "speed_worst": [1.5, 2.5], "saturated": [1.0, 3.0], "margin": [0.1, 0.2],
    "violation": 2.0, "angle_worst": 5.0, "trouble": 0.0,
}  # fmt: skip


def test_metrics_are_roots_of_means_and_largest_values():
    metrics, flags = result.metrics_of_computed(SETUP, SLOTS, computed({}, {"violation": 4.0}), (0.5, 0.9))
    assert flags == ["", ""]
    assert {name: values[0].tolist() for name, values in metrics.items()} == {
        "tip_rms": 3.0, "tip_max": 5.0, "tip_final": 4.0, "position_rms": [1.0, 2.0], "position_max": [0.5, 0.6],
        "peak_torque": [7.0, 8.0], "peak_command": [9.0, 10.0], "torque_rms": [4.0, 5.0], "peak_speed": [1.5, 2.5],
        "saturated_s": [0.02, 0.06], "limit_margin": [0.1, 0.2], "first_violation": 0.04,
        "tip_q50": 1.0, "tip_q90": 2.0,
    }  # fmt: skip
    assert metrics["first_violation"][1] == np.inf
    assert metrics["tip_q50"].tolist() == [1.0, 3.0]


FARTHEST = (sincos("float64").most_half_turns - 1) * np.pi
"""[rad] Where the range reduction ends."""


@pytest.mark.parametrize(
    ("change", "flag"),
    [
        ({"margin": [0.1, 0.0]}, "stop"), ({"margin": [0.1, 1e-300]}, ""), ({"trouble": np.nan}, "not finite"),
        ({"speed_worst": [20.1, 0.0]}, "out of range"), ({"speed_worst": [19.9, 0.0]}, ""),
        ({"margin": [-1.0, 1.0], "trouble": np.nan}, "stop"),
        ({"angle_worst": 1.001 * FARTHEST**2}, "out of range"), ({"angle_worst": 0.999 * FARTHEST**2}, ""),
        ({"trouble": np.nan, "speed_worst": [1e9, 0.0]}, "not finite"),
    ],
)  # fmt: skip
def test_a_flag_says_what_ended_a_run(change, flag):
    """0.2 rad a step of RK4, two of them in 20 ms."""
    assert result.metrics_of_computed(SETUP, SLOTS, computed(change, {}), ())[1] == [flag, ""]
    assert flag in result.FLAGS


@pytest.mark.parametrize(
    ("change", "flag"),
    [
        ({"margin": [-1.0, 0.0]}, ""),
        ({"speed_worst": [0.999 * TURN * 50.0, 0.0]}, ""),
        ({"speed_worst": [1.001 * TURN * 50.0, 0.0]}, "out of range"),
    ],
)
def test_speed_counts_by_samples_where_steps_are_many_and_stops_only_where_they_are_on(change, flag):
    """A tenth of a turn a sample would be seen in the angles."""
    loop = SimpleNamespace(rate=50.0, substeps=99, position_limits=False)
    free = SimpleNamespace(**{**vars(SETUP), "loop": loop})
    assert result.metrics_of_computed(free, SLOTS, computed(change), ())[1] == [flag]


def test_figures_of_a_run_are_those_of_its_rows():
    arm = replace(lwr_dyn.load("lwr4plus"))
    q = np.full((3, 7), 0.2)
    off, signs = np.outer([0.0, 0.1, 0.3], np.ones(7)), np.resize([1.0, -1.0], 7)
    command = arm.effort * signs * [[2.0], [0.5], [3.0]]
    run = SimpleNamespace(
        t=np.array([0.0, 0.1, 0.4]), q=q, q_ref=q + off * signs, dq=off * 2.0 * signs, tau_applied=-10.0 * off * signs,
        tau_command=command,
    )  # fmt: skip
    tips = [flange_pose(arm.chain, x)[:, :3, 3] for x in (run.q, run.q_ref)]
    away = np.sqrt(((tips[0] - tips[1]) ** 2).sum(axis=1))
    found = result.figures_of(run, arm, away[1] * 0.999, (0.5,))
    joints = {
        "position_rms": np.sqrt(0.1 / 3.0), "position_max": 0.3, "peak_torque": 3.0, "peak_speed": 0.6,
        "torque_rms": 10.0 * np.sqrt(0.1 / 3.0), "saturated_s": 0.1, "peak_command": 3.0 * arm.effort,
        "limit_margin": np.minimum(0.2 - arm.lower, arm.upper - 0.2),
    }  # fmt: skip
    single = {
        "tip_rms": np.sqrt((away**2).mean()), "tip_max": away.max(), "tip_final": away[2], "first_violation": 0.1,
        "tip_q50": np.median(away),
    }  # fmt: skip
    expected = {name: np.broadcast_to(value, 7) for name, value in joints.items()} | single
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-14), name
    assert [result.figures_of(run, arm, x)["first_violation"] for x in (None, away[1])] == [np.inf, 0.4]


@pytest.mark.parametrize("hand_over", [True, False])
def test_runs_with_a_flag_are_made_again_and_the_others_stay(hand_over):
    run = SimpleNamespace(q=np.full((3, 2), 5.0), dq=np.full((3, 2), 6.0), tau_applied=np.full((3, 2), 7.0))
    run.q[1] = 99.0

    def again(i):
        if i == 2:
            raise DivergenceError(0.0, "a joint", "much", "less")
        return run

    record, metrics = np.zeros((4, 2, 6)), {"a": np.arange(4.0), "b": np.arange(8.0).reshape(4, 2)}
    given = (record, 2, again) if hand_over else (None, 2, None)
    simulated = result.settle(
        ["", "stop", "not finite", ""], metrics, *given, lambda run, i: {"a": 10.0 * i, "b": run.q[0]}
    )
    nan, made = [np.nan] * 2, hand_over
    assert simulated.tolist() == [False, made, made, False]
    np.testing.assert_array_equal(metrics["a"], [0.0, 10.0 if made else np.nan, np.nan, 3.0])
    np.testing.assert_array_equal(metrics["b"], [[0.0, 1.0], [5.0, 5.0] if made else nan, nan, [6.0, 7.0]])
    if made:
        expected = np.zeros((4, 2, 6))
        expected[1], expected[2] = [5.0, 5.0, 6.0, 6.0, 7.0, 7.0], np.nan
        np.testing.assert_array_equal(record, expected)


def test_a_run_is_counted_from_either_end_and_shown():
    done = result.Rollouts({"a": 0}, ("", "stop", "stop"), np.array([False, True, False]), again=lambda i: i)
    assert [done.run(i) for i in (0, 2, -1, -3, np.int64(1))] == [0, 2, 2, 0, 1]
    for i in (3, -4, 1.0, True, "a", None):
        with pytest.raises(OptionError, match=r"allowed: 0 to 2"):
            done.run(i)
    assert repr(done) == "Rollouts(3 runs, flags: 2 stop, 1 of them by simulate, 1 metrics)"
    with pytest.raises(OptionError):
        result.Rollouts({}, ("",), np.array([False])).run(0)


def test_quantiles_are_shares_between_0_and_1():
    assert result.checked_quantiles([0.5, np.float64(0.9)]) == (0.5, 0.9)
    for wrong in (0.5, [0.0], [1.0], ["a"]):
        with pytest.raises(OptionError, match="quantiles"):
            result.checked_quantiles(wrong)
