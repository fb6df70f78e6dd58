"""Events against closed forms: when a joint meets its limit, sticks or slips, and which comes first."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.simulation import contact
from lwr_dyn.simulation.arm_friction import chosen_friction
from lwr_dyn.simulation.contact import contact_mode
from lwr_dyn.simulation.integrators import rk4
from lwr_dyn.simulation.plant import plant_of
from tests.simulation.sample_runs import one_joint

STEP, SPEED, BRAKE = 0.01, 2.0, 300.0
"""[s], [m/s], [m/s^2] of a slider that turns back within one step."""
MOMENT = 1e-14
"""[s] Root finding to 1e-15 of a parabola that RK4 follows to rounding."""


def slider(**limits):
    """A slider of 2 kg with Coulomb friction of 3 N, static 4 N."""
    arm = one_joint(**limits)
    both = Direction(3.0, 0.0, static=4.0)
    return plant_of(arm, lwr_dyn.dynamics_of(arm), chosen_friction(arm, [JointFriction(both, both)]))


def interval(speed=SPEED, acceleration=-BRAKE, h=STEP):
    def rates(t, y):
        return np.array([y[1], acceleration])

    return contact.Interval(rk4(1), rates, 0.0, h, np.array([0.0, speed]))


def none_holds(s):
    raise AssertionError("no joint is at rest")


def found(mode, motion, holding=none_holds, barred=False):
    """The possible events of an interval of motion."""
    return contact.possible_events(mode, motion, motion.later(STEP), np.array([barred]), holding)


def mode(plant, side):
    return contact_mode(plant, np.zeros(1), np.array([side]))


def test_the_state_within_an_interval_is_the_parabola_and_is_kept():
    motion = interval()
    later = motion.later(0.004)
    np.testing.assert_allclose(later, [SPEED * 0.004 - BRAKE * 0.004**2 / 2, SPEED - BRAKE * 0.004], rtol=1e-14)
    assert motion.later(0.004) is later
    assert motion.later(0.0) is motion.y


@pytest.mark.parametrize("side", [1, -1])
def test_a_joint_past_its_limit_was_there_at_the_moment_of_the_parabola(side):
    motion = interval(side * SPEED, side * BRAKE)
    (event,) = found(mode(slider(lower=-0.03, upper=0.03), side), motion)
    assert (event.kind, event.joint, event.side) == ("stop", 0, side)
    crossing = contact.earliest([event])
    assert crossing.after == pytest.approx((-SPEED + np.sqrt(SPEED**2 + 2 * BRAKE * 0.03)) / BRAKE, abs=MOMENT)


def test_a_joint_that_is_braked_sticks_where_its_speed_is_zero():
    motion = interval()
    (event,) = found(mode(slider(), 1), motion)
    assert (event.kind, event.side) == ("stick", 0)
    assert contact.earliest([event]).after == pytest.approx(SPEED / BRAKE, abs=MOMENT)


def test_a_speed_that_dips_below_zero_and_recovers_is_seen():
    def rates(t, y):
        return np.array([y[1], 2 * 4e4 * (t - STEP / 2)])

    motion = contact.Interval(rk4(1), rates, 0.0, STEP, np.array([0.0, 0.9]))  # slowest 0.9 - 1.0 m/s, at half the step
    assert motion.later(STEP)[1] > 0.0
    (event,) = found(mode(slider(), 1), motion)
    assert contact.earliest([event]).after == pytest.approx(STEP / 2 - np.sqrt(0.1 / 4e4), abs=1e-12)


@pytest.mark.parametrize("side", [1, -1])
def test_a_joint_at_rest_slips_where_its_holding_torque_passes_the_static_level(side):
    rest, motion = mode(slider(), 0), interval(0.0, 0.0)

    def ramp(s):
        return np.array([side * 8.0 * s / STEP])

    (event,) = found(rest, motion, ramp)
    assert (event.kind, event.side) == ("slip", side)
    assert contact.earliest([event]).after == pytest.approx(STEP / 2, abs=1e-12)
    assert found(rest, motion, ramp, barred=True) == []
    assert found(rest, motion, lambda s: ramp(s) / 2.1) == []


def test_the_first_of_several_events_is_chosen():
    def at(moment, joint):
        return contact.EventFunction("stop", joint, 1, lambda s: s - moment, STEP)

    crossing = contact.earliest([at(0.006, 0), at(0.002, 1), at(0.004, 2), at(0.5, 3)])
    assert (crossing.event.joint, crossing.after) == (1, pytest.approx(0.002, abs=MOMENT))
    assert contact.earliest([at(0.5, 3)]) is None
    assert contact.earliest([]) is None


def test_a_start_on_the_root_is_left_or_is_the_answer():
    assert contact.first_root(lambda s: s * (s - 0.5), 1.0) == pytest.approx(0.5, abs=MOMENT)
    assert contact.first_root(lambda s: s, 1.0) == 0.0


def test_a_whole_turn_in_a_step_and_numbers_that_are_not_finite_cannot_be_followed():
    fastest = contact.TURN / STEP
    assert contact.followable(np.array([0.0, -fastest]), 1, STEP)
    for y in ([0.0, 1.001 * fastest], [0.0, -1.001 * fastest], [np.nan, 0.0], [0.0, np.inf]):
        assert not contact.followable(np.array(y), 1, STEP)
