"""The spread: one task, all readings, controllers on one and plants on another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.arrays import Array, read_only
from lwr_dyn.audit.sensitivity.conclusions import Conclusion, conclusions
from lwr_dyn.audit.sensitivity.jobs import Job, job_of
from lwr_dyn.audit.sensitivity.pairs import Outcome, Progress, outcomes
from lwr_dyn.audit.sensitivity.statics import Statics, statics_of
from lwr_dyn.errors import OptionError, ShapeError
from lwr_dyn.model.arm import Arm
from lwr_dyn.trajectory.laws import positive

POSES = 500
OMEGA_N, XI = 50.0, 1.0
"""Of the gains that are compared: the LWR 4+ paper's."""
MOST_POSES = 1_000_000
MOST = 8
"""Arms at once: the runs grow with the square."""


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """What depends on the reading, and what does not."""

    names: tuple[str, ...]
    joints: tuple[str, ...]
    job: Job
    rate: float
    poses: int
    statics: Mapping[str, Statics]
    outcomes: tuple[Outcome, ...]
    conclusions: tuple[Conclusion, ...]

    def tip_rms_mm(self, law: str) -> Array:
        """RMS errors of the tip [mm], rows believed, columns real; NaN where a run came to nothing."""
        return self._matrix(law, lambda run: run.tip_rms_mm)

    def worst_mrad(self, law: str) -> Array:
        """Largest joint errors [mrad], rows believed, columns real."""
        return self._matrix(law, lambda run: run.worst_mrad)

    def _matrix(self, law: str, figure: Any) -> Array:
        found = {(o.believed, o.real): figure(o) for o in self.outcomes if o.law == law}
        return read_only(np.array([[found[b, r] for r in self.names] for b in self.names]))


def spread(
    arms: Mapping[str, Arm],
    task: str | None = None,
    *,
    poses: int = POSES,
    seed: int = 0,
    rate: float = 1000.0,
    progress: Progress | None = None,
) -> Spread:
    """The same task under several readings (or files) of a robot, for every controller and plant.

    Parameters
    ----------
    arms : mapping
        Name -> arm, two to eight; the first sets the reference and is what others are compared with.
    task : {"ist", "lspb", "two-points", "joint-move"}, optional
        The one that the first arm's paper sets it, if not given.
    poses, seed : int
        How many joint positions the gravity torques are compared at.
    rate : float
        Samples a second of the simulations [Hz].
    progress : callable, optional
        Called with the share of the runs that are done.

    Returns
    -------
    Spread

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
    if not 2 <= len(arms) <= MOST:
        raise OptionError("arms", f"{len(arms)}", f"2 to {MOST} readings or files")
    if not 1 <= poses <= MOST_POSES:
        raise OptionError("poses", poses, f"from 1 to {MOST_POSES}")
    positive("rate", rate)
    first, *others = arms.items()
    for name, arm in others:
        if arm.n != first[1].n:
            raise ShapeError(name, f"{arm.n} joints", f"{first[1].n}, as {first[0]} has")
    for arm in arms.values():
        arm.require_dynamics()
    job = job_of(first[1], task)
    statics = statics_of(arms, poses, seed, OMEGA_N, XI)
    runs = tuple(outcomes(arms, job, statics, rate, progress))
    return Spread(
        names=tuple(arms), joints=first[1].joint_names, job=job, rate=rate, poses=poses, statics=statics,
        outcomes=runs, conclusions=conclusions(job, runs, statics),
    )  # fmt: skip
