"""`lwr-dyn spread`: one task under all readings of a robot, controllers on one and plants on another."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import click
import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.audit.sensitivity.matrix import POSES, Spread, spread
from lwr_dyn.cli.options import print_json
from lwr_dyn.errors import OptionError
from lwr_dyn.front import load, readings
from lwr_dyn.model.arm import Arm
from lwr_dyn.tables import aligned


@click.command("spread")
@click.argument("robots", nargs=-1, required=True, metavar="ROBOT|FILE...")
@click.option("--task", help="ist, lspb, two-points or joint-move; what the first robot's paper sets if not given.")
@click.option("--rate", type=float, default=1000.0, show_default=True, help="Samples a second of the simulations.")
@click.option("--poses", type=int, default=POSES, show_default=True, help="Where gravity torques are compared.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def command(robots: tuple[str, ...], task: str | None, rate: float, poses: int, as_json: bool) -> None:
    """What depends on the reading: g, max B_ii, gains, tracking errors, and which conclusions of the paper survive.

    One ROBOT is taken under all its readings; several, and .toml and .urdf files, are compared with each other, the
    first one setting the task. Every controller is simulated on every plant.
    """
    arms = _arms(robots)
    with click.progressbar(length=100, label="simulating", file=sys.stderr, hidden=not sys.stderr.isatty()) as bar:

        def progress(share: float) -> None:
            bar.update(max(0, int(100 * share) - bar.pos))

        found = spread(arms, task, rate=rate, poses=poses, progress=progress)
    if as_json:
        print_json(_record(found))
    else:
        click.echo(_text(found))


def _arms(robots: tuple[str, ...]) -> dict[str, Arm]:
    """Every reading of every robot, named so that the names differ."""
    arms: dict[str, Arm] = {}
    for robot in robots:
        short = Path(robot).stem if robot.endswith((".toml", ".urdf")) else robot
        for reading in (None,) if robot.endswith(".urdf") else readings(robot):
            arm = load(robot, reading)
            name = arm.reading if len(robots) == 1 else f"{short} {arm.reading}" if reading else short
            if name in arms:
                raise OptionError("robots", f"{name} twice", "different names")
            arms[name] = arm
    if len(arms) < 2:
        raise OptionError("robots", f"{robots[0]} has one reading", "a robot with several readings, or several robots")
    return arms


def _text(found: Spread) -> str:
    runs = len(found.outcomes)
    parts = [
        f"{', '.join(found.names)}: {found.job.about}",
        f"\ngravity torques at {found.poses} poses [N m (N)]",
        _gravity(found),
        "\nlargest inertia b = max B_ii over the joint box [kg m^2 (kg)], and gains 2500 b, 100 b",
        _inertias(found),
        f"\n{runs} runs of {found.job.reference.duration:g} s at {found.rate:g} samples a second: RMS error of the tip"
        " [mm] (largest error of a joint [mrad (mm)]); rows: the controller believes, columns: what is moved",
        *(_matrix(found, law.name) for law in found.job.laws),
        *_notes(found),
        "\nwhat survives",
        aligned([(c.text, c.verdict()) for c in found.conclusions], ("conclusion", "verdict")),
    ]
    return "\n".join(parts)


def _gravity(found: Spread) -> str:
    first = found.statics[found.names[0]]
    rows = []
    for name, s in found.statics.items():
        rows.append((name, "largest |g|", *_numbers(np.abs(s.gravity).max(axis=0))))
        if s is not first:
            rows.append((name, f"largest difference to {found.names[0]}", *_numbers(s.gravity_off(first))))
    return aligned(rows, ("reading", "figure", *found.joints))


def _inertias(found: Spread) -> str:
    first, rows = found.statics[found.names[0]], []
    for name, s in found.statics.items():
        rows += [(name, f, *_numbers(x)) for f, x in (("b", s.b), ("Kp", s.gains.Kp), ("Kd", s.gains.Kd))]
        if s is not first:
            rows.append((name, f"off {found.names[0]}", *(f"{x:+.2%}" for x in s.b / first.b - 1.0)))
    return aligned(rows, ("reading", "figure", *found.joints))


def _numbers(values: Array) -> tuple[str, ...]:
    return tuple(f"{x:.4g}" if abs(x) > TINY else "0" for x in values)


TINY = 1e-12
"""Below this a torque or inertia is rounding."""


def _matrix(found: Spread, law: str) -> str:
    tips, worst = found.tip_rms_mm(law), found.worst_mrad(law)
    raised = {(o.believed, o.real) for o in found.outcomes if o.law == law and o.rate > found.rate}
    rows = []
    for i, believed in enumerate(found.names):
        cells = []
        for j, real in enumerate(found.names):
            mark = "*" if (believed, real) in raised else ""
            cells.append("no run" if math.isnan(tips[i, j]) else f"{tips[i, j]:.3g} ({worst[i, j]:.3g}){mark}")
        rows.append((believed, *cells))
    return aligned(rows, (law, *(f"on {name}" for name in found.names)))


def _notes(found: Spread) -> list[str]:
    raised = sorted({o.rate for o in found.outcomes if o.rate > found.rate})
    notes = []
    if raised:
        rates = " or ".join(f"{r:g}" for r in raised)
        fault = (
            f"at {found.rate:g} samples a second this loop chatters: the damping is too strong for the lighter plant"
        )
        notes.append(f"* {fault}; simulated at {rates}, as good as continuous")
    return notes + [f"no run of {o.law}, {o.believed} on {o.real}: {o.fault}" for o in found.outcomes if o.fault]


def _record(found: Spread) -> dict[str, Any]:
    statics = {
        name: {"gravity_largest": np.abs(s.gravity).max(axis=0), "b": s.b, "Kp": s.gains.Kp, "Kd": s.gains.Kd}
        | {"gravity_difference": s.gravity_off(found.statics[found.names[0]])}
        for name, s in found.statics.items()
    }
    runs = [
        {"law": o.law, "believed": o.believed, "real": o.real, "rate": o.rate, "fault": o.fault}
        | {"metrics": None if o.figures is None else o.figures.to_json()}
        for o in found.outcomes
    ]
    said = [
        {"text": c.text, "survives": c.survives, "share": c.share, "verdict": c.verdict()}
        | {"holds": [{"case": list(key), "holds": held} for key, held in c.holds.items()]}
        for c in found.conclusions
    ]
    head = {
        "readings": list(found.names),
        "joints": list(found.joints),
        "task": found.job.name,
        "about": found.job.about,
    }
    return {**head, "rate": found.rate, "poses": found.poses, "statics": statics, "runs": runs, "conclusions": said}
