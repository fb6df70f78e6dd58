"""Gain and delay margins of one loop: known by hand, met by the simulated arm."""

import sys

import numpy as np
import pytest

from lwr_dyn.design.loop_margins import delay_margin, frequency_grid, loop_gain, margins_at, sensitivity, state_spaces
from lwr_dyn.design.margins import margins
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, Sampling
from lwr_dyn.foundation.errors import DivergenceError, MissingPackageError, OptionError
from lwr_dyn.simulation.simulate import simulate
from tests.design.margin_cases import BENT, arm, dynamics, law, sliders
from tests.simulation.sample_runs import Still

AT = Sampling(1000.0, 1)


@pytest.fixture(scope="module")
def bent():
    return margins_at(RestingLoop.of(dynamics(), law("pd-gravity"), BENT[None]), AT, BENT)


def test_the_margins_of_sliders_are_those_by_hand():
    """Sliders known by hand: v+ = (1 - a) v with a = T Kd / m, held for a sample."""
    loop, free = sliders(2.0, 5.0, Kd=[500.0, 2500.0]), Sampling(1000.0)  # a = 0.25, 0.5
    found = margins_at(loop, free, np.zeros(2))
    np.testing.assert_allclose(found.gain_up, [8.0, 4.0], rtol=2e-4)
    np.testing.assert_allclose(found.gain_down, 0.0, atol=1e-9)
    assert found.all_up == pytest.approx(4.0, rel=2e-4)
    np.testing.assert_allclose(np.sort(found.poles.real), [0.5, 0.75, 1.0, 1.0], atol=1e-7)
    np.testing.assert_allclose(found.peak, [1 / (1 - a / 2) for a in (0.25, 0.5)], rtol=1e-4)  # at half the rate
    # late by f samples: z^2 - (1 - a (1 - f)) z + a f, stable to f = 1 / a
    fast = sliders(2.0, Kd=3000.0)  # a = 1.5
    assert delay_margin(fast, free) == pytest.approx(1e-3 / 1.5, rel=1e-3)
    assert np.isinf(delay_margin(sliders(2.0, Kd=1.0), free))
    assert np.isinf(delay_margin(sliders(2.0, Kd=1.0), Sampling(1000.0, 80)))
    # one sample late: z^2 - z + a, stable to a = 1
    late = margins_at(loop, AT, np.zeros(2))
    np.testing.assert_allclose(late.gain_up, [4.0, 2.0], rtol=2e-4)
    unstable = margins_at(sliders(2.0, Kd=5000.0), free, np.zeros(1))
    assert not unstable.is_stable
    assert np.isnan([unstable.gain_up[0], unstable.all_down, unstable.delay_margin]).all()
    # with an integral the gain may not fall for ever: s^3 + 2 xi w s^2 + w^2 s + ki, ki < 2 w^3, nearly continuous
    integral = margins_at(sliders(1.0, Kp=100.0, Kd=20.0, integral=500.0), Sampling(10000.0), np.zeros(1))
    assert integral.gain_down[0] == pytest.approx(0.25, rel=0.02)  # c 20 * c 100 = c 500


def test_the_simulated_arm_turns_unstable_where_the_gain_and_the_delay_margin_say(bent):
    for joint in (0, 1):
        for factor, grows in ((0.97, False), (1.03, True)):
            scale = 1 + (factor * bent.gain_up[joint] - 1) * np.eye(7)[joint]
            assert swings(scale, AT.delay) is grows
    whole = int(bent.delay_margin * 1000.0)
    assert bent.delay_margin > 0
    assert [swings(1.0, AT.delay + x) for x in (whole, whole + 1)] == [False, True]


