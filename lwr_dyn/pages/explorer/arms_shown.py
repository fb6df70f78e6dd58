"""The arms of a page: one robot with its paper's other readings, or two robots side by side.

Each has its record of numbers, its part of the stage, and its functions: arms with the same kinematics share functions
and shapes, because masses, rotors and gravity are data.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.arms.papers.catalog import readings, robots
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.pages.explorer.closed_forms import closed_forms
from lwr_dyn.pages.explorer.page_data import (
    arm_record,
    body_record,
    inertial_record,
    motor_limits,
    pose_as_run,
    start_pose,
)
from lwr_dyn.pages.replay import scene
from lwr_dyn.pages.replay.replay_page import run_record
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun, replayed_runs


@dataclass(frozen=True, slots=True, eq=False)
class ShownArm:
    """An arm of a page."""

    arm: Arm
    label: str
    """What its button says."""
    start: Array
    """Positions at the start, (n,) [rad or m]."""
    group: int
    """Arms of one group stand at the same place, and one of them is shown; groups stand side by side."""


def readings_shown(arm: Arm, q: ArrayLike | None = None) -> tuple[ShownArm, ...]:
    """The arm with the other readings of its paper; raises as `start_pose`."""
    start = start_pose(arm, q)
    others = other_readings(arm)
    shown = [ShownArm(other, name, _inside(other, start), 0) for name, other in others.items()]
    return (ShownArm(arm, arm.reading if others else arm.name, start, 0), *shown)


def beside_each_other(arm: Arm, other: Arm, q: ArrayLike | None = None) -> tuple[ShownArm, ...]:
    """Two arms side by side, q (n,) of the first; raises as `start_pose`."""
    labels = [arm.name, other.name]
    if arm.name == other.name:
        labels = [f"{arm.name} {arm.reading}", f"{other.name} {other.reading}"]
    if labels[0] == labels[1]:
        labels = [f"{labels[0]}, left", f"{labels[1]}, right"]
    start = start_pose(arm, q)
    at = start_pose(other) if other.n != arm.n else _inside(other, start)
    return ShownArm(arm, labels[0], start, 0), ShownArm(other, labels[1], at, 1)


def other_readings(arm: Arm) -> dict[str, Arm]:
    """The same robot, mounted and loaded as it is, as its paper's other readings have it; none of a robot of a file."""
    if arm.file or arm.name not in robots() or arm.reading not in readings(arm.name):
        return {}
    names = [name for name in readings(arm.name) if name != arm.reading]
    return {name: load_with_paper(arm.name, name, **arm.loaded_with)[0] for name in names}


def _inside(arm: Arm, q: Array) -> Array:
    """The positions, moved into the limits of another arm."""
    return q.clip(arm.lower, arm.upper)


def shown_records(shown: Sequence[ShownArm], sets: Sequence[int | None], live: bool = False) -> dict[str, Any]:
    """The arms and the stage as JSON values; `sets` says which functions each arm has.

    The scene of a live page are meshcat's commands, else short ones, which own_stage.js reads.
    """
    stage, runs = _stage(shown)
    if not live:
        stage["scene"] = [short_command(command) for command in stage["scene"]]
    records = [
        {
            "label": each.label, "group": each.group, "set": chosen, "run": run, "start": each.start.tolist(),
            "arm": arm_record(each.arm), "bodies": [body_record(body) for body in each.arm.bodies()],
            "motors": motor_limits(each.arm), **inertial_record(each.arm), "closed_forms": closed_forms(each.arm),
        }
        for each, chosen, run in zip(shown, sets, runs, strict=True)
    ]  # fmt: skip
    return {"arms": records, "stage": stage}


def _stage(shown: Sequence[ShownArm]) -> tuple[dict[str, Any], list[int]]:
    """What is drawn, once for arms that look alike, and the place of each arm among it."""
    places: dict[tuple[int, str], int] = {}
    commands: list[Any] = []
    records: list[Any] = []
    runs = []
    for each in shown:
        drawn = _drawn(each)
        look = (each.group, json.dumps(list(scene.arm_commands(drawn, 0))))
        if look not in places:
            places[look] = len(places)
            commands += scene.arm_commands(drawn, places[look])
            records.append(run_record(drawn))
        runs.append(places[look])
    return {"scene": commands, "runs": records}, runs


def short_command(command: Mapping[str, Any]) -> list[Any]:
    """Run, link, and the link's transform; or run, link, a cylinder's transform, radii, height, colours and token.

    >>> short_command({"type": "set_transform", "path": "/arms/run_0/link_0/link_1", "matrix": [1.0, 0.5]})
    [0, 1, [1, 0.5]]
    """
    links = [part for part in command["path"].split("/") if part.startswith("link_")]
    run = int(command["path"].split("/run_")[1].split("/")[0])
    place = [run, len(links) - 1]
    if command["type"] == "set_transform":
        return [*place, _short_numbers(command["matrix"])]
    shape = command["object"]
    (solid,), (paint,), mesh = shape["geometries"], shape["materials"], shape["object"]
    sizes = [solid["radiusTop"], solid["radiusBottom"], solid["height"], solid["radialSegments"]]
    colours = [paint["color"], paint["specular"], paint["shininess"]]
    return [*place, _short_numbers(mesh["matrix"]), sizes, colours, mesh["userData"]["token"]]


def _short_numbers(values: Sequence[float]) -> list[float]:
    """Whole numbers without a point."""
    return [int(x) if x == int(x) else x for x in values]


def _drawn(each: ShownArm) -> ReplayedRun:
    (drawn,) = replayed_runs([pose_as_run(each.arm, each.start)], each.arm, [each.arm.name])
    return drawn
