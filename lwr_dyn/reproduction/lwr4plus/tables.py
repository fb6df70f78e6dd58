"""Tables IV and VI of the LWR 4+ paper recomputed: worst-case inertias under every reading, and the gains."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.control.worst_case_inertia import InertiaMaximum, worst_case_inertia, worst_case_inertias
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import principal_moments
from lwr_dyn.papers.assembly import arm_from_paper
from lwr_dyn.papers.catalog import open_paper, open_readings
from lwr_dyn.papers.printed_number import agrees
from lwr_dyn.reproduction.printed import printed_tables

PAPER_ZERO = (0.0, 90.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Printed angle minus DH angle [deg]: the paper counts joint 2 from the horizontal."""


@dataclass(frozen=True, slots=True, eq=False)
class InertiaRow:
    """One row of Table IV: printed b, its value under each reading, and what the printed configuration gives."""

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

    @property
    def configuration_holds(self) -> bool:
        """The printed configuration gives the printed value."""
        return agrees(self.printed, self.at_printed[1])


@dataclass(frozen=True, slots=True)
class GainCell:
    """One cell of Table VI, recomputed from the printed b."""

    name: str
    joint: int
    printed: str
    value: float
    fits: str
    """The name of the cell whose value is printed here, if it is another one."""

    @property
    def reproduced(self) -> bool:
        """To the printed digits."""
        return agrees(self.printed, self.value)


def arms() -> dict[str, Arm]:
    """The arm under each of its readings."""
    return {paper.reading.name: arm_from_paper(paper) for paper in open_readings("lwr4plus")}


def table_iv() -> tuple[InertiaRow, ...]:
    """Table IV: B_ii maximised over the joint box under every reading; configurations under the default one."""
    tables = printed_tables("lwr4plus")
    printed = zip(tables["table_iv"]["b"], tables["table_iv_configurations"]["q"], strict=True)
    all_arms = arms()
    worst = {name: worst_case_inertias(arm) for name, arm in all_arms.items()}
    default = next(iter(all_arms))
    rows = []
    for i, (b, q) in enumerate(printed):
        values = {name: found[i].value for name, found in worst.items()}
        span = inertia_at(all_arms[default], i, q)
        rows.append(InertiaRow(i, b, values, tuple(q), span, worst[default][i]))
    return tuple(rows)


def inertia_at(arm: Arm, joint: int, printed_q: Sequence[str]) -> tuple[float, float]:
    """Smallest and largest B_ii at a printed configuration: its signs tried, its "-" free."""
    choices = []
    for j, text in enumerate(printed_q):
        if text == "-":
            continue
        size = float(text.removeprefix("+-"))
        angles = (size, -size) if text.startswith("+-") else (size,)
        choices.append([(j, math.radians(a - PAPER_ZERO[j])) for a in angles])
    least, most = math.inf, -math.inf
    for combination in itertools.product(*choices):
        fixed = dict(combination)
        most = max(most, worst_case_inertia(arm, joint, fixed).value)
        least = min(least, worst_case_inertia(arm, joint, fixed, smallest=True).value)
    return least, most


def shell_spread(arm: Arm) -> float:
    """How far the principal moments of the four mirror-image shells (links 1 to 4) lie apart, over their mean."""
    moments = np.array([principal_moments(body.inertia_com) for body in (arm.chain.bodies or ())[:4]])
    return float((np.ptp(moments, axis=0) / moments.mean(axis=0)).max())


def in_paper_angles(worst: InertiaMaximum) -> list[tuple[str, ...]]:
    """Maximisers in the paper's whole degrees, "*" for free joints."""
    return [
        tuple("*" if math.isnan(x) else f"{math.degrees(x) + zero:.0f}" for x, zero in zip(q, PAPER_ZERO, strict=True))
        for q in worst.maximisers
    ]


def errata_that_matter() -> tuple[str, ...]:
    """The errata by which the reading that reproduces Table IV differs from the printed one."""
    readings = open_paper("lwr4plus").readings
    printed, computed = (readings[name].errata for name in ("printed", "computed"))
    return tuple(e for e in computed if e not in printed)


def table_vi() -> tuple[GainCell, ...]:
    """Table VI from xi, omega_n and the printed b of Table IV; a cell that fits elsewhere names the other cell."""
    tables = printed_tables("lwr4plus")
    table, b = tables["table_vi"], [float(x) for x in tables["table_iv"]["b"]]
    gains = second_order_gains(b, table["omega_n"], table["xi"])
    values = {("Kp", i): float(gains.Kp[i]) for i in range(7)} | {("Kd", i): float(gains.Kd[i]) for i in range(7)}
    cells = []
    for (name, i), value in values.items():
        text = table[name][i]
        others = [f"{n}_{j + 1}" for (n, j), v in values.items() if (n, j) != (name, i) and agrees(text, v)]
        fits = "" if agrees(text, value) or not others else others[0]
        cells.append(GainCell(name, i, text, value, fits))
    return tuple(cells)
