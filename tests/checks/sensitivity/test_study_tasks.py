"""The tasks of the papers as data: what the files hold, and faults that name file and field."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.checks.sensitivity.study_tasks import (
    JOINT_MOVE,
    ControllerChoice,
    _nearest,
    controller_of,
    joint_move,
    lspb_travel,
    mastering_cycle,
    parse_tasks,
    printed_task,
    simulated_task,
    study_tasks,
)
from lwr_dyn.foundation.errors import OptionError, PaperError

TASK = """
robot = "mine"
[[task]]
name = "wave"
about = "joint 1 there and back"
where = "section 3"
reference = { name = "lspb", start = [0.0], travel = 1.0, duration = 2.0, blend = 0.5 }
controllers = [{ id = "PD", controller = "pd-gravity", options = { own_gains = true } }]
[[task.claim]]
text = "joint 2 has the highest errors"
where = "below Table 3"
controller = "PD"
joints = [2]
statistic = "max"
"""


def test_every_task_is_one_of_a_robot_with_that_file():
    tasks = study_tasks()
    assert {"ist-clear", "ist", "lspb", "two-points"} <= set(tasks)
    assert [printed_task(robot) for robot in ("lwr4plus", "wam7", "lwr4")] == ["ist", "lspb", None]
    assert {task.robot for task in tasks.values()} <= set(studied())
    for task in tasks.values():
        joints = lwr_dyn.load(task.robot).n
        assert all(j < joints for claim in task.claims for j in claim.joints)


def test_a_task_holds_the_values_of_its_file_and_one_like_it_what_it_does_not_give_itself():
    more = '[[task]]\nname = "twin"\nlike = "wave"\nabout = "another path"\nreference = { name = "hold", q = [0.0] }\n'
    task, same = parse_tasks(TASK + more, "mine.toml")
    assert (task.reference, task.options["blend"], task.substeps, task.like) == ("lspb", 0.5, 1, "")
    (choice,), (claim,) = task.controllers, task.claims
    assert (choice.id, choice.controller, choice.options) == ("PD", "pd-gravity", {"own_gains": True})
    assert (claim.joints, claim.statistic) == ((1,), "max")
    text = TASK.replace("[2]", "[1, 3]").replace('"section 3"', '"section 3"\nsubsteps = 3')
    (other,) = parse_tasks(text, "mine.toml")
    assert (other.claims[0].joints, other.substeps) == ((0, 2), 3)
    assert (same.reference, same.like, same.controllers) == ("hold", "wave", task.controllers)
    assert (same.where, same.claims) == (task.where, ())
    with pytest.raises(PaperError, match=r"task\[1\].like.*'waves'.*one of wave"):
        parse_tasks(TASK + more.replace('"wave"', '"waves"'), "mine.toml")


@pytest.mark.parametrize(
    ("old", "new", "field", "allowed"),
    [
        ('robot = "mine"', "", "robot", "text"),
        ('about = "joint 1', 'abuot = "joint 1', r"task\[0\].about", "text"),
        ('where = "section 3"', 'where = "section 3"\nwhy = "x"', r"task\[0\].why", "name, about, where"),
        ('name = "lspb", ', "", r"task\[0\].reference.name", "the name of a reference"),
        ("options = {", "gains = {", r"task\[0\].controllers\[0\].gains", "id, controller, options"),
        ('controller = "PD"', 'controller = "PID"', r"task\[0\].claim\[0\].controller", "one of PD"),
        ("joints = [2]", "joints = [0]", r"task\[0\].claim\[0\].joints", "counted from 1"),
        ("joints = [2]", "joints = []", r"task\[0\].claim\[0\].joints", "counted from 1"),
        ("joints = [2]", "joints = [true]", r"task\[0\].claim\[0\].joints", "counted from 1"),
        ('statistic = "max"', 'statistic = "most"', r"task\[0\].claim\[0\].statistic", "mean_abs"),
        ('statistic = "max"', 'statistic = "max"\nwhy = 1', r"task\[0\].claim\[0\].why", "text, where"),
        ('robot = "mine"', 'robot = "mine"\nwhy = 1', "why", "robot, task"),
        ("[[task]]", "[[task]", "TOML", "valid TOML"),
    ],
)
def test_faults_name_file_and_field(old, new, field, allowed):
    assert old in TASK
    with pytest.raises(PaperError, match=rf"mine\.toml.*{field}.*{allowed}"):
        parse_tasks(TASK.replace(old, new, 1), "mine.toml")


def test_no_two_tasks_have_one_name(monkeypatch):
    monkeypatch.setattr("lwr_dyn.checks.sensitivity.study_tasks.parse_tasks", lambda *_: parse_tasks(TASK, "mine.toml"))
    with pytest.raises(PaperError, match=r"lwr4plus\.toml: task\.name: 'wave' of mine; allowed: another name"):
        study_tasks()


def test_a_task_on_another_arm_has_neither_the_claims_of_its_paper_nor_gains_that_it_lacks(arm, monkeypatch):
    wam = lwr_dyn.load("wam7")
    known, unknown = (simulated_task(one, "lspb").task.controllers[0] for one in (wam, replace(wam, gains=None)))
    assert (known.options, unknown.options) == ({"own_gains": True, "velocity_error": True}, {"velocity_error": True})
    task = replace(JOINT_MOVE, name="wave", robot="lwr4plus", claims=parse_tasks(TASK, "mine.toml")[0].claims)
    monkeypatch.setattr("lwr_dyn.checks.sensitivity.study_tasks.study_tasks", lambda: {"wave": task})
    assert simulated_task(arm).task == task
    assert simulated_task(replace(arm, name="other"), "wave").task == replace(task, claims=())
    assert simulated_task(replace(arm, name="other")).task == JOINT_MOVE
    law = controller_of(arm, ControllerChoice("PD", "pd-gravity"), np.arange(1.0, 8.0))
    np.testing.assert_allclose(law.Kp, 2500.0 * np.arange(1.0, 8.0))


def test_moves_of_tasks_pass_their_places(arm):
    """A tenth of each range about its middle; equal travel; points near each other, in the order of the list."""
    move, middle, wide = joint_move(arm), (arm.lower + arm.upper) / 2, (arm.upper - arm.lower) / 20
    start, q = np.arange(7) / 10, move.sample(np.array([0.0, 2.0, 4.0])).q
    np.testing.assert_allclose(q, middle + np.outer([-1, 1, -1], wide), atol=1e-12)
    q = lspb_travel(arm, start, 0.2, 3.0, 0.5).sample(np.array([0.0, 3.0])).q
    np.testing.assert_allclose(q, [start, start + 0.2], atol=1e-12)
    with pytest.raises(OptionError, match="task: lwr4plus has 7 joints; allowed: an arm of 2 joints"):
        lspb_travel(arm, [0.0, 1.0], 0.2, 3.0, 0.5)
    kuka = lwr_dyn.load("kr30ha")
    cycle = simulated_task(kuka).reference
    q = cycle.sample(np.array([0.0, 4.0, 8.0, 12.0])).q
    np.testing.assert_allclose(q[[0, 3]], [kuka.mastering] * 2, atol=1e-12)
    for i, point in ((1, [91.0, -1139.0, 1392.0]), (2, [91.0, -1117.0, 1447.0])):
        T = lwr_dyn.forward_kinematics(kuka, q[i])
        np.testing.assert_allclose(T[:3, 3], np.array(point) / 1e3, atol=1e-9)
        np.testing.assert_allclose(T[:3, :3], np.eye(3), atol=1e-9)
        solutions = lwr_dyn.inverse_kinematics(kuka, T).solutions
        assert min(np.abs(s.q - q[i - 1]).max() for s in solutions) == pytest.approx(np.abs(q[i] - q[i - 1]).max())
        assert all(np.array_equal(_nearest(kuka, T, s.q), s.q) for s in solutions)
    with pytest.raises(OptionError, match=r"task: kr30ha does not reach \[9\. 0\. 0\.\]; allowed: an arm that does"):
        mastering_cycle(kuka, [[9000.0, 0.0, 0.0]], 4.0)
