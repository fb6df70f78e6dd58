"""Defaults of a loop: the task that fits, the first law whose poles are inside, and each with its reason in a line."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

import lwr_dyn
from lwr_dyn.design import sampled_stability
from lwr_dyn.design.defaults import LAWS, law_fault, law_stability, unstable_words, usual_law, usual_task
from lwr_dyn.foundation.errors import DivergenceError, MissingDataError
from lwr_dyn.trajectory.references.ist import ist_reference

PANDA = Path(pin.__file__).parents[4] / "share" / "example-robot-data" / "robots/panda_description/urdf/panda.urdf"


class Loop:
    """An arm with its usual task; laws are made by their names."""

    def __init__(self, robot):
        self.arm = lwr_dyn.load(robot)
        self.dynamics, self.task = lwr_dyn.dynamics_of(self.arm), usual_task(self.arm)

    def make(self, name):
        return lwr_dyn.controller(name, self.arm)

    def usual(self, rate, make=None):
        return usual_law(self.arm, self.dynamics, make or self.make, self.task.reference, rate)

    def judged(self, judge, rate):
        return judge(self.arm, self.dynamics, self.make("pd-gravity"), self.task.reference, rate)


@pytest.fixture(scope="module")
def panda():
    return Loop(PANDA)


def test_the_arm_of_the_paper_keeps_the_paper_s_task_and_law_without_a_word(monkeypatch):
    lwr = Loop("lwr4plus")
    assert (lwr.task.name, lwr.task.words) == ("ist", "")
    t = np.linspace(0.0, 14.0, 5)
    np.testing.assert_array_equal(lwr.task.reference.sample(t).q, ist_reference(lwr.arm).sample(t).q)
    law = lwr.usual(1000.0)
    assert (law.name, law.words) == ("pd-gravity", "")
    slow = lwr.judged(law_fault, 100.0)
    assert slow.to_json() == lwr.judged(law_stability, 100.0).to_json()
    assert (slow.unstable, slow.poses) == (200, 200)
    # of a law that holds all is known: no least rate is searched
    monkeypatch.setattr(sampled_stability, "_least_rate", None)
    assert lwr.judged(law_fault, 1000.0) is None


@pytest.mark.parametrize(
    ("robot", "uses"), [("kr30ha", "at most [0-9]+ % of a speed limit; torque limits unknown"),
                        (PANDA, "at most [0-9]+ % of a speed limit and [0-9]+ % of a torque limit")]
)  # fmt: skip
def test_other_arms_move_between_poses_of_their_own_and_the_line_says_so(robot, uses):
    arm = lwr_dyn.load(robot)
    task = usual_task(arm)
    assert task.name == "move"
    ends = r"\(.*\) deg to \(.*\) deg"
    line = (
        rf"task: point-to-point, chosen for this arm \(--task move\): {ends} in {task.reference.duration:g} s; {uses}"
    )
    assert re.fullmatch(line, task.words), task.words


@pytest.mark.slow
def test_a_law_is_passed_over_where_its_poles_say_so_and_simulation_agrees(panda):
    law, found = panda.usual(1000.0), panda.judged(law_stability, 1000.0)
    assert law.name == "inverse-dynamics"
    assert law.words == (
        f"controller: inverse-dynamics, chosen for this arm: at 1000 Hz pd-gravity {unstable_words(found)}"
    )
    assert panda.usual(1.01 * found.least_rate).name == "pd-gravity"
    assert panda.usual(0.99 * found.least_rate).name == "inverse-dynamics"
    with pytest.raises(DivergenceError):
        lwr_dyn.simulate(
            panda.arm, panda.make("pd-gravity"), panda.task.reference, saturate=False, position_limits=False
        )
    run = lwr_dyn.simulate(panda.arm, law.controller, panda.task.reference, duration=0.5)
    assert np.abs(run.q - run.q_ref).max() < 1e-3


@pytest.mark.parametrize(
    ("least", "words"), [(1500.0, "it is stable from 1500 Hz on"), (None, "no rate up to 1e+06 Hz makes it stable")]
)
def test_at_how_many_poses_a_loop_is_unstable_in_words(least, words):
    found = SimpleNamespace(unstable=3, poses=200, least_rate=least)
    assert unstable_words(found) == f"is unstable at rest at 3 of 200 poses of this task ({words})"


def test_where_no_law_is_stable_the_first_is_left_and_one_that_cannot_be_made_is_passed_over(panda):
    assert panda.usual(20.0).name == LAWS[0]

    def without(*names):
        def make(name):
            if name in names:
                raise MissingDataError("panda", "position limits", name)
            return panda.make(name)

        return make

    law = panda.usual(1000.0, without(LAWS[0]))
    assert (law.name, "pd-gravity cannot be made (panda: position limits not given" in law.words) == (LAWS[1], True)
    with pytest.raises(MissingDataError, match=LAWS[-1]):
        panda.usual(1000.0, without(*LAWS))
