"""Tables IV and VI of the LWR 4+ paper recomputed: worst-case inertias under every reading, and the gains.

Searches for the largest B_ii are cached by all that it depends on: a changed table repeats only those it touches.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.control.inertia.worst_case import InertiaMaximum, diagonal, worst_case_inertia, worst_case_inertias
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.printed_number import agrees
from lwr_dyn.model.spatial import principal_moments
from lwr_dyn.reproduction.papers import printed_tables

AUTHORS = "computed"
"""The reading that the authors computed with."""
PAPER_ZERO = (0.0, 90.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Printed angle minus DH angle [deg]: the paper counts joint 2 from the horizontal."""

_cache: dict[bytes, tuple[float, float]] = {}
"""What B_ii depends on -> its least and most value, or the most value twice."""


@cache
def arms() -> Mapping[str, Arm]:
    """The arm under each of its readings, the authors' first."""
    found = {name: arm_from_paper(open_paper("lwr4plus", name)) for name in (AUTHORS, "printed", "physical")}
    return MappingProxyType(found)


def largest(arm: Arm, joint: int, from_known_maxima: bool = False) -> float:
    """max B_ii [kg m^2] of one joint: by a search, or the largest value at the maxima of the paper's own readings."""
    key = _key(arm, joint) + bytes([from_known_maxima])
    if key not in _cache:
        if from_known_maxima:
            value = float(diagonal(Recursion.of(arm.require_dynamics()), joint, _ends(joint)).max())
        else:
            value = worst_case_inertia(arm, joint).value
        _cache[key] = value, value
    return _cache[key][1]


def at_printed(arm: Arm, joint: int, printed_q: Sequence[str]) -> tuple[float, float]:
    """Least and most B_ii [kg m^2] at a printed configuration: both signs of "+-", "-" free; from a lattice."""
    key = _key(arm, joint) + "/".join(printed_q).encode()
    if key not in _cache:
        _cache[key] = _span(arm, joint, printed_q)
    return _cache[key]


def _span(arm: Arm, joint: int, printed_q: Sequence[str]) -> tuple[float, float]:
    choices = []
    for j, text in enumerate(printed_q):
        if text != "-":
            size = float(text.removeprefix("+-"))
            angles = (size, -size) if text.startswith("+-") else (size,)
            choices.append([(j, math.radians(a - PAPER_ZERO[j])) for a in angles])
    values = []
    for fixed in map(dict, itertools.product(*choices)):
        starts = _lattice(arm, joint, fixed)
        values += [worst_case_inertia(arm, joint, fixed, small, starts).value for small in (True, False)]
    return min(values), max(values)


def _lattice(arm: Arm, joint: int, fixed: dict[int, float]) -> Array:
    """Corners of a 60 deg lattice of the free joints that B_ii depends on; the last joint turns a near-round body."""
    free = [j for j in range(joint + 1, arm.n) if j not in fixed]
    axes = [[0.0] if j == arm.n - 1 else [-2.0, -1.0, 0.1, 1.0, 2.0] for j in free]
    rows = list(itertools.product(*axes))
    points = np.tile((arm.lower + arm.upper) / 2, (len(rows), 1))
    for j, value in fixed.items():
        points[:, j] = value
    points[:, free] = np.array(rows).reshape(len(rows), len(free))
    return points


def _key(arm: Arm, joint: int) -> bytes:
    """All that B_ii depends on: the links from joint i outward, its rotor, the limits of the joints after it."""
    parts = [arm.lower[joint + 1 :], arm.upper[joint + 1 :], arm.armature[joint : joint + 1]]
    for link in arm.chain.links[joint:]:
        body = link.body
        parts += [link.before.matrix(), link.after.matrix()]
        parts += [] if body is None else [np.array([body.mass]), body.com, body.inertia_com]
    return bytes([joint]) + b"".join(np.ascontiguousarray(part).tobytes() for part in parts)


@cache
def _ends(joint: int) -> Array:
    """Where the searches of the package's own readings ended, (k, n)."""
    return np.array([worst_case_inertia(arm, joint).q for arm in arms().values()])


READINGS = ("printed", "computed", "physical")