def swings(scale, delay, samples=400):
    """Whether a small deviation of the simulated, nonlinear loop grows, its torques scaled about those at rest."""
    held, control = dynamics().gravity_vector(BENT), law("pd-gravity")

    def scaled(*state):
        return held + scale * (control(*state) - held)

    try:
        run = simulate(
            arm(), scaled, Still(BENT, samples * 1e-3), q0=BENT + 1e-8, delay=delay, saturate=False,
            position_limits=False,
        )  # fmt: skip
    except DivergenceError:
        return True
    speed = np.abs(run.dq).max(axis=1)
    return bool(speed[-50:].max() > speed[len(speed) // 2 - 50 : len(speed) // 2].max())


def test_gain_and_delay_margins_are_where_the_radius_passes_one(bent):
    loop = RestingLoop.of(dynamics(), law("pd-gravity"), BENT[None])
    T = 1e-3
    for share, stable in ((0.999, True), (1.001, False)):
        late = share * bent.delay_margin
        whole = int(late / T)
        radius = loop.radius(Sampling(1000.0, 1 + whole), late - whole * T)[0]
        assert (radius <= GROWS) is np.bool_(stable)
        assert (loop.radius(AT, scale=share * bent.all_up)[0] <= GROWS) is np.bool_(stable)
    assert delay_margin(loop, AT) == bent.delay_margin


JOINTS = (0, 1, 3)


def report(name="pd-gravity", **options):
    return margins(arm(), law(name), engine=dynamics(), q=[BENT], **options)


@pytest.fixture(scope="module")
def control():
    import control

    return control


@pytest.mark.slow
@pytest.mark.parametrize(("name", "options"), [("pd-gravity", {"delay": 2}), ("pid", {"cutoff_hz": 100.0})])
def test_python_control_closes_the_loop_to_the_same_poles_and_responses(name, options, control):
    found = report(name, **options)
    spaces, T = found.state_spaces(), 1e-3
    closed = control.feedback(spaces.open_loop, np.eye(7))
    ours, theirs = (np.sort(np.abs(p)) for p in (found.worst.poles, closed.poles()))
    np.testing.assert_allclose(theirs, ours, atol=1e-6)
    hz = frequency_grid(1000.0, 9)[4:]  # below 1 Hz three integrators leave few digits
    gain = loop_gain(found.loop, found.case.sampling, hz)
    z = np.exp(2j * np.pi * hz * T)
    shown = np.array([spaces.open_loop(x) for x in z])
    np.testing.assert_allclose(shown, gain[0], atol=1e-8 * np.abs(gain).max())
    diagonal = np.array([np.diag(spaces.sensitivity(x)) for x in z])
    np.testing.assert_allclose(diagonal, sensitivity(gain)[0], atol=1e-7)
    assert spaces.plant.dt == spaces.open_loop.dt == T
    assert spaces.plant.output_labels[0] == "q_joint_1"
    plant = found.loop.plant
    if plant.A.shape[-1] == 14:  # the plant is what python-control makes of the continuous one
        sampled = control.sample_system(control.ss(plant.A[0], plant.B[0], np.eye(14), 0), T, "zoh")
        np.testing.assert_allclose(sampled.A, spaces.plant.A, atol=1e-10)
        np.testing.assert_allclose(sampled.B, spaces.plant.B, atol=1e-10)


def test_gain_margins_of_python_control_are_not_those_of_these_loops(control):
    """`stability_margins` of the loop cut at a joint, all others closed, which has one input and one output: the gain
    margin that it gives is passed by far without harm, and its distance from -1 is sometimes missing."""
    found = report()
    space, closed_others = found.state_spaces().open_loop, []
    for joint in JOINTS:
        others = [j for j in range(7) if j != joint]
        A = space.A - space.B[:, others] @ space.C[others]
        cut = control.ss(A, space.B[:, [joint]], space.C[[joint]], 0, 1e-3)
        closed_others.append(control.stability_margins(cut)[:3])
        true = found.worst.gain_up[joint]
        for factor, stable in ((0.99 * true, True), (1.01 * true, False)):
            scale = 1 + (factor - 1) * np.eye(7)[joint]
            assert (found.loop.radius(found.case.sampling, scale=scale)[0] <= GROWS) is np.bool_(stable)
    gains, _, distances = np.array(closed_others).T  # the numbers differ with and without slycot: wrong in both
    assert (gains < 0.5 * found.worst.gain_up[list(JOINTS)]).all()
    assert np.isinf(distances).any()


def test_without_python_control_the_extra_is_named_and_a_loop_of_several_poses_is_refused(monkeypatch, control):
    found, two = report(), np.array([BENT, BENT])
    with pytest.raises(OptionError, match="2 poses; allowed: one pose"):
        margins_at(RestingLoop.of(dynamics(), law("pd-gravity"), two), AT, BENT)
    with pytest.raises(OptionError, match="one pose"):
        state_spaces(found.loops(two), found.case.sampling, arm().joint_names)
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(MissingPackageError, match=r"lwr_dyn\[design\]"):
        found.state_spaces()
