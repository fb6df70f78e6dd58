"""The same task under all readings of a robot: every controller simulated on every plant, and what follows."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.sensitivity.closed_loops import ClosedLoopResult, Progress, closed_loops
from lwr_dyn.checks.sensitivity.conclusions import Conclusion, conclusions
from lwr_dyn.checks.sensitivity.simulated_task import SimulatedTask, simulated_task
from lwr_dyn.checks.sensitivity.statics import Statics, statics_of
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.motion_profile import positive_number

POSES = 500
OMEGA_N, XI = 50.0, 1.0
"""[rad/s], 1: of the gains that are compared."""
MOST_POSES = 1_000_000
MOST_ARMS = 8
"""Arms at once: the number of runs grows with the square."""


@dataclass(frozen=True, slots=True, eq=False)
class Sensitivity:
    """What depends on the reading, and what does not."""

    names: tuple[str, ...]
    joints: tuple[str, ...]
    study: SimulatedTask
    rate: float
    poses: int
    statics: Mapping[str, Statics]
    runs: tuple[ClosedLoopResult, ...]
    conclusions: tuple[Conclusion, ...]

    def tip_rms_mm(self, controller: str) -> Array:
        """RMS errors of the tip [mm], a row per model, a column per plant; NaN where a simulation failed."""
        return self._matrix(controller, lambda run: run.tip_rms_mm)

    def worst_mrad(self, controller: str) -> Array:
        """Largest joint errors [mrad], a row per model, a column per plant."""
        return self._matrix(controller, lambda run: run.worst_mrad)

    def _matrix(self, controller: str, figure: Callable[[ClosedLoopResult], float]) -> Array:
        values = {(r.model, r.plant): figure(r) for r in self.runs if r.controller == controller}
        return read_only(np.array([[values[model, plant] for plant in self.names] for model in self.names]))


def sensitivity(
    arms: Mapping[str, Arm],
    task: str | None = None,
    *,
    poses: int = POSES,
    seed: int = 0,
    rate: float = 1000.0,
    progress: Progress | None = None,
) -> Sensitivity:
    """The same task under several readings (or files) of a robot, for every controller and plant.

    Parameters
    ----------
    arms : mapping
        Name -> arm, two to eight; the first sets the reference and is what others are compared with.
    task : str, optional
        A task of `lwr_dyn.checks.sensitivity.study_tasks`, or "joint-move"; that of the first arm's paper if not given.
    poses, seed : int
        How many joint positions the gravity torques are compared at.
    rate : float
        Samples a second of the simulations [Hz].
    progress : callable, optional
        Called with the share of the runs that are done.

    Returns
    -------
    Sensitivity

    Raises
    ------
    OptionError
        Fewer than two arms or more than eight, no poses, no rate, a task that the first arm cannot do.
    ShapeError
        Arms with different numbers of joints.
    UnknownNameError
        No task of that name.
    MissingDataError, PathLimitError
        An arm without inertias, a task beyond the limits of the first arm.
    """
    if not 2 <= len(arms) <= MOST_ARMS:
        raise OptionError("arms", f"{len(arms)}", f"2 to {MOST_ARMS} readings or files")
    if not 1 <= poses <= MOST_POSES:
        raise OptionError("poses", poses, f"from 1 to {MOST_POSES}")
    positive_number("rate", rate)
    first, *others = arms.items()
    for name, arm in others:
        if arm.n != first[1].n:
            raise ShapeError(name, f"{arm.n} joints", f"{first[1].n}, as {first[0]} has")
    for arm in arms.values():
        arm.require_dynamics()
    study = simulated_task(first[1], task)
    statics = statics_of(arms, poses, seed, OMEGA_N, XI)
    runs = tuple(closed_loops(arms, study, statics, rate, progress))
    return Sensitivity(
        names=tuple(arms), joints=first[1].joint_names, study=study, rate=rate, poses=poses, statics=statics,
        runs=runs, conclusions=conclusions(study, runs, statics),
    )  # fmt: skip
