"""Defaults of a loop: the task that fits, the first law whose poles are inside, and each with its reason in a line."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import lwr_dyn
from lwr_dyn.design import sampled_stability
from lwr_dyn.design.defaults import LAWS, law_fault, law_stability, usual_law, usual_task
from lwr_dyn.foundation.errors import DivergenceError, MissingDataError
from lwr_dyn.trajectory.references.ist import ist_reference

ROBOTS = Path(pin.__file__).parents[4] / "share" / "example-robot-data" / "robots"
PANDA = ROBOTS / "panda_description" / "urdf" / "panda.urdf"


@pytest.fixture(scope="module")
def panda():
    return lwr_dyn.load(PANDA)


def maker(arm):
    return lambda name: lwr_dyn.controller(name, arm)


def test_the_arm_of_the_paper_keeps_the_paper_s_task_and_law_without_a_word():
    arm = lwr_dyn.load("lwr4plus")
    task = usual_task(arm)
    assert (task.name, task.words) == ("ist", "")
    t = np.linspace(0.0, 14.0, 5)
    np.testing.assert_array_equal(task.reference.sample(t).q, ist_reference(arm).sample(t).q)
    law = usual_law(arm, lwr_dyn.dynamics_of(arm), maker(arm), task.reference, 1000.0)
    assert (law.name, law.words) == ("pd-gravity", "")


def test_of_a_law_that_holds_no_least_rate_is_searched_and_of_another_all_is_known(monkeypatch):
    arm = lwr_dyn.load("lwr4plus")
    case = arm, lwr_dyn.dynamics_of(arm), maker(arm)("pd-gravity"), ist_reference(arm)
    slow = law_fault(*case, 100.0)
    assert slow.to_json() == law_stability(*case, 100.0).to_json()
    assert slow.unstable
    monkeypatch.setattr(sampled_stability, "_least_rate", None)
    assert law_fault(*case, 1000.0) is None


@pytest.mark.parametrize("robot", ["kr30ha", PANDA])
def test_other_arms_move_between_poses_of_their_own_and_the_line_says_so(robot):
    task = usual_task(lwr_dyn.load(robot))
    assert task.name == "move"
    assert task.words.startswith("task: point-to-point, chosen for this arm (--task move): (")
    assert ("torque limits unknown" in task.words) == (robot == "kr30ha")


@pytest.mark.slow
def test_a_law_is_passed_over_where_its_poles_say_so_and_simulation_agrees(panda):
    task = usual_task(panda)
    law = usual_law(panda, lwr_dyn.dynamics_of(panda), maker(panda), task.reference, 1000.0)
    assert law.name == "inverse-dynamics"
    found = law_stability(panda, lwr_dyn.dynamics_of(panda), maker(panda)("pd-gravity"), task.reference, 1000.0)
    assert f"unstable at rest at {found.unstable} of {found.poses} poses" in law.words
    with pytest.raises(DivergenceError):
        lwr_dyn.simulate(panda, maker(panda)("pd-gravity"), task.reference, saturate=False, position_limits=False)
    run = lwr_dyn.simulate(panda, law.controller, task.reference, duration=0.5)
    assert np.abs(run.q - run.q_ref).max() < 1e-3


@pytest.mark.slow
def test_from_the_least_rate_on_the_first_law_is_taken(panda):
    task = usual_task(panda)
    slow = law_stability(panda, lwr_dyn.dynamics_of(panda), maker(panda)("pd-gravity"), task.reference, 1000.0)
    assert (
        usual_law(panda, lwr_dyn.dynamics_of(panda), maker(panda), task.reference, 1.01 * slow.least_rate).name
        == "pd-gravity"
    )
    assert (
        usual_law(panda, lwr_dyn.dynamics_of(panda), maker(panda), task.reference, 0.99 * slow.least_rate).name
        == "inverse-dynamics"
    )


def test_where_no_law_is_stable_the_first_is_left_and_one_that_cannot_be_made_is_passed_over(panda):
    task = usual_task(panda)
    assert usual_law(panda, lwr_dyn.dynamics_of(panda), maker(panda), task.reference, 20.0).name == LAWS[0]

    def make(name):
        if name == LAWS[0]:
            raise MissingDataError("panda", "position limits", "a search")
        return maker(panda)(name)

    law = usual_law(panda, lwr_dyn.dynamics_of(panda), make, task.reference, 1000.0)
    assert law.name == LAWS[1]
    assert "pd-gravity cannot be made (panda: position limits not given" in law.words

    def none(name):
        raise MissingDataError("panda", "masses", name)

    with pytest.raises(MissingDataError, match="inverse-dynamics"):
        usual_law(panda, lwr_dyn.dynamics_of(panda), none, task.reference, 1000.0)
