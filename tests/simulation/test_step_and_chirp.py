"""Figures of a step against those of the second-order loop."""

import numpy as np
import pytest
from scipy.signal import lfilter

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.step_and_chirp import (
    _crossing,
    _first,
    frequency_responses,
    response_parts,
    responses_of,
    step_responses,
)
from tests.simulation.answers import ARM, OMEGA, START, answered


def theory(xi):
    """Rise 10 to 90 %, peak, overshoot, settling within 2 % of a step of w^2 / (s^2 + 2 xi w s + w^2), xi < 1."""
    t = np.linspace(0.0, 1.0, 2_000_001)
    damped = OMEGA * np.sqrt(1.0 - xi**2)
    y = 1.0 - np.exp(-xi * OMEGA * t) * (np.cos(damped * t) + xi * OMEGA / damped * np.sin(damped * t))
    rise = t[np.argmax(y >= 0.9)] - t[np.argmax(y >= 0.1)]
    settling = t[np.flatnonzero(np.abs(y - 1.0) > 0.02)[-1]]
    return rise, np.pi / damped, np.exp(-np.pi * xi / np.sqrt(1.0 - xi**2)), settling


@pytest.mark.slow
@pytest.mark.parametrize(("xi", "joint"), [(0.3, 2), (0.7, 6)])
def test_figures_are_those_of_theory(xi, joint):
    (found,) = step_responses(answered("step", xi, joint, rate=2000.0), ARM)
    rise, peak, overshoot, settling = theory(xi)
    assert found.joint == joint
    assert found.rise == pytest.approx(rise, abs=5e-6)  # a line between samples
    assert found.peak == pytest.approx(peak, abs=5.1e-4)
    assert found.overshoot == pytest.approx(overshoot, abs=2e-4)
    # the last stage of RK4 before the step sees it already: the loop is a sixth of 0.5 ms ahead
    assert found.settling == pytest.approx(settling - 0.5e-3 / 6.0, abs=5e-6)
    assert abs(found.left) < 2e-3
    assert found.cut == 0.0


def answer_of(t, asked, q, about, beyond=0):
    """A run of joint 2 as it stands, its torques `beyond` their limits in so many samples."""
    tables = {name: np.zeros((t.size, 7)) for name in ("q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied")}
    tables["q"][:, 1], tables["q_ref"][:, 1] = q, asked
    tables["tau_command"][:beyond, 3] = 1.001 * ARM.effort[3]
    meta = {"reference": {"about": {"joints": [2], **about}}}
    return Run(t, *tables.values(), np.zeros((t.size, 7)), np.zeros(t.size), {}, (), meta)


@pytest.mark.parametrize("size", [0.02, -0.5])
def test_figures_are_those_of_a_written_answer(size):
    """Of 1 - exp(-xi w t) (...), xi = 0.3, a step at 50 ms that lasts 0.5 s, and 37 ms of cut torque before."""
    t, begin = np.arange(0.0, 0.7, 1e-3), 0.05
    s, damped = np.maximum(t - begin, 0.0), OMEGA * np.sqrt(1 - 0.3**2)
    y = 1.0 - np.exp(-0.3 * OMEGA * s) * (np.cos(damped * s) + 0.3 * OMEGA / damped * np.sin(damped * s))
    about = {"task": "step", "size": size, "begin": begin, "window": 0.5}
    run = answer_of(t, 0.1 + size * (t >= begin - 1e-9), 0.1 + size * y, about, beyond=87)
    (found,) = step_responses(run, ARM)
    rise, peak, overshoot, settling = theory(0.3)
    assert (found.joint, found.size, found.t.size) == (2, size, 500)
    assert found.rise == pytest.approx(rise, abs=2e-5)
    assert found.peak == pytest.approx(peak, abs=5.1e-4)
    assert found.overshoot == pytest.approx(overshoot, abs=2e-4)
    assert found.settling == pytest.approx(settling, abs=2e-5)
    assert found.left == pytest.approx(np.mean(1.0 - found.y[found.t >= found.t[-1] - 0.05]), abs=1e-12)
    assert found.y == pytest.approx(y[50:550], abs=1e-12)
    assert found.cut == pytest.approx(0.037)
    record = found.to_json()
    assert (record["joint"], record["rise"], record["cut"]) == (2, found.rise, found.cut)
    fact, table, note = response_parts(run, ARM)
    assert (fact.key, fact.value) == ("responses", [record])
    assert table.rows[0] == (2, 1e3 * found.rise, found.overshoot, 1e3 * found.settling, found.left)
    cells = (
        f"{1e3 * found.rise:.4g}  {100 * found.overshoot:.2f} %  {1e3 * found.settling:.4g}  {100 * found.left:.2f} %"
    )
    assert table.text().splitlines()[-1].split() == ["2", *cells.split()]
    short = answer_of(t[:60], 0.1 + size * (t[:60] >= begin - 1e-9), 0.1 + size * y[:60], about)
    assert response_parts(short, ARM)[1].text().splitlines()[-1].count("not reached") == 2
    assert note.text == (
        "torque was cut while joint 2 (0.037 s) answered: not the response of a linear loop; try a smaller size"
    )
    assert step_responses(answer_of(t[:30], t[:30], t[:30], about), ARM) == ()


