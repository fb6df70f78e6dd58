"""The description of a figure: wrong ones are refused, series are the runs' numbers, colours follow one rule."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.pages.figures.figure import Curve, Figure, Panel, Series, run_series
from lwr_dyn.pages.replay.replayed_runs import replayed_runs

TWO = np.array([1.0, 2.0])


def figure_of(*panels):
    return Figure("f", "f", "", "x", "", tuple(Panel("", "y", "", tuple(curves)) for curves in panels))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Series(0, "speed"), "quantity: 'speed'"),
        (lambda: Series(0, "q"), "joint of 'q': None"),
        (lambda: Series(0, "tip error", 1), "joint of 'tip error': 1"),
        (lambda: Curve("c", TWO), "y as numbers, x not"),
        (lambda: Curve("c", Series(0, "q", 0), Series(1, "q", 0)), "a series of the same run"),
        (lambda: Curve("c", TWO, np.zeros(3)), r"x of shape \(3,\), y of shape \(2,\)"),
        (lambda: Curve("c", TWO, TWO, text=("one",)), "1 names; allowed: one per point"),
        (lambda: Curve("c", Series(0, "q", 0)).points(()), "run of a series: 0; allowed: no run is shown"),
    ],
)
def test_what_cannot_be_drawn_is_refused(make, message):
    with pytest.raises(OptionError, match=message):
        make()


def test_series_are_the_numbers_of_the_runs(arm, two_runs):
    runs = replayed_runs(two_runs, arm)
    run, pose = two_runs[1], flange_pose(arm.chain, two_runs[1].q)
    np.testing.assert_array_equal(run_series(runs[1], "torque"), run.tau_applied)
    np.testing.assert_array_equal(run_series(runs[1], "flange y"), pose[:, 1, 3])
    np.testing.assert_array_equal(run_series(runs[1], "energy"), run.energy)
    np.testing.assert_array_equal(run_series(runs[1], "tip error"), runs[1].tip_error)
    np.testing.assert_array_equal(Series(1, "position error", 2, 1e3).values(runs), 1e3 * (run.q_ref - run.q)[:, 2])
    with pytest.raises(OptionError, match="joint of a series: 7; allowed: 0 to 6"):
        Curve("c", Series(1, "q", 7)).points(runs)
    with pytest.raises(OptionError, match="run of a series: 2; allowed: 0 to 1"):
        Curve("c", Series(2, "q", 0)).points(runs)
