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

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError, PaperError, UnknownNameError
from lwr_dyn.foundation.fields import Fields, parse_toml
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference
from lwr_dyn.trajectory.references.joint_moves import lspb_move, point_to_point
from lwr_dyn.trajectory.references.references import REFERENCES

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

    Raises `PaperError` for broken TOML, a field that is unknown, missing or of another type, and a claim about no
    controller of its task.
    """
    top = Fields(parse_toml(text, file), file)
    robot = top.text("robot")
    entries = top.take("task", list)
    tasks = tuple(_task(Fields(_filled(x, entries, file, i), file, f"task[{i}]"), robot) for i, x in enumerate(entries))
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


def _task(fields: Fields, robot: str) -> StudyTask:
    texts = {key: fields.text(key) for key in ("name", "about", "where")}
    options = dict(fields.take("reference", dict))
    reference = options.pop("name", None)
    if not isinstance(reference, str):
        raise fields.refuse("reference.name", repr(reference), "the name of a reference")
    controllers = tuple(map(_controller, fields.tables("controllers")))
    ids = [c.id for c in controllers]
    claims = tuple(_claim(x, ids) for x in fields.tables("claim", default=[]))
    substeps, like = fields.take("substeps", int, default=1), fields.text("like", default="")
    fields.refuse_unknown()
    return StudyTask(
        robot, **texts, reference=reference, options=options, controllers=controllers, claims=claims,
        substeps=substeps, like=like,
    )  # fmt: skip


def _controller(fields: Fields) -> ControllerChoice:
    choice = ControllerChoice(fields.text("id"), fields.text("controller"), fields.take("options", dict, default={}))
    fields.refuse_unknown()
    return choice


def _claim(fields: Fields, controllers: list[str]) -> PublishedClaim:
    text, where, controller = fields.text("text"), fields.text("where"), fields.choice("controller", controllers)
    joints = fields.take("joints", list)
    if not joints or any(type(j) is not int or j < 1 for j in joints):
        raise fields.refuse("joints", repr(joints), "numbers of joints, counted from 1")
    statistic = fields.choice("statistic", STATISTICS)
    fields.refuse_unknown()
    return PublishedClaim(text, where, controller, tuple(j - 1 for j in joints), statistic)


RANGE_SHARE = 0.1
"""A joint move covers this share of the joints' ranges, about the middle."""
JOINT_LEG = 2.0
"""[s] of each leg of a joint move."""

JOINT_MOVE = StudyTask(
    robot="", name="joint-move", where="for arms to which no paper sets a task", reference="joint-move", options={},
    about=f"every joint over {RANGE_SHARE:.0%} of its range about the middle and back, quintics of {JOINT_LEG:g} s",
    controllers=(ControllerChoice("PD", "pd-gravity"), ControllerChoice("inverse dynamics", "inverse-dynamics")),
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedTask:
    """A task, the reference of its joints, and the labels of its controllers by their ids.

    The claims of a paper stay with the paper's own robot.
    """

    task: StudyTask
    reference: Reference
    labels: Mapping[str, str]


def simulated_task(arm: Arm, name: str | None = None) -> SimulatedTask:
    """A task by name for an arm; if not given the first that the arm's paper sets, else a joint move.

    Raises `UnknownNameError`; `OptionError`, `PathLimitError` or `MissingDataError` where the arm cannot do it, or the
    task's file gives an option that its reference does not have, or lacks one.
    """
    tasks = study_tasks() | {JOINT_MOVE.name: JOINT_MOVE}
    own = next((task.name for task in tasks.values() if task.robot == arm.name), JOINT_MOVE.name)
    if (name or own) not in tasks:
        raise UnknownNameError("task", str(name), tasks)
    task = tasks[name or own]
    registry = OWN_REFERENCES if task.reference in OWN_REFERENCES.rows else REFERENCES
    reference = registry.make(task.reference, arm, **task.options)
    controllers = task.controllers
    if arm.gains is None:  # the gains of the arm's file are used only where it has some
        unknown = [{k: v for k, v in choice.options.items() if k != "own_gains"} for choice in controllers]
        controllers = tuple(replace(c, options=left) for c, left in zip(controllers, unknown, strict=True))
    claims = task.claims if task.robot == arm.name else ()
    labels = {choice.id: label_of(controller_of(arm, choice, np.ones(arm.n))) for choice in controllers}
    return SimulatedTask(replace(task, claims=claims, controllers=controllers), reference, labels)


def controller_of(arm: Arm, choice: ControllerChoice, b: Array) -> Controller:
    """The controller of a choice for an arm whose largest inertias `b` (n,) [kg m^2] are known."""
    known: dict[str, Any] = {"inertia": b} if choice.controller == "pd-gravity" else {}
    return make_controller(choice.controller, arm, **choice.options, **known)


def lspb_travel(arm: Arm, start: ArrayLike, travel: float, duration: float, blend: float) -> Reference:
    """All joints at once from `start` (n,) by the same `travel` [rad], in `duration` [s] on an LSPB."""
    q = np.array(start)
    if q.shape != (arm.n,):
        raise OptionError("task", f"{arm.name} has {arm.n} joints", f"an arm of {len(q)} joints")
    return lspb_move(arm, q, q + travel, duration=duration, blend=blend)


def mastering_cycle(arm: Arm, points_mm: ArrayLike, leg: float) -> Reference:
    """From the mastering position through points of the flange, which is not turned, and back; `leg` [s] each."""
    if not arm.mastering:
        raise OptionError("task", f"{arm.name} has no mastering position", "an arm whose file gives one")
    waypoints = [np.array(arm.mastering)]
    for point in np.asarray(points_mm) / 1e3:
        T = np.eye(4)
        T[:3, 3] = point
        waypoints.append(_nearest(arm, T, waypoints[-1]))
    return point_to_point(arm, np.array([*waypoints, waypoints[0]]), [leg] * len(waypoints))


def _nearest(arm: Arm, T: Array, q: Array) -> Array:
    """The solution nearest to the joints before; raises `OptionError` when there is none."""
    solutions = inverse_kinematics(arm, T).solutions
    if not solutions:
        raise OptionError("task", f"{arm.name} does not reach {T[:3, 3].round(3)}", "an arm that does")
    return min((s.q for s in solutions), key=lambda s: float(np.abs(s - q).max()))


def joint_move(arm: Arm) -> Reference:
    """Every joint there and back about the middle of its range."""
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    middle, half = (lower + upper) / 2, RANGE_SHARE * (upper - lower) / 2
    return point_to_point(arm, np.array([middle - half, middle + half, middle - half]), [JOINT_LEG, JOINT_LEG])


OWN_REFERENCES: Registry[Callable[..., Reference]] = Registry(
    "reference",
    {
        "lspb-travel": Row(f"{__name__}:lspb_travel", "all joints by the same angle on an LSPB"),
        "mastering-cycle": Row(f"{__name__}:mastering_cycle", "mastering position, points of the flange, and back"),
        "joint-move": Row(f"{__name__}:joint_move", "every joint there and back about the middle of its range"),
    },
)
"""References of study tasks beside those of `lwr_dyn.trajectory.references`."""