def test_the_response_is_that_of_a_written_filter():
    """Of (1 - a) / (1 - a z^-1) on a chirp: exact at every line, with its bandwidth and its phase there."""
    low, high, sweep, h = 1.0, 40.0, 3.0, 1e-3
    t = np.arange(0.0, 4.0 + 0.5 * h, h)
    reference = lwr_dyn.reference("chirp", ARM, start=START, joint=2, low=low, high=high, duration=sweep)
    asked = reference.sample(t).q[:, 1]
    a = np.exp(-2 * np.pi * 8.0 * h)
    q = START[1] + lfilter([1 - a], [1, -a], asked - START[1])
    about = {"task": "chirp", "low": low, "high": high, "sweep": sweep, "rest": 1.0}
    run = answer_of(t, asked, q, about, beyond=12)
    (found,) = frequency_responses(run, ARM)

    def theory_at(f):
        return (1 - a) / (1 - a * np.exp(-2j * np.pi * f * h))

    assert np.abs(found.H / theory_at(found.f) - 1.0).max() < 1e-3
    assert not found.f.flags.writeable
    assert not found.coherence.flags.writeable
    growth = (high / low) ** 0.05
    assert low * growth <= found.f[0] < low * growth * 2 ** (1 / 24 + 0.35)
    assert high / growth * 2 ** (-1 / 12) < found.f[-1] <= high / growth
    octaves = np.log2(found.f[-1] / found.f[0])
    assert found.f.size <= 24 * octaves + 2
    lines = np.arange(1, 400) / 4.0
    lines = lines[(lines >= low * growth) & (lines <= high / growth)]
    assert found.f.size == np.unique(np.round(24 * np.log2(lines))).size
    assert abs(theory_at(found.bandwidth)) == pytest.approx(np.sqrt(0.5), rel=1e-3)
    assert found.phase == pytest.approx(np.angle(theory_at(found.bandwidth)), abs=5e-3)
    assert (found.peak, found.peak_at) == (np.abs(found.H).max(), found.f[0])
    assert found.cut == pytest.approx(0.012)
    assert found.least_coherence == found.coherence[found.f <= found.bandwidth].min() > 0.999
    assert responses_of(run, ARM)[0].bandwidth == found.bandwidth
    assert frequency_responses(answer_of(t[:-2], asked[:-2], q[:-2], about), ARM) == ()
    _, table, _ = response_parts(run, ARM)
    assert table.rows[0][:3] == (2, found.bandwidth, np.degrees(found.phase))


def test_without_overshoot_and_where_the_window_is_too_short_for_numbers():
    """xi = 1: y = 1 - (1 + w t) exp(-w t)."""
    (found,) = step_responses(answered("step", 1.0, 1), ARM)
    assert found.overshoot < 1e-6
    t = np.linspace(0.0, 0.3, 300_001)
    y = 1.0 - (1.0 + OMEGA * t) * np.exp(-OMEGA * t)
    assert found.rise == pytest.approx(t[np.argmax(y >= 0.9)] - t[np.argmax(y >= 0.1)], abs=5e-5)
    (short,) = step_responses(answered("step", 0.3, 1, duration=0.02), ARM)
    assert np.isnan([short.rise, short.settling]).all()
    assert short.to_json()["settling"] is None
    (later,) = step_responses(answered("step", 0.3, 1, duration=0.1), ARM)
    assert np.isnan(later.settling)
    assert later.rise > 0.0


