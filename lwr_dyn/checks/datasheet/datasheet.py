"""A DH table and its limits against the maker's data sheet: poses, axes, ranges, reach, envelope volume and mass.

The table and the data sheet are independent sources. A length that is 1 cm off or an angle that is 90 deg off breaks at
least one of these checks.
"""

import math
from collections.abc import Iterator

import numpy as np

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.checks.arm.verdict import Verdict
from lwr_dyn.checks.datasheet.envelope import SECTION, working_envelope
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.kinematics.forward import flange_pose, joint_axes
from lwr_dyn.kinematics.six_joints.six_joint_geometry import wrist_arm_geometry
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import from_rpy

HALF_MILLIMETRE = 0.5e-3
"""[m] Lengths are printed in whole millimetres."""
VOLUME = 0.02
"""[m^3] The volume is printed to 0.01; lengths in whole millimetres change it by another 0.01."""
RIGHT_ANGLES = 1e-9
"""Entries of rotations whose angles are whole quarter turns."""
_POSES = ("axis", "zero_flange", "flange_rpy", "mastering_wrist")


def datasheet_verdicts(arm: Arm, paper: Paper) -> list[Verdict]:
    """The checks that the paper's `poses` and `ratings` allow; none when it has none of them."""
    return [*_poses(arm, paper), *_ranges(arm), *_envelope(arm), *_mass(arm)]


def _poses(arm: Arm, paper: Paper) -> Iterator[Verdict]:
    printed = {name: paper.columns[f"poses.{name}"].si() for name in _POSES if f"poses.{name}" in paper.columns}
    zero = flange_pose(arm.chain, np.zeros(arm.n))
    if "axis" in printed:
        deviation = float(np.abs(joint_axes(arm.chain, np.zeros(arm.n)).z - printed["axis"]).max())
        yield Verdict("axes at zero - the maker's", deviation, RIGHT_ANGLES, "1")
    if "zero_flange" in printed:
        deviation = float(np.linalg.norm(zero[:3, 3] - printed["zero_flange"][0]))
        yield Verdict("flange at zero - as printed", deviation, HALF_MILLIMETRE, "m")
    if "flange_rpy" in printed:
        yield _rotation_verdict("flange at zero: rotation - the maker's", zero, printed["flange_rpy"][0])
    if not arm.mastering:
        return
    mastered = flange_pose(arm.chain, np.array(arm.mastering))
    if "flange_rpy" in printed:
        yield _rotation_verdict("flange at mastering: rotation - the maker's", mastered, printed["flange_rpy"][0])
    if "mastering_wrist" in printed:
        geometry = wrist_arm_geometry(arm.chain)
        wrist = np.full(3, np.nan) if geometry is None else mastered[:3, :3] @ geometry.wrist_in_flange
        deviation = float(np.linalg.norm(mastered[:3, 3] + wrist - printed["mastering_wrist"][0]))
        yield Verdict("wrist centre at mastering - as printed", deviation, HALF_MILLIMETRE, "m")


def _rotation_verdict(name: str, pose: Array, rpy: Array) -> Verdict:
    return Verdict(name, float(np.abs(pose[:3, :3] - from_rpy(rpy)).max()), RIGHT_ANGLES, "1")


def _ranges(arm: Arm) -> Iterator[Verdict]:
    """The ranges of joints 1, 4, 5 and 6 are symmetric, since the arm is its own mirror image in its plane at zero.

    The mirror reverses axes 1, 4 and 6, which lie in that plane, and axis 5 where the wrist is straight.
    """
    if arm.ratings.envelope_volume is None or wrist_arm_geometry(arm.chain) is None:
        return
    for i in (0, 3, 4, 5):
        asymmetry = abs(float(arm.upper[i] + arm.lower[i]))
        yield Verdict(f"{arm.joint_names[i]}: range as wide either way", asymmetry, RIGHT_ANGLES, "rad")


def _envelope(arm: Arm) -> Iterator[Verdict]:
    reach, volume = arm.ratings.reach, arm.ratings.envelope_volume
    if reach is None and volume is None:
        return
    try:
        envelope = working_envelope(arm)
        computed_reach, computed_volume = envelope.reach, envelope.volume
    except LwrDynError:
        computed_reach = computed_volume = math.nan
    if reach is not None:
        yield Verdict("reach - data sheet", abs(computed_reach - reach), HALF_MILLIMETRE, "m")
    if volume is not None:
        yield Verdict(f"envelope volume {SECTION} - data sheet", abs(computed_volume - volume), VOLUME, "m^3")


def _mass(arm: Arm) -> Iterator[Verdict]:
    bodies, base, total = arm.chain.bodies, arm.ratings.base_mass, arm.ratings.mass
    if bodies is not None and base is not None and total is not None:
        difference = abs(base + sum(body.mass for body in bodies) - total)
        yield Verdict("mass of base and links - data sheet", difference, 1e-6, "kg")
