"""Steps and chirps of the set-point: what is asked, when, of which joint."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, PathLimitError, ShapeError
from lwr_dyn.trajectory.references.excitations import BEFORE, REST
from tests.trajectory.differences import check_derivatives

ARM = lwr_dyn.load("lwr4plus")
START = np.array([0.0, 0.5, 0.0, -1.2, 0.0, 0.6, 0.0])


def test_each_joint_steps_in_turn_and_stays():
    reference = lwr_dyn.reference("step", ARM, start=START, size=0.01, duration=0.2)
    assert reference.duration == pytest.approx(BEFORE + 7 * 0.2)
    begins = BEFORE + 0.2 * np.arange(7)
    motion = reference.sample(np.concatenate([begins - 1e-6, begins + 1e-12, [99.0]]))
    earlier = np.tri(7, k=-1)
    stepped = np.vstack([earlier, earlier + np.eye(7), np.ones(7)])
    np.testing.assert_allclose(motion.q, START + 0.01 * stepped, atol=1e-15)
    assert not np.any([motion.dq, motion.ddq])


def test_rates_are_exact_derivatives():
    reference = lwr_dyn.reference("chirp", ARM, start=START, joint=1, low=1.0, high=10.0, duration=4.0, rates=True)
    t = np.linspace(0.213, 3.787, 400)
    check_derivatives(reference.sample, t, 1e-3, ("q", "dq", "ddq"), atol=1e-9)
    assert np.abs(reference.sample(t).ddq).max() > 1.0


@pytest.mark.parametrize("rates", [False, True])
def test_a_chirp_is_its_formula_with_a_cosine_at_both_ends(rates):
    """size w sin(2 pi low (exp(g t) - 1) / g), g = ln(high / low) / T; w rises and falls in a twentieth of T."""
    low, high, T, size = 1.5, 12.0, 3.0, -0.02
    reference = lwr_dyn.reference("chirp", ARM, start=START, size=size, low=low, high=high, duration=T, rates=rates)
    assert reference.duration == 7 * (T + REST) == 28.0
    g = np.log(high / low) / T
    for joint in (0, 3):
        t = np.array([-0.1, 0.0, 0.03, 0.149, 0.151, 1.0, 1.5, 2.849, 2.97, 3.0, 3.5])
        w = np.select(
            [t < 0.15, t > 2.85], [(1 - np.cos(np.pi * t / 0.15)) / 2, (1 - np.cos(np.pi * (T - t) / 0.15)) / 2], 1.0
        )
        x = np.where((t > 0.0) & (t < T), size * w * np.sin(2 * np.pi * low * (np.exp(g * t) - 1) / g), 0.0)
        motion = reference.sample(t + joint * 4.0)
        np.testing.assert_allclose(motion.q[:, joint] - START[joint], x, atol=1e-14)
        assert not (np.delete(motion.q, joint, axis=1) - np.delete(START, joint)).any()
        assert motion.dq.any() == motion.ddq.any() == rates
    assert reference.about == {
        "task": "chirp", "joints": [1, 2, 3, 4, 5, 6, 7], "size": size, "low": low, "high": high, "sweep": T,
        "rest": 1.0, "rates": rates,
    }  # fmt: skip


def test_what_is_asked_where_nothing_is_given():
    step, chirp = (lwr_dyn.reference(task, ARM, start=START, joint=2) for task in ("step", "chirp"))
    assert (step.joints, step.window, step.duration) == ((1,), 0.5, 0.55)
    assert step.size == pytest.approx(np.pi / 360, rel=1e-15)
    assert step.about == {"task": "step", "joints": [2], "size": step.size, "window": 0.5, "begin": 0.05}
    assert (chirp.low, chirp.high, chirp.sweep, chirp.rates) == (0.5, 50.0, 6.0, False)
    assert chirp.size == pytest.approx(np.pi / 900, rel=1e-15)
    assert (step.name, chirp.name) == ("StepReference", "ChirpReference")
    room = float(ARM.upper[1] - START[1])
    for task in ("step", "chirp"):  # up to the limit, and no further
        assert lwr_dyn.reference(task, ARM, start=START, joint=2, size=room * (1 - 1e-12)).size < room
        with pytest.raises(PathLimitError, match="joint_2"):
            lwr_dyn.reference(task, ARM, start=START, joint=2, size=room * (1 + 1e-9))
    with pytest.raises(PathLimitError):
        lwr_dyn.reference("chirp", ARM, start=START, joint=2, size=START[1] - ARM.lower[1] + 1e-9)
    assert lwr_dyn.reference("chirp", ARM, start=START, low=1.0, duration=3.0).sweep == 3.0


BAD = [
    ("step", {"joint": 8}, OptionError, "joint: 8; allowed: 1 to 7"),
    ("step", {"joint": 0}, OptionError, "joint: 0"),
    ("step", {"size": 0.0}, OptionError, "size"),
    ("step", {"joint": 1.0}, OptionError, "joint: 1.0; allowed: 1 to 7"),
    ("chirp", {"low": 0.0}, OptionError, "low: 0.0"),
    ("chirp", {"low": 5.0, "high": 4.9}, OptionError, "low, high: 5 to 4.9 Hz"),
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
