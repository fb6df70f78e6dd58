"""`lwr-dyn gains`: each joint's largest inertia, what is proven of it, and gains for a second-order loop."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import click
import numpy as np

from lwr_dyn.cli import options
from lwr_dyn.cli.options import ELASTIC_HELP, Loading, OneOf, OptionRule, given_elasticity, robot_options
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.control.gains import OMEGA_N, XI, Gains, second_order_gains
from lwr_dyn.control.inertia.worst_case import InertiaMaximum, worst_case_inertias
from lwr_dyn.design import gain_search
from lwr_dyn.design.gain_search import PEAK, CertificateRecord, MarginGains, MarginRecord
from lwr_dyn.design.loop_judgement import LoopCase, sampled_loops, stability_table
from lwr_dyn.design.sampled_loop import Sampling
from lwr_dyn.design.sampled_stability import SampledStability, StabilityRecord
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.progress import progress
from lwr_dyn.foundation.registry import REQUIRED, options_of
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.transmission import chosen_elasticity
from lwr_dyn.simulation.setup import ENCODERS
from lwr_dyn.trajectory.references.references import REFERENCES

TASKS = tuple(
    name
    for name in REFERENCES.names
    if all(option.default is not REQUIRED for option in options_of(REFERENCES.load(name)).values())
)
"""Tasks that need no options."""
ON_TASK = 50
"""Poses of a task."""
RULES = tuple(
    OptionRule(name, lambda given: given["margin"] is not None, "with --margin") for name in ("task", "elastic")
)
RULES += (OptionRule("encoders", lambda given: given["elastic"] is not None, "with --elastic"),)
HEADINGS = (
    Heading("joint"),
    Heading("b", "kg m^2", ".6g", says="Largest inertia, kg m^2 (kg for a sliding joint)."),
    Heading("Kp", "N m/rad", ".6g", says="N m/rad (N/m)."),
    Heading("Kd", "N m s/rad", ".6g", says="N m s/rad (N s/m)."),
    Heading("where (deg; * any)", key=None),
    Heading(key="q", says="Where it is: joint positions, rad (m for sliding joints)."),
    Heading(key="free", says="Whether a joint does not change it there when moved alone."),
    Heading(key="search", says="How the maximum was searched."),
    Heading(key="certificate", says="What is proven of it; null without the extra batch.",
            kind=CertificateRecord | None),
)  # fmt: skip
"""Units of turning joints; sliding ones are in kg, N/m, N s/m and m."""


@click.command("gains")
@robot_options
@click.option("--omega-n", default=OMEGA_N, show_default=True, help="Natural frequency, rad/s.")
@click.option("--xi", default=XI, show_default=True, help="Damping ratio.")
@click.option("--rate", default=1000.0, show_default=True, help="Samples a second at which the loop is judged.")
@with_shared("--delay", default=0)
@click.option(
    "--margin",
    type=float,
    is_flag=False,
    flag_value=PEAK,
    metavar="[MS]",
    help=f"Add the largest omega-n with |S_ii| up to MS ({PEAK:g} if not given) at this rate and delay; half a minute.",
)
@with_shared("--task", ", with --margin: at its poses, not over the joint box", kind=OneOf(TASKS))
@click.option("--elastic", metavar="K|file", help=f"With --margin: {ELASTIC_HELP[0].lower()}{ELASTIC_HELP[1:]}")
@with_shared("--encoders", ", with --elastic", ENCODERS[0], kind=OneOf(ENCODERS))
@with_shared("--json as_json")
def command(
    robot: str, loading: Loading, omega_n: float, xi: float, rate: float, delay: int, as_json: bool, **given: Any
) -> None:
    """Worst-case inertia of each joint over its limits, Kp = omega_n^2 b and Kd = 2 xi omega_n b, where sampling makes
    the loop unstable, and with --margin the largest omega_n that keeps a margin."""
    options.refuse_unused(RULES, given)
    second_order_gains([1.0], omega_n, xi)  # refuse bad options before the search
    sampling = Sampling(rate, delay)
    arm = loading.arm(robot, options.used_by(given["elastic"]))
    search = None if given["margin"] is None else _margin_search(arm, (rate, delay), **given)
    with progress("searching the largest inertias"):
        maxima = worst_case_inertias(arm)
        gains = second_order_gains([w.value for w in maxima], omega_n, xi)
        sampled = sampled_loops(arm, gains, sampling)
        kept = search(gains) if search is not None else None
        proven = gain_search.certificates(arm, maxima)
    options.show(document(arm, gains, maxima, proven, sampled, kept), as_json)


def document(
    arm: Arm,
    gains: Gains,
    maxima: Sequence[InertiaMaximum],
    proven: Sequence[Any] | None,
    sampled: Mapping[str, SampledStability],
    kept: MarginGains | None,
) -> Document:
    """The largest inertias with their gains, what sampling does to them, and the frequencies that keep a margin."""
    omega_n, xi = gains.omega_n, gains.xi
    facts = [
        Fact("robot", arm.name, "Name of the robot."), Fact("reading", arm.reading, "Its reading.", kind=str),
        Fact("omega_n", omega_n, "Natural frequency, rad/s."), Fact("xi", xi, "Damping ratio."),
    ]  # fmt: skip
    bounds = [None] * arm.n if proven is None else [x.to_json() for x in proven]
    rows = [
        (arm.joint_names[w.joint], w.value, gains.Kp[w.joint], gains.Kd[w.joint], places(arm, w), w.q, w.free,
         w.statement(), bounds[w.joint])
        for w in maxima
    ]  # fmt: skip
    judged = {name: each.to_json() for name, each in sampled.items()}
    found = Table("", HEADINGS, rows, key="joints", says="Joint by joint.")
    sections = [
        Section("", [found, Note(searched(arm, maxima) if proven is None else gain_search.certified(arm, proven))]),
        Section("", [
            stability_table(arm, sampled),
            Fact("sampled", judged, "The sampled loop at rest, controller by controller.",
                 kind=dict[str, StabilityRecord]),
        ]),
        Section("", [
            *([] if kept is None else [kept.table]),
            Fact("margin", kept and kept.record(), "With --margin: the largest omega_n of each controller that keeps "
                 "|S_ii| within the limit; null without.", kind=MarginRecord | None),
        ]),
    ]  # fmt: skip
    head = f"max B_ii over the joint box, omega_n = {omega_n:g} rad/s, xi = {xi:g}"
    return Document(f"{arm.name}, reading {arm.reading}: {head}", "", sections, "lwr-dyn gains", "gains", facts)


def _margin_search(
    arm: Arm, sampled: tuple[float, int], margin: float, task: str | None, elastic: str | None, encoders: str
) -> Callable[[Gains], MarginGains]:
    """What searches the largest omega_n of each controller: rigid, and elastic where a stiffness is given.

    Raises before the search what options cannot be.
    """
    gain_search.check_margin(margin)
    cases = [LoopCase(*sampled)]
    if elastic is not None:
        elasticity = chosen_elasticity(arm, given_elasticity(elastic))
        cases.append(LoopCase(*sampled, None, elasticity, encoders))
    q = None
    if task is not None:
        reference = REFERENCES.make(task, arm)
        q = np.asarray(reference.sample(np.linspace(0.0, reference.duration, ON_TASK)).q)
    return lambda gains: gain_search.margin_gains(arm, margin, cases, gains, q)


def searched(arm: Arm, maxima: Sequence[InertiaMaximum]) -> list[str]:
    """How the maxima were searched: a line for all joints, one for each whose climbs ended elsewhere too."""
    starts = [w.starts for w in maxima]
    odd = [w for w in maxima if w.share < 1.0]
    ended = "all ended at these values" + (", except:" if odd else "")
    lines = [f"searched from {min(starts)} to {max(starts)} starts a joint; {ended}"]
    return [*lines, *(f"  {arm.joint_names[w.joint]}: {w.statement().partition('; ')[2]}" for w in odd)]


def places(arm: Arm, worst: InertiaMaximum) -> str:
    """The maximisers in degrees (metres for sliding joints), free joints as *."""
    texts = []
    for q in worst.maximisers[:2]:
        shown = [_joint_text(x, link.kind) for x, link in zip(q, arm.chain.links, strict=True)]
        texts.append(f"({' '.join(shown)})")
    more = worst.distinct - len(texts)
    return " ".join(texts) + (f" and {more} more" if more > 0 else "")


def _joint_text(x: float, kind: JointKind) -> str:
    if np.isnan(x):
        return "*"
    return f"{np.degrees(x):.0f}" if kind is JointKind.REVOLUTE else f"{x:.3g}"
