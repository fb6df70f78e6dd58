"""A study task with the joint reference that an arm follows in it, and its controllers by their labels."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.checks.sensitivity.study_tasks import ControllerChoice, StudyTask, study_tasks
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference
from lwr_dyn.trajectory.references.joint_moves import lspb_move, point_to_point
from lwr_dyn.trajectory.references.tasks import REFERENCES

RANGE_SHARE = 0.1
"""A joint move covers this share of the joints' ranges, about the middle."""
JOINT_LEG = 2.0
"""[s] of each leg of a joint move."""
JOINT_MOVE = StudyTask(
    robot="",
    name="joint-move",
    about=f"every joint over {RANGE_SHARE:.0%} of its range about the middle and back, quintics of {JOINT_LEG:g} s",
    where="for arms to which no paper sets a task",
    reference="joint-move",
    options={},
    controllers=(
        ControllerChoice("PD", "pd-gravity"),
        ControllerChoice("inverse dynamics", "inverse-dynamics"),
    ),
)


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

    Raises
    ------
    UnknownNameError
        No task of that name.
    OptionError, PathLimitError, MissingDataError
        The arm cannot do it; the task's file gives an option that its reference does not have, or lacks one.
    """
    tasks = study_tasks() | {JOINT_MOVE.name: JOINT_MOVE}
    own = next((task.name for task in tasks.values() if task.robot == arm.name), JOINT_MOVE.name)
    if (name or own) not in tasks:
        raise UnknownNameError("task", str(name), tasks)
    task = tasks[name or own]
    registry = OWN_REFERENCES if task.reference in OWN_REFERENCES.rows else REFERENCES
    reference = registry.make(task.reference, arm, **task.options)
    controllers = tuple(_with_known_gains(choice, arm) for choice in task.controllers)
    claims = task.claims if task.robot == arm.name else ()
    labels = {choice.id: label_of(controller_of(arm, choice, np.ones(arm.n))) for choice in controllers}
    return SimulatedTask(replace(task, claims=claims, controllers=controllers), reference, labels)


def controller_of(arm: Arm, choice: ControllerChoice, b: Array) -> Controller:
    """The controller of a choice for an arm whose largest inertias `b` (n,) [kg m^2] are known."""
    known: dict[str, Any] = {"inertia": b} if choice.controller == "pd-gravity" else {}
    return make_controller(choice.controller, arm, **choice.options, **known)


def _with_known_gains(choice: ControllerChoice, arm: Arm) -> ControllerChoice:
    """The gains of the arm's file only where it has some."""
    if arm.gains is not None:
        return choice
    return replace(choice, options={k: v for k, v in choice.options.items() if k != "own_gains"})


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
