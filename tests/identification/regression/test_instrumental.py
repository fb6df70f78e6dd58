"""Instrumental variables on logs without a filter, by a known or a commanded motion, beside least squares."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal.windows import hann

import lwr_dyn
from lwr_dyn.foundation.errors import LogError, OptionError, ShapeError
from lwr_dyn.identification.logs.joint_log import JointLog, read_log, write_log
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.instrumental import (
    HANN_BAND,
    UNFILTERED,
    commanded_motion,
    instrumental,
    instrumental_information,
    smooth_step,
    window_sums,
)
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.run import Motion
from tests.identification.bags import write_bag
from tests.identification.plants import inside, perturbed_plant, random_motion, simulated_log

ARM = lwr_dyn.load("lwr4plus", "physical")
ENCODER, NOISE = 1e-5, 0.1


@pytest.fixture(scope="module")
def plant():
    return perturbed_plant(TorqueColumns(ARM.chain, "directions"), ARM, np.random.default_rng(1), 0.2)


@pytest.fixture(scope="module")
def motion():
    return random_motion(ARM, 10.0, np.random.default_rng(2), rate=1000.0)


@pytest.fixture(scope="module")
def command(motion):
    """What `excite` writes: times and positions at 100 Hz."""
    q = motion.q[::10]
    return JointLog("e.csv", tuple(range(1, 8)), motion.t[::10], q, np.full(q.shape, np.nan))


@pytest.fixture(scope="module")
def log(plant, motion):
    return simulated_log(plant, motion, NOISE, np.random.default_rng(3), ENCODER, source="log.csv")


def at(samples, motion):
    """The motion at the instants of samples."""
    rows = np.searchsorted(motion.t, samples.t - 1e-6)
    return Motion(samples.t, motion.q[rows], motion.dq[rows], motion.ddq[rows])


def found_in(plant, motion, log):
    samples = samples_of([log], UNFILTERED)
    return instrumental(samples, plant.columns, at(samples, motion))


def misses(found, plant):
    return (found.values - plant.base) / found.sigma


@pytest.mark.slow
def test_unfiltered_logs_are_cured(plant, motion):
    """Recovery figure: 8 logs with 1e-5 rad at 1 kHz; least squares on the same rows covers under half."""
    tau = plant.torque(motion)
    logs = [simulated_log(plant, motion, NOISE, np.random.default_rng(seed), ENCODER, tau=tau) for seed in range(8)]
    draws = [found_in(plant, motion, log) for log in logs]
    z = np.array([misses(found, plant) for found in draws])
    assert inside(z) > 0.98
    assert 0.7 < np.mean(z**2) < 1.5
    assert np.sqrt(np.mean(z.mean(axis=0) ** 2)) < 0.55  # 8 draws of no bias give 0.35
    assert draws[0].noise == pytest.approx(NOISE, rel=0.3)
    assert inside(misses(information_of(samples_of(logs[:1], SampleRule(cutoff=None)), plant.columns), plant)) < 0.6


def test_all_rows_are_more_precise_than_the_filter_on_every_tenth(plant, motion, log):
    filtered = information_of(samples_of([log]), plant.columns)
    assert np.median(found_in(plant, motion, log).sigma / filtered.sigma) < 0.5


def test_without_noise_the_truth_comes_back(plant, motion):
    found = found_in(plant, motion, simulated_log(plant, motion, 0.0, np.random.default_rng(0)))
    assert found.values == pytest.approx(plant.base, abs=1e-6)


def test_a_reference_that_the_arm_follows_badly_still_works(plant, motion, log):
    """Instruments need not be the motion itself: one that lags by 20 ms and is 5 per cent large has no bias."""
    late = [1.05 * np.concatenate([x[:1].repeat(20, axis=0), x[:-20]]) for x in (motion.q, motion.dq, motion.ddq)]
    assert inside(misses(found_in(plant, Motion(motion.t, *late), log), plant)) > 0.97


def test_values_and_covariance_are_those_of_the_equations_written_out(plant):
    """Z^T W b = Z^T tau with the noise that is said, its covariance the sandwich of the scores' slow sums."""
    rng, columns = np.random.default_rng(5), plant.columns
    motion = random_motion(ARM, 4.0, rng, rate=500.0)
    samples = samples_of([simulated_log(plant, motion, NOISE, rng, ENCODER)], UNFILTERED)
    true = at(samples, motion)
    found = instrumental(samples, columns, true, slowest=0.2, window=0.2)
    W, Z = (columns(x.q, x.dq, x.ddq)[:, :, found.base.kept] for x in (samples, true))
    w = smooth_step(np.abs(true.dq) / 0.2 - 1.0) * samples.used
    noise, Z = np.ones(7), Z * w[:, :, None]
    for _ in range(3):
        weighted = Z / noise[:, None] ** 2
        across = np.einsum("kgp,kgq->pq", weighted, W, optimize=True)
        values = np.linalg.solve(across, np.einsum("kgp,kg->p", weighted, samples.tau))
        left = samples.tau - W @ values
        sums, said = window_sums(left * w, samples.recording, 100), noise
        noise = np.sqrt((sums**2).sum(axis=0) / (w**2).sum(axis=0))
    assert found.noise == pytest.approx(said, rel=1e-6)
    assert (np.abs(found.values - values) < 1e-6 * found.sigma).all()
    slow = window_sums(np.einsum("kgp,kg->kp", weighted, left), samples.recording, 100)
    free, root = HANN_BAND * np.count_nonzero(w) / 100, np.linalg.solve(across, slow.T)
    sigma = np.sqrt((root**2).sum(axis=1) * free / (free - len(values)))
    assert found.sigma == pytest.approx(sigma, rel=1e-6)
    assert found.equations == np.count_nonzero(w)