def test_torques_that_were_cut_are_told_and_an_answer_may_begin_above_its_mark():
    run = answered("step", 1.0, 2, continuous=False, size=0.2)
    (found,) = step_responses(run, ARM)
    assert 0.0 < found.cut < 0.1
    assert "torque was cut while joint 2" in response_parts(run, ARM)[-1].text
    t, y = np.array([1.0, 2.0, 4.0]), np.array([-1.0, -0.5, 1.5])
    assert (_first(t, y), _first(t, y, 2), _first(t, -y)) == (2.5, 2.5, 1.0)
    assert np.isnan(_first(t, y - 9.0))


def test_each_joint_has_its_answer_and_sweeps_that_did_not_end_are_left_out():
    loop = lwr_dyn.controller("pd-gravity", ARM)
    run = lwr_dyn.simulate(ARM, loop, lwr_dyn.reference("step", ARM, start=START, duration=0.3))
    found = step_responses(run, ARM)
    assert [one.joint for one in found] == [1, 2, 3, 4, 5, 6, 7]
    assert all(0.06 < one.rise < 0.09 for one in found)
    loop, reference = lwr_dyn.controller("inverse-dynamics", ARM), lwr_dyn.reference("chirp", ARM, start=START, **SWEEP)
    run = lwr_dyn.simulate(ARM, loop, reference, duration=8.5, rate=500.0)
    assert [one.joint for one in frequency_responses(run, ARM)] == [1, 2]


@pytest.mark.parametrize(
    ("sizes", "at"),
    [([1.0, 1.0, 0.25], 2.0 * 2.0 ** (0.5 / 2.0)), ([1.0, 0.25, 0.1], 2.0 ** (0.5 / 2.0)), ([0.5, 0.4, 0.3], np.nan),
     ([0.5, 1.0, 0.3], np.nan), ([1.0, 0.9, 0.8], np.nan)],
)  # fmt: skip
def test_the_bandwidth_is_where_the_line_in_logarithms_first_meets_half_of_the_power(sizes, at):
    assert _crossing(np.array([1.0, 2.0, 4.0]), np.array(sizes)) == pytest.approx(at, rel=1e-12, nan_ok=True)


@pytest.mark.parametrize(("of", "task"), [(step_responses, "step"), (frequency_responses, "chirp")])
def test_a_run_of_another_task_is_refused(two_runs, of, task):
    with pytest.raises(OptionError, match=f"a run of the task '{task}'"):
        of(two_runs[0])


SWEEP = {"low": 1.0, "high": 40.0, "duration": 3.0}


@pytest.mark.slow
@pytest.mark.parametrize(("xi", "joint"), [(0.5, 2), (1.0, 7)])
def test_the_response_is_that_of_theory(xi, joint):
    (found,) = frequency_responses(answered("chirp", xi, joint, **SWEEP), ARM)
    s = 2j * np.pi * found.f
    H = OMEGA**2 / (s**2 + 2.0 * xi * OMEGA * s + OMEGA**2)
    assert np.abs(found.H / H - 1.0).max() < 3e-3
    bandwidth = OMEGA / (2.0 * np.pi) * np.sqrt(1 - 2 * xi**2 + np.sqrt((1 - 2 * xi**2) ** 2 + 1))
    assert found.bandwidth == pytest.approx(bandwidth, rel=2e-3)
    assert found.joint == joint
    assert found.least_coherence > 0.999
    if xi < 0.7:
        assert found.peak == pytest.approx(1.0 / (2.0 * xi * np.sqrt(1.0 - xi**2)), rel=2e-3)
        assert found.peak_at == pytest.approx(OMEGA / (2.0 * np.pi) * np.sqrt(1.0 - 2.0 * xi**2), rel=0.04)


@pytest.mark.slow
def test_feed_forward_of_the_rates_leaves_nothing_to_follow_and_noise_lowers_the_coherence():
    (found,) = frequency_responses(answered("chirp", 1.0, 7, rates=True, rate=1000.0, **SWEEP | {"high": 10.0}), ARM)
    assert np.abs(found.H - 1.0).max() < 3e-4  # of order 1 in the step: the taper ends with a jump of ddq
    assert np.isnan(found.bandwidth)
    assert found.to_json()["bandwidth"] is None
    loop = lwr_dyn.controller("inverse-dynamics", ARM)
    reference = lwr_dyn.reference("chirp", ARM, start=START, joint=4, **SWEEP)
    (found,) = frequency_responses(lwr_dyn.simulate(ARM, loop, reference, encoder=Encoder(0.0, 3e-4, 100.0)), ARM)
    assert found.coherence[-1] < 0.999
    assert found.bandwidth == pytest.approx(5.2, rel=0.1)
