"""The description of a figure: wrong ones are refused, series are the runs' numbers, axes have round ticks."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.pages.figures.figure import (
    Axis,
    Curve,
    Series,
    apart,
    axis_of,
    frequency_axis,
    logarithmic_axis,
    round_length,
    run_series,
)
from lwr_dyn.pages.replay.replayed_runs import replayed_runs

TWO = np.array([1.0, 2.0])
Q = Series(0, "q", 0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Series(0, "speed"), "quantity: 'speed'; allowed: q, q_ref, dq, dq_ref, position error"),
        (lambda: Series(0, "q"), "joint of 'q': None; allowed: a 0-based joint for joint quantities, none for others"),
        (lambda: Series(0, "tip error", 1), "joint of 'tip error': 1"),
        (lambda: Curve("c", TWO), "y as numbers, x not"),
        (lambda: Curve("c", TWO, Q), "y as numbers, x not"),
        (lambda: Curve("c", Q, Series(1, "q", 0)), "a series of the same run"),
        (lambda: Curve("c", Q, TWO), "a series of the same run"),
        (lambda: Curve("c", TWO, np.zeros(3)), r"x of shape \(3,\), y of shape \(2,\)"),
        (lambda: Curve("c", np.zeros(0), np.zeros(0)), r"x of shape \(0,\), y of shape \(0,\)"),
        (lambda: Curve("c", np.zeros((2, 2)), np.zeros((2, 2))), r"x of shape \(2, 2\)"),
        (lambda: Curve("c", TWO, TWO, text=("one",)), "1 names; allowed: one per point"),
        (lambda: Curve("c", Q, text=("one",)), "1 names; allowed: one per point"),
        (lambda: Curve("c", Q).points(()), "run of a series: 0; allowed: no run is shown"),
    ],
)
def test_what_cannot_be_drawn_is_refused(make, message):
    with pytest.raises(OptionError, match=message):
        make()


def test_series_are_the_numbers_of_the_runs(arm, two_runs):
    runs = replayed_runs(two_runs, arm)
    run = two_runs[1]
    poses = {"flange": flange_pose(arm.chain, run.q), "reference": flange_pose(arm.chain, run.q_ref)}
    expected = {f"{what} {axis}": pose[:, k, 3] for what, pose in poses.items() for k, axis in enumerate("xyz")}
    expected |= {
        "q": run.q, "q_ref": run.q_ref, "dq": run.dq, "dq_ref": run.dq_ref, "position error": run.q_ref - run.q,
        "velocity error": run.dq_ref - run.dq, "torque": run.tau_applied, "friction": run.tau_friction,
        "tip error": runs[1].tip_error, "energy": run.energy,
    }  # fmt: skip
    for name, values in expected.items():
        np.testing.assert_array_equal(run_series(runs[1], name), values)
    followed = {name for name in expected if Series(0, name, None if expected[name].ndim == 1 else 0).is_reference}
    assert followed == {"q_ref", "dq_ref", "reference x", "reference y", "reference z"}
    np.testing.assert_array_equal(Series(1, "position error", 2, 1e3).values(runs), 1e3 * (run.q_ref - run.q)[:, 2])
    t, q = Curve("c", Series(1, "q", 2)).points(runs)
    np.testing.assert_array_equal([t, q], [run.t, run.q[:, 2]])
    assert Curve("c", Series(1, "q", 6), Series(1, "q", 0)).points(runs)[0] is not t
    for series, message in (
        (Series(1, "q", 7), "joint of a series: 7; allowed: 0 to 6"), (Series(1, "q", -1), "joint of a series: -1"),
        (Series(2, "q", 0), "run of a series: 2; allowed: 0 to 1"), (Series(-1, "q", 0), "run of a series: -1"),
    ):  # fmt: skip
        with pytest.raises(OptionError, match=message):
            Curve("c", series).points(runs)


@pytest.mark.parametrize(
    ("values", "options", "ends", "labels", "power"),
    [
        ([0.0, 14.0], {"padding": 0.0}, (0.0, 14.0), ["0", "5", "10"], 0),
        ([0.0, 14.0], {}, (-0.84, 14.84), ["0", "5", "10"], 0),
        ([0.0, 14.0], {"most": 8}, (-0.84, 14.84), ["0", "2", "4", "6", "8", "10", "12", "14"], 0),
        ([np.nan, -1.0, 1.0, np.inf], {"padding": 0.0}, (-1.0, 1.0), ["\u22121", "0", "1"], 0),
        ([np.nan], {"padding": 0.0}, (0.0, 1.0), ["0.0", "0.5", "1.0"], 0),
        ([5.0, 5.0], {"padding": 0.0}, (4.5, 5.5), ["4.5", "5.0", "5.5"], 0),
        ([0.0, 0.0], {"padding": 0.0}, (-1.0, 1.0), ["\u22121", "0", "1"], 0),
        ([0.0, 0.04], {"padding": 0.0}, (0.0, 0.04), ["0.00", "0.02", "0.04"], 0),
        ([0.0, 9990.0], {"padding": 0.0}, (0.0, 9990.0), ["0", "5000"], 0),
        ([0.0, 40000.0], {"padding": 0.0}, (0.0, 40000.0), ["0", "20", "40"], 3),
        ([0.0, 4e-6], {"padding": 0.0}, (0.0, 4e-6), ["0", "2", "4"], -6),
    ],
)
def test_an_axis_has_round_ticks_and_short_labels(values, options, ends, labels, power):
    axis = axis_of(np.array(values), **options)
    assert (axis.low, axis.high) == pytest.approx(ends)
    assert (list(axis.labels), axis.power, axis.is_logarithmic) == (labels, power, False)
    assert axis.share(axis.low) == 0.0
    assert axis.share(axis.high) == 1.0
    assert float(axis.share((axis.low + axis.high) / 2)) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("values", "decades", "ends", "ticks"),
    [
        ([*[0.02] * 99, 30.0], 6, (1e-2, 1e2), [1e-2, 1e-1, 1.0, 10.0, 100.0]),
        ([0.02, *[3.0] * 99], 6, (1.0, 10.0), [1.0, 10.0]),  # one in a hundred is left below the axis
        ([3.0, 4.0], 6, (1.0, 10.0), [1.0, 10.0]),
        ([10.0, 10.0], 6, (1.0, 10.0), [1.0, 10.0]),
        ([*[1e-9] * 99, 1.0, np.nan, 0.0, -1.0], 6, (1e-6, 1.0), [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0]),
        ([*[1e-9] * 99, 1.0], 8, (1e-8, 1.0), [1e-8, 1e-6, 1e-4, 1e-2, 1.0]),
    ],
)
def test_a_logarithmic_axis_ends_at_powers_of_ten(values, decades, ends, ticks):
    axis = logarithmic_axis(np.array(values), decades)
    assert (axis.low, axis.high, axis.is_logarithmic, axis.power) == (*map(pytest.approx, ends), True, 0)
    assert axis.ticks == pytest.approx(ticks)
    shares = np.log10(np.array(ticks) / ends[0]) / np.log10(ends[1] / ends[0])
    np.testing.assert_allclose(axis.share(np.array(ticks)), shares, atol=1e-12)
    assert axis.share(ends[0] / 10.0) == 0.0  # what is below is at the end


@pytest.mark.parametrize(
    ("values", "ticks"),
    [
        ([0.7, 8.0, 33.0], [1.0, 2.0, 5.0, 10.0, 20.0]),
        ([1.0, 199.0], [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]),
        ([1.0, np.nan, 200.0], [1.0, 10.0, 100.0]),
        ([2.1, 4.9], [2.1, 4.9]),
    ],
)
def test_a_frequency_axis_has_its_own_ends(values, ticks):
    axis = frequency_axis(np.array(values))
    assert (axis.low, axis.high, axis.ticks) == (values[0], values[-1], pytest.approx(ticks))
    assert float(axis.share(np.sqrt(axis.low * axis.high))) == pytest.approx(0.5)


def test_lengths_are_round_and_names_apart():
    found = {x: round_length(x) for x in (0.49, 0.5, 0.2, 0.199, 1e3, 9.9e-4, 1.0)}
    assert found == pytest.approx({0.49: 0.2, 0.5: 0.5, 0.2: 0.2, 0.199: 0.1, 1e3: 1e3, 9.9e-4: 5e-4, 1.0: 1.0})
    assert apart([0.1, 0.3, 0.35], 0.1) == pytest.approx([0.1, 0.3, 0.4])
    assert apart([0.9, 0.95, 1.0], 0.1) == pytest.approx([0.8, 0.9, 1.0])
    assert apart([], 0.1) == []
    assert Axis(0.0, 1.0, ()).power == 0
