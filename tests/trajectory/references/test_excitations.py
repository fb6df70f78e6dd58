"""Steps and chirps of the set-point: what is asked, when, of which joint."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, PathLimitError, ShapeError
from lwr_dyn.trajectory.references.excitations import BEFORE, REST

ARM = lwr_dyn.load("lwr4plus")
START = np.array([0.0, 0.5, 0.0, -1.2, 0.0, 0.6, 0.0])


def test_each_joint_steps_in_turn_and_stays():
    reference = lwr_dyn.reference("step", ARM, start=START, size=0.01, duration=0.2)
    assert reference.duration == pytest.approx(BEFORE + 7 * 0.2)
    t = np.array([0.0, BEFORE - 1e-6, BEFORE, BEFORE + 0.2 - 1e-6, BEFORE + 0.2, 99.0])
    motion = reference.sample(t)
    stepped = np.round((motion.q - START) / 0.01, 9)
    assert stepped[:3, 0].tolist() == [0.0, 0.0, 1.0]
    assert stepped[3:, 1].tolist() == [0.0, 1.0, 1.0]
    assert stepped[5].tolist() == [1.0] * 7
    assert not motion.dq.any()
    assert not motion.ddq.any()


def test_a_chirp_rises_in_frequency_and_rests():
    reference = lwr_dyn.reference("chirp", ARM, start=START, size=0.01, joint=3, low=1.0, high=20.0, duration=4.0)
    t = np.linspace(0.0, reference.duration, 20_001)
    motion = reference.sample(t)
    moved = motion.q - START
    assert not np.delete(moved, 2, axis=1).any()
    assert not moved[t > 4.0].any()
    assert reference.duration == 4.0 + REST
    crossings = t[1:][np.diff(np.sign(moved[:, 2])) != 0.0]
    pace = 0.5 / np.diff(crossings[crossings < 3.9])
    middle = 0.5 * (crossings[1:] + crossings[:-1])[: pace.size]
    assert pace == pytest.approx(20.0 ** (middle / 4.0), rel=0.02)
    assert np.abs(moved).max() == pytest.approx(0.01, rel=1e-3)
    assert not motion.dq.any()


def test_rates_are_exact_derivatives():
    reference = lwr_dyn.reference("chirp", ARM, start=START, joint=1, low=1.0, high=10.0, duration=4.0, rates=True)
    t, h = np.linspace(0.013, 3.987, 400), 1e-5
    ahead, behind, motion = (reference.sample(x) for x in (t + h, t - h, t))
    assert (ahead.q - behind.q) / (2.0 * h) == pytest.approx(motion.dq, abs=1e-6)
    assert (ahead.dq - behind.dq) / (2.0 * h) == pytest.approx(motion.ddq, abs=1e-4)
    assert np.abs(motion.ddq).max() > 1.0


BAD = [
    ("step", {"joint": 8}, OptionError, "joint: 8; allowed: 1 to 7"),
    ("step", {"joint": 0}, OptionError, "joint: 0"),
    ("step", {"size": 0.0}, OptionError, "size"),
    ("step", {"duration": -1.0}, OptionError, "duration"),
    ("step", {"start": [0.0]}, ShapeError, "start"),
    ("step", {"size": 3.0, "joint": 2}, PathLimitError, "joint_2"),
    ("chirp", {"size": -3.0}, PathLimitError, "joint_"),
    ("chirp", {"low": 5.0, "high": 5.0}, OptionError, "low, high: 5 to 5 Hz; allowed: frequencies that rise"),
    ("chirp", {"duration": 1.0}, OptionError, "duration: 1 s at 0.5 Hz; allowed: at least 6 s, 3 periods"),
]


@pytest.mark.parametrize(("task", "options", "error", "words"), BAD)
def test_bad_options_are_one_line(task, options, error, words):
    with pytest.raises(error) as caught:
        lwr_dyn.reference(task, ARM, **{"start": START, **options})
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
