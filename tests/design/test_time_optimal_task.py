"""The task `least-time`: options of the task along whose path it goes, and what it refuses."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LwrDynError, OptionError, UnknownNameError

ARM = lwr_dyn.load("lwr4plus")
MOVE = {"start": [0.0] * 7, "end": [0.5] * 7}


def test_it_follows_the_path_of_another_task():
    quick = lwr_dyn.reference("least-time", ARM, along="point-to-point", acceleration=2.0, **MOVE)
    assert quick.duration == pytest.approx(1.0, abs=2e-3)
    assert quick.sample(np.array([quick.duration])).q[0] == pytest.approx(MOVE["end"])


@pytest.mark.slow
def test_its_name_says_whose_path_it_is():
    line = {"start": [0.0, 0.5, 0.0, -1.2, 0.0, 0.6, 0.0], "to_xyz": [-0.3, 0.2, 0.5]}
    quick = lwr_dyn.reference("least-time", ARM, along="line", **line)
    assert quick.about["task"] == "line in the least time"
    assert quick.about["timing"]["effort_share"] == 0.9


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"along": "least-time"}, OptionError, "along: 'least-time'; allowed: another task"),
        ({"along": "lists"}, UnknownNameError, "no reference named 'lists'"),
        ({"along": "hold", "start": [0.0] * 7}, LwrDynError, "start"),
        ({"along": "line", "shift": [0.0] * 3}, OptionError, "shift: no option of reference line"),
        ({"along": "line"}, OptionError, "start: not given"),
    ],
)
def test_bad_options_are_one_line(options, error, words):
    with pytest.raises(error) as caught:
        lwr_dyn.reference("least-time", ARM, **options)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
