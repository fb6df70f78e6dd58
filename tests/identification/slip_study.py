"""Slips planted in a table, one a trial, and what the trace makes of them.

study = SlipStudy.of(arm, noise=0.1)            # one log of 20 s
outcome = study.outcome(fault, deviation=0.05, rng=rng)
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.identification.regression.information import Information, information_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.identification.slips.hypotheses import FREED, Hypothesis
from lwr_dyn.identification.slips.printed_cells import (
    MASS,
    ROTOR,
    Cell,
    PrintedCells,
    ShownCells,
    printed_cells,
    shown_cells,
)
from lwr_dyn.identification.slips.repairs import exchanges
from lwr_dyn.identification.slips.trace import trace_cells
from lwr_dyn.model.arm import Arm
from tests.identification.plants import Motion, perturbed_plant, random_motion, simulated_samples

WELL_EXCITED = 12
"""Random motions of which the best is logged, in place of an optimised one."""
SAME = 0.1
"""Change of the log, in sigma, below which two tables are one."""


class Fault(NamedTuple):
    """A slip of a table: its kind, the cells that it changes, and the table with it."""

    kind: str
    cells: tuple[Cell, ...]
    table: PrintedCells


def single_faults(table: PrintedCells) -> list[Fault]:
    """Every cell with its sign, its point, or its number (the one of the link before) wrong."""
    faults = []
    for cell in table.cells:
        value = table.value(cell)
        wrong = {"x10": 10.0 * value, "/10": value / 10.0} if value else {}
        if value and cell.quantity not in (MASS, ROTOR):
            wrong["sign"] = -value
        before = Cell(cell.link - 1, cell.quantity)
        if cell.link and cell.quantity != ROTOR and table.value(before) not in (value, 0.0):
            wrong["copy"] = table.value(before)
        faults += [Fault(k, (cell,), table.with_cell(cell, v)) for k, v in wrong.items()]
    return faults


def exchanged_faults(table: PrintedCells) -> list[Fault]:
    """Every exchange of cells, axes, rows, bodies."""
    return [Fault(r.kind, r.cells, r.table) for r in exchanges(table)]


class Outcome(NamedTuple):
    """`seen`: the table does not meet the log; `traced`: likeliest is the fault's cell or one that has its effect, or
    the exchange itself; `listed`: among the explanations; `one`: the only explanation, and no free value (but a copy).
    """

    seen: bool
    traced: bool
    listed: bool
    one: bool


@dataclass(frozen=True)
class SlipStudy:
    """A table that is right, and a log of its arm."""

    arm: Arm
    table: PrintedCells
    information: Information
    shown: ShownCells

    @classmethod
    def of(
        cls, arm: Arm, paper: Paper, motion: Motion | None = None, noise: float = 0.1, duration: float = 20.0
    ) -> SlipStudy:  # fmt: skip
        """A motion at 100 Hz, or the best of some random ones; 0.1 N m of white torque noise."""
        rng, columns = np.random.default_rng(0), TorqueColumns(arm.chain)
        plant = perturbed_plant(columns, arm, rng, 0.0)
        motions = [motion] if motion else [random_motion(arm, duration, rng) for _ in range(WELL_EXCITED)]
        logged = [information_of(simulated_samples(plant, m, noise, rng), columns) for m in motions]
        information = max(logged, key=lambda x: np.linalg.slogdet(x.precision)[1])
        return cls(arm, printed_cells(paper), information, shown_cells(information, printed_cells(paper)))

    def log(self, off: float, rng: np.random.Generator) -> Information:
        """Another log of the same motion, of an arm that is `off` (a share) its table."""
        columns = self.information.columns
        plant = perturbed_plant(columns, self.arm, rng, off)
        noise = np.linalg.solve(self.information.factor, rng.normal(size=self.information.base.count))
        return replace(self.information, values=plant.base + noise)

    def outcome(self, fault: Fault, off: float, rng: np.random.Generator, deviation: float | None = None) -> Outcome:
        """One trial; the trace takes the arm to be `off` its table unless told otherwise."""
        report = trace_cells(self.log(off, rng), fault.table, deviation=off if deviation is None else deviation)
        found = report.explanations
        right = [self._right(fault, e) for e in found]
        stated = [len(e.repairs) == 1 and (e.repairs[0].kind not in FREED or fault.kind == "copy") for e in found]
        alone = len(found) == 1 and right[0] and stated[0]
        return Outcome(not report.fits, bool(right and right[0]), any(right), alone)

    def _away(self, table: PrintedCells) -> np.ndarray:
        columns, n = self.information.columns, self.table.n
        own = [*range(10 * n), *columns.rotor_indices]
        change = table.parameters() - self.table.parameters()
        return np.asarray(self.information.base.grouping[:, own] @ change)

    def _right(self, fault: Fault, explanation: Hypothesis) -> bool:
        """The fault undone; or only its cell, or one that no motion can tell from it, changed."""
        if len(explanation.repairs) == 1:
            cells = explanation.repairs[0].cells
            if len(fault.cells) == 1 == len(cells) and cells[0] in self.shown.like(fault.cells[0]):
                return True
        return bool(np.linalg.norm(self.information.factor @ self._away(explanation.table)) < SAME)


def shares(outcomes: Iterable[Outcome]) -> str:
    """How many were seen, and of those traced, listed, traced to one repair."""
    every = np.array(list(outcomes))
    traced, listed, one = every[every[:, 0], 1:].mean(axis=0) if every[:, 0].any() else np.zeros(3)
    said = f"{len(every)} planted, {every[:, 0].sum()} seen; traced {traced:.1%}, listed {listed:.1%}"
    return f"{said}, one repair {one:.1%}"
