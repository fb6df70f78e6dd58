"""Vectors between neighbouring frames: a printed column of them shows shifted rows and the DH convention.

standard  r_{i-1,i} in frame i    = (a_i,  d_i sin alpha_i, d_i cos alpha_i)
modified  r_{i-1,i} in frame i-1  = (a_i, -d_i sin alpha_i, d_i cos alpha_i)

Neither depends on q of a turning joint, so a paper can print it.
"""

from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.checks.conventions.evidence import Evidence
from lwr_dyn.checks.conventions.printed_table import PrintedTable
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Chain, link_frames
from lwr_dyn.model.dh import Convention
from lwr_dyn.model.spatial import cos_sin

SHIFTS = (0, 1, -1, 2, -2)
"""Rows by which a column may belong lower than printed, the plainest first."""
HALF_UNIT_SLACK = 4.0
"""Half units by which a printed place may be missed: rounded lengths of a table add up."""


@dataclass(frozen=True, slots=True)
class FramesFinding:
    """Misses of one DH convention and row shift against what is printed of the frames."""

    convention: Convention
    shift: int
    rows_missed: int
    """Rows of the vector column that differ from the DH table's."""
    miss: float
    """Largest difference of any of them [m]."""
    place_miss: float
    """Largest distance between a printed place of the flange and the one computed [m]."""
    places_missed: int

    @property
    def fits(self) -> bool:
        """Nothing printed of the frames contradicts it."""
        return self.rows_missed == 0 and self.places_missed == 0


def frame_vectors(table: PrintedTable, convention: Convention) -> Array:
    """r_{i-1,i} of every row, (n, 3) [m]: standard in frame i, modified in frame i-1."""
    turn = 1.0 if convention is Convention.STANDARD else -1.0
    out = []
    for row in table.rows:
        c, s = cos_sin(row.alpha)
        out.append((row.a, turn * row.d * s, row.d * c))
    return np.array(out)


def other_ends(table: PrintedTable, convention: Convention) -> Array:
    """Where the other end of each link lies in its own frame, (n, 3) [m].

    Standard DH puts frame i at the far end of link i: the other end is the origin of frame i-1. Modified DH puts it
    at the near end: the other is the origin of frame i+1, for the last link the flange.
    """
    vectors = frame_vectors(table, convention)
    if convention is Convention.STANDARD:
        return -vectors
    return np.vstack([vectors[1:], table.flange.position])


def reaches(chain: Chain, link: int, com: Array, thickness: float) -> Array:
    """How far the mass of a link can lie from each of its possible coms (O, 3), (O,) [m].

    The farther of the link's two joints, and `thickness` times the reach of the whole arm beyond it.
    """
    links = chain.links
    start = links[link].after.inverse().position
    end = links[link + 1].before.position if link + 1 < chain.n else chain.flange.position
    poses = [pose for x in links for pose in (x.before, x.after)]
    total = sum(float(np.linalg.norm(pose.position)) for pose in (*poses, chain.flange))
    spans = [np.linalg.norm(com - end_point, axis=-1) for end_point in (start, end)]
    reach: Array = np.maximum(*spans) + thickness * total
    return reach


def frames_findings(table: PrintedTable, evidence: Evidence) -> tuple[FramesFinding, ...]:
    """Every pair of convention and row shift with its misses, the best first."""
    conventions = [c for c in Convention if evidence.convention in (None, c.value)]
    shifts = SHIFTS if table.origin is not None else (0,)
    findings = [_finding(table, evidence, c, s) for c in conventions for s in shifts]
    return tuple(sorted(findings, key=lambda f: (f.rows_missed + f.places_missed, abs(f.shift), f.miss)))


def _finding(table: PrintedTable, evidence: Evidence, convention: Convention, shift: int) -> FramesFinding:
    missed, miss = 0, 0.0
    if table.origin is not None:
        wanted = frame_vectors(table, convention)
        printed = shifted(table.origin, shift)
        gap = np.abs(printed - wanted).max(axis=-1)
        gap = gap[np.isfinite(gap)]
        missed, miss = int((gap > table.com_step).sum()), float(gap.max(initial=0.0))
    chain, far, places = table.chain(convention), 0.0, 0
    for place in evidence.places:
        *_, flange = link_frames(chain, np.asarray(place.q))
        distance = float(np.abs(flange[:3, 3] - place.xyz).max())
        far, places = max(far, distance), places + (distance > HALF_UNIT_SLACK * place.half)
    return FramesFinding(convention, shift, missed, miss, far, places)


def shifted(column: Array, shift: int) -> Array:
    """A column moved `shift` rows down, NaN in the rows left empty.

    >>> shifted(np.array([[1.0], [2.0], [3.0]]), 1)[:, 0]
    array([nan,  1.,  2.])
    """
    out = np.full_like(column, np.nan)
    n = len(column)
    for i in range(n):
        if 0 <= i - shift < n:
            out[i] = column[i - shift]
    return out


def with_rows_moved(table: PrintedTable, shift: int) -> PrintedTable:
    """The table with its vector column moved; rows that fall out of it fill blank centres of mass beside it."""
    if table.origin is None or shift == 0:
        return table
    spilled = table.origin[-shift:] if shift > 0 else table.origin[:-shift]
    blank = np.flatnonzero(np.isnan(table.com).any(axis=-1))
    com = table.com.copy()
    for row, value in zip(blank, spilled[: len(blank)], strict=False):
        com[row] = value
    return replace(table, origin=shifted(table.origin, shift), com=com)
