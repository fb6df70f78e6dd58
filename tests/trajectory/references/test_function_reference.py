"""A function q(t) as a reference: sampled, followed, compared; what it may not do is one line."""

import math

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, PathLimitError, ShapeError
from lwr_dyn.trajectory.references.function_reference import FunctionReference
from tests.optional import need

W = np.arange(1.0, 8.0)


def wave(t):
    return 0.1 * np.sin(W * t)


def wave_rate(t):
    return 0.1 * W * np.cos(W * t)


def wave_second(t):
    return -0.1 * W * W * np.sin(W * t)


def by_parts(t):
    return [0.1 * math.sin(w * t) for w in W]


def of_times(function, times):
    return np.array([function(t) for t in times])


def step(t):
    return np.full(7, 0.1 if t > 0.4 else 0.0)


def ramp(t):
    return np.full(7, abs(t - 0.5))


@pytest.mark.parametrize("given", [{}, {"dq": wave_rate}, {"dq": wave_rate, "ddq": wave_second}])
def test_derivatives_are_those_of_the_function(arm, given):
    move, times = lwr_dyn.reference(wave, arm, duration=1.5, **given), np.linspace(0.0, 1.5, 200)
    motion = move.sample(times)
    assert isinstance(move, FunctionReference)
    assert move.duration == 1.5
    assert np.array_equal(motion.q, of_times(wave, times))
    assert np.abs(motion.dq - of_times(wave_rate, times)).max() < 1e-14
    assert np.abs(motion.ddq - of_times(wave_second, times)).max() < 1e-10
    ways = move.about["derivatives"]
    by = {0: ("complex step", "difference of the complex step"), 1: ("given", "complex step"), 2: ("given", "given")}
    assert (ways["dq"]["by"], ways["ddq"]["by"]) == by[len(given)]
    assert [way["error"] for way in ways.values() if way["by"] == "given"] == [0.0] * len(given)


def test_real_functions_state_their_error(arm):
    move, times = lwr_dyn.reference(by_parts, arm, duration=1.5), np.linspace(0.0, 1.5, 200)
    ways = move.about["derivatives"]
    assert ways["dq"]["by"] == ways["ddq"]["by"] == "differences"
    assert 0.0 < ways["dq"]["error"] < 1e-9
    off = float(np.abs(move.sample(times).ddq - of_times(wave_second, times)).max())
    assert off < min(1e-6 * 4.9, 3.0 * ways["ddq"]["error"])


def test_before_and_after_it_stands_still(arm):
    motion = lwr_dyn.reference(wave, arm, duration=1.0).sample(np.array([-1.0, 0.0, 1.0, 1.0 + 1e-13, 2.0]))
    assert np.array_equal(motion.q[[0, 4]], [wave(0.0), wave(1.0)])
    assert not np.any([motion.dq[[0, 4]], motion.ddq[[0, 4]]])
    assert motion.dq[:, 0] == pytest.approx([0.0, 0.1, 0.1 * math.cos(1.0), 0.1 * math.cos(1.0), 0.0], abs=1e-12)


def test_it_is_followed_compared_and_kept(arm, tmp_path):
    class Wave:
        """A motion of one's own."""

        duration = 0.3

        def sample(self, t):
            return lwr_dyn.Motion(t, *(of_times(f, t) for f in (wave, wave_rate, wave_second)))

    reference = lwr_dyn.reference(wave, arm, duration=0.3)
    names = ("pid", "inverse-dynamics")
    runs = [lwr_dyn.simulate(arm, lwr_dyn.controller(name, arm), reference) for name in names]
    own = lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), Wave())
    assert np.abs(runs[1].q - own.q).max() < 1e-12
    assert np.abs(runs[1].q - of_times(wave, runs[1].t)).max() < 1e-4
    assert all(run.audit["closed"] for run in runs)
    assert len(lwr_dyn.compare(*runs).runs) == 2
    runs[0].save(tmp_path / "wave.npz")
    record = lwr_dyn.Run.load(tmp_path / "wave.npz").meta["reference"]
    assert (record["name"], record["duration"], record["about"]["function"]) == ("FunctionReference", 0.3, "wave")


