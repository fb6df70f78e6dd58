"""One entry of B, C or g in closed form, from the links' Jacobians; no other entry is derived than it needs.

    B_ij = sum m Jv_i . Jv_j + Jw_i . I Jw_j + Ia_i (i = j),      g_i = -sum m g_0 . Jv_i

over the links from joint max(i, j) on, in each link's own frame; C is the Christoffel form of B.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import sympy as sp

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.dynamics.symbolic.arm_equations import gravity_symbols, symbol_values, symbolic_links
from lwr_dyn.dynamics.symbolic.equation_text import expression_text
from lwr_dyn.dynamics.symbolic.link_motion import SymbolicLink, Variables
from lwr_dyn.dynamics.symbolic.trigonometry import normal_form, readable
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.chain import Chain

LONGEST_SHORTENED = 60
"""[terms] A longer entry is printed as it is expanded: to shorten it takes minutes."""


@dataclass(frozen=True, slots=True)
class LinkColumn:
    """What a joint does to a link: velocity of the frame's origin and angular velocity, (3, 1) in the link's frame."""

    v: sp.Matrix
    w: sp.Matrix


@dataclass(frozen=True, eq=False)
class SymbolicEntries:
    """Entries of B, C and g of a chain of links, each derived when asked for."""

    links: Sequence[SymbolicLink]
    gravity: sp.Matrix
    values: Mapping[str, float]
    """Numbers of the letters."""
    _found: dict[tuple[int, int], Any] = field(default_factory=dict)

    @cached_property
    def variables(self) -> Variables:
        """Positions, speeds and accelerations of the joints."""
        return Variables.of([link.joint for link in self.links if link.joint is not None])

    @cached_property
    def columns(self) -> list[list[LinkColumn]]:
        """`columns[i][k - i]`: what joint i does to link k, 0-based."""
        return [self._column(i) for i in range(len(self.links))]

    def mass(self, i: int, j: int) -> Any:
        """B_ij, 0-based, in normal form."""
        i, j = min(i, j), max(i, j)
        if (i, j) not in self._found:
            shares = [self._share(k, i, j) for k in range(j, len(self.links))]
            rotor = self.links[i].armature if i == j else sp.S.Zero
            self._found[i, j] = normal_form(sp.Add(*shares, rotor), self.variables.q)
        return self._found[i, j]

    def coriolis(self, i: int, j: int) -> Any:
        """C_ij = sum_k (dB_ij/dq_k + dB_ik/dq_j - dB_jk/dq_i) dq_k / 2 (Siciliano eqs. 7.44, 7.45)."""
        q, dq = self.variables.q, self.variables.dq
        if i == j:  # half of dB_ii/dt: the other terms cancel
            return normal_form(sp.Add(*(self.mass(i, i).diff(q[k]) * dq[k] / 2 for k in range(len(q)))), q)
        terms = [
            (self.mass(i, j).diff(q[k]) + self.mass(i, k).diff(q[j]) - self.mass(j, k).diff(q[i])) * dq[k] / 2
            for k in range(len(q))
        ]
        return normal_form(sp.Add(*terms), q)

    def weight(self, i: int) -> Any:
        """g_i, in normal form (Siciliano eq. 7.39)."""
        shares = []
        g = self.gravity
        for k, link in enumerate(self.links):
            g = normal_form(link.pose[:3, :3].T * g, self.variables.q)
            if k >= i and link.body is not None:
                shares.append(-link.body.mass * g.dot(self._centre(i, k)))
        return normal_form(sp.Add(*shares), self.variables.q)

    def text(self, letter: str, i: int, j: int = 0) -> str:
        """The right side of an entry's equation, shortened where it is not too long; 0-based."""
        x = self.variables
        entry = {"B": self.mass, "C": self.coriolis}[letter](i, j) if letter != "g" else self.weight(i)
        if len(sp.Add.make_args(entry)) > LONGEST_SHORTENED:
            return expression_text(entry)
        weights = sorted((s for s in entry.free_symbols if s.name[0] in "mI"), key=str)
        return expression_text(readable(entry, (*x.ddq, *x.dq), weights))

    def _column(self, i: int) -> list[LinkColumn]:
        q, link = self.variables.q, self.links[i]
        turn = link.pose[:3, :3].T
        here = LinkColumn(normal_form(turn * link.pose[:3, 3].diff(link.joint), q), link.axis)
        out = [here]
        for beyond in self.links[i + 1 :]:
            turn, arm = beyond.pose[:3, :3].T, beyond.pose[:3, 3]
            here = LinkColumn(normal_form(turn * (here.v + here.w.cross(arm)), q), normal_form(turn * here.w, q))
            out.append(here)
        return out

    def _centre(self, i: int, k: int) -> sp.Matrix:
        body, column = self.links[k].body, self.columns[i][k - i]
        return column.v if body is None else column.v + column.w.cross(body.com)

    def _share(self, k: int, i: int, j: int) -> Any:
        body = self.links[k].body
        if body is None:
            return sp.S.Zero
        spin = self.columns[i][k - i].w.dot(body.inertia_com * self.columns[j][k - j].w)
        return body.mass * self._centre(i, k).dot(self._centre(j, k)) + spin


def symbolic_entries(chain: Chain, paper: Paper | None = None) -> SymbolicEntries:
    """The entries of a chain, letters as in `equations_of_motion` with `keep_zeros`; a paper names its own lengths.

    Lengths are numbers where a paper has none for all of the chain.
    """
    try:
        links = symbolic_links(chain, paper, chain.bodies)
    except OptionError:
        links, paper = symbolic_links(chain, None, chain.bodies), None
    return SymbolicEntries(links, gravity_symbols(chain.gravity), symbol_values(chain, paper))


def entry_text(robot: str | Path, entry: str, reading: str | None = None) -> str:
    """The right side of one entry's equation for a robot's name or a file, such as "B_23", "C_11" or "g_4".

    An entry that many joints take part in is long, and may take minutes.

    Raises
    ------
    OptionError
        No entry of that name.
    MissingDataError
        An arm without masses. And what `lwr_dyn.load` raises.

    >>> entry_text("lwr4plus", "B_77")
    'I7zz + Ia7'
    """
    arm, paper = load_with_paper(robot, reading)
    entries = symbolic_entries(arm.require_dynamics(), paper)
    found = named_entries(len(entries.links))
    if entry not in found:
        raise OptionError("entry", entry, "B_ij, C_ij or g_i with the joints' numbers, such as B_23")
    return entries.text(*found[entry])


def named_entries(n: int) -> dict[str, tuple[str, int, int]]:
    """Letter, row and column (from 0) of each entry of B, C and g, by its name; beyond nine joints as B_2,10.

    >>> named_entries(2)["C_21"], named_entries(2)["g_2"]
    (('C', 1, 0), ('g', 1, 0))
    """
    comma = "," if n > 9 else ""
    square = {f"{m}_{i + 1}{comma}{j + 1}": (m, i, j) for m in "BC" for i in range(n) for j in range(n)}
    return square | {f"g_{i + 1}": ("g", i, 0) for i in range(n)}
