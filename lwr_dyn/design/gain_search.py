"""The largest natural frequency omega_n with which a law keeps a stated margin, over poses and over several plants.

The margin is max |S_ii| over frequency, joints, poses and plants. It does not grow steadily with omega_n: a law that
adds g(q) feeds positions back positively, and low gains lift |S_ii| again. So the search comes from above: down in
steps of `STEP` to the first omega_n that keeps the margin, then bisection between it and the one above.

For the command `gains` stand here the largest omega_n of each controller, rigid and elastic, and the largest inertias
with what is proven of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from inspect import signature
from itertools import product
from typing import Annotated, Any, TypedDict

import numpy as np

from lwr_dyn.control.controllers import CONTROLLERS, make_controller, split_name
from lwr_dyn.control.gains import Gains
from lwr_dyn.control.inertia.worst_case import InertiaMaximum, worst_case_inertias
from lwr_dyn.control.protocol import Controller
from lwr_dyn.design.loop_judgement import LoopCase, reads_motor
from lwr_dyn.design.loop_margins import PlantResponse, frequency_grid, sensitivity
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, RestingPlant, law_at_rest
from lwr_dyn.design.sampled_stability import climb, joint_box, pose_text
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array, freeze_arrays, joint_array
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm

PEAK = 1.7
"""Of |S_ii|: by it the gain of any one joint may grow by 2.4 or fall by 0.63, and its phase by 34 deg."""

POSES, SEED = 200, 0
"""Poses drawn evenly from the joint box."""

LEAST, STEP, CLOSE = 0.5, 1.2, 1.003
"""The search ends at LEAST [rad/s]; its steps from above, and the ratio at which the bisection ends."""

PART = 10
"""Poses that are computed at once; those where the last try failed come first."""

COUNT = 100
"""Frequencies: neighbours differ by 10 %, and a peak of 1.7 is met to 0.1 %."""

CLIMBS, CLIMBED = 3, 0.005
"""Times that a pose is searched that is worse than the worst one, and added; by less of the margin it is no worse."""


class TunedRecord(TypedDict):
    """`TunedFrequency.to_json`."""

    omega_n: Annotated[float, "Natural frequency, rad/s; null where none keeps it."]
    peak: Annotated[float, "Largest |S_ii| with it; null where the loop is unstable."]
    limit: Annotated[float, "The peak that was asked for."]
    case: Annotated[str, "The plant on which a larger omega_n fails."]
    q: Annotated[list[float], "The pose there, rad or m."]
    joint: Annotated[int, "The joint there, from 1."]
    poses: Annotated[int, "How many poses were looked at."]
    at_most: Annotated[bool, "Whether the largest omega_n that was tried keeps it already."]


class ControllerRecord(TunedRecord):
    """The same of a controller by name."""

    controller: str


class MarginRecord(TypedDict):
    """`MarginGains.record`."""

    limit: Annotated[float, "Of |S_ii|."]
    where: Annotated[str, "The poses, in words."]
    controllers: Annotated[list[ControllerRecord], "One a controller and plant."]


class CertificateRecord(TypedDict):
    """`InertiaCertificate.to_json`."""

    value: Annotated[float, "The largest that was met, kg m^2 (kg)."]
    upper: Annotated[float, "No position in the box has more, kg m^2 (kg)."]
    gap: Annotated[float, "(upper - value) / value."]
    boxes: Annotated[int, "How many were bounded."]
    allowance: Annotated[float, "The part of upper for rounding, kg m^2 (kg)."]
    left_out: Annotated[float, "The part of upper for joints that hardly matter, kg m^2 (kg)."]


@dataclass(frozen=True, slots=True, eq=False)
class TunedFrequency:
    """The largest omega_n [rad/s] that keeps the margin, and what stands in the way of a larger one.

    omega_n is None where none from `LEAST` up does; then the rest is of `LEAST`. `at_most` says that the largest one
    tried already keeps it. `peak` is max |S_ii| with this omega_n (inf where the loop is unstable), at the pose `q`
    (n,) and the 0-based `joint` in `case`; `poses` were looked at in each case.
    """

    omega_n: float | None
    peak: float
    limit: float
    case: LoopCase
    q: Array
    joint: int
    poses: int
    at_most: bool = False

    def __post_init__(self) -> None:
        freeze_arrays(self, "q")

    def to_json(self) -> dict[str, Any]:
        """The result as JSON values."""
        return {
            "omega_n": self.omega_n, "peak": self.peak, "limit": self.limit, "case": self.case.words, "q": self.q,
            "joint": self.joint + 1, "poses": self.poses, "at_most": self.at_most,
        }  # fmt: skip


def largest_omega_n(
    arm: Arm,
    controller: str | Callable[[float], Controller],
    cases: Sequence[LoopCase] = (LoopCase(),),
    *,
    q: Array | None = None,
    peak: float = PEAK,
    poses: int = POSES,
    seed: int = SEED,
    most: float | None = None,
    dynamics: Dynamics | None = None,
    **options: Any,
) -> TunedFrequency:
    """The largest omega_n with which a controller keeps max |S_ii| <= peak in every case.

    Parameters
    ----------
    arm : Arm
        Of the plant and, by name, of the controller's model.
    controller : str or function
        A name as of `make_controller` whose law has an option omega_n, or a function omega_n -> controller.
    cases : sequence of LoopCase
        All of them must keep the margin, as the set {rigid with a delay of 1 to 4 samples, elastic}.
    q : (k, n) array_like, optional
        Poses, such as those of a motion; if not given `poses` drawn evenly from the joint box, to which the worst one
        that a search finds is added.
    peak : float
        The margin, above 1.
    most : float, optional
        omega_n [rad/s] from which the search comes down; 1 rad a sample of the first case if not given.
    dynamics : Dynamics, optional
        Of the plant; Pinocchio's of the arm if not given.
    options
        Of the controller, by name only.

    Raises
    ------
    OptionError
        No cases, a margin not above 1, a controller without omega_n, or one that cannot be linearised.
    ShapeError, MissingDataError, UnknownNameError
        As `LoopCase.plant` and `make_controller`.
    """
    if not cases:
        raise OptionError("cases", "none", "at least one LoopCase")
    check_margin(peak)
    plant_dynamics = dynamics_of(arm) if dynamics is None else dynamics
    make = _maker(arm, controller, options) if isinstance(controller, str) else controller
    lower, upper, _ = joint_box(arm)
    if q is None:
        rows = np.random.default_rng(seed).uniform(lower, upper, (poses, arm.n))
    else:
        rows = np.atleast_2d(joint_array("q", q, arm.n))
    search = _Search(arm, plant_dynamics, make, tuple(cases), peak)
    search.add(*(rows[i : i + PART] for i in range(0, len(rows), PART)))
    found = search.from_above(most if most is not None else cases[0].rate)
    for _ in range(CLIMBS if q is None else 0):
        worse = search.worse_pose(found, lower, upper)
        if worse is None:
            break
        search.add(worse[None])
        found = search.from_above(STEP * (found.omega_n or LEAST))
    return found


def check_margin(peak: float) -> None:
    """Raise `OptionError` for a largest |S_ii| that is not above 1."""
    if not (np.isfinite(peak) and peak > 1.0):
        raise OptionError("margin, the largest |S_ii|", peak, "a number above 1")


def _maker(arm: Arm, name: str, options: dict[str, Any]) -> Callable[[float], Controller]:
    """omega_n -> controller; the search of the largest inertias, where a law needs it, is done once."""
    law, model = split_name(name)[0], dynamics_of(arm)
    if law.endswith(".py"):
        raise OptionError("controller", law, "a name of a law with an option omega_n, or a function of omega_n")
    known = signature(CONTROLLERS.load(law)).parameters
    if "omega_n" not in known:
        raise OptionError("controller", f"{law}, which has no option omega_n", "a law that is tuned by omega_n")
    if "inertia" in known and "inertia" not in options:
        options = {**options, "inertia": [w.value for w in worst_case_inertias(arm)]}
    return lambda omega_n: make_controller(name, arm, model, omega_n=omega_n, **options)


@dataclass(slots=True, eq=False)
class _Search:
    arm: Arm
    dynamics: Dynamics
    make: Callable[[float], Controller]
    cases: tuple[LoopCase, ...]
    peak: float
    parts: list[Array] = field(default_factory=list)
    order: list[tuple[int, int]] = field(default_factory=list)  # (part, case), those that failed last in front
    responses: dict[tuple[Any, ...], tuple[RestingPlant, PlantResponse, Array]] = field(default_factory=dict)

    def add(self, *parts: Array) -> None:
        """Poses to be looked at, (k, n) each, before those that are there."""
        self.order[:0] = product(range(len(self.parts), len(self.parts) + len(parts)), range(len(self.cases)))
        self.parts += parts

    def from_above(self, top: float) -> TunedFrequency:
        """The first omega_n from above that keeps the margin, refined by bisection."""
        high, low = top, top
        found, holds = self.judged(low)
        while not holds and low > LEAST:
            high, low = low, max(low / STEP, LEAST)
            found, holds = self.judged(low)
        if not holds:
            return found
        while high > CLOSE * low:
            middle = float(np.sqrt(low * high))
            tried, holds = self.judged(middle)
            low, high, found = (middle, high, tried) if holds else (low, middle, found)
        return replace(found, omega_n=low, at_most=low == top)

    def judged(self, omega_n: float) -> tuple[TunedFrequency, bool]:
        """The worst of all cases and poses with this omega_n, and whether it keeps the margin; ends where it cannot."""
        controller = self.make(omega_n)
        k = sum(map(len, self.parts))
        worst = TunedFrequency(None, -1.0, self.peak, self.cases[0], self.parts[0][0], 0, k)
        for place in self.order:
            q, case = self.parts[place[0]], self.cases[place[1]]
            peaks = self.peaks(controller, case, q, place[0])
            i, joint = np.unravel_index(int(np.argmax(peaks)), peaks.shape)
            if peaks[i, joint] > worst.peak:
                worst = replace(worst, peak=float(peaks[i, joint]), case=case, q=q[i], joint=int(joint))
            if worst.peak > self.peak:
                self.order.remove(place)
                self.order.insert(0, place)
                return worst, False
        return worst, True

    def peaks(self, controller: Controller, case: LoopCase, q: Array, part: int | None = None) -> Array:
        """max |S_ii| (k, n) at the poses q; the response of the plant is kept for poses of a part."""
        motor = reads_motor(controller, q)
        key = (part, case.rate, case.encoders, motor, id(case.elasticity))
        kept = self.responses.get(key) if part is not None else None
        if kept is None:
            plant = case.plant(self.arm, self.dynamics, q, motor)
            response = PlantResponse.of(plant, case.rate, frequency_grid(case.rate, COUNT))
            kept = plant, response, case.seen(self.arm, self.dynamics, q, motor)
            if part is not None:
                self.responses[key] = kept
        loop = RestingLoop.of_plant(kept[0], law_at_rest(controller, kept[2]).feedback, kept[2])
        found = np.abs(sensitivity(kept[1].loop_gain(loop.feedback, case.sampling))).max(axis=1)
        found[loop.radius(case.sampling) > GROWS] = np.inf
        return np.asarray(found)

    def worse_pose(self, found: TunedFrequency, lower: Array, upper: Array) -> Array | None:
        """A pose near the worst one that breaks the margin with the omega_n found; None where the search meets none."""
        if found.omega_n is None:
            return None
        controller = self.make(found.omega_n)
        end = climb(lambda x: self.peaks(controller, found.case, x).max(axis=1), found.q, lower, upper)
        worst = float(self.peaks(controller, found.case, end[None]).max())
        return end if worst > (1.0 + CLIMBED) * self.peak else None


LAWS = ("pd-gravity", "pid", "inverse-dynamics")

OF_INERTIA = LAWS[:2]
"""Those whose gains are made of the largest inertias."""


@dataclass(frozen=True, slots=True, eq=False)
class MarginGains:
    """The frequencies found, by (controller, case in words)."""

    arm: Arm
    limit: float
    where: str
    found: Mapping[tuple[str, str], TunedFrequency]

    @property
    def table(self) -> Table:
        """One row a controller and case: omega_n, and where a larger one would break the margin."""
        title = (
            f"Largest omega_n with |S_ii| <= {self.limit:g}, {self.where}; linear and at rest, without friction and"
            " torque limits"
        )
        headings = ("controller", "plant", Heading("omega_n", "rad/s"), "stopped by")
        return Table(title, headings, [self._row(*key, each) for key, each in self.found.items()])

    def _row(self, controller: str, case: str, each: TunedFrequency) -> tuple[str, str, str, str]:
        pose = f"{self.arm.joint_names[each.joint]} at {pose_text(each.q, self.arm)}"
        if each.omega_n is None:
            return controller, case, "none", pose
        if each.at_most:
            return controller, case, f"over {each.omega_n:.4g}", "nothing that was tried"
        return controller, case, f"{each.omega_n:.1f}", pose

    def record(self) -> dict[str, Any]:
        """The table as JSON values."""
        rows = [{"controller": name, **each.to_json()} for (name, _), each in self.found.items()]
        return {"limit": self.limit, "where": self.where, "controllers": rows}


def margin_gains(
    arm: Arm, limit: float, cases: Sequence[LoopCase], gains: Gains, q: Array | None = None, **options: Any
) -> MarginGains:
    """The largest omega_n of each controller in each case, over the joint box or at the poses q (k, n).

    `gains` say of which largest inertias and damping ratio the controllers are made; `options` are those of
    `largest_omega_n`, which says what is raised.
    """
    inertia = gains.Kp / gains.omega_n**2
    found: dict[tuple[str, str], TunedFrequency] = {}
    for name in LAWS:
        own: dict[str, Any] = {"inertia": inertia} if name in OF_INERTIA else {}
        for case in cases:
            found[name, case.words] = largest_omega_n(arm, name, [case], q=q, peak=limit, xi=gains.xi, **own, **options)
    poses = max(each.poses for each in found.values())
    where = f"over the joint box ({poses} poses)" if q is None else f"at {poses} poses of the task"
    return MarginGains(arm, limit, where, found)


def certificates(arm: Arm, maxima: Sequence[InertiaMaximum]) -> Sequence[Any] | None:
    """A proven bound for each maximum (`lwr_dyn.control.inertia.certificate.InertiaCertificate`).

    None without the extra `batch`, and for an arm with too many joints for it.
    """
    from lwr_dyn.control.inertia.certificate import inertia_certificates

    try:
        return inertia_certificates(arm, maxima)
    except (MissingPackageError, OptionError):
        return None


def certified(arm: Arm, proven: Sequence[Any]) -> list[str]:
    """What is proven, in a line for all joints; one for each joint whose bound is not as near as asked."""
    closed = [x.gap for x in proven if x.holds]
    boxes = sum(x.boxes for x in proven)
    words = f"more than {100 * max(closed):.1e} % above these values" if closed else "above the bounds that follow"
    but = ", except:" if closed and len(closed) < len(proven) else ""
    lines = [f"certified: nowhere in the joint box {words} ({boxes} boxes; rounding errors included){but}"]
    return [*lines, *(f"  {arm.joint_names[x.joint]}: {x.statement()}" for x in proven if not x.holds)]