BAD = {
    "no duration": (wave, {}, OptionError, "duration: not given"),
    "negative": (wave, {"duration": -1}, OptionError, "duration: -1; allowed: 0.001 to 100000 s"),
    "text": (wave, {"duration": "long"}, ShapeError, "duration: not an array of numbers"),
    "unknown option": (wave, {"duration": 1, "rate": 3}, OptionError, "allowed: duration, dq, ddq, limits"),
    "shape": (lambda t: wave(t)[:6], {"duration": 1}, ShapeError, "at t = 0 s: 6 numbers; allowed: 7 numbers"),
    "nan": (lambda t: [math.nan if t > 0.5 else 0.0] * 7, {"duration": 1}, ShapeError, "t = 0.5025 s: nan at"),
    "fails": (lambda t: 1 / 0, {"duration": 1}, OptionError, "ZeroDivisionError at t = 0 s"),
    "jump": (step, {"duration": 1}, OptionError, "position of joint_1 jumps by 0.1 rad at t = 0.4 s"),
    "jump, small": (
        lambda t: wave(t) + 2e-8 * (t > 0.4),
        {"duration": 1},
        OptionError,
        "jumps by 2.04e-08 rad at t = 0.4",
    ),
    "jump, all given": (step, {"duration": 1, "dq": wave, "ddq": wave}, OptionError, "jumps by 0.1 rad at t = 0.4 s"),
    "kink": (ramp, {"duration": 1}, OptionError, "speed of joint_1 jumps by 2 rad/s at t = 0.5 s"),
    "kink, dq given": (
        ramp,
        {"duration": 1, "dq": lambda t: np.sign(t - 0.5) * W**0},
        OptionError,
        "jumps by 2 rad/s at",
    ),
    "limit": (lambda t: 3 * t * W**0, {"duration": 1}, PathLimitError, "at t = 1 s, reference q(t): joint_2 at 3 rad"),
    "speed": (lambda t: wave(9 * t), {"duration": 1}, PathLimitError, "6.3 rad/s, 1.96 times its speed limit"),
    "dq": (wave, {"duration": 1, "dq": lambda t: 2 * wave_rate(t)}, OptionError, "dq(t) of joint_1: 0.2 at t = 0 s"),
    "ddq": (wave, {"duration": 1, "ddq": wave}, OptionError, "reference ddq(t) of joint_1"),
    "no function": (wave, {"duration": 1, "dq": 3}, OptionError, "reference dq: 3; allowed: a function of the time"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_it_may_not_do_is_one_line(arm, case):
    function, options, kind, words = BAD[case]
    with pytest.raises(kind) as fault:
        lwr_dyn.reference(function, arm, **options)
    assert words in str(fault.value)
    assert "\n" not in str(fault.value)


def test_kinks_are_allowed_where_derivatives_are_given_and_limits_can_be_left(arm):
    move = lwr_dyn.reference(
        ramp, arm, duration=1.0, dq=lambda t: np.full(7, np.sign(t - 0.5)), ddq=lambda t: np.zeros(7)
    )
    assert move.sample(np.array([0.25, 0.75])).dq[:, 3].tolist() == [-1.0, 1.0]
    lwr_dyn.reference(  # a jump that is as small beside the duration as rounding may be
        lambda t: wave(t) + 2e-8 * (t > 0.4), arm, duration=3.0, dq=wave_rate, ddq=wave_second
    )
    fast = lwr_dyn.reference(lambda t: wave(9 * t), arm, duration=1.0, limits=False)
    assert fast.sample(np.array([0.0])).dq[0, 6] == pytest.approx(6.3)


def test_a_plain_function_names_the_road(arm):
    with pytest.raises(OptionError, match=r"the function wave; allowed: lwr_dyn.reference\(function, arm, duration"):
        lwr_dyn.simulate(arm, lwr_dyn.controller("pid", arm), wave)
    need("llvmlite")
    with pytest.raises(OptionError, match=r"the function wave; allowed: lwr_dyn.reference"):
        lwr_dyn.rollouts(arm, "pid", [wave], runs=2)


@pytest.mark.slow
def test_rollouts_follow_it_as_simulate_does(arm):
    need("llvmlite")
    reference = lwr_dyn.reference(wave, arm, duration=0.05)
    rolls = lwr_dyn.rollouts(arm, "inverse-dynamics", reference, runs=1, record=1)
    run = lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), reference, friction="none")
    assert np.abs(rolls.q[0] - run.q).max() < 1e-10