@dataclass(frozen=True, slots=True, eq=False)
class InertiaRow:
    """One row of Table IV: printed b, its value under each reading, and B_ii at the printed configuration."""

    joint: int
    printed: str
    values: Mapping[str, float]
    printed_q: tuple[str, ...]
    at_printed: tuple[float, float]
    """Smallest and largest B_ii with the printed angles held and the unprinted free [kg m^2]."""
    worst: InertiaMaximum

    def reproduced(self, reading: str) -> bool:
        """To the printed digits."""
        return agrees(self.printed, self.values[reading])

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "joint": self.joint + 1, "printed": self.printed, "values": dict(self.values),
            "search": self.worst.statement(), "reproduced": {name: self.reproduced(name) for name in self.values},
            "at_printed_q": list(self.at_printed),
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class GainCell:
    """One cell of Table VI, recomputed from the printed b."""

    cell: str
    printed: str
    value: float
    fits: str
    """The name of the cell whose value is printed here, if it is another one."""

    @property
    def reproduced(self) -> bool:
        """To the printed digits."""
        return agrees(self.printed, self.value)

    @property
    def verdict(self) -> str:
        """In words."""
        return "reproduced" if self.reproduced else f"printed here: the value of {self.fits}" if self.fits else "open"

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        shown = {"cell": self.cell, "printed": self.printed, "value": self.value, "reproduced": self.reproduced}
        return shown | {"fits": self.fits or None}


def inertia_rows() -> tuple[InertiaRow, ...]:
    """Table IV: B_ii maximised over the joint box under every reading; configurations under the authors'."""
    tables, all_arms = printed_tables("lwr4plus"), arms()
    printed = zip(tables["table_iv"]["b"], tables["table_iv_configurations"]["q"], strict=True)
    worst = {name: worst_case_inertias(arm) for name, arm in all_arms.items()}
    rows = []
    for i, (b, q) in enumerate(printed):
        values = {name: maxima[i].value for name, maxima in worst.items()}
        rows.append(InertiaRow(i, b, values, tuple(q), at_printed(all_arms[AUTHORS], i, q), worst[AUTHORS][i]))
    return tuple(rows)


def inertia_table(rows: Sequence[InertiaRow]) -> Table:
    """Table IV under every reading, the printed configurations, the maximisers, and how they were searched."""
    title = "Table IV, worst-case inertia [kg m^2]; = reproduced to the printed digits; * any; q2 from the horizontal"
    cells = []
    for r in rows:
        values = [f"{r.values[name]:.6g}{' =' if r.reproduced(name) else ''}" for name in READINGS]
        cells.append((r.joint + 1, r.printed, *values, " ".join(r.printed_q), r.at_printed[1], maximisers(r.worst)))
    there = Heading("B_ii there, at most", format=".5g")
    heads = ("joint", "Table IV", *READINGS, "printed q [deg]", there, "maximisers [deg]")
    note = [f"b{r.joint + 1}{r.joint + 1}: {r.worst.statement()}" for r in rows]
    note.append(f"what makes the difference between printed and computed: {' and '.join(errata_that_matter())}")
    return Table(title, heads, cells, "\n".join(note))


def maximisers(worst: InertiaMaximum) -> str:
    """Where B_ii is largest, in the paper's whole degrees, "*" for free joints."""
    rows = (np.degrees(q) + PAPER_ZERO for q in worst.maximisers)
    shown = [" ".join("*" if math.isnan(x) else f"{x:.0f}" for x in row) for row in rows]
    more = worst.distinct - len(shown)
    return " | ".join(shown) + (f" | and {more} more" if more > 0 else "")


def errata_that_matter() -> tuple[str, ...]:
    """The errata by which the reading that reproduces Table IV differs from the printed one."""
    printed, computed = (open_paper("lwr4plus").readings[name].errata for name in ("printed", "computed"))
    return tuple(e for e in computed if e not in printed)


def shell_asymmetry(arm: Arm) -> float:
    """How far the principal moments of the four mirror-image shells (links 1 to 4) lie apart, over their mean."""
    moments = np.array([principal_moments(body.inertia_com) for body in (arm.chain.bodies or ())[:4]])
    return float((np.ptp(moments, axis=0) / moments.mean(axis=0)).max())


def gain_cells() -> tuple[GainCell, ...]:
    """Table VI from xi, omega_n and the printed b of Table IV; a cell that fits elsewhere names the other cell."""
    tables = printed_tables("lwr4plus")
    table = tables["table_vi"]
    gains = second_order_gains([float(x) for x in tables["table_iv"]["b"]], table["omega_n"], table["xi"])
    values = {f"{name}_{i + 1}": float(x) for name in ("Kp", "Kd") for i, x in enumerate(getattr(gains, name))}
    cells = []
    for cell, value in values.items():
        text = table[cell[:2]][int(cell[3:]) - 1]
        others = [other for other, x in values.items() if other != cell and agrees(text, x)]
        cells.append(GainCell(cell, text, value, "" if agrees(text, value) or not others else others[0]))
    return tuple(cells)


def gain_table(cells: Sequence[GainCell]) -> Table:
    """Table VI; an exchanged cell names the cell whose value is printed there."""
    heads = ("cell", "printed", Heading("recomputed", format=".6g"), "verdict")
    rows = [(c.cell, c.printed, c.value, c.verdict) for c in cells]
    return Table("Table VI, gains from omega_n = 50 rad/s, xi = 1 and the printed b", heads, rows)
