"""`lwr-dyn ik`: joint positions for a pose of the flange, all branches; exit 1 when there is none."""

import sys
from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Annotated, Any

import click
import numpy as np

from lwr_dyn.cli.options import NUMBERS, Loading, OneOf, robot_options, show
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.arrays import Array, fixed_array
from lwr_dyn.foundation.document import Document, Fact, Note, Section
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.tables import Table
from lwr_dyn.kinematics.inverse import IK_SOLVERS, inverse_kinematics, nearest_words
from lwr_dyn.kinematics.solution import InverseResult, nearest_solution
from lwr_dyn.kinematics.solution_rows import Solution, SolutionRecord
from lwr_dyn.krl.robot import kuka_pose
from lwr_dyn.model.arm import Arm, from_degrees
from lwr_dyn.model.caveats import KINEMATICS
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.spatial import from_rpy

ANGLES = ("--rpy", "--rpy-deg", "--abc-deg")
MANY = 32
"""Solutions that are listed with all their whole-turn copies."""


@click.command("ik")
@robot_options
@click.option("--xyz", type=NUMBERS, help="Position of the flange (or tool) in the base (or world), x,y,z in m.")
@click.option("--rpy", "rpy_si", type=NUMBERS, help="Roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll), rad.")
@click.option("--rpy-deg", type=NUMBERS, help="The same in deg.")
@click.option("--xyz-mm", type=NUMBERS, help="Position in KUKA's units, X,Y,Z in mm.")
@click.option("--abc-deg", type=NUMBERS, help="A,B,C: R = Rz(A) Ry(B) Rx(C), deg.")
@click.option("--status", type=int, help="Only solutions with this Status S (KUKA).")
@click.option("--turn", type=int, help="Only solutions with this Turn T (KUKA).")
@with_shared("--from-deg", ": only the solution with the least travel from there")
@click.option("--arm-angle-deg", type=float, help="Arm angle of an S-R-S arm; the safest on each branch if not given.")
@click.option("--solver", type=OneOf(IK_SOLVERS.names), help="The first that recognises the arm if not given.")
@click.option("--all", "every", is_flag=True, help="Print all: whole-turn copies too where there are many.")
@with_shared("--json as_json")
def command(
    robot: str, loading: Loading, arm_angle_deg: float | None, every: bool, as_json: bool, **given: Any
) -> None:
    """Joint positions for a pose of the flange, every branch; exit 1 when out of reach or outside the limits.

    Without an orientation: one solution for the position, near --from-deg; most arms have infinitely many.
    """
    arm = loading.arm(robot, KINEMATICS)
    pose, turned = _pose(arm, given)
    angle = None if arm_angle_deg is None else float(np.radians(arm_angle_deg))
    options: dict[str, Any] = {"arm_angle": angle, "solver": given["solver"]}
    if not turned:
        options |= {"position_only": True, "q0": _start(arm, given)}
    result = inverse_kinematics(arm, pose, **options)
    kept = _selected(arm, result.solutions, given)
    result = replace(result, solutions=kept, outside=result.outside if kept == result.solutions else ())
    if as_json or result.solutions or result.outside:
        show(_document(arm, pose, result, every), as_json)
    if result.status != "solved":
        click.echo(f"lwr-dyn: {_verdict(arm, pose, result, angle)}", err=True)
        sys.exit(1)


def _selected(arm: Arm, solutions: Sequence[Solution], given: dict[str, Any]) -> Sequence[Solution]:
    """The solutions with the Status and Turn that are given, and of these the one nearest to --from-deg."""
    s, t, start = given["status"], given["turn"], _start(arm, given)
    if s is not None or t is not None:
        solutions = kuka_pose.KukaUnits(arm).selected(solutions, s, t)
    if start is None or not solutions:
        return solutions
    return (nearest_solution(solutions, start),)


def _start(arm: Arm, given: dict[str, Any]) -> Array | None:
    """[rad or m]"""
    typed = given["from_deg"]
    return None if typed is None else from_degrees(arm, typed, "--from-deg")


def _pose(arm: Arm, given: dict[str, Any]) -> tuple[Array, bool]:
    """The pose, and whether its orientation is given."""
    place = _one_of(given, "--xyz", "--xyz-mm")
    pose = np.eye(4)
    pose[:3, 3] = fixed_array(place, given[_key(place)], (3,)) / (1e3 if place == "--xyz-mm" else 1.0)
    if all(given[_key(option)] is None for option in ANGLES):
        if given["status"] is not None or given["turn"] is not None:
            raise OptionError("--status, --turn", "given without an orientation", "with " + " or ".join(ANGLES))
        return pose, False
    angles_option = _one_of(given, *ANGLES)
    angles = fixed_array(angles_option, given[_key(angles_option)], (3,))
    if angles_option == "--abc-deg":
        pose[:3, :3] = kuka_pose.rotation_of_abc(angles.tolist())
    else:
        pose[:3, :3] = from_rpy(angles if angles_option == "--rpy" else np.radians(angles))
    return pose, True


def _one_of(given: dict[str, Any], *options: str) -> str:
    """Which one of the options is given; raises `OptionError` unless exactly one is."""
    typed = [option for option in options if given[_key(option)] is not None]
    if len(typed) != 1:
        fault = {0: "neither given", 2: "both given"}.get(len(typed), "several given")
        raise OptionError(", ".join(options), fault, "one of them")
    return typed[0]


def _key(option: str) -> str:
    return {"--rpy": "rpy_si"}.get(option, option[2:].replace("-", "_"))


