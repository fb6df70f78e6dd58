"""`lwr-dyn ik`: joint positions for a pose of the flange, all branches; exit 1 when there is none."""

from __future__ import annotations

import sys
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from lwr_dyn.arm import Arm
from lwr_dyn.arrays import fixed_array
from lwr_dyn.cli.options import NUMBERS, load_robot, print_json, robot_options
from lwr_dyn.dh import JointKind
from lwr_dyn.errors import OptionError
from lwr_dyn.kinematics.inverse import InverseResult, Solution, inverse_kinematics
from lwr_dyn.spatial import from_rpy
from lwr_dyn.text import table


@click.command("ik")
@robot_options
@click.option("--xyz", type=NUMBERS, required=True, help="Position of the flange in the base, x,y,z in m.")
@click.option("--rpy", "rpy_si", type=NUMBERS, help="Roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll), rad.")
@click.option("--rpy-deg", type=NUMBERS, help="The same in deg.")
@click.option("--arm-angle-deg", type=float, help="Arm angle of an S-R-S arm; the safest on each branch if not given.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
def command(
    robot: str,
    reading: str | None,
    tip: str | None,
    locks: tuple[str, ...],
    xyz: tuple[float, ...],
    rpy_si: tuple[float, ...] | None,
    rpy_deg: tuple[float, ...] | None,
    arm_angle_deg: float | None,
    as_json: bool,
) -> None:
    """Joint positions for a pose of the flange, every branch; exit 1 when out of reach or outside the limits."""
    arm = load_robot(robot, reading, tip, locks)
    pose = _pose(xyz, rpy_si, rpy_deg)
    angle = None if arm_angle_deg is None else float(np.radians(arm_angle_deg))
    found = inverse_kinematics(arm, pose, arm_angle=angle)
    if as_json:
        print_json(_record(arm, pose, found))
    elif found.solutions or found.outside:
        _print_branches(arm, found)
    if found.status != "solved":
        click.echo(f"lwr-dyn: {_verdict(arm, found, angle)}", err=True)
        sys.exit(1)


def _pose(
    xyz: tuple[float, ...], rpy: tuple[float, ...] | None, rpy_deg: tuple[float, ...] | None
) -> NDArray[np.float64]:
    if rpy is not None and rpy_deg is not None:
        raise OptionError("--rpy, --rpy-deg", "both given", "one of them")
    pose = np.eye(4)
    pose[:3, 3] = fixed_array("--xyz", xyz, (3,))
    if rpy is not None:
        pose[:3, :3] = from_rpy(fixed_array("--rpy", rpy, (3,)))
    elif rpy_deg is not None:
        pose[:3, :3] = from_rpy(np.radians(fixed_array("--rpy-deg", rpy_deg, (3,))))
    else:
        raise OptionError("--rpy, --rpy-deg", "neither given", "one of them")
    return pose


def _verdict(arm: Arm, found: InverseResult, angle: float | None) -> str:
    """One line: what fails, where, by how much."""
    sure = "" if found.complete else " (numeric search, not proven)"
    if found.status == "out of reach":
        return f"{arm.name}: out of reach by {found.distance:.6g} m{sure}"
    where = "any" if angle is None else "this"
    other = "; at another it is inside" if any(found.arm_angle_intervals.values()) else ""
    at = f" at {where} arm angle{other}" if found.complete else sure
    excess = found.excess or 0.0
    if arm.chain.links[arm.joint_names.index(found.joint or "")].kind is JointKind.PRISMATIC:
        return f"{arm.name}: outside limits: {found.joint} by {excess:.6g} m{at}"
    return f"{arm.name}: outside limits: {found.joint} by {excess:.6g} rad ({np.degrees(excess):.6g} deg){at}"


def _print_branches(arm: Arm, found: InverseResult) -> None:
    turning = np.array([link.kind is JointKind.REVOLUTE for link in arm.chain.links])
    how = "all branches" if found.complete else "found numerically, not complete"
    units = "deg" if turning.all() else "deg (m for sliding joints)"
    click.echo(f"{arm.name}, reading {arm.reading}: {how}; joints in {units}")
    rows = []
    for solution in (*found.solutions, *found.outside):
        rows.append(
            (
                solution.branch or "-",
                "-" if solution.arm_angle is None else f"{np.degrees(solution.arm_angle):.4f}",
                " ".join(f"{x:9.4f}" for x in np.where(turning, np.degrees(solution.q), solution.q) + 0.0),
                f"{_shown(arm, solution):.4f}",
                solution.joint,
                "inside" if solution.inside_limits else "OUTSIDE",
            )
        )
    click.echo(table(rows, ("branch", "arm angle", " ".join(f"{n:>9}" for n in arm.joint_names), "margin", "at", "")))
    for branch, intervals in found.arm_angle_intervals.items():
        said = ", ".join(f"{np.degrees(a):.4f} to {np.degrees(b):.4f}" for a, b in intervals)
        click.echo(f"arm angle inside limits, {branch}: {said or 'none'}")


def _shown(arm: Arm, solution: Solution) -> float:
    kind = arm.chain.links[arm.joint_names.index(solution.joint)].kind
    return float(np.degrees(solution.margin)) if kind is JointKind.REVOLUTE else solution.margin


def _record(arm: Arm, pose: NDArray[np.float64], found: InverseResult) -> dict[str, Any]:
    return {
        "robot": arm.name,
        "reading": arm.reading,
        "T": pose,
        "status": found.status,
        "complete": found.complete,
        "joint": found.joint,
        "excess": found.excess,
        "distance": found.distance,
        "solutions": [_row(s) for s in found.solutions],
        "outside": [_row(s) for s in found.outside],
        "arm_angle_intervals": dict(found.arm_angle_intervals),
    }


def _row(solution: Solution) -> dict[str, Any]:
    return {
        "q": solution.q,
        "branch": solution.branch or None,
        "arm_angle": solution.arm_angle,
        "margin": solution.margin,
        "joint": solution.joint,
        "inside_limits": solution.inside_limits,
        "residual": solution.residual,
    }
