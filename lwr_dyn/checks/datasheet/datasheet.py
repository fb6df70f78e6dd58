"""A DH table and its limits against the maker's data sheet: poses, axes, ranges, reach, envelope volume and mass.

The table and the data sheet are independent sources. A length that is 1 cm off or an angle that is 90 deg off breaks at
least one of these checks.

Where the DH convention is unknown, the poses of the sheet find it, with zero and direction of the maker's joints: each
angle is theta_i = sign_i q_i + offset_i, offsets by quarter turns. The axes that the maker draws at q = 0 fix them
joint by joint, from the base outward; the readings that remain are judged by the printed positions and orientations of
flange and wrist, by the limits and by the envelope.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, TypedDict

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.checks.arm.model_laws import Verdict
from lwr_dyn.checks.conventions.printed_table import printed_rows
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LwrDynError, MissingDataError
from lwr_dyn.kinematics.forward import flange_pose, joint_axes
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain, Convention, DHRow, link_frames
from lwr_dyn.model.spatial import Pose, from_rpy

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
        yield Verdict("axes at zero against the maker's", deviation, RIGHT_ANGLES, "1")
    if "zero_flange" in printed:
        deviation = float(np.linalg.norm(zero[:3, 3] - printed["zero_flange"][0]))
        yield Verdict("flange at zero against the print", deviation, HALF_MILLIMETRE, "m")
    if "flange_rpy" in printed:
        yield _rotation_verdict("flange at zero: rotation against the maker's", zero, printed["flange_rpy"][0])
    if not arm.mastering:
        return
    mastered = flange_pose(arm.chain, np.array(arm.mastering))
    if "flange_rpy" in printed:
        yield _rotation_verdict("flange at mastering: rotation against the maker's", mastered, printed["flange_rpy"][0])
    if "mastering_wrist" in printed:
        from lwr_dyn.kinematics.six_joints.spherical_wrist import wrist_arm_geometry  # it loads much of SciPy

        geometry = wrist_arm_geometry(arm.chain)
        wrist = np.full(3, np.nan) if geometry is None else mastered[:3, :3] @ geometry.wrist_in_flange
        deviation = float(np.linalg.norm(mastered[:3, 3] + wrist - printed["mastering_wrist"][0]))
        yield Verdict("wrist centre at mastering against the print", deviation, HALF_MILLIMETRE, "m")


def _rotation_verdict(name: str, pose: Array, rpy: Array) -> Verdict:
    return Verdict(name, float(np.abs(pose[:3, :3] - from_rpy(rpy)).max()), RIGHT_ANGLES, "1")


def _ranges(arm: Arm) -> Iterator[Verdict]:
    """The ranges of joints 1, 4, 5 and 6 are symmetric, since the arm is its own mirror image in its plane at zero.

    The mirror reverses axes 1, 4 and 6, which lie in that plane, and axis 5 where the wrist is straight.
    """
    if arm.ratings.envelope_volume is None:
        return
    from lwr_dyn.kinematics.six_joints.spherical_wrist import wrist_arm_geometry

    if wrist_arm_geometry(arm.chain) is None:
        return
    for i in (0, 3, 4, 5):
        asymmetry = abs(float(arm.upper[i] + arm.lower[i]))
        yield Verdict(f"{arm.joint_names[i]}: range as wide either way", asymmetry, RIGHT_ANGLES, "rad")


def _envelope(arm: Arm) -> Iterator[Verdict]:
    reach, volume = arm.ratings.reach, arm.ratings.envelope_volume
    if reach is None and volume is None:
        return
    from lwr_dyn.checks.datasheet.envelope import SECTION, working_envelope

    try:
        envelope = working_envelope(arm)
        computed_reach, computed_volume = envelope.reach, envelope.volume
    except LwrDynError:
        computed_reach = computed_volume = math.nan
    if reach is not None:
        yield Verdict("reach against the data sheet", abs(computed_reach - reach), HALF_MILLIMETRE, "m")
    if volume is not None:
        yield Verdict(f"envelope volume {SECTION} against the data sheet", abs(computed_volume - volume), VOLUME, "m^3")


def _mass(arm: Arm) -> Iterator[Verdict]:
    bodies, base, total = arm.chain.bodies, arm.ratings.base_mass, arm.ratings.mass
    if bodies is not None and base is not None and total is not None:
        difference = abs(base + sum(body.mass for body in bodies) - total)
        yield Verdict("mass of base and links against the data sheet", difference, 1e-6, "kg")


AXIS = 1e-9
"""Entries of an axis may differ by this: angles are whole quarter turns."""
QUARTERS = (0, 1, -1, 2)
"""Quarter turns that an offset may be moved by, the plainest first."""


class ZeroRecord(TypedDict):
    """A reading of zero and signs as JSON values."""

    convention: Annotated[str, "DH convention."]
    signs: Annotated[list[int], "Of each joint."]
    offsets_deg: Annotated[list[float], "Of each joint, deg."]
    failed: Annotated[int, "Checks by the data sheet that fail."]


@dataclass(frozen=True, slots=True, eq=False)
class ZeroReading:
    """Signs and offsets under one DH convention, and their verdicts by the data sheet's poses."""

    convention: Convention
    rows: tuple[DHRow, ...]
    chain: Chain
    verdicts: tuple[Verdict, ...]
    changes: int
    """Offsets that are not as printed, and signs that differ from the others."""

    @property
    def failed(self) -> int:
        """Checks that fail."""
        return sum(not v.holds for v in self.verdicts)

    @property
    def signs(self) -> tuple[int, ...]:
        """Per joint."""
        return tuple(row.sign for row in self.rows)

    @property
    def offsets_deg(self) -> tuple[float, ...]:
        """Per joint, between -180 and 180."""
        return tuple(180.0 - (180.0 - math.degrees(row.theta_offset)) % 360.0 for row in self.rows)

    def record(self) -> ZeroRecord:
        """As JSON values."""
        signs, offsets = [*self.signs], [*self.offsets_deg]
        return {"convention": self.convention.value, "signs": signs, "offsets_deg": offsets, "failed": self.failed}


