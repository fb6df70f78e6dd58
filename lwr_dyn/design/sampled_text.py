"""What sampling does to a loop, in words: a table for `gains`; for `simulate` lines before and after the run."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lwr_dyn.control.linear_feedback import Linearised
from lwr_dyn.design.loop_case import LoopCase
from lwr_dyn.design.sampled_loop import Sampling
from lwr_dyn.design.sampled_stability import (
    PLACES,
    POSES,
    SEED,
    STARTS,
    WHOLE_DELAY,
    SampledStability,
    box_stability,
    judged_count,
    places_of,
    pose_text,
    rate_text,
    stability_at,
)
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.simulation.setup import Setup


def sampling_text(sampling: Sampling) -> str:
    """Rate and delay in words.

    >>> sampling_text(Sampling(1000.0, 2))
    '1000 Hz with a delay of 2 samples'
    """
    late = {0: "", 1: " with a delay of 1 sample"}.get(sampling.delay, f" with a delay of {sampling.delay} samples")
    return f"{sampling.rate:g} Hz{late}"


def unknown_text(found: SampledStability) -> str:
    """Which limits of the box are assumed; empty where all are known."""
    names = ", ".join(found.unknown_limits)
    return f"limits of {names} unknown: +-180 deg (sliding: +-1 m) taken" if names else ""


def stability_table(arm: Arm, results: Mapping[str, SampledStability]) -> Table:
    """One row a controller: the unstable share of the joint box, the worst pose found, the least rate."""
    first = next(iter(results.values()))
    title = (
        f"Sampled at {sampling_text(first.sampling)}: unstable at rest, of {first.poses} poses drawn evenly from the"
        f" joint box (seed {SEED}); linear, without friction and torque limits"
    )
    headings = (
        "controller", "unstable", Heading("holds from", format=rate_text),
        Heading("largest growth a sample", format=".4g"), "there",
    )  # fmt: skip
    rows = [
        (name, found.share_text, found.least_rate, found.radius, pose_text(found.worst, arm))
        for name, found in results.items()
    ]
    return Table(title, headings, rows, unknown_text(first))


def judged_setup(setup: Setup) -> dict[str, SampledStability] | None:
    """The sampled loop of a setup "in_box" and "along_reference"; None where the linear theory does not apply.

    It does not for a continuous run, for a controller without a linear form, nor where the plant's mass matrix is
    singular or an elastic joint has no rotor. Elastic joints are judged by Spong's model, whatever the engine.
    """
    controller, options, plant = setup.controller, setup.options, setup.plant
    if options.continuous or not isinstance(controller, Linearised):
        return None
    cutoff_hz = None if setup.encoder is None else setup.encoder.cutoff_hz
    case = LoopCase(options.rate, options.delay, cutoff_hz, setup.elasticity, setup.encoders)
    rows = places_of(setup.motion.q, judged_count(PLACES, options.delay))
    poses, starts = judged_count(POSES, options.delay), 0 if options.delay > WHOLE_DELAY else STARTS
    try:
        return {
            "in_box": box_stability(
                plant.arm,
                lambda q: case.loop(plant.arm, plant.dynamics, controller, q),
                case.sampling,
                poses,
                starts=starts,
            ),
            "along_reference": stability_at(
                case.loop(plant.arm, plant.dynamics, controller, rows), case.sampling, rows
            ),
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
    judged = judged_setup(setup)
    lines, refusable = stability_lines(setup.plant.arm, judged), setup.elasticity is not None
    before, once_begun = ([], lines) if refusable else (lines, [])
    return SampledNotes(before, once_begun, not_judged_lines(setup), stability_record(judged))


def not_judged_lines(setup: Setup) -> list[str]:
    """That nothing is known of the sampled loop of a controller without a linear form, such as one from a file."""
    if setup.options.continuous or isinstance(setup.controller, Linearised):
        return []
    return ["note: whether sampling makes this loop unstable is not judged: the controller has no linear_feedback(q)"]


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
        lines.append(f"note: {unknown_text(box)}")
    if path.holds:
        return [*lines, f"note: at the poses of this reference ({path.poses} of them) it is stable"]
    where = f"at {path.unstable} of {path.poses} poses of this reference it is unstable"
    return [*lines, f"note: {where}; {_worst(arm, path)}; {_from_rate(path)} there"]


def _worst(arm: Arm, found: SampledStability) -> str:
    return f"worst found at {pose_text(found.worst, arm)}, where a deviation grows {_growth(found.radius)} a sample"


def _from_rate(found: SampledStability) -> str:
    if found.least_rate is None:
        return f"{rate_text(None)} makes it hold"
    return f"from {rate_text(found.least_rate)} on it holds"


def _growth(radius: float) -> str:
    return f"{radius:.3g}-fold" if radius >= 1.1 else f"by {100 * (radius - 1):.2g} %"


def stability_record(judged: Mapping[str, SampledStability] | None) -> dict[str, Any] | None:
    """The same as JSON values."""
    return None if judged is None else {name: found.to_json() for name, found in judged.items()}
