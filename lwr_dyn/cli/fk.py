"""`lwr-dyn fk`: the pose of the flange, a point on it, and the DH matrices in symbols."""

from typing import Any

import click
import numpy as np

from lwr_dyn.arms.loading import ONE_READING
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.cli.options import NAMED_AXES, NUMBERS, Loading, robot_options, say_caveats, show
from lwr_dyn.cli.vocabulary import given_positions, with_shared
from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import OptionError, UnknownNameError, needs_extra
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.kinematics.forward import forward_kinematics
from lwr_dyn.krl.robot.kuka_pose import FlangeRecord, kuka_units
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.caveats import KINEMATICS
from lwr_dyn.model.chain import JointKind, names_of_ends
from lwr_dyn.model.spatial import to_rpy


@click.command("fk")
@robot_options
@with_shared("--q q_si")
@with_shared("--q-deg")
@click.option("--axes-deg", type=NAMED_AXES, help="Joint positions by name, A1=0,A2=-90 in deg; 0 if not named.")
@click.option("--point", type=NUMBERS, default=(0.0, 0.0, 0.0), help="A point in the flange or tool frame, x,y,z in m.")
@click.option("--symbolic", is_flag=True, help="Print A_1 ... A_n in symbols and the position by two routes.")
@with_shared("--json as_json")
def command(
    robot: str, loading: Loading, point: tuple[float, ...], symbolic: bool, as_json: bool, **given: Any
) -> None:
    """Pose of the flange in the base, at --q, --q-deg or --axes-deg; for a KUKA arm in its units as well."""
    if symbolic and (as_json or given["q_si"] or given["q_deg"]):
        raise OptionError("--symbolic", "with --json, --q or --q-deg", "--symbolic alone: it prints symbols as text")
    if symbolic:
        if ends_in(robot, *ONE_READING):
            raise OptionError("--symbolic", robot, "a robot with a DH table")
        with needs_extra("symbolic"):
            from lwr_dyn.dynamics.symbolic.link_motion import dh_matrices_text
        _, paper = loading.arm_and_paper(robot, KINEMATICS)
        say_caveats()
        click.echo(dh_matrices_text(open_paper(robot, loading.reading) if paper is None else paper))
        return
    arm = loading.arm(robot, KINEMATICS)
    q = _positions(arm, **given)
    show(_document(arm, q, fixed_array("--point", point, (3,))), as_json)


def _document(arm: Arm, q: Array, point: Array) -> Document:
    """The flange at q (n,), and a point (3,) of it, in the base."""
    pose, kuka = forward_kinematics(arm, q), kuka_units(arm)
    at, outside = pose[:3, :3] @ point + pose[:3, 3], _outside(arm, q)
    degenerate = kuka.note(pose) if kuka else None
    first, last = names_of_ends(arm.installation)
    rpy = " ".join(f"{round(x, 6) + 0.0:.6f}" for x in np.degrees(to_rpy(pose[:3, :3])))
    facts = [
        Fact("robot", arm.name, "Name of the robot."), Fact("reading", arm.reading, "Its reading.", kind=str),
        Fact("q", q, "Joint positions, rad (m for sliding joints)."), Fact("T", pose, "Pose, 4 x 4, metres."),
        Fact("position", pose[:3, 3], "Metres."), Fact("rpy", to_rpy(pose[:3, :3]), "Roll, pitch, yaw, rad."),
        Fact("point", point, "In the flange or tool frame, metres."),
        Fact("point_in_base", at, "The same point in the base, metres."),
        Fact("outside", outside, "Joints beyond their limits, and by how much.", kind=list[str]),
        Fact("kuka", kuka.record(q) if kuka else None, "In KUKA's units; null for an arm without KUKA's axes A1 to A6.",
             kind=FlangeRecord | None),
    ]  # fmt: skip
    shown = Section("", [
        Note(["  " + " ".join(f"{round(x, 8) + 0.0:12.8f}" for x in row) for row in pose]),
        Note([f"position  {_triple(pose[:3, 3])} m", f"rpy       {rpy} deg"]),
        Note(f"point     {_triple(at)} m  ({last} {', '.join(f'{x:g}' for x in point)})", bool(point.any())),
        Note(f"KUKA      {kuka.line(q)}  (mm, deg)" if kuka else ()),
        Note(outside, before="note: "),
        Note(degenerate or "", bool(degenerate), before="note: "),
    ])  # fmt: skip
    return Document(f"{arm.name}, reading {arm.reading}: {last} in {first}, metres", "", [shown], "lwr-dyn fk",
                    facts=facts)  # fmt: skip


def _positions(
    arm: Arm, q_si: tuple[float, ...] | None, q_deg: tuple[float, ...] | None, axes_deg: dict[str, float] | None
) -> Array:
    if sum(given is not None for given in (q_si, q_deg, axes_deg)) != 1:
        raise OptionError("--q, --q-deg, --axes-deg", "none or several given", "one of them")
    if axes_deg is not None:
        return _positions_of_named(arm, axes_deg)
    return np.asarray(given_positions(arm, q_si, q_deg))


def _positions_of_named(arm: Arm, axes: dict[str, float]) -> Array:
    """Joint positions [rad or m] of axes named in deg (m); raises `UnknownNameError` for an unknown joint."""
    q = np.zeros(arm.n)
    for name, value in axes.items():
        if name not in arm.joint_names:
            raise UnknownNameError(f"joint of {arm.name}", name, arm.joint_names)
        i = arm.joint_names.index(name)
        q[i] = np.radians(value) if arm.chain.links[i].kind is JointKind.REVOLUTE else value
    return fixed_array("--axes-deg", q, (arm.n,))


def _outside(arm: Arm, q: Array) -> list[str]:
    """Joints beyond their limits, and by how much."""
    excess = zip(arm.joint_names, np.maximum(arm.lower - q, q - arm.upper), strict=True)
    return [f"{name} is outside its limits by {x:.6g}" for name, x in excess if x > 0.0]


def _triple(values: Array) -> str:
    return " ".join(f"{round(x, 9) + 0.0:.9f}" for x in values)
