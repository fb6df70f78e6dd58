"""`lwr_dyn.margins`: what sampling, delay and elastic joints leave of a loop's stability, and where it is worst.

The report as a document: shares over the poses, then the worst pose joint by joint.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.design import sampled_stability
from lwr_dyn.design.gain_search import PEAK
from lwr_dyn.design.loop_judgement import LoopCase, unknown_text
from lwr_dyn.design.loop_margins import LoopMargins, LoopStateSpaces, largest_sensitivity, margins_at, state_spaces
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, law_at_rest
from lwr_dyn.design.sampled_stability import SampledStability, climb, joint_box, pose_text, rate_text, wilson_interval
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array, arm_argument, joint_array
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm, caveats_of
from lwr_dyn.model.caveats import ALL, DYNAMICS
from lwr_dyn.model.run import repr_html, short_repr
from lwr_dyn.model.transmission import JointElasticity

LIMIT = PEAK
"""Of |S_ii|, the margin that is asked for if no other is."""

PEAK_POSES = 300
"""Of the poses drawn, so many are judged by |S_ii| too."""

COARSE = 60
"""Frequencies of that search."""

STARTS = 2
"""Poses with the largest |S_ii| from which a worse one is searched."""

BOX, GIVEN = "joint box", "given poses"
"""What the poses are of."""


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

    @property
    def document(self) -> Document:
        """The report for people and programs."""
        return _document(self)

    def record(self) -> dict[str, Any]:
        """The report as JSON values: angles in rad, times in s."""
        return self.document.record()

    def __str__(self) -> str:
        return self.document.text()

    _repr_html_ = repr_html


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
    poses: int = sampled_stability.POSES,
    seed: int = sampled_stability.SEED,
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

    loops: Callable[[Array], RestingLoop] = partial(case.loop, moving, dynamics, law)
    sampling = case.sampling
    if q is None:
        stability = sampled_stability.box_stability(moving, loops, sampling, poses, seed)
        rows = np.random.default_rng(seed).uniform(*joint_box(moving)[:2], (poses, arm.n))[:PEAK_POSES]
    else:
        rows = np.atleast_2d(joint_array("q", q, arm.n))
        stability = sampled_stability.stability_at(loops(rows), sampling, rows)
    peaks = largest_sensitivity(loops(rows), sampling).max(axis=1)
    worst = stability.worst
    if stability.radius <= GROWS:
        worst = _worst_peak(loops, case, rows, peaks, None if q is not None else joint_box(moving)[:2])
    loop = loops(worst[None])
    found = margins_at(loop, sampling, worst)
    joint = int(np.argmax(found.peak)) if found.is_stable else _growing_joint(loop, case, dynamics, worst)
    name = controller if isinstance(controller, str) else str(getattr(law, "name", type(law).__name__))
    return MarginReport(
        arm, name, label_of(law), case, BOX if q is None else GIVEN, stability, limit,
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


def percent(share: float, interval: tuple[float, float]) -> str:
    """A share with its interval at 95 %.

    >>> percent(0.2295, (0.2116, 0.2485))
    '22.9 % (21.2 to 24.9 % at 95 %)'
    """
    return f"{100 * share:.3g} % ({100 * interval[0]:.3g} to {100 * interval[1]:.3g} % at 95 %)"


def _document(report: MarginReport) -> Document:
    """The report."""
    found, worst, case, arm = report.stability, report.worst, report.case, report.arm
    above = report.above / report.peak_poses
    where = GIVEN if report.where == GIVEN else "poses drawn evenly from the joint box"

    def share(count: int, whole: int, interval: tuple[float, float]) -> str:
        return f"{count if report.where == GIVEN else percent(count / whole, interval)} of {whole}"

    facts = [
        Fact("robot", arm.name, "Name of the robot."), Fact("reading", arm.reading, "Its reading.", kind=str),
        Fact("controller", report.controller, "Its name or file."),
        Fact("label", report.label, "The controller and its variant."),
        Fact("case", case.words, "Plant and sampling in words."), Fact("rate", case.rate, "Hz."),
        Fact("delay", case.delay, "Samples."),
        Fact("where", report.where, "What the poses are of.", kind=Literal["joint box", "given poses"]),
        Fact("poses", found.poses, "How many."),
        Fact("unstable", found.unstable, "Poses at which a deviation grows."),
    ]  # fmt: skip
    whole = Section("", [
        Note("linear and at rest: without speeds, friction, torque limits and stops"),
        Fact("unstable_share", found.share, "Of the poses.", "unstable",
             format=lambda _: f"{share(found.unstable, found.poses, found.interval)} {where}"),
        Fact("unstable_share_interval", found.interval, "Of the whole box, at 95 % (Wilson)."),
        Fact("least_rate_hz", found.least_rate,
             "From this rate on no pose looked at is unstable; null where none does it.", "stable from", "",
             rate_text, float),
        Note(f"{rate_text(None)} makes it stable", found.least_rate is None),
        Fact("limit", report.limit, "Of |S_ii|."),
        Fact("above_limit_poses", report.peak_poses, "Poses at which |S_ii| was computed."),
        Fact("above_limit_share", above, "Of these, with |S_ii| above the limit.", f"|S_ii| above {report.limit:g}",
             format=lambda _: f"{share(report.above, report.peak_poses, report.above_interval)} of them"),
        Fact("above_limit_interval", report.above_interval, "Of the whole box, at 95 % (Wilson)."),
        Fact("holds", report.holds, "Whether |S_ii| keeps the limit wherever it was looked at."),
        Fact("worst_q", worst.q, "Where deviations grow fastest, else where |S_ii| is largest; rad (m for sliding "
             "joints).", "worst pose", format=lambda q: pose_text(q, arm)),
        Fact("worst_joint", report.worst_joint, "The joint that moves most there, or whose |S_ii| is largest.",
             "worst joint"),
        Fact("unknown_limits", list(found.unknown_limits),
             "Joints without limits, taken as half a turn to both sides.", kind=list[str]),
        Note(unknown_text(found, arm), bool(found.unknown_limits)),
        Note(report.notes, key="notes", says="What was left out or assumed.", before="note: "),
    ])  # fmt: skip
    detail = Section(
        "The worst pose",
        _worst(report),
        "worst",
        "The margins at the worst pose; null where the loop is unstable there, or past what was tried.",
    )
    title = f"{arm.name}, reading {arm.reading}: {report.label}; {case.words}"
    return Document(title, "", [whole, detail], "lwr-dyn margins", "margins", facts, _caveats(report))


def _caveats(report: MarginReport) -> tuple[str, ...]:
    return caveats_of([report.arm], DYNAMICS if report.case.elasticity is None else ALL)


def _worst(report: MarginReport) -> list[Fact | Note | Table]:
    worst, stable = report.worst, report.worst.is_stable
    swing = abs(float(np.angle(worst.poles[0]))) * report.case.rate / (2 * np.pi)
    maybe = list[float] | None
    columns = (
        Heading("joint", key=None), Heading("max |S_ii|", "", ".3f", "peak", "max |S_ii| of each joint.", maybe),
        Heading("at", "Hz", ".3g", "peak_hz", "Where it is, Hz.", maybe),
        Heading("gain up to", "", _factor, "gain_up", "Factor that the torque of a joint bears; null past 1000."),
        Heading("gain down to", "", _factor, "gain_down", "And down to which; 0 below a thousandth."),
    )  # fmt: skip
    peaks = (worst.peak, worst.peak_hz) if stable else [(None,) * report.arm.n] * 2
    rows = zip(report.arm.joint_names, *peaks, worst.gain_up, worst.gain_down, strict=True)
    return [
        Fact("q", worst.q, "The pose, rad (m for sliding joints)."),
        Fact("radius", worst.radius, "Spectral radius of the step from sample to sample.",
             "largest factor of a deviation from sample to sample", format=".4g"),
        Fact("stable", stable, "Whether none grows."),
        Fact(None, None if stable else swing, "Half the rate: it changes its sign at each sample.",
             "unstable, no margins there; the fastest deviation swings at", "Hz", ".3g"),
        Fact("poles", np.column_stack([worst.poles.real, worst.poles.imag]),
             "Eigenvalues of that step: real and imaginary part, the largest first."),
        Table("", columns, [*rows], columnwise=True, when=stable),
        Fact("all_up", worst.all_up, "The same for the torques of all joints.", "gain of all torques together, up to",
             "", _factor),
        Fact("all_down", worst.all_down, "And down to which.", "gain of all torques together, down to", "",
             _factor),
        Fact("delay_margin", worst.delay_margin, "s.", "delay of all torques together, up to", "", _later),
    ]  # fmt: skip


def _factor(value: float) -> str:
    """A gain margin; past what was tried it is said to be so."""
    if np.isnan(value):
        return ""
    return "over 1000" if np.isinf(value) else "under 0.001" if value == 0.0 else f"{value:.3g}"


def _later(seconds: float) -> str:
    return "" if np.isnan(seconds) else "more than was tried" if np.isinf(seconds) else f"{1e3 * seconds:.3g} ms"
