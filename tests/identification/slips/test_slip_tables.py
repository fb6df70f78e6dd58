"""Every cell of a table against a log."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.identification.slips.hypotheses import as_printed, log_evidence
from lwr_dyn.identification.slips.printed_cells import Cell
from lwr_dyn.identification.slips.slip_tables import OFF, table_against_log
from tests.identification.slip_study import SlipStudy

HIDDEN = ["m1", "c1x", "c1y", "c1z", "I1xx", "I1xy", "I1xz", "I1yz", "I1zz", "c2y"]


def test_every_cell_against_the_log(study: SlipStudy) -> None:
    information = study.log(0.0, np.random.default_rng(5))
    paper = open_paper("lwr4plus", "physical")
    rows = {row.cell.name: row for row in table_against_log(information, paper, deviation=0.0)}
    assert len(rows) == 77
    assert sorted(name for name, row in rows.items() if row.sigma == np.inf) == sorted(HIDDEN)
    pulls = np.array([row.pull for row in rows.values() if np.isfinite(row.sigma)])
    assert np.abs(pulls).max() < 4.0
    wrong = replace(as_printed(log_evidence(information, study.table, 0.0), study.table.with_cell(Cell(3, 9), 0.0879)))
    row = {r.cell.name: r for r in table_against_log(information, paper, deviation=0.0, at=wrong)}["I4zz"]
    assert row.state == OFF
    assert abs(row.value - study.table.value(Cell(3, 9))) < 4 * row.sigma
    assert rows["c5z"].like == (Cell(5, 2),)
