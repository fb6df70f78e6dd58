"""The tasks that papers set: a motion, the controllers that follow it, and what the paper concludes from it.

`tasks/ROBOT.toml` stands beside the robot's file, not in it: that file's digest is in every model.

    robot = "my_arm"
    [[task]]
    name = "wave"                                          # different from the tasks of other robots
    about = "joint 1 there and back"
    where = "section 3"
    reference = { name = "hold", q = [0.0, 1.0] }           # a row of references, with its options
    controllers = [{ id = "PD", controller = "pd-gravity", options = { own_gains = true } }]
    substeps = 1                                           # RK4 steps a sample
    [[task.claim]]
    text = "joint 2 has the highest errors"                # the controller's label is added
    where = "below Table 3"
    controller = "PD"                                      # one of the ids above
    joints = [2]                                           # counted from 1
    statistic = "max"                                      # of the joints' position errors

A task with `like = "wave"` takes what it does not give itself from that task of the file; not the claims, which are
about the paper's own motion.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from typing import Any

from lwr_dyn.arms.papers.fields import Fields, parse_toml
from lwr_dyn.foundation.errors import PaperError

STATISTICS = ("mean", "mean_abs", "max", "min", "rms")


@dataclass(frozen=True, slots=True)
class ControllerChoice:
    """A controller of a task: its row of `lwr_dyn.control.controllers`, and options of that.

    `id` is for claims of the same file; readers see the controller's own label.
    """

    id: str
    controller: str
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class PublishedClaim:
    """A conclusion of a paper: these joints (counted from 0) have the largest errors under a controller."""

    text: str
    where: str
    controller: str
    joints: tuple[int, ...]
    statistic: str
    """One of `STATISTICS`; its absolute value ranks the joints."""


@dataclass(frozen=True, slots=True)
class StudyTask:
    """A task as its file states it; `options` are those of the row of references."""

    robot: str
    name: str
    about: str
    where: str
    reference: str
    options: Mapping[str, Any]
    controllers: tuple[ControllerChoice, ...]
    claims: tuple[PublishedClaim, ...] = ()
    substeps: int = 1
    like: str = ""
    """The task that this one repeats on another motion; empty for a task as its paper sets it."""


def printed_task(robot: str) -> str | None:
    """The name of the first task of a robot that is as its paper sets it, like no other; None if there is none."""
    return next((task.name for task in study_tasks().values() if task.robot == robot and not task.like), None)


def study_tasks() -> dict[str, StudyTask]:
    """All tasks by name, robot by robot; the first of a robot is the one on which its controllers are compared.

    >>> study_tasks()["lspb"].robot
    'wam7'
    """
    folder = resources.files("lwr_dyn.arms.papers").joinpath("tasks")
    tasks: dict[str, StudyTask] = {}
    for file in sorted((f for f in folder.iterdir() if f.name.endswith(".toml")), key=lambda f: f.name):
        for task in parse_tasks(file.read_text(encoding="utf-8"), file.name):
            if task.name in tasks:
                raise PaperError(file.name, "task.name", f"{task.name!r} of {tasks[task.name].robot}", "another name")
            tasks[task.name] = task
    return tasks


def parse_tasks(text: str, file: str) -> tuple[StudyTask, ...]:
    """The tasks of one file's text.

    Raises
    ------
    PaperError
        Broken TOML; a field that is unknown, missing or of another type; a claim about no controller of its task.
    """
    top = Fields(parse_toml(text, file), file, "")
    robot = top.take("robot", str)
    entries = top.take("task", list)
    tasks = tuple(_task(_filled(x, entries, file, i), robot, file, f"task[{i}]") for i, x in enumerate(entries))
    top.refuse_unknown()
    return tasks


def _filled(entry: Any, entries: list[Any], file: str, i: int) -> Any:
    """A task with what it takes from the task that it is like."""
    if not isinstance(entry, dict) or "like" not in entry:
        return entry
    others: dict[Any, dict[str, Any]] = {x.get("name"): x for x in entries if isinstance(x, dict) and "like" not in x}
    if entry["like"] not in others:
        raise PaperError(file, f"task[{i}].like", repr(entry["like"]), f"one of {', '.join(map(str, others))}")
    taken = {key: value for key, value in others[entry["like"]].items() if key != "claim"}
    return {**taken, **entry}


def _task(entry: Any, robot: str, file: str, path: str) -> StudyTask:
    fields = Fields(entry, file, path)
    texts = {key: fields.take(key, str) for key in ("name", "about", "where")}
    options = dict(fields.take("reference", dict))
    reference = options.pop("name", None)
    if not isinstance(reference, str):
        raise PaperError(file, f"{path}.reference.name", repr(reference), "the name of a reference")
    listed = enumerate(fields.take("controllers", list))
    controllers = tuple(_controller(x, file, f"{path}.controllers[{i}]") for i, x in listed)
    ids = [c.id for c in controllers]
    claimed = enumerate(fields.take("claim", list, default=[]))
    claims = tuple(_claim(x, ids, file, f"{path}.claim[{i}]") for i, x in claimed)
    substeps, like = fields.take("substeps", int, default=1), fields.take("like", str, default="")
    fields.refuse_unknown()
    return StudyTask(
        robot, **texts, reference=reference, options=options, controllers=controllers, claims=claims,
        substeps=substeps, like=like,
    )  # fmt: skip


def _controller(entry: Any, file: str, path: str) -> ControllerChoice:
    fields = Fields(entry, file, path)
    own_id, controller = fields.take("id", str), fields.take("controller", str)
    options = fields.take("options", dict, default={})
    fields.refuse_unknown()
    return ControllerChoice(own_id, controller, options)


def _claim(entry: Any, controllers: list[str], file: str, path: str) -> PublishedClaim:
    fields = Fields(entry, file, path)
    text, where = fields.take("text", str), fields.take("where", str)
    controller = fields.take_one_of("controller", controllers)
    joints = fields.take("joints", list)
    if not joints or any(type(j) is not int or j < 1 for j in joints):
        raise PaperError(file, f"{path}.joints", repr(joints), "numbers of joints, counted from 1")
    statistic = fields.take_one_of("statistic", STATISTICS)
    fields.refuse_unknown()
    return PublishedClaim(text, where, controller, tuple(j - 1 for j in joints), statistic)
