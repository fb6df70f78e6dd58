"""KUKA's units on the command line: mm and deg, axes by name, Status and Turn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click
import numpy as np

from lwr_dyn.arrays import Array, fixed_array
from lwr_dyn.errors import OptionError, UnknownNameError
from lwr_dyn.kinematics.kuka_pose import (
    KukaPose,
    abc_of_rotation,
    degenerate_abc,
    has_kuka_axes,
    kuka_pose,
    status,
    turn,
    with_status_and_turn,
)
from lwr_dyn.kinematics.solution import Solution, nearest_solution
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind


class NamedAxes(click.ParamType):  # type: ignore[type-arg] # generic only since click 8.4
    """Joints by name: `A1=10,A2=-90`; those not named are 0."""

    name = "name=value,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> dict[str, float]:
        """Name -> value."""
        if isinstance(value, dict):
            return value
        try:
            pairs = [part.split("=") for part in str(value).split(",")]
            return {name.strip(): float(number) for name, number in pairs}
        except ValueError:
            self.fail(
                f"{value!r} is not a list of axes; allowed: NAME=DEG separated by commas, A1=10,A2=-90", param, ctx
            )


NAMED_AXES = NamedAxes()


def positions_of_named(arm: Arm, axes: dict[str, float]) -> Array:
    """Joint positions [rad or m] of axes named in deg (m); raises `UnknownNameError` for an unknown joint."""
    q = np.zeros(arm.n)
    for name, value in axes.items():
        if name not in arm.joint_names:
            raise UnknownNameError(f"joint of {arm.name}", name, arm.joint_names)
        i = arm.joint_names.index(name)
        q[i] = np.radians(value) if arm.chain.links[i].kind is JointKind.REVOLUTE else value
    return fixed_array("--axes-deg", q, (arm.n,))


def degenerate_note(rotation: Array) -> str | None:
    """A note on A, B, C at B = +-90 deg; None elsewhere."""
    abc = abc_of_rotation(rotation)
    if not degenerate_abc(abc):
        return None
    other = "C - A" if abc[1] > 0 else "C + A"
    return f"B is {abc[1]:+.0f} deg: A and C turn about one axis, only {other} counts; written with A = 0"


def pose_line(pose: KukaPose) -> str:
    """X, Y, Z, A, B, C, S, T as one line in KRL's form."""
    names = ("X", "Y", "Z", "A", "B", "C")
    values = (pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg)
    text = ", ".join(f"{name} {round(value, 6) + 0.0:.6f}" for name, value in zip(names, values, strict=True))
    return text if pose.s is None else f"{text}, S {pose.s}, T {pose.t}"


def pose_record(pose: KukaPose) -> dict[str, float | int | None]:
    """The same as a record."""
    return {name: getattr(pose, name) for name in KukaPose.__slots__}


def kuka_record(arm: Arm, q: Array) -> dict[str, Any] | None:
    """Axes in deg and the flange in KUKA's units; None for an arm without KUKA's axes."""
    if not has_kuka_axes(arm):
        return None
    return {"axes_deg": dict(zip(arm.joint_names, np.degrees(q).tolist(), strict=True))} | pose_record(
        kuka_pose(arm, q)
    )


def select_solutions(
    arm: Arm, solutions: tuple[Solution, ...], s: int | None, t: int | None, start_deg: Sequence[float] | None
) -> tuple[Solution, ...]:
    """The solutions with Status `s` and Turn `t`, and of these the one nearest to `start_deg` when it is given."""
    if (s is not None or t is not None) and not has_kuka_axes(arm):
        raise OptionError("--status, --turn", f"given for {arm.name}", "only for an arm with KUKA's axes A1 to A6")
    if s is not None or t is not None:
        solutions = with_status_and_turn(arm, solutions, s, t)
    if start_deg is None or not solutions:
        return solutions
    return (nearest_solution(solutions, np.radians(fixed_array("--from-deg", start_deg, (arm.n,)))),)


def status_and_turn(arm: Arm, solution: Solution) -> tuple[int, int] | None:
    """S and T of a solution; None for an arm without KUKA's axes."""
    return (status(arm, solution.q), turn(solution.q)) if has_kuka_axes(arm) else None