def test_slow_sums_are_those_under_windows_inside_recordings():
    """By hand; white noise shows its variance, second differences of it next to none."""
    rng, length = np.random.default_rng(0), 20
    series, recording = rng.normal(size=(93, 2)), np.repeat([0, 1, 2], [50, 36, 7])
    wanted = []
    for one, size in ((series[:50], length), (series[50:86], length), (series[86:], 7)):
        shape, starts = hann(size + 2)[1:-1], range(0, len(one) - size + 1, max(1, size // 4))
        sums = np.array([shape @ one[k : k + size] for k in starts])
        wanted.append(sums * np.sqrt(len(one) / len(starts) / np.sum(shape**2)))
    assert window_sums(series, recording, length) == pytest.approx(np.concatenate(wanted), abs=1e-12)
    noise, one = rng.normal(size=(20_000, 2)), np.zeros(20_000, dtype=int)
    v = window_sums(noise, one, 100)
    assert v.T @ v / len(noise) == pytest.approx(np.eye(2), abs=0.2)
    second = np.diff(noise, n=2, axis=0)
    assert (window_sums(second, one[2:], 100) ** 2).sum() < 1e-3 * (second**2).sum()


def test_the_weight_rises_smoothly():
    assert smooth_step(np.array([-1.0, 0.0, 0.25, 0.5, 0.75, 1.0, 2.0])).tolist() == [
        0.0, 0.0, 0.103515625, 0.5, 0.896484375, 1.0, 1.0,
    ]  # fmt: skip
    assert np.abs(np.diff(smooth_step(np.linspace(-1, 2, 3001)), n=2)).max() / 1e-6 < 6.0


def cut(motion):
    return Motion(motion.t, motion.q, motion.dq[1:], motion.ddq)


def stopped(motion):
    return Motion(motion.t, motion.q, motion.dq * 0.0, motion.ddq)


@pytest.mark.parametrize(
    ("change", "options", "error", "words"),
    [
        (Motion, {"window": 0.0}, OptionError, "instrumental window: 0.0; allowed: a number above 0"),
        (Motion, {"slowest": np.inf}, OptionError, "instrumental slowest: inf; allowed: a number above 0"),
        (cut, {}, ShapeError, "dq of the motion"),
        (
            stopped,
            {},
            LogError,
            "log.csv: columns q1..: the motion does not determine all parameters; needed: a motion",
        ),
    ],
)
def test_bad_input(change, options, error, words, plant, motion, log):
    samples = samples_of([log], UNFILTERED)
    known = at(samples, motion)
    changed = known if change is Motion else change(known)
    with pytest.raises(error, match=words):
        instrumental(samples, plant.columns, changed, **options)


def test_a_command_at_100_hz_is_enough(plant, motion, log, command):
    """Recovery: bodies near the table come out of it too."""
    result = identify_motion([log], ARM, instruments=[command])
    z = misses(result.information, plant)
    assert inside(z) > 0.97
    assert 0.5 < np.mean(z**2) < 2.0
    assert result.consistent.physical.all()
    assert (result.validation, result.whiteness) == ((), ())
    fast = np.abs(motion.dq[3:-3]) > 0.05
    assert result.information.equations == pytest.approx(fast.sum(axis=0), abs=20)
    assert result.information.chi2 == result.information.dof
    unseen = random_motion(ARM, 10.0, np.random.default_rng(9), rate=1000.0)
    judged = result.validated_on([simulated_log(plant, unseen, NOISE, np.random.default_rng(4), ENCODER)])
    assert all(v.held_out < 1.3 * NOISE < v.model for v in judged[:4])


def test_the_spline_is_the_motion_that_was_commanded_and_covers_half_a_step_more(command, motion):
    inner = slice(100, -100)
    found = commanded_motion(command, motion.t)
    for name, bound in (("q", 1e-8), ("dq", 1e-6), ("ddq", 1e-3)):
        assert getattr(found, name)[inner] == pytest.approx(getattr(motion, name)[inner], abs=bound)
    for t in ([-0.004, 5.0], [5.0, 10.004]):
        commanded_motion(command, np.array(t))
    for t, said in (([-0.006, 5.0], "-0.006 to 5"), ([5.0, 10.006], "5 to 10.006")):
        words = rf"e\.csv: column time: 0 to 10 s; needed: all times of the log, {said} s"
        with pytest.raises(LogError, match=words):
            commanded_motion(command, np.array(t))


def test_each_log_has_its_command_as_long_as_it_is(log, command):
    with pytest.raises(OptionError, match="instruments: 1 for 2 logs; allowed: one for each log, in their order"):
        instrumental_information([log, log], [command], TorqueColumns(ARM.chain), 0.05)
    short = replace(command, t=command.t[:500], q=command.q[:500], tau=command.tau[:500])
    with pytest.raises(LogError, match=r"e\.csv.*0 to 4\.99 s.*all times of the log"):
        identify_motion([log], ARM, instruments=[short])


@pytest.fixture
def identify(tmp_path, log, command, lwr_dyn_command):
    write_log(tmp_path / "log.csv", log)
    write_log(tmp_path / "e.csv", replace(command, tau=np.zeros(command.q.shape)))
    line = ("identify", "motion", "lwr4plus", str(tmp_path / "log.csv"), "--reading", "physical")
    return lambda *more: lwr_dyn_command(*line, *(x.format(e=tmp_path / "e.csv") for x in more))


@pytest.mark.slow
def test_on_the_command_line(identify):
    code, out, _ = identify("--instruments", "{e}", "--json")
    found = json.loads(out)
    assert (code, found["validation"], found["whiteness"]) == (0, [], [])
    assert found["identified"] > 55  # least squares with the filter on this log: 51
    code, out, _ = identify("--instruments", "{e}")
    heads = [text.split(":")[0] for text in out.splitlines()]
    assert (code, heads.count("instrumental variables on unfiltered rows")) == (0, 1)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--instruments", "{e}", "--stribeck"), "without --instruments"),
        (("--instruments", "{e}", "--instruments", "{e}"), "2 for 1 logs"),
        (("--instruments", "nothing.csv"), "nothing.csv"),
    ],
)
def test_bad_options_are_one_line(identify, more, message):
    code, _, err = identify(*more)
    assert (code, message in err, err.count("\n") - err.count("warning:")) == (2, True, 1)


def test_parameters_from_a_ros_bag(plant, log, tmp_path):
    """Recovery figure: joint states at 250 Hz in a bag of a ROS 2 robot, with the filter."""
    every = slice(None, None, 4)
    mixed = [6, 2, 0, 1, 3, 5, 4]  # drivers publish joints in any order
    fields = {"position": log.q[every][:, mixed], "effort": log.tau[every][:, mixed]}
    names = [ARM.joint_names[j] for j in mixed]
    bag = write_bag(tmp_path / "bag", [("/joint_states", names, log.t[every], fields)])
    result = identify_motion([read_log(bag, arm=ARM)], ARM)
    assert inside(misses(result.information, plant)) > 0.97
    assert result.identified > 40