@dataclass(frozen=True, slots=True, eq=False)
class ZeroReadings:
    """All readings whose axes at zero are the maker's, the best first; and the table as printed."""

    name: str
    readings: tuple[ZeroReading, ...]
    printed: ZeroReading
    joints: tuple[str, ...]

    @property
    def best(self) -> tuple[ZeroReading, ...]:
        """Readings that fail least and change least: more than one when nothing distinguishes them."""
        least = [(r.failed, r.changes) for r in self.readings]
        return tuple(r for r in self.readings if (r.failed, r.changes) == min(least))


def zero_readings(paper: Paper) -> ZeroReadings:
    """Signs, offsets and DH convention of a robot from its data sheet's poses.

    Raises `MissingDataError` where the file does not give the directions of the joint axes at zero.
    """
    if "poses.axis" not in paper.columns:
        raise MissingDataError(paper.name, "axes of the joints at zero (poses.axis)", "a reading of signs and offsets")
    arm, rows, axes = arm_from_paper(paper), printed_rows(paper), paper.columns["poses.axis"].si()
    judged = [_quickly_judged(arm, paper, rows, c, left) for c in Convention for left in _with_axes(rows, axes, c)]
    least = min((r.failed for r in judged), default=0)
    readings = [_fully_judged(arm, paper, r) if r.failed == least else r for r in judged]
    printed = _fully_judged(arm, paper, _quickly_judged(arm, paper, rows, paper.convention, rows))
    ranked = sorted(readings, key=lambda r: (r.failed, r.changes))
    return ZeroReadings(paper.name, tuple(ranked), printed, paper.joints)


