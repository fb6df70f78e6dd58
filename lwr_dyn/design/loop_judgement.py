"""What a loop is judged with (`LoopCase`), and what sampling does to it in words.

For `gains` the sampled loops of all controllers as a table; for `simulate` lines before and after the run.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lwr_dyn.control.gains import Gains, Linearised
from lwr_dyn.control.paper_laws import PID, PDGravity, tuned_inverse_dynamics, tuned_pd_gravity
from lwr_dyn.control.protocol import Controller, filter_pole
from lwr_dyn.design import sampled_stability as stability
from lwr_dyn.design.elastic_loop import ElasticArm, at_rest
from lwr_dyn.design.sampled_loop import RestingLoop, RestingPlant, Sampling, law_at_rest, rigid_plant
from lwr_dyn.design.sampled_stability import SampledStability, pose_text, rate_text
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.transmission import JointElasticity, chosen_elasticity
from lwr_dyn.simulation.setup import ENCODERS, Setup


@dataclass(frozen=True, slots=True)
class LoopCase:
    """A plant and a sampling: rigid joints without delay if nothing is given.

    Parameters
    ----------
    rate : float
        Samples a second [Hz].
    delay : int
        From a command to its torque [samples].
    cutoff_hz : float, optional
        Of the velocity filter of an encoder [Hz]; true speeds if not given.
    elasticity : "file", float or JointElasticity, optional
        As of `simulate`: stiffness of the file, or the largest stiffness [N m/rad]; rigid joints if not given.
    encoders : {"motor", "link"}
        The side that ordinary laws read on elastic joints.

    Raises
    ------
    OptionError
        A rate, a delay or a cut-off that cannot be, another side.
    """

    rate: float = 1000.0
    delay: int = 0
    cutoff_hz: float | None = None
    elasticity: JointElasticity | str | float | None = None
    encoders: str = "motor"

    def __post_init__(self) -> None:
        Sampling(self.rate, self.delay)
        if self.cutoff_hz is not None:
            filter_pole(self.cutoff_hz, self.rate)  # raises where it cannot be
        if self.encoders not in ENCODERS:
            raise OptionError("encoders", repr(self.encoders), " or ".join(ENCODERS))

    @property
    def sampling(self) -> Sampling:
        """How the controller is sampled."""
        return Sampling(self.rate, self.delay, self.cutoff_hz)

    @property
    def words(self) -> str:
        """The case in words.

        >>> LoopCase(delay=1).words, LoopCase(elasticity=1e4, encoders="link").words
        ('rigid, 1000 Hz, delay of 1 sample', 'elastic (10000 N m/rad, link encoders), 1000 Hz')
        """
        stiffness = f"{self.elasticity:g} N m/rad, " if isinstance(self.elasticity, float | int) else ""
        parts = ["rigid" if self.elasticity is None else f"elastic ({stiffness}{self.encoders} encoders)"]
        parts += [f"{self.rate:g} Hz"]
        parts += [f"delay of {self.delay} sample{'s' if self.delay > 1 else ''}"] if self.delay else []
        parts += [f"speeds filtered at {self.cutoff_hz:g} Hz"] if self.cutoff_hz is not None else []
        return ", ".join(parts)

    def plant(self, arm: Arm, dynamics: Dynamics, q: Array, motor: bool = False) -> RestingPlant:
        """The arm near rest at the poses q (k, n); `motor` for a law that reads the motor side whatever is given.

        Raises `OptionError`: a singular mass matrix, a stiffness that cannot be, no rotor at an elastic joint;
        `MissingDataError`: "file" for an arm whose file gives no stiffness.
        """
        elastic = self._elastic(arm, dynamics, motor)
        return rigid_plant(dynamics, q) if elastic is None else elastic.plant(at_rest(q))

    def seen(self, arm: Arm, dynamics: Dynamics, q: Array, motor: bool = False) -> Array:
        """What the law reads (k, n) where the links rest at q: motors turn ahead by g / K. Raises as `plant`."""
        elastic = self._elastic(arm, dynamics, motor)
        on_motor = motor or self.encoders == "motor"
        return q if elastic is None or not on_motor else elastic.spring_side(at_rest(q))

    def loop(self, arm: Arm, dynamics: Dynamics, controller: Controller, q: Array) -> RestingLoop:
        """The loop at the poses q (k, n), the law linearised at what it reads; raises as `plant`, `law_at_rest`."""
        motor = reads_motor(controller, q)
        seen = self.seen(arm, dynamics, q, motor)
        law = law_at_rest(controller, seen).feedback
        return RestingLoop.of_plant(self.plant(arm, dynamics, q, motor), law, seen)

    def _elastic(self, arm: Arm, dynamics: Dynamics, motor: bool) -> ElasticArm | None:
        elasticity = chosen_elasticity(arm, self.elasticity)
        if elasticity is None:
            return None
        return ElasticArm(dynamics, elasticity, arm.armature, "motor" if motor else self.encoders)


def reads_motor(controller: Controller, q: Array) -> bool:
    """Whether a law says that it reads the motor side whatever the encoders are."""
    return isinstance(controller, Linearised) and controller.linear_feedback(q[:1]).motor


def sampling_text(sampling: Sampling) -> str:
    """Rate and delay in words.

    >>> sampling_text(Sampling(1000.0, 2))
    '1000 Hz with a delay of 2 samples'
    """
    late = {0: "", 1: " with a delay of 1 sample"}.get(sampling.delay, f" with a delay of {sampling.delay} samples")
    return f"{sampling.rate:g} Hz{late}"


def unknown_text(found: SampledStability, arm: Arm) -> str:
    """Which limits of the box are assumed; empty where all are known."""
    unknown = found.unknown_limits
    names = "all joints" if len(unknown) == arm.n else ", ".join(unknown)
    sliding = "" if arm.chain.turning.all() else " (sliding: +-1 m)"
    return f"limits of {names} unknown: +-180 deg{sliding} taken" if unknown else ""


def stability_table(arm: Arm, results: Mapping[str, SampledStability]) -> Table:
    """One row a controller: the unstable share of the joint box, the worst pose found, the least rate."""
    first = next(iter(results.values()))
    title = (
        f"Sampled at {sampling_text(first.sampling)}: unstable at rest, of {first.poses} poses drawn evenly from the"
        f" joint box (seed {stability.SEED}); linear, without friction and torque limits"
    )
    headings = (
        "controller", "unstable", Heading("stable from", format=rate_text),
        Heading("largest factor a sample", format=".4g"), "there",
    )  # fmt: skip
    rows = [
        (name, found.share_text, found.least_rate, found.radius, pose_text(found.worst, arm))
        for name, found in results.items()
    ]
    return Table(title, headings, rows, unknown_text(first, arm))


def judged_setup(setup: Setup) -> dict[str, SampledStability] | None:
    """The sampled loop of a setup "in_box" and "along_reference"; None where the linear theory does not apply.

    It does not for a continuous run, for a controller without a linear form, nor where the plant's mass matrix is
    singular or an elastic joint has no rotor. Elastic joints are judged by Spong's model, whatever the engine.
    """
    controller, loop, plant = setup.controller, setup.loop, setup.plant
    if loop.continuous or not isinstance(controller, Linearised):
        return None
    cutoff_hz = None if loop.encoder is None else loop.encoder.cutoff_hz
    case = LoopCase(loop.rate, loop.delay, cutoff_hz, setup.elasticity, loop.encoders)
    rows = stability.places_of(setup.motion.q, stability.judged_count(stability.PLACES, loop.delay))

    def loops(q: Array) -> RestingLoop:
        return case.loop(plant.arm, plant.dynamics, controller, q)

    try:
        return {
            "in_box": stability.box_stability(plant.arm, loops, case.sampling),
            "along_reference": stability.stability_at(loops(rows), case.sampling, rows),
        }
    except OptionError:
        return None


@dataclass(frozen=True, slots=True, eq=False)
class SampledNotes:
    """What to say of a simulation's sampled loop: lines before and after the run, and the record for JSON.

    What could not be judged is said after the run: a controller's file that fails gives its one line of error alone.
    A run of elastic joints may be refused when it begins: what is known of it is said when it ends or diverges.
    """

    before: list[str]
    once_begun: list[str]
    after: list[str]
    record: dict[str, Any] | None


def sampled_notes(setup: Setup) -> SampledNotes:
    """The notes of a simulation that is about to run."""
    judged, after = judged_setup(setup), []
    if not (setup.loop.continuous or isinstance(setup.controller, Linearised)):
        why = "the controller has no linear_feedback(q)"
        after = [f"note: whether sampling makes this loop unstable is not judged: {why}"]
    lines, refusable = stability_lines(setup.plant.arm, judged), setup.elasticity is not None
    before, once_begun = ([], lines) if refusable else (lines, [])
    record = None if judged is None else {name: found.to_json() for name, found in judged.items()}
    return SampledNotes(before, once_begun, after, record)


def stability_lines(arm: Arm, judged: Mapping[str, SampledStability] | None) -> list[str]:
    """What to know before the run; nothing where the loop is stable everywhere, or not judged."""
    if judged is None or all(found.holds for found in judged.values()):
        return []
    box, path = judged["in_box"], judged["along_reference"]
    share = f"{box.unstable} of {box.poses} poses of the joint box"
    if 0 < box.unstable < box.poses:
        share = f"{box.share_text} of the joint box ({box.poses} poses)"
    lines = [
        f"note: sampled at {sampling_text(box.sampling)}, this loop is unstable at rest in {share}; {_worst(arm, box)};"
        f" {_from_rate(box)} in all of them"
    ]
    if box.unknown_limits:
        lines.append(f"note: {unknown_text(box, arm)}")
    if path.holds:
        return [*lines, f"note: at the poses of this reference ({path.poses} of them) it is stable"]
    where = f"at {path.unstable} of {path.poses} poses of this reference it is unstable"
    return [*lines, f"note: {where}; {_worst(arm, path)}; {_from_rate(path)} there"]


def _worst(arm: Arm, found: SampledStability) -> str:
    growth = f"{found.radius:.3g} times" if found.radius >= 1.1 else f"by {100 * (found.radius - 1):.2g} %"
    return f"worst found at {pose_text(found.worst, arm)}, where a deviation grows {growth} with each sample"


def _from_rate(found: SampledStability) -> str:
    if found.least_rate is None:
        return f"{rate_text(None)} makes it stable"
    return f"from {rate_text(found.least_rate)} on it is stable"


def sampled_loops(arm: Arm, gains: Gains, sampling: Sampling) -> dict[str, SampledStability]:
    """The sampled loop of each controller with these gains, and with the gains of the arm's file, where it has any."""
    dynamics, omega_n, xi = dynamics_of(arm), gains.omega_n, gains.xi
    controllers: dict[str, Linearised] = {
        "pd-gravity": PDGravity(dynamics, gains.Kp, gains.Kd),
        "pid": PID(gains.Kp, gains.Kd, arm.effort, dynamics=dynamics, omega_n=omega_n),
        "inverse-dynamics": tuned_inverse_dynamics(arm, dynamics, omega_n=omega_n, xi=xi),
    }
    if arm.gains is not None:
        controllers["pd-gravity --own-gains"] = tuned_pd_gravity(arm, dynamics, own_gains=True)

    def judged(controller: Linearised) -> SampledStability:
        return stability.box_stability(arm, lambda q: RestingLoop.of(dynamics, controller, q), sampling)

    return {name: judged(controller) for name, controller in controllers.items()}
