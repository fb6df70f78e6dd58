"""`lwr-dyn sensitivity`: one task under all readings of a robot, controllers on one and plants on another."""

from pathlib import Path

import click

from lwr_dyn.arms.loading import ONE_READING, load
from lwr_dyn.arms.papers.catalog import readings
from lwr_dyn.checks.sensitivity.analysis import POSES, sensitivity
from lwr_dyn.checks.sensitivity.study_tasks import JOINT_MOVE, study_tasks
from lwr_dyn.cli.options import OneOf, show, stands_on
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.foundation.progress import progress
from lwr_dyn.model.arm import Arm


@click.command("sensitivity")
@click.argument("robots", nargs=-1, required=True, metavar="ROBOT|FILE...")
@with_shared("--task", "; by default the first robot's first", kind=OneOf([*study_tasks(), JOINT_MOVE.name]))
@click.option("--rate", type=float, default=1000.0, show_default=True, help="Samples a second of the simulations.")
@with_shared("--poses", ", at which gravity torques are compared", POSES)
@with_shared("--json as_json")
def command(robots: tuple[str, ...], task: str | None, rate: float, poses: int, as_json: bool) -> None:
    """What depends on the reading: g, max B_ii, gains, tracking errors, and the conclusions that always hold.

    One ROBOT is taken under all its readings; several, and files of robots, are compared with each other, the
    first one setting the task. Every controller is simulated on every plant.
    """
    arms = _arms(robots)
    with progress("simulating") as report:
        result = sensitivity(arms, task, rate=rate, poses=poses, progress=report)
    show(result.document, as_json)


def _arms(robots: tuple[str, ...]) -> dict[str, Arm]:
    """Every reading of every robot, named so that the names differ."""
    arms: dict[str, Arm] = {}
    for robot in robots:
        short = Path(robot).stem if ends_in(robot, ".toml", *ONE_READING) else robot
        for reading in (None,) if ends_in(robot, *ONE_READING) else readings(robot):
            arm = stands_on(load(robot, reading))
            name = arm.reading if len(robots) == 1 else f"{short} {arm.reading}" if reading else short
            if name in arms:
                raise OptionError("robots", f"{name} twice", "different names")
            arms[name] = arm
    if len(arms) < 2:
        raise OptionError("robots", f"{robots[0]} has one reading", "a robot with several readings, or several robots")
    return arms