def _with_axes(rows: Sequence[DHRow], axes: Array, convention: Convention) -> Iterator[tuple[DHRow, ...]]:
    """Rows with signs and offsets whose axes at zero are the maker's."""

    def grow(pose: Pose, chosen: tuple[DHRow, ...]) -> Iterator[tuple[DHRow, ...]]:
        i = len(chosen)
        if i == len(rows):
            yield chosen
            return
        for quarter in QUARTERS:
            for sign in (1, -1):
                row = replace(rows[i], sign=sign, theta_offset=rows[i].theta_offset + quarter * math.pi / 2)
                before, after = row.fixed_poses(convention)
                at = pose @ before
                if np.abs(at.rotation[:, 2] - axes[i]).max() <= AXIS:
                    yield from grow(at @ after, (*chosen, row))

    yield from grow(Pose.identity(), ())


def _arm(arm: Arm, rows: Sequence[DHRow], convention: Convention) -> Arm:
    links = []
    for link, row in zip(arm.chain.links, rows, strict=True):
        before, after = row.fixed_poses(convention)
        links.append(replace(link, before=before, after=after, body=None))
    return arm.with_chain(Chain(tuple(links), arm.chain.flange, arm.chain.gravity))


def _quickly_judged(
    arm: Arm, paper: Paper, printed: Sequence[DHRow], convention: Convention, rows: Sequence[DHRow]
) -> ZeroReading:
    """A reading judged by the poses alone: the envelope takes longer."""
    poses = replace(paper, columns={k: v for k, v in paper.columns.items() if not k.startswith("ratings.")})
    posed = replace(_arm(arm, rows, convention), ratings=type(arm.ratings)())
    offsets = sum(abs(a.theta_offset - b.theta_offset) > AXIS for a, b in zip(rows, printed, strict=True))
    against = min(sum(r.sign == s for r in rows) for s in (1, -1))
    return ZeroReading(convention, tuple(rows), posed.chain, tuple(datasheet_verdicts(posed, poses)), offsets + against)


def _fully_judged(arm: Arm, paper: Paper, reading: ZeroReading) -> ZeroReading:
    return replace(reading, verdicts=tuple(datasheet_verdicts(_arm(arm, reading.rows, reading.convention), paper)))


def zero_text(result: ZeroReadings) -> list[str]:
    """The result, line by line."""
    ways = len(Convention) * (2 * len(QUARTERS)) ** len(result.joints)
    out = [
        f"zero and signs: of {ways} ways (DH convention, sign and quarter-turn offset of every joint) "
        f"{len(result.readings)} have the maker's axes at zero",
        f"as printed, {result.printed.convention.value} DH: {_failures(result.printed)}",
    ]
    for convention in Convention:
        readings = [r for r in result.readings if r.convention is convention]
        words = f"{len(readings)} with these axes" + (f"; the best: {_failures(readings[0])}" if readings else "")
        out.append(f"{convention.value} DH: {words}")
    for r in result.best:
        offsets = ", ".join(f"{x:g}" for x in r.offsets_deg)
        out.append(f"reading: {r.convention.value} DH, signs {r.signs}, offsets ({offsets}) deg: {_failures(r)}")
    rivals = [r for r in result.readings if r.failed == result.best[0].failed and r is not result.best[0]]
    others = [r for r in rivals if not same_motion(result.best[0], r)]
    if others:
        out.append(f"UNDECIDED: {len(others)} other readings hold as well and move otherwise; least change first")
    else:
        also = f"; {len(rivals)} more move the flange the same in every pose, frames turned inside" if rivals else ""
        out.append(f"decided by the poses: every other reading breaks a check{also}")
    return out


def same_motion(a: ZeroReading, b: ZeroReading) -> bool:
    """The last frame stands in the same pose at all joint positions."""
    q = np.linspace(-2.0, 2.0, 5)[:, None] * np.sqrt(np.arange(1.0, len(a.rows) + 1.0))
    places = [list(link_frames(r.chain, q))[-1] for r in (a, b)]
    return bool(np.abs(places[0] - places[1]).max() <= AXIS)


def _failures(r: ZeroReading) -> str:
    failed = [v.name for v in r.verdicts if not v.holds]
    hold = f"{len(r.verdicts) - len(failed)} of {len(r.verdicts)} checks hold"
    return f"{hold}; not: {', '.join(failed)}" if failed else hold
