"""A study task with the joint reference that an arm follows in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.arrays import Array, fixed_array
from lwr_dyn.errors import OptionError, UnknownNameError
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference
from lwr_dyn.papers.study_tasks import ControllerChoice, StudyTask, study_tasks
from lwr_dyn.trajectory.references.ist import ist_reference
from lwr_dyn.trajectory.references.lspb_move import lspb_move
from lwr_dyn.trajectory.references.point_to_point import point_to_point

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
        ControllerChoice("PD + gravity", "pd-gravity"),
        ControllerChoice("inverse dynamics", "inverse-dynamics"),
    ),
)


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedTask:
    """A task and the reference of its joints; the claims of a paper stay with the paper's own robot."""

    task: StudyTask
    reference: Reference


def simulated_task(arm: Arm, name: str | None = None) -> SimulatedTask:
    """A task by name for an arm; if not given the first that the arm's paper sets, else a joint move.

    Raises
    ------
    UnknownNameError
        No task of that name.
    OptionError, PathLimitError, MissingDataError
        The arm cannot do it.
    PaperError
        The task's file gives an option that its reference does not have, or lacks one.
    """
    tasks = study_tasks() | {JOINT_MOVE.name: JOINT_MOVE}
    own = next((task.name for task in tasks.values() if task.robot == arm.name), JOINT_MOVE.name)
    if (name or own) not in tasks:
        raise UnknownNameError("task", str(name), tasks)
    task = tasks[name or own]
    if task.reference not in REFERENCES:
        raise UnknownNameError(f"reference of task {task.name}", task.reference, REFERENCES)
    reference = REFERENCES[task.reference](arm, task)
    controllers = {c.name: _with_known_gains(c, arm) for c in task.controllers}
    own_claims = task.claims if task.robot == arm.name else ()
    claims = tuple(replace(claim, controller=controllers[claim.controller].name) for claim in own_claims)
    return SimulatedTask(replace(task, claims=claims, controllers=tuple(controllers.values())), reference)


def _with_known_gains(choice: ControllerChoice, arm: Arm) -> ControllerChoice:
    """Gains of the file only where the arm's file has some; the name says so."""
    if not choice.file_gains or arm.gains is None:
        return replace(choice, file_gains=False)
    return replace(choice, name=f"{choice.name}, the maker's gains")


def _ist(arm: Arm, task: StudyTask) -> Reference:
    fields = task.fields()
    timing = fields.take("timing", str)
    fields.refuse_unknown()
    return ist_reference(arm, timing)


def _lspb(arm: Arm, task: StudyTask) -> Reference:
    """All joints at once, by the same angle."""
    fields = task.fields()
    start, travel = fields.take("start", list), fields.take("travel", float)
    duration, blend = fields.take("duration", float), fields.take("blend", float)
    fields.refuse_unknown()
    if arm.n != len(start):
        raise OptionError(f"task {task.name}", f"{arm.n} joints", f"an arm of {len(start)} joints")
    q = fixed_array("start", start, (arm.n,))
    return lspb_move(arm, q, q + travel, duration=duration, blend=blend)


def _mastering_cycle(arm: Arm, task: StudyTask) -> Reference:
    """From the mastering position through points of the flange, which is not turned, and back; quintics."""
    fields = task.fields()
    points_mm, leg = fields.take("points_mm", list), fields.take("leg", float)
    fields.refuse_unknown()
    if not arm.mastering:
        raise OptionError(f"task {task.name}", f"{arm.name} has no mastering position", "an arm whose file gives one")
    home = np.array(arm.mastering)
    waypoints = [home]
    for point in points_mm:
        T = np.eye(4)
        T[:3, 3] = fixed_array("points_mm", point, (3,)) / 1e3
        waypoints.append(_nearest(arm, T, waypoints[-1], task.name))
    return point_to_point(arm, np.array([*waypoints, home]), [leg] * len(waypoints))


def _nearest(arm: Arm, T: Array, q: Array, task: str) -> Array:
    """The solution nearest to the joints before; raises `OptionError` when there is none."""
    solutions = inverse_kinematics(arm, T).solutions
    if not solutions:
        raise OptionError(f"task {task}", f"{arm.name} does not reach {T[:3, 3].round(3)}", "an arm that does")
    return min((s.q for s in solutions), key=lambda s: float(np.abs(s - q).max()))


def _joint_move(arm: Arm, _: StudyTask) -> Reference:
    """Every joint there and back about the middle of its range."""
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    middle, half = (lower + upper) / 2, RANGE_SHARE * (upper - lower) / 2
    return point_to_point(arm, np.array([middle - half, middle + half, middle - half]), [JOINT_LEG, JOINT_LEG])


REFERENCES: dict[str, Callable[[Arm, StudyTask], Reference]] = {
    "ist": _ist,
    "lspb": _lspb,
    "mastering-cycle": _mastering_cycle,
    "joint-move": _joint_move,
}
"""Reference of a task -> what builds it from the task's options."""
