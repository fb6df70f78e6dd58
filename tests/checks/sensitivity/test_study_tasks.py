"""The tasks of the papers as data: what the files hold, and faults that name file and field."""

import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.checks.sensitivity.study_tasks import parse_tasks, printed_task, study_tasks
from lwr_dyn.foundation.errors import PaperError

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
        ('statistic = "max"', 'statistic = "most"', r"task\[0\].claim\[0\].statistic", "mean_abs"),
        ("[[task]]", "[[task]", "TOML", "valid TOML"),
    ],
)
def test_faults_name_file_and_field(old, new, field, allowed):
    assert old in TASK
    with pytest.raises(PaperError, match=rf"mine\.toml.*{field}.*{allowed}"):
        parse_tasks(TASK.replace(old, new, 1), "mine.toml")
