"""`lwr-dyn margins`: what sampling, delay and elastic joints leave of a loop's stability, and where it is worst."""

import sys
from typing import Any

import click
import numpy as np

from lwr_dyn.arms.loading import load
from lwr_dyn.cli import options
from lwr_dyn.cli.options import NUMBERS, Given, Loading, OneOf, OptionRule, option, robot_options, row_options
from lwr_dyn.cli.simulate import CONTROLLER
from lwr_dyn.cli.vocabulary import given_positions, shared
from lwr_dyn.control.controllers import CONTROLLERS, faults_in, split_name
from lwr_dyn.design.margins import LIMIT, margins
from lwr_dyn.design.sampled_stability import PLACES, POSES, SEED
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.progress import progress
from lwr_dyn.model.arm import Arm, arm_with_payload
from lwr_dyn.pages.figures.margins import picture_writer
from lwr_dyn.simulation.setup import ENCODERS
from lwr_dyn.trajectory.references.references import REFERENCES

LOOP = [
    option("--rate", "Samples a second.", float, 1000.0),
    shared("--delay", default=0),
    shared("--velocity-cutoff", " of encoders; exact speeds if not given"),
]
PLANT = [
    option("--elastic", options.ELASTIC_HELP, str, metavar="K|file"),
    option("--encoders", "The side of elastic joints that the controller gets.", OneOf(ENCODERS), ENCODERS[0]),
    option("--payload", "Point mass at the flange that the controller does not know, kg.", float, 0.0),
    option("--plant-reading", "Judge another reading than the controller's.", str),
]
WHERE = [
    shared("--q q_si", ", of one pose"),
    shared("--q-deg", ", of one pose; the joint box if not given"),
    shared("--task", ": poses along it, in place of the joint box", kind=OneOf(REFERENCES.names)),
]
BOX = [
    option("--poses", "Poses drawn from the joint box.", int, POSES),
    option("--seed", "Seed of the drawing.", int, SEED),
]
PICTURE = "Picture: bode, nyquist, sensitivity, map, or a file named after one. Repeatable."
MAPPED = "Joints of the map, from 1; the two that count most if not given."
OUT = [
    option("--limit", "Largest |S_ii| allowed; exit 1 where it is given and not kept.", float, LIMIT),
    option("--plot", PICTURE, str, metavar="NAME|FILE.png", multiple=True),
    option("--map-joints", MAPPED, NUMBERS, metavar="I,J"),
    shared("--json"),
]


def _is_posed(given: Given) -> bool:
    return given["q_deg"] is not None or given["q_si"] is not None


RULES = (
    OptionRule("encoders", lambda given: given["elastic"] is not None, "with --elastic"),
    OptionRule("task", lambda given: not _is_posed(given), "without --q-deg"),
    OptionRule("poses", lambda given: not _is_posed(given) and given["task"] is None, "without --q-deg and --task"),
    OptionRule("seed", lambda given: not _is_posed(given) and given["task"] is None, "without --q-deg and --task"),
    OptionRule("map-joints", lambda given: any("map" in wish.lower() for wish in given["plot"]), "with --plot map"),
)


LAW = "pd-gravity"
"""The law that is judged where none is named."""


@click.command("margins")
@robot_options
def command(robot: str, loading: Loading, **given: Any) -> None:
    """Judge the sampled loop of ROBOT near rest: share of the joint box that is unstable, least rate, |S_ii| of each
    joint, gain and delay margins at the worst pose.

    Speeds, friction, torque limits and stops are left out.
    """
    given["controller"] = given["controller"] or LAW
    law = split_name(given["controller"])[0]
    CONTROLLERS_OPTIONS.refuse_unused(law)
    TASKS.refuse_unused(given["task"] or "")
    options.refuse_unused(RULES, given)
    options.check_code([given["controller"]], given["no_code"])
    writers = [picture_writer(wish) for wish in given["plot"]]
    arm = loading.arm(robot, options.used_by(given["elastic"]))
    with progress("judging the loop"), faults_in(law):
        report = margins(
            arm, given["controller"], q=_poses(arm, given), rate=given["rate"], delay=given["delay"],
            cutoff_hz=given["velocity_cutoff"], elasticity=options.given_elasticity(given["elastic"]),
            encoders=given["encoders"], plant=_plant(arm, robot, given), limit=given["limit"], poses=given["poses"],
            seed=given["seed"],
            **CONTROLLERS_OPTIONS.values(law, given, arm),
        )  # fmt: skip
    joints = _map_joints(given["map_joints"])
    written = [path for write in writers for path in write(report, joints)]
    options.show(report.document, given["json"], written)
    sys.exit(1 if options.Flag("limit", None).is_typed and not report.holds else 0)


_FIRST = [*command.params, CONTROLLER, options.NO_CODE, *LOOP, *PLANT, *WHERE, *BOX, *OUT]
TASKS = row_options(REFERENCES, "task", _FIRST)
OF_TASKS = TASKS.click_options()
CONTROLLERS_OPTIONS = row_options(CONTROLLERS, "controller", [*_FIRST, *OF_TASKS])
command.params += [
    CONTROLLER, *CONTROLLERS_OPTIONS.click_options(), options.NO_CODE, *LOOP, *PLANT, *WHERE, *OF_TASKS, *BOX, *OUT,
]  # fmt: skip


def _poses(arm: Arm, given: dict[str, Any]) -> Array | None:
    """The poses that are named or that a task goes through; None for the joint box.

    Raises `OptionError` for a delay that is longer than the task.
    """
    if _is_posed(given):
        return given_positions(arm, given["q_si"], given["q_deg"])
    if given["task"] is None:
        return None
    reference = REFERENCES.make(given["task"], arm, **TASKS.values(given["task"], given, arm))
    if given["rate"] > 0.0 and given["delay"] >= reference.duration * given["rate"]:
        allowed = f"less than the {reference.duration:g} s of the task"
        raise OptionError("--delay", f"{given['delay']} samples at {given['rate']:g} Hz", allowed)
    return np.asarray(reference.sample(np.linspace(0.0, reference.duration, PLACES)).q)


def _plant(arm: Arm, robot: str, given: dict[str, Any]) -> Arm | None:
    """The arm that moves, where it is not the controller's."""
    name, payload = given["plant_reading"], given["payload"]
    plant = arm if name is None else options.stands_on(load(robot, name, **arm.loaded_with))
    if payload != 0.0:
        plant = arm_with_payload(plant, payload)
    return None if plant is arm else plant


def _map_joints(numbers: tuple[float, ...] | None) -> tuple[int, int] | None:
    if numbers is None:
        return None
    if len(numbers) != 2 or any(number != int(number) for number in numbers):
        raise OptionError("--map-joints", ",".join(f"{x:g}" for x in numbers), "two joints counted from 1, as 2,4")
    return int(numbers[0]) - 1, int(numbers[1]) - 1
