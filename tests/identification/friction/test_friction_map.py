"""Cruises are found where a joint moves at constant speed, and nowhere else."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.friction.friction_map import CruiseRule, ModelTorque, find_cruises, position_noise
from lwr_dyn.trajectory.motion_profile import lspb

T = np.arange(1001) / 100
COUNT = 4e-5


def long_ones(q, t=T):
    return [c for c in find_cruises(t, q) if c.duration >= 0.5]


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("count", [0.0, COUNT])
def test_the_straight_part_of_an_lspb_is_one_cruise(way, count):
    q = way * lspb(0.5, 7.0, 1.0).at(T).s
    q = np.round(q / count) * count if count else q
    (cruise,) = long_ones(q)
    assert 1.0 <= T[cruise.first] < 1.25
    assert 5.75 < T[cruise.last] <= 6.0


def test_a_staircase_of_speeds_gives_one_cruise_a_step():
    speed = np.select([T < 3, T < 6], [0.1, 0.2], -0.15)
    found = long_ones(np.cumsum(speed) / 100)
    assert [round(float(speed[c.first]), 2) for c in found] == [0.1, 0.2, -0.15]


@pytest.mark.parametrize("q", [np.zeros_like(T), T**2 * 0.02, 0.3 * np.sin(2 * np.pi * T), 2e-4 * T])
def test_rest_acceleration_oscillation_and_creep_are_no_cruises(q):
    assert not long_ones(q)


def test_noise_at_rest_is_no_cruise():
    assert not long_ones(np.random.default_rng(0).normal(0.0, 1e-4, T.size))


def test_a_gap_in_time_parts_two_recordings():
    t = np.concatenate([T[:200], T[:200] + 60.0])
    found = long_ones(0.1 * np.concatenate([T[:200], T[:200]]), t)
    assert [c.last < 200 or c.first >= 200 for c in found] == [True, True]


def test_rows_need_not_be_even():
    t = T + np.random.default_rng(0).uniform(-3e-3, 3e-3, T.size)
    (cruise,) = long_ones(0.1 * t, t)
    assert cruise.duration > 9.0


def test_position_noise_sees_rounding_and_not_the_motion():
    q = lspb(0.5, 7.0, 1.0).at(T).s
    assert position_noise(q) < 2e-6  # the first step of the blend passes for a count
    assert position_noise(np.round(q / COUNT) * COUNT) == pytest.approx(COUNT / np.sqrt(12), rel=0.5)
    assert position_noise(q + np.random.default_rng(0).normal(0, 1e-4, T.size)) == pytest.approx(1e-4, rel=0.15)


@pytest.mark.parametrize("field", ["shortest", "window", "tolerance", "slowest"])
def test_a_rule_needs_numbers_above_0(field):
    with pytest.raises(OptionError, match=f"cruise {field}: 0; allowed: a number above 0"):
        CruiseRule(**{field: 0})


def test_a_part_to_subtract_that_does_not_exist():
    with pytest.raises(OptionError, match="subtract: 'friction'; allowed: none, gravity"):
        ModelTorque(lwr_dyn.load("wam7"), "friction")