def _verdict(arm: Arm, pose: Array, result: InverseResult, angle: float | None) -> str:
    """One line: what fails, where, by how much."""
    sure = "" if result.complete else " (numeric search, not proven)"
    if result.turn is not None:
        off = f"the nearest found is off by {np.degrees(result.turn):.4g} deg"
        return f"{arm.name}: the position is within reach, the orientation is not: {off}{sure}"
    if result.status == "out of reach":
        return f"{arm.name}: out of reach by {result.distance:.6g} m{sure}{nearest_words(arm, pose, result)}"
    where = "any" if angle is None else "this"
    other = "; at another it is inside" if any(result.arm_angle_intervals.values()) else ""
    at = sure if not result.complete else f" at {where} arm angle{other}" if result.arm_angle_intervals else ", at best"
    excess = result.excess or 0.0
    if arm.chain.links[arm.joint_names.index(result.joint or "")].kind is JointKind.PRISMATIC:
        return f"{arm.name}: outside limits: {result.joint} by {excess:.6g} m{at}"
    return f"{arm.name}: outside limits: {result.joint} by {excess:.6g} rad ({np.degrees(excess):.6g} deg){at}"


def _document(arm: Arm, pose: Array, result: InverseResult, every: bool) -> Document:
    kuka, listed = kuka_pose.kuka_units(arm), (*result.solutions, *result.outside)
    turning = np.array([link.kind is JointKind.REVOLUTE for link in arm.chain.links])
    kept = listed if every or len(listed) <= MANY else _without_copies(listed, turning)
    facts = [
        Fact("robot", arm.name, "Name of the robot."), Fact("reading", arm.reading, "Its reading.", kind=str),
        Fact("T", pose, "Pose, 4 x 4, metres."), *result.document.facts,
        Fact("kuka", asdict(kuka_pose.pose_of_matrix(pose)) if kuka else None,
             "The pose in KUKA's units; null for an arm without KUKA's axes A1 to A6.", kind=kuka_pose.KukaPose | None),
        Fact("solutions", [_row(one, kuka) for one in result.solutions],
             "Inside the limits, that with the largest margin first.", kind=list[BranchRecord]),
        Fact("outside", [_row(one, kuka) for one in result.outside], "Outside the limits, that least outside first.",
             kind=list[BranchRecord]),
    ]  # fmt: skip
    note, copies = kuka.note(pose) if kuka else None, len(listed) - len(kept)
    angles = [
        f"{branch}: {', '.join(f'{np.degrees(a):.4f} to {np.degrees(b):.4f}' for a, b in intervals) or 'none'}"
        for branch, intervals in result.arm_angle_intervals.items()
    ]
    shown = Section("", [
        _table(arm, kept, kuka, turning),
        Note(f"and {copies} copies of these, whole turns of joints apart: --all, --json", copies > 0),
        Note("singular wrist: such a solution is one of a family whose joints move and leave the flange",
             "wrist" in result.singular, before="note: "),
        Note(note or "", note is not None, before="note: "),
        Note(angles, before="arm angle inside limits, "),
    ])  # fmt: skip
    units = "deg" if turning.all() else "deg (m for sliding joints)"
    title = f"{arm.name}, reading {arm.reading}: {_how_found(result)}; joints in {units}"
    return Document(title, "", [shown], "lwr-dyn ik", facts=facts)


class BranchRecord(SolutionRecord):
    """A solution, in KUKA's units too."""

    kuka: Annotated[kuka_pose.FlangeRecord | None, "In KUKA's units; null for an arm without KUKA's axes A1 to A6."]


def _row(solution: Solution, kuka: kuka_pose.KukaUnits | None) -> dict[str, Any]:
    return {**solution.record, "kuka": kuka.record(solution.q) if kuka else None}


def _table(arm: Arm, solutions: Sequence[Solution], kuka: kuka_pose.KukaUnits | None, turning: Array) -> Table:
    """Angles in degrees."""
    widths = [max(9, len(name)) for name in arm.joint_names]
    heads = ("branch", "S, T" if kuka else "arm angle", " ".join(f"{n:>9}" for n in arm.joint_names), "margin", "at")
    rows = []
    for one in solutions:
        shown = np.where(turning, np.degrees(one.q), one.q) + 0.0
        turns = turning[arm.joint_names.index(one.joint)]
        angle = "-" if one.arm_angle is None else f"{np.degrees(one.arm_angle):.4f}"
        rows.append((
            one.branch or "-", kuka.label(one.q) if kuka else angle,
            " ".join(f"{x:{width}.4f}" for x, width in zip(shown, widths, strict=True)),
            f"{np.degrees(one.margin) if turns else one.margin:.4f}", one.joint,
            "inside" if one.inside_limits else "OUTSIDE",
            f"singular: {', '.join(one.singular)}" if one.singular else "",
        ))  # fmt: skip
    return Table("", (*heads, "", ""), rows)


def _without_copies(solutions: Sequence[Solution], turning: Array) -> tuple[Solution, ...]:
    """The first, that with the largest margin, of solutions that are equal up to whole turns."""
    first: dict[tuple[str, bytes], Solution] = {}
    for solution in solutions:
        turned = np.where(turning, np.exp(1j * solution.q), solution.q)
        first.setdefault((solution.branch, (np.round(turned, 6) + 0.0).tobytes()), solution)
    return tuple(first.values())


def _how_found(result: InverseResult) -> str:
    if result.position_only:
        how = "one of many solutions for the position (most arms have infinitely many)"
    elif result.complete or result.turns_left_out:
        how = "all branches"
    elif any(one.branch for one in (*result.solutions, *result.outside)):
        how = "branches of the nearest exact geometry, polished on the arm; not proven complete"
    else:
        how = "found numerically, not complete"
    each = ", each at one arm angle" if result.arm_angle_intervals else ""
    left = result.turns_left_out
    return how + each + (f"; {left} copies whole turns apart, inside the limits too, are not listed" if left else "")
