"""Substeps of smooth friction: chosen so that the error that they leave is small, against much smaller steps."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts import substeps
from lwr_dyn.codegen.rollouts.law_forms import INVERSE_DYNAMICS
from lwr_dyn.codegen.rollouts.loop_setup import kept_values, loop_setup
from lwr_dyn.codegen.rollouts.substeps import ENOUGH, MOST, Steps, enough_steps, evenly, steps
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.friction import symmetric
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop

ARM = lwr_dyn.load("lwr4plus")
LAW = lwr_dyn.controller("inverse-dynamics", ARM)
IST = lwr_dyn.reference("ist-clear", ARM)
RUBBING = replace(ARM, friction=(symmetric(0.5, 0.1),) * 7)
TABLE = np.array([5.0, 1.0, 5.0, 1.0, 0.0])[:, None] * np.ones(7)


def rolled(**options):
    """Two runs, the second with twice the friction."""
    given = {"rate": 250.0, "duration": 0.04, "friction": "smooth", "friction_width": 0.05} | options
    own = {} if given["friction"] == "none" else {"friction": [TABLE, 2 * TABLE]}
    return lwr_dyn.rollouts(ARM, LAW, IST, parameters={"payload": [0.0, 1.0], **own}, **given)


@pytest.mark.slow
def test_the_steps_that_are_chosen_leave_less_than_is_allowed_and_half_as_many_leave_more():
    done, finest, half = (rolled(record=1, duration=2.0, **more) for more in ({}, {"substeps": 32}, {"substeps": 2}))
    assert done.setup["substeps"] == 4
    left, more = (np.abs(one.q - finest.q).max() for one in (done, half))
    assert left < 1.2 * done.setup["step_error"] < ENOUGH < more
    assert "step error 3e-08 rad (estimated)" in repr(done)


@pytest.mark.slow
def test_substeps_that_are_given_or_without_friction_are_not_chosen():
    for options in ({"friction": "none"}, {"substeps": 2}):
        done = rolled(**options)
        assert done.setup["step_error"] is None
        assert done.setup["substeps"] == options.get("substeps", 1)
        assert "step error" not in repr(done)


def test_an_estimate_looks_at_runs_over_all_with_true_readings(monkeypatch):
    """By a kernel that notes its tasks, and whose positions are off by 1e-4 / substeps^4."""
    tasks = []

    def kernel(plan):
        def run(task):
            tasks.append((plan, task))
            return SimpleNamespace(record=np.full((task.runs, 3, 21), 1e-4 / plan.substeps**4))

        return SimpleNamespace(slots=plan.slots, run=run)

    monkeypatch.setattr(substeps, "rollout_kernel", kernel)
    runs = 130
    given = {"noise": np.full(runs, 1e-3), "resolution": np.full(runs, 1e-3), "payload": np.linspace(0.0, 1.0, runs)}
    loop = Loop(rate=500.0, duration=2.0, friction="smooth", encoder=Encoder(1e-3, 1e-3, 50.0))
    setup = loop_setup(RUBBING, LAW, IST, loop, 0.3)
    chosen = substeps.chosen_steps(setup, INVERSE_DYNAMICS.of(LAW, RUBBING), given, runs)
    assert (chosen.substeps, chosen.error) == (4, pytest.approx(1e-4 / 4**4 * (1 - 1 / 16)))
    assert [plan.substeps for plan, _ in tasks] == [1, 2, 4, 8]
    for plan, task in tasks:
        row = dict(zip(task.places.astype(int).tolist(), task.given.T, strict=True))
        loads = np.linspace(0.0, 1.0, runs)[evenly(runs)]
        plant = np.transpose([row[place] for place in plan.slots.places("plant")])
        assert np.array_equal(plant, kept_values(RUBBING.chain, None, loads, None))
        assert not np.any([row[plan.slots.first(name)] for name in ("noise", "resolution")])
        assert [task.common[plan.slots.first(name)] for name in ("noise", "resolution")] == [0.0, 0.0]
        assert (task.runs, task.stride, task.first_run) == (64, 2, 0)


def test_friction_that_no_allowed_step_follows_is_refused():
    with pytest.raises(OptionError, match=r"substeps from .* on, or a larger friction_width") as fault:
        rolled(friction_width=1e-5)
    assert int(str(fault.value).split("from ")[1].split()[0]) > MOST


def shifted(error):
    """Positions of two runs that are off by `error(substeps)`; the second is not followed."""
    return lambda k: np.array([np.full((3, 2), error(k)), np.full((3, 2), np.nan)])


@pytest.mark.parametrize(
    ("error", "first", "found"),
    [
        (lambda k: 1e-4 / k**4, 1, Steps(4, 1e-4 / 4**4 * (1 - 1 / 16))),
        (lambda k: 1e-4 / k**4, 8, Steps(8, 1e-4 / 8**4 * (1 - 1 / 16))),
        (lambda k: 1e-3 if k < 4 else (-1) ** k.bit_length(), 1, Steps(1, 0.0)),
        (lambda k: 1e-2 * (-1) ** k.bit_length() / k**0.2, 1, Steps(1, 1e-2 * (1 + 2**-0.2))),
        (lambda k: 1e2 / k, 1, Steps(MOST, 1e2 / 2 / MOST)),
    ],
    ids=["of fourth order", "small at once", "no difference", "amplified", "slow"],
)  # fmt: skip
def test_steps_are_doubled_until_they_are_enough_or_help_no_more(error, first, found):
    chosen = enough_steps(shifted(error), first)
    assert chosen.substeps == found.substeps
    assert chosen.error == pytest.approx(found.error, rel=1e-9)
    assert chosen.are_enough == (found.error < ENOUGH)


def test_an_error_is_small_below_a_millionth_and_nothing_is_known_without_a_run_to_compare():
    assert [Steps(2, x).are_enough for x in (np.nextafter(1e-6, 0.0), 1e-6)] == [True, False]
    chosen = steps(lambda _: np.full((1, 2, 3), np.nan), 2)
    assert np.isnan(chosen.error)
    assert not chosen.are_enough


def test_runs_of_an_estimate_lie_evenly_over_all():
    assert evenly(1).tolist() == [0]
    many = evenly(1000)
    assert (many.size, many[0], many[-1]) == (64, 0, 999)
    assert set(np.diff(many)) <= {15, 16}
