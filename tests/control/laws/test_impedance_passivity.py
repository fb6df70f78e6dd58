"""Law and wall take energy out at every step when the law is continuous; what sampling gives back.

A share of the time; `scripts/soak.py passivity` runs 60 s.
"""

import numpy as np
import pytest

from tests.control.laws.passivity import cartesian, jointly

ROUNDING = 1e-9
"""[J] The wall's contact begins inside a step of 1 ms: RK4 leaves 2.4e-10."""


@pytest.mark.slow
@pytest.mark.parametrize("law", [cartesian, jointly])
def test_a_continuous_law_and_the_wall_are_passive(law):
    run = law(seconds=1.5)
    assert 0.2 < np.mean(run.depth > 0.0) < 0.8
    assert run.hand_work[-1] > 0.1
    assert np.diff(run.law_loss).min() > 0.0
    assert np.diff(run.wall_loss).min() > -ROUNDING
    assert np.diff(run.excess).max() < ROUNDING


@pytest.mark.slow
def test_held_torques_of_a_damped_law_give_energy_at_the_first_touch_alone():
    """Of order 4 in the period: until the first sample after a push the law does not know of it."""
    given = []
    for rate in (500, 250):
        run = cartesian(seconds=0.4, rate=rate, held=True, substeps=4)
        losses = np.diff(run.law_loss)
        assert losses[1:].min() > 0.0
        given.append(-losses[0])
    assert 12.0 < given[1] / given[0] < 20.0


@pytest.mark.slow
def test_held_torques_of_a_law_with_too_little_damping_give_energy():
    """A held spring takes omega T / 4 off the damping ratio of a mode: at 45 rad/s 0.011 at 1 kHz, 0.046 at 250 Hz."""
    fast, slow = (cartesian(seconds=1.5, rate=rate, held=True, substeps=1000 // rate, xi=0.02) for rate in (1000, 250))
    assert fast.law_loss[-1] > 0.1
    assert slow.law_loss[-1] < -0.1
    assert slow.excess.max() > 0.1


def test_a_law_that_gives_energy_is_seen():
    """The check itself: a spring with the wrong sign of damping."""
    run = cartesian(seconds=0.3, slip=lambda tau, dq: tau + 40.0 * dq)
    assert np.diff(run.law_loss).min() < -1e-6
