"""The record of what closes a loop: the grid of samples, the start, and what is refused before a run begins."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.simulation.arm_friction import chosen_friction
from lwr_dyn.simulation.integrators import rk4
from lwr_dyn.simulation.plant import Encoder, plant_of
from lwr_dyn.simulation.setup import (
    STABLE,
    Loop,
    friction_rate,
    sampled_reference,
    start_state,
)
from tests.simulation.sample_runs import Still, controllers, one_joint


def slider(friction="none", **limits):
    arm = one_joint(**limits)
    return plant_of(arm, lwr_dyn.dynamics_of(arm), chosen_friction(arm, friction))


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ({"rate": 0.0}, "rate: 0.0; allowed: a number above 0"),
        ({"rtol": np.nan}, "rtol: nan; allowed: a number above 0"),
        ({"method": "euler"}, "method: 'euler'; allowed: rk4, dop853, radau"),
        ({"substeps": 1001}, "substeps: 1001; allowed: a whole number from 1 to 1000"),
        ({"seed": -1}, "seed: -1; allowed: a whole number from 0 on"),
        ({"seed": 0.5}, "seed: 0.5; allowed: a whole number from 0 on"),
    ],
)
def test_a_value_outside_what_is_allowed(option, message):
    with pytest.raises(OptionError) as fault:
        Loop(**option)
    assert str(fault.value) == message


@pytest.mark.parametrize(("duration", "samples"), [(0.1, 101), (0.1 + 1e-13, 101), (0.1001, 102), (1e-9, 2)])
def test_samples_are_on_the_grid_and_the_last_is_not_before_the_end(duration, samples):
    t = Loop(rate=1000.0).times(duration)
    assert t.size == samples
    np.testing.assert_array_equal(t, np.arange(samples) / 1000.0)
    assert t[-1] >= duration * (1 - 1e-9)


def test_durations_that_cannot_be_sampled():
    for duration in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(OptionError, match=r"duration: .*; allowed: a number above 0, in s"):
            Loop().times(duration)
    with pytest.raises(OptionError, match=r"1000 samples a second over 10001 s; allowed: at most 1e\+07 samples"):
        Loop().times(10001.0)


def test_the_integrator_is_that_of_the_method_with_its_substeps():
    def rates(t, y):
        return -y

    y = np.ones(1)
    three = Loop(substeps=3).integrator()(rates, 0.0, y, 1.0)
    np.testing.assert_array_equal(three, rk4(3)(rates, 0.0, y, 1.0))
    adaptive = Loop(method="dop853", rtol=1e-10).integrator()(rates, 0.0, y, 1.0)
    assert 0.0 < abs(adaptive[0] - np.exp(-1.0)) < 1e-9 < abs(three[0] - np.exp(-1.0))


def test_a_run_starts_on_its_reference_or_where_it_is_put_inside_the_limits():
    plant = slider(lower=-1.0, upper=1.0)
    motion = sampled_reference(Still(np.array([0.4]), 1.0), np.arange(3.0), 1)
    assert start_state(plant, motion, None, None).tolist() == [[0.4], [0.0]]
    assert start_state(plant, motion, [1.0], [2.0]).tolist() == [[1.0], [2.0]]
    with pytest.raises(OptionError, match=r"q0 of joint_1: 1\.5; allowed: -1 to 1, or position_limits=False"):
        start_state(plant, motion, [1.5], None)
    with pytest.raises(ShapeError, match="dq0"):
        start_state(plant, motion, None, [0.0, 0.0])
    with pytest.raises(ShapeError, match=r"reference q: shape \(3, 1\); allowed: \(3, 2\)"):
        sampled_reference(Still(np.array([0.4]), 1.0), np.arange(3.0), 2)


def test_continuous_runs_take_controllers_that_keep_no_hidden_memory():
    class Remembers:
        def reset(self):
            """It has a state that no integrator sees."""

    for name in ("pid", "pd-gravity"):
        Loop(continuous=True).check(controllers()[name])
    with pytest.raises(OptionError, match="encoder: given for a continuous run"):
        Loop(continuous=True, encoder=Encoder.of_bits(12)).check(controllers()["pid"])
    with pytest.raises(OptionError, match="continuous: with a controller that remembers between calls"):
        Loop(continuous=True).check(Remembers())
    Loop().check(Remembers())


def test_the_rate_of_viscous_friction_is_that_of_a_braked_mass_and_bounds_the_step_of_rk4():
    damping, mass = 500.0, 2.0
    plant = slider("set-valued", viscous=damping, coulomb=0.0)
    stiff = slider("smooth", viscous=damping, coulomb=1000.0)
    q = np.zeros(1)
    assert friction_rate(slider(), q, Loop()) == 0.0
    assert friction_rate(plant, q, Loop()) == pytest.approx(damping / mass)
    rate = friction_rate(stiff, q, Loop(method="dop853"))
    need = int(np.ceil(rate / 1000.0 / STABLE))
    assert friction_rate(stiff, q, Loop(substeps=need)) == rate
    with pytest.raises(OptionError, match=f"smooth, .*substeps from {need} on, method dop853, or friction set"):
        friction_rate(stiff, q, Loop(substeps=need - 1))


def test_a_delay_longer_than_the_run_is_refused():
    options = Loop(delay=5)
    assert options.times(0.005).size == 6
    with pytest.raises(OptionError, match="delay: 5 samples in a run of 4; allowed: a delay shorter than the run"):
        options.times(0.004)
