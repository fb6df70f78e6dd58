"""Where a maker counts joints from and which way: DH convention, signs and offsets by the poses of a data sheet.

Each joint's angle is theta_i = sign_i q_i + offset_i, with offsets by quarter turns. The axes that the maker draws at
q = 0 fix them joint by joint, from the base outward; what then remains is judged by the places and turns that are
printed of the flange and the wrist, by the limits and by the envelope, all of `checks.datasheet`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.audit.conventions.printed import printed_rows
from lwr_dyn.checks.datasheet import datasheet_verdicts
from lwr_dyn.checks.verdict import Verdict
from lwr_dyn.errors import MissingDataError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Chain, link_frames
from lwr_dyn.model.dh import Convention, DHRow
from lwr_dyn.model.spatial import Pose
from lwr_dyn.papers.assembly import arm_from_paper
from lwr_dyn.papers.schema import Paper

AXIS = 1e-9
"""Entries of an axis may differ by this: angles are whole quarter turns."""
QUARTERS = (0, 1, -1, 2)
"""Quarter turns that an offset may be moved by, the plainest first."""


@dataclass(frozen=True, slots=True, eq=False)
class ZeroReading:
    """Signs and offsets under one DH convention, and what the data sheet's poses say of them."""

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


@dataclass(frozen=True, slots=True, eq=False)
class ZeroResolution:
    """All readings whose axes at zero are the maker's, the best first; and the table as printed."""

    name: str
    readings: tuple[ZeroReading, ...]
    printed: ZeroReading
    joints: tuple[str, ...]
    axes_only: int
    """How many the axes alone leave."""

    @property
    def best(self) -> tuple[ZeroReading, ...]:
        """Readings that fail least and change least: more than one when they cannot be told apart."""
        least = [(r.failed, r.changes) for r in self.readings]
        return tuple(r for r in self.readings if (r.failed, r.changes) == min(least))


def resolve_zero(paper: Paper) -> ZeroResolution:
    """Signs, offsets and DH convention of a robot from its data sheet's poses.

    Raises
    ------
    MissingDataError
        The file does not say how the joint axes point at zero.
    """
    if "poses.axis" not in paper.columns:
        raise MissingDataError(paper.name, "axes of the joints at zero (poses.axis)", "a reading of signs and offsets")
    arm, rows, axes = arm_from_paper(paper), printed_rows(paper), paper.columns["poses.axis"].si()
    found = []
    for convention in Convention:
        leaves = list(_with_axes(rows, axes, convention))
        found += [(convention, leaf) for leaf in leaves]
    judged = [_cheap(arm, paper, rows, convention, leaf) for convention, leaf in found]
    least = min((r.failed for r in judged), default=0)
    full = [_full(arm, paper, r) if r.failed == least else r for r in judged]
    printed = _full(arm, paper, _cheap(arm, paper, rows, paper.convention, rows))
    return ZeroResolution(
        name=paper.name, readings=tuple(sorted(full, key=lambda r: (r.failed, r.changes))), printed=printed,
        joints=paper.joints, axes_only=len(found),
    )  # fmt: skip


def _with_axes(rows: Sequence[DHRow], axes: Array, convention: Convention) -> Iterator[tuple[DHRow, ...]]:
    """Rows with signs and offsets whose axes at zero are the maker's."""

    def grow(pose: Pose, done: tuple[DHRow, ...]) -> Iterator[tuple[DHRow, ...]]:
        i = len(done)
        if i == len(rows):
            yield done
            return
        for quarter in QUARTERS:
            for sign in (1, -1):
                row = replace(rows[i], sign=sign, theta_offset=rows[i].theta_offset + quarter * math.pi / 2)
                before, after = row.fixed_poses(convention)
                at = pose @ before
                if np.abs(at.rotation[:, 2] - axes[i]).max() <= AXIS:
                    yield from grow(at @ after, (*done, row))

    yield from grow(Pose.identity(), ())


def _arm(arm: Arm, rows: Sequence[DHRow], convention: Convention) -> Arm:
    links = []
    for link, row in zip(arm.chain.links, rows, strict=True):
        before, after = row.fixed_poses(convention)
        links.append(replace(link, before=before, after=after, body=None))
    return arm.with_chain(Chain(tuple(links), arm.chain.flange, arm.chain.gravity))


def _cheap(
    arm: Arm, paper: Paper, printed: Sequence[DHRow], convention: Convention, rows: Sequence[DHRow]
) -> ZeroReading:
    """Judged by the poses alone: the envelope takes longer."""
    poses = replace(paper, columns={k: v for k, v in paper.columns.items() if not k.startswith("ratings.")})
    posed = replace(_arm(arm, rows, convention), ratings=type(arm.ratings)())
    offsets = sum(abs(a.theta_offset - b.theta_offset) > AXIS for a, b in zip(rows, printed, strict=True))
    against = min(sum(r.sign == s for r in rows) for s in (1, -1))
    return ZeroReading(convention, tuple(rows), posed.chain, tuple(datasheet_verdicts(posed, poses)), offsets + against)


def _full(arm: Arm, paper: Paper, reading: ZeroReading) -> ZeroReading:
    return replace(reading, verdicts=tuple(datasheet_verdicts(_arm(arm, reading.rows, reading.convention), paper)))


def zero_statements(found: ZeroResolution) -> list[str]:
    """What was found, line by line."""
    ways = len(Convention) * (2 * len(QUARTERS)) ** len(found.joints)
    out = [
        f"zero and signs: of {ways} ways (DH convention, sign and quarter-turn offset of every joint) "
        f"{found.axes_only} have the maker's axes at zero"
    ]
    out.append(f"as printed, {found.printed.convention.value} DH: {_failures(found.printed)}")
    for convention in Convention:
        here = [r for r in found.readings if r.convention is convention]
        words = f"{len(here)} with these axes" + (f"; the best: {_failures(here[0])}" if here else "")
        out.append(f"{convention.value} DH: {words}")
    for r in found.best:
        offsets = ", ".join(f"{x:g}" for x in r.offsets_deg)
        out.append(f"reading: {r.convention.value} DH, signs {r.signs}, offsets ({offsets}) deg: {_failures(r)}")
    rivals = [r for r in found.readings if r.failed == found.best[0].failed and r is not found.best[0]]
    others = [r for r in rivals if not same_motion(found.best[0], r)]
    if others:
        out.append(f"UNDECIDED: {len(others)} other readings hold as well and move otherwise; least change first")
    else:
        also = f"; {len(rivals)} more move the flange the same in every pose, frames turned inside" if rivals else ""
        out.append(f"decided by the poses: every other reading breaks a check{also}")
    return out


def same_motion(a: ZeroReading, b: ZeroReading) -> bool:
    """Whether two readings put the last frame in the same place whatever the joints do."""
    q = np.linspace(-2.0, 2.0, 5)[:, None] * np.sqrt(np.arange(1.0, len(a.rows) + 1.0))
    places = [list(link_frames(r.chain, q))[-1] for r in (a, b)]
    return bool(np.abs(places[0] - places[1]).max() <= AXIS)


def _failures(r: ZeroReading) -> str:
    failed = [v.name for v in r.verdicts if not v.holds]
    hold = f"{len(r.verdicts) - len(failed)} of {len(r.verdicts)} checks hold"
    return f"{hold}; not: {', '.join(failed)}" if failed else hold
