"""Steps a sample: one is kept bit for bit where it is enough, more are found where it is not, friction asks too."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Event
from lwr_dyn.simulation.setup import Loop, prepare
from lwr_dyn.simulation.simulate import run_setup
from lwr_dyn.simulation.substeps import (
    ENOUGH,
    MOST,
    SPARE,
    STABLE,
    SteppedRun,
    applies,
    change_bound,
    doubled,
    enough_steps,
    friction_substeps,
    tip_change,
    with_substeps,
)

ARM = lwr_dyn.load("lwr4plus")
FAST = lwr_dyn.reference("point-to-point", ARM, start=[0.0] * 7, end=[1.0] * 7, duration=0.6)


def setup_of(rate=1000.0, **options):
    law = lwr_dyn.controller("inverse-dynamics", ARM, omega_n=20.0)
    return prepare(ARM, law, FAST, Loop(rate=rate, saturate=False, **options))


def test_a_run_whose_bound_is_small_is_kept_as_it_is_and_the_bound_is_one():
    setup = setup_of()
    run = run_setup(setup)
    found = enough_steps(run, lambda steps: pytest.fail("no further run is needed"))
    assert found.run is run
    assert (found.substeps, found.words) == (1, "")
    words = "substeps: 4, chosen for this run: its friction needs them; twice as many change the tip by 3e-07 m at most"
    assert SteppedRun(run, 4, 3e-7, True).words == words
    assert SteppedRun(run, 1, ENOUGH, False).words.endswith(" by 1e-06 m, and more steps do not leave less")
    true = tip_change(run, run_setup(with_substeps(setup, 2)))
    assert 0.0 < true < found.change < ENOUGH


def test_the_change_is_the_largest_distance_of_the_tips():
    run = run_setup(setup_of())
    other = replace(run, q=run.q + np.linspace(0.0, 0.2, run.t.size)[:, None])
    ours, theirs = (lwr_dyn.forward_kinematics(ARM, x.q[-1])[:3, 3] for x in (run, other))
    assert tip_change(run, other) == pytest.approx(np.linalg.norm(ours - theirs), rel=0.05)
    whole = [lwr_dyn.forward_kinematics(ARM, x.q)[:, :3, 3] for x in (run, other)]
    assert tip_change(run, other) <= np.linalg.norm(whole[0] - whole[1], axis=1).max() * (1.0 + 1e-12)


def test_the_bound_is_that_of_the_worst_interval_and_none_where_all_have_events():
    run = run_setup(setup_of())
    everywhere = tuple(Event(float(t), "stop", 0, 0.0) for t in (run.t[:-1] + run.t[1:]) / 2)
    assert change_bound(replace(run, events=everywhere)) == np.inf
    one = [change_bound(replace(run, events=tuple(e for e in everywhere if e.t // 1e-3 != k))) for k in (100, 300)]
    assert 0.0 < max(one) < change_bound(run)
    assert np.isnan(change_bound(replace(run, q=np.full_like(run.q, np.nan))))


def test_a_coarse_run_gets_the_fewest_steps_whose_doubling_no_longer_moves_the_tip():
    setup = setup_of(rate=40.0)
    runs = {steps: run_setup(with_substeps(setup, steps)) for steps in (1, 2, 4, 8, 16)}
    assert change_bound(runs[1]) > ENOUGH
    changes = {steps: tip_change(runs[steps], runs[2 * steps]) for steps in (1, 2, 4, 8)}
    fewest = next(steps for steps, change in changes.items() if change < ENOUGH)
    found = enough_steps(runs[1], runs.__getitem__)
    assert (found.substeps, found.change) == (fewest, changes[fewest])
    assert fewest > 1
    assert f"substeps: {fewest}, chosen for this run: twice as many change the tip by" in found.words


def test_where_doubling_does_not_help_it_ends_and_says_so():
    setup = setup_of(rate=40.0)
    run, noise = run_setup(setup), np.random.default_rng(0)

    def again(steps):
        other = run_setup(setup)
        return replace(other, q=other.q + noise.normal(0.0, 1e-3, other.q.shape))

    found = enough_steps(run, again)
    assert found.run is run
    assert found.words.endswith("and more steps do not leave less")


def test_friction_asks_for_a_power_of_two_with_something_to_spare_or_is_refused():
    setup = setup_of()
    assert friction_substeps(setup) == 1
    assert friction_substeps(replace(setup, friction_rate=2700.0)) == 2
    assert friction_substeps(replace(setup, friction_rate=14670.0)) == 16
    most = MOST * STABLE * 1000.0 / SPARE
    assert friction_substeps(replace(setup, friction_rate=most * (1 - 1e-12))) == MOST == 64
    with pytest.raises(OptionError, match="substeps from 65 on"):
        friction_substeps(replace(setup, friction_rate=most * (1 + 1e-12)))
    assert doubled(lambda steps: 1.0 / steps**4, 1, 2e-4) == (16, 1.0 / 16**4)
    assert doubled(lambda steps: 1.0, 2, 1e-3) == (2, 1.0)
    with pytest.raises(OptionError, match="needs 167 RK4 steps a sample; allowed: substeps from 167 on"):
        friction_substeps(replace(setup, friction_rate=3e5))


def test_steps_are_chosen_for_sampled_rk4_alone():
    assert applies(setup_of())
    assert not applies(setup_of(method="dop853"))
    assert not applies(setup_of(continuous=True))
    assert not applies(setup_of(loop="compiled"))
