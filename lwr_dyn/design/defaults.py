"""What a loop gets where nothing is asked for: a task, a law; each with a line that says what was chosen and why.

The task is `ist` for an arm that can follow it within its limits, and else `move`. The law is the first of `LAWS` whose
sampled loop is stable at rest at the poses of the task, by its poles at the rate that is given.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.control.protocol import Controller
from lwr_dyn.design.loop_judgement import LoopCase
from lwr_dyn.design.sampled_loop import RestingLoop, Sampling
from lwr_dyn.design.sampled_stability import SampledStability, pose_text, rate_text, stability_at, unstable_at
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError, OptionError, OutOfReachError, PathLimitError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference
from lwr_dyn.trajectory.references.chosen_move import limit_use
from lwr_dyn.trajectory.references.references import REFERENCES

TASKS = ("ist", "move")
"""Tasks that are tried for an arm, in this order; the last one is for all arms."""

LAWS = ("pd-gravity", "inverse-dynamics")
"""Laws that are tried, in this order."""

PLACES = 200
"""Poses of a task, evenly in time, at which the poles of a loop are looked at."""


@dataclass(frozen=True, slots=True)
class UsualTask:
    """The name of a task, its reference, and in words why it is not the first of `TASKS`; empty where it is."""

    name: str
    reference: Reference
    words: str = ""


@dataclass(frozen=True, slots=True)
class UsualLaw:
    """The name of a law, the law, and in words why it is not the first that was tried; empty where it is."""

    name: str
    controller: Controller
    words: str = ""


def usual_task(arm: Arm) -> UsualTask:
    """The task of an arm for which none is asked.

    Raises as the last of `TASKS`, `chosen_move`: `OptionError`, whose words name what is in the way.

    >>> import lwr_dyn
    >>> usual_task(lwr_dyn.load("lwr4plus")).name, usual_task(lwr_dyn.load("kr30ha")).name
    ('ist', 'move')
    """
    *others, last = TASKS
    for name in others:
        try:
            reference = REFERENCES.make(name, arm)
        except (OptionError, OutOfReachError, PathLimitError):
            continue
        if limit_use(arm, reference, None if arm.chain.bodies is None else dynamics_of(arm)).fits:
            return UsualTask(name, reference)
    reference = REFERENCES.make(last, arm)
    return UsualTask(last, reference, move_words(arm, reference))


def move_words(arm: Arm, reference: Reference) -> str:
    """A chosen move in one line: its ends, its duration, and what it takes of the arm's limits."""
    ends = [pose_text(q, arm) for q in reference.sample(np.array([0.0, reference.duration])).q]
    uses = limit_use(arm, reference, None if arm.chain.bodies is None else dynamics_of(arm))
    named = (("speed", uses.speed), ("torque", uses.torque))
    known = [f"{100 * use:.0f} % of a {name} limit" for name, use in named if use is not None]
    unknown = [name for name, use in named if use is None]
    parts = [f"at most {' and '.join(known)}"] if known else []
    parts += [f"{' and '.join(unknown)} limits unknown"] if unknown else []
    about = f"{ends[0]} to {ends[1]} in {reference.duration:g} s; {'; '.join(parts)}"
    return f"task: point-to-point, chosen for this arm (--task move): {about}"


def usual_law(
    arm: Arm,
    dynamics: Dynamics,
    make: Callable[[str], Controller],
    reference: Reference,
    rate: float,
    laws: Sequence[str] = LAWS,
) -> UsualLaw:
    """The first law whose loop is stable; where none is, the first that can be made.

    Parameters
    ----------
    arm, dynamics
        The model of the controller, which is taken for the plant too: rigid, without delay.
    make : callable
        Name -> controller; what it raises as `MissingDataError` passes to the next law.
    reference : Reference
        Its poses are looked at.
    rate : float
        [Hz]

    Raises
    ------
    MissingDataError
        No law can be made: that of the last one.
    """
    made, why = [], []
    for name in laws:
        try:
            made.append(UsualLaw(name, make(name)))
        except MissingDataError as fault:
            if name == laws[-1] and not made:
                raise
            why.append(f"{name} cannot be made ({fault})")
            continue
        found = law_fault(arm, dynamics, made[-1].controller, reference, rate)
        if found is None:
            words = f"controller: {name}, chosen for this arm: {'; '.join(why)}" if why else ""
            return replace(made[-1], words=words)
        why.append(f"at {rate:g} Hz {name} {unstable_words(found)}")
    return made[0]


def law_stability(
    arm: Arm, dynamics: Dynamics, controller: Controller, reference: Reference, rate: float, delay: int = 0
) -> SampledStability | None:
    """The sampled loop of a rigid arm at rest at poses of a reference; None for a law that hides a memory."""
    return _judged(stability_at, LoopCase(rate, delay), arm, dynamics, controller, reference)


def law_fault(
    arm: Arm, dynamics: Dynamics, controller: Controller, reference: Reference, rate: float
) -> SampledStability | None:
    """`law_stability` of a law whose loop is unstable; None where it holds, and for a law that hides a memory."""
    return _judged(unstable_at, LoopCase(rate), arm, dynamics, controller, reference)


def _judged(
    judge: Callable[[RestingLoop, Sampling, Array], SampledStability | None],
    case: LoopCase,
    arm: Arm,
    dynamics: Dynamics,
    controller: Controller,
    reference: Reference,
) -> SampledStability | None:
    poses = np.asarray(reference.sample(np.linspace(0.0, reference.duration, PLACES)).q)
    try:
        return judge(case.loop(arm, dynamics, controller, poses), case.sampling, poses)
    except OptionError:
        return None


def unstable_words(found: SampledStability) -> str:
    """At how many poses of a task a loop is unstable, and from which rate on it holds."""
    where = f"{found.unstable} of {found.poses} poses of this task"
    least = f"{rate_text(found.least_rate)}{' on' if found.least_rate is not None else ''}"
    holds = f"it is stable from {least}" if found.least_rate is not None else f"{least} makes it stable"
    return f"is unstable at rest at {where} ({holds})"
