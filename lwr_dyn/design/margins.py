"""`lwr_dyn.margins`: what sampling, delay and elastic joints leave of a loop's stability, and where it is worst."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.design.gain_search import PEAK
from lwr_dyn.design.joint_box import climb, joint_box, wilson_interval
from lwr_dyn.design.law_differences import law_at_rest
from lwr_dyn.design.loop_case import LoopCase
from lwr_dyn.design.loop_margins import LoopMargins, margins_at
from lwr_dyn.design.loop_response import largest_sensitivity
from lwr_dyn.design.margins_text import margins_text
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop
from lwr_dyn.design.sampled_stability import POSES, SEED, SampledStability, box_stability, stability_at
from lwr_dyn.design.state_spaces import LoopStateSpaces, state_spaces
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array, arm_argument, joint_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.elasticity import JointElasticity
from lwr_dyn.model.shown import short_repr

LIMIT = PEAK
"""Of |S_ii|, the margin that is asked for if no other is."""
PEAK_POSES = 300
"""Of the poses drawn, so many are judged by |S_ii| too."""
COARSE = 60
"""Frequencies of that search."""
STARTS = 2
"""Poses with the largest |S_ii| from which a worse one is searched."""


@dataclass(frozen=True, slots=True, eq=False)
class MarginReport:
    """The margins of a loop over poses, and in detail at the worst one.

    The worst pose is the one where deviations grow fastest, if any do; else the one with the largest |S_ii|.
    """

    arm: Arm
    controller: str
    label: str
    case: LoopCase
    where: str
    stability: SampledStability
    limit: float
    above: int
    """Poses of `peak_poses` at which |S_ii| passes `limit`, unstable ones among them."""
    peak_poses: int
    worst: LoopMargins
    joint: int
    """0-based: of the growing motion the joint with the largest energy; else the one with the largest |S_ii|."""
    loop: RestingLoop
    """The linear loop at the worst pose, for `state_spaces` and figures."""
    loops: Callable[[Array], RestingLoop]
    notes: tuple[str, ...] = ()
    __repr__ = short_repr

    @property
    def holds(self) -> bool:
        """Whether |S_ii| stays within `limit` at every pose that was looked at."""
        return self.above == 0 and self.stability.holds and float(self.worst.peak.max()) <= self.limit

    @property
    def worst_joint(self) -> str:
        """Name of the worst joint."""
        return self.arm.joint_names[self.joint]

    @property
    def above_interval(self) -> tuple[float, float]:
        """Of the share of poses at which |S_ii| passes `limit`, at 95 %."""
        return wilson_interval(self.above, self.peak_poses)

    def state_spaces(self) -> LoopStateSpaces:
        """The loop at the worst pose for python-control; raises `MissingPackageError` without the extra `design`."""
        return state_spaces(self.loop, self.case.sampling, self.arm.joint_names)

    def record(self) -> dict[str, Any]:
        """The report as JSON values: angles in rad, times in s."""
        found = self.stability
        return {
            "robot": self.arm.name, "reading": self.arm.reading, "controller": self.controller, "label": self.label,
            "case": self.case.words, "rate": self.case.rate, "delay": self.case.delay, "where": self.where,
            "poses": found.poses, "unstable": found.unstable, "unstable_share": found.share,
            "unstable_share_interval": found.interval, "least_rate_hz": found.least_rate,
            "limit": self.limit, "above_limit_poses": self.peak_poses,
            "above_limit_share": self.above / self.peak_poses, "above_limit_interval": self.above_interval,
            "holds": self.holds,
            "worst_q": self.worst.q, "worst_joint": self.worst_joint, "worst": self.worst.to_json(),
            "unknown_limits": list(found.unknown_limits), "notes": list(self.notes),
        }  # fmt: skip

    def __str__(self) -> str:
        return margins_text(self)


def margins(
    arm: Arm,
    controller: str | Controller = "pd-gravity",
    *,
    q: ArrayLike | None = None,
    rate: float = 1000.0,
    delay: int = 0,
    cutoff_hz: float | None = None,
    elasticity: JointElasticity | str | float | None = None,
    encoders: str = "motor",
    plant: Arm | None = None,
    limit: float = LIMIT,
    poses: int = POSES,
    seed: int = SEED,
    engine: str | Dynamics = "pinocchio",
    **options: Any,
) -> MarginReport:
    """The sampled loop of an arm near rest: share of unstable poses, least rate, ``|S_ii|``, gain and delay margins.

    The plant is linearised at each pose and held exactly over a sample, with delay, velocity filter and elastic joints.
    Speeds, friction, torque limits and stops are left out.

    Parameters
    ----------
    arm : Arm
        As the controller knows it.
    controller : str or Controller
        A name as of `lwr_dyn.controller`, a .py file, or the controller itself. One without `linear_feedback(q)` and
        without memory is linearised by differences, which the report's notes say.
    q : (n,) or (k, n) array_like, optional
        Poses [rad or m], such as `reference.sample(t).q`; the joint box of the arm if not given.
    rate, delay, cutoff_hz, elasticity, encoders
        See `LoopCase`.
    plant : Arm, optional
        The arm that moves, such as one with a payload; `arm` if not given.
    limit : float
        Of ``|S_ii|``, above 1.
    poses, seed : int
        Number of poses drawn evenly from the joint box, and the seed of the drawing.
    engine : str or Dynamics
        Of the controller's model, and of the plant by name.
    options
        Of the controller, by name only, such as omega_n.

    Raises
    ------
    OptionError, ShapeError, MissingDataError, UnknownNameError, FileAccessError
        What cannot be: see `LoopCase`, `law_at_rest` and `make_controller`.

    >>> import lwr_dyn
    >>> found = margins(lwr_dyn.load("lwr4plus"), "inverse-dynamics", q=[0, 0.5, 0, -1, 0, 0.5, 0], delay=1)
    >>> found.stability.share, found.worst.peak.max().round(2)
    (0.0, np.float64(1.15))
    """
    arm_argument(arm)
    if not (np.isfinite(limit) and limit > 1.0):
        raise OptionError("limit of |S_ii|", limit, "a number above 1")
    if not (isinstance(poses, int) and poses > 0):
        raise OptionError("poses", poses, "a whole number above 0")
    case = LoopCase(rate, delay, cutoff_hz, elasticity, encoders)
    moving = arm if plant is None else plant
    model = dynamics_of(arm, engine) if isinstance(engine, str) else engine
    dynamics = model if plant is None else dynamics_of(plant, engine if isinstance(engine, str) else "pinocchio")
    law = make_controller(controller, arm, model, **options) if isinstance(controller, str) else controller

    def loops(x: Array) -> RestingLoop:
        return case.loop(moving, dynamics, law, x)

    sampling = case.sampling
    if q is None:
        stability = box_stability(moving, loops, sampling, poses, seed)
        rows = np.random.default_rng(seed).uniform(*joint_box(moving)[:2], (poses, arm.n))[:PEAK_POSES]
    else:
        rows = np.atleast_2d(joint_array("q", q, arm.n))
        stability = stability_at(loops(rows), sampling, rows)
    peaks = largest_sensitivity(loops(rows), sampling).max(axis=1)
    worst = stability.worst
    if stability.radius <= GROWS:
        worst = _worst_peak(loops, case, rows, peaks, None if q is not None else joint_box(moving)[:2])
    loop = loops(worst[None])
    found = margins_at(loop, sampling, worst)
    joint = int(np.argmax(found.peak)) if found.is_stable else _growing_joint(loop, case, dynamics, worst)
    name = controller if isinstance(controller, str) else str(getattr(law, "name", type(law).__name__))
    return MarginReport(
        arm, name, label_of(law), case, "joint box" if q is None else "given poses", stability, limit,
        int((peaks > limit).sum()), len(rows), found, joint, loop, loops, law_at_rest(law, worst[None]).notes,
    )  # fmt: skip


def _worst_peak(
    loops: Callable[[Array], RestingLoop], case: LoopCase, rows: Array, peaks: Array, box: tuple[Array, Array] | None
) -> Array:
    """The pose with the largest |S_ii| among the rows, or uphill from there inside the box."""

    def height(x: Array) -> Array:
        return np.asarray(largest_sensitivity(loops(x), case.sampling, COARSE).max(axis=1))

    best = np.argsort(-peaks, kind="stable")[:STARTS]
    ends = [] if box is None else [climb(height, rows[i], *box) for i in best]
    found = np.array([*ends, rows[best[0]]])
    return np.asarray(found[int(np.argmax(height(found)))])


def _growing_joint(loop: RestingLoop, case: LoopCase, dynamics: Dynamics, q: Array) -> int:
    """The joint that has most of the kinetic energy of the motion that grows fastest."""
    values, vectors = np.linalg.eig(loop.step_matrices(case.sampling)[0])
    fastest = vectors[: loop.plant.size, int(np.argmax(np.abs(values)))]
    speeds = np.abs(loop.plant.velocity @ fastest)
    return int(np.argmax(np.diag(dynamics.mass_matrix(q)) * speeds**2))
