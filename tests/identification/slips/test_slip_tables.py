"""Every cell of a table against a log, and the card: every cell in its place, what is off, and the repairs."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.identification.logs.joint_log import write_log
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.identification.slips.hypotheses import as_printed, log_evidence
from lwr_dyn.identification.slips.printed_cells import QUANTITIES, Cell
from lwr_dyn.identification.slips.repairs import of_cells
from lwr_dyn.identification.slips.slip_tables import (
    HIDDEN,
    OFF,
    OTHERS,
    best_table,
    slip_document,
    slips_card,
    table_against_log,
    table_card,
)
from lwr_dyn.identification.slips.trace import trace_slips
from lwr_dyn.model.chain import Body, with_bodies
from lwr_dyn.pages.document import table_html
from tests.identification.plants import Plant, random_motion, simulated_log, simulated_samples
from tests.identification.slips import test_printed_cells


def test_every_cell_against_the_log(study):
    information = study.log(0.0, np.random.default_rng(5))
    paper = open_paper("lwr4plus", "physical")
    rows = {row.cell.name: row for row in table_against_log(information, paper, deviation=0.0)}
    assert len(rows) == 77
    assert sorted(name for name, row in rows.items() if row.sigma == np.inf) == sorted(test_printed_cells.HIDDEN)
    pulls = np.array([row.pull for row in rows.values() if np.isfinite(row.sigma)])
    assert np.abs(pulls).max() < 4.0
    wrong = as_printed(log_evidence(information, study.table, 0.0), study.table.with_cell(Cell(3, 9), 0.0879))
    row = {r.cell.name: r for r in table_against_log(information, paper, deviation=0.0, at=wrong)}["I4zz"]
    assert row.state == OFF
    assert abs(row.value - study.table.value(Cell(3, 9))) < 4 * row.sigma
    assert rows["c5z"].like == (Cell(5, 2),)


@pytest.fixture(scope="module")
def information(lwr):
    """What a log of the arm as it is says, its friction aside."""
    columns, rng = TorqueColumns(lwr.chain), np.random.default_rng(2)
    plant = Plant(columns, columns.own(lwr))
    return information_of(simulated_samples(plant, random_motion(lwr, 20.0, rng), 0.1, rng, slowest=0.05), columns)


@pytest.fixture(scope="module")
def slipped(lwr):
    """The arm with the mass of link 4 times ten."""
    bodies = [link.body for link in lwr.chain.links]
    heavy = bodies[3]
    bodies[3] = Body(10.0 * heavy.mass, heavy.com, heavy.inertia_com)
    return replace(lwr, chain=with_bodies(lwr.chain, bodies))


def darkest(table):
    return max(shade or 0.0 for row in table.shades for shade in row)


def test_a_right_table_agrees(information, lwr):
    (section,) = table_card(information, lwr)
    cells, notes = section.parts
    assert section.title == "The table against the logs, cell by cell"
    assert [h.head for h in cells.columns] == ["link", *QUANTITIES]
    assert darkest(cells) == 0.0
    assert "lwr-dyn identify table" in notes.lines[0]
    found = table_against_log(information, lwr)
    assert sum(text == "\u00b7" for row in cells.cells for text in row) == sum(one.state == HIDDEN for one in found)
    bare = replace(lwr, chain=with_bodies(lwr.chain, [None] * 7))
    assert table_card(information, bare) == ()


def test_a_slip_is_dark_in_its_place(information, slipped):
    ((cells, off, _),) = (one.parts for one in table_card(information, slipped))
    found = {one.cell.name: one for one in table_against_log(information, slipped)}
    column = 1 + INERTIAL.index("m")
    assert found["m4"].state == OFF
    assert cells.rows[3][column] is not None
    assert cells.shades[3][column] == darkest(cells) == 0.55
    assert cells.cells[3][column] == f"{found['m4'].pull:.1f}".replace("-", "\u2212")
    assert off.rows[0][0] == max(found.values(), key=lambda one: abs(one.pull)).cell.name
    assert len(off.rows) == sum(one.state == OFF for one in found.values())
    dark = 'style="background:color-mix(in srgb, var(--alarm) 55%, transparent)"'
    assert dark in table_html(cells.shown(page=True))


def test_repairs_are_listed_and_the_cells_after_them_agree(information, slipped):
    slips = trace_slips(information, slipped)
    repairs, after, printed, _, notes = slips_card(information, slipped, slips).parts
    assert ("m4" in repairs.rows[0][1], len(repairs.rows)) == (True, len(slips.explanations))
    assert notes.lines[0].startswith("The table does not meet the logs (chi squared")
    assert "explanation 1" in after.title
    assert darkest(after) == 0.0 < darkest(printed)


def said(report, information, arm):
    """The lines of the document above its table."""
    cells = table_against_log(information, arm, deviation=report.deviation, at=best_table(report))
    return slip_document(report, cells, open_paper("lwr4plus", "physical")).text().split("\n\n")[0].splitlines()


def test_the_document_begins_with_the_verdict_the_repairs_and_what_may_stand_in_their_place(information, slipped):
    slips = trace_slips(information, slipped)
    best, table = slips.explanations[0], slips.explanations[0].table
    verdict, repair, last = said(slips, information, slipped)
    assert verdict.startswith("the table does not meet the log (chi^2 ")
    assert verdict.endswith("with the arm itself 0.05 off a right table); it does with 1 repair:")
    assert f"furthest cell {slips.pull.sigmas:.3g} sigma (m4), at most {slips.pull.limit:.2g}" in verdict
    assert (repair, last) == (f"- {best.repairs[0].text}", f"chi^2 with them: {best.chi2:.4g}")
    changes = [x for x in of_cells(table) if x.kind == "sign"][: OTHERS + 2]
    instead = tuple(replace(best, repairs=(x,)) for x in changes)
    two = replace(best, repairs=tuple(changes[:2]))
    open_question = replace(slips, explanations=(best, *instead, two), deviation=0.0)
    lines = said(open_question, information, slipped)
    assert "with the arm exactly as a right table" in lines[0]
    assert lines[2:-1] == [*(f"  or {x.text}" for x in changes[:OTHERS]), "  or one of 2 more"]
    unexplained = said(replace(slips, explanations=()), information, slipped)
    assert unexplained[0].endswith("and no repairs were found with which it does")
    assert unexplained[1:] == [f"nearest: {x.text}" for x in slips.nearest.repairs]
    fitting = replace(slips, printed=best, pull=slips.pull._replace(sigmas=0.5, cell=None), explanations=())
    line, *_ = said(fitting, information, slipped)
    assert line.startswith(f"the table meets the log: chi^2 {best.chi2:.4g}, at most ")
    assert f"furthest cell 0.5 sigma, at most {slips.pull.limit:.2g}" in line


def test_the_command_writes_it(lwr, tmp_path, lwr_dyn_command):
    columns, rng = TorqueColumns(lwr.chain, "directions"), np.random.default_rng(3)
    plant = Plant(columns, columns.own(lwr))
    log = simulated_log(plant, random_motion(lwr, 5.0, rng, rate=500.0), 0.1, rng, 1e-5)
    write_log(tmp_path / "log.csv", log)
    page = tmp_path / "table.html"
    command = ("identify", "table", "lwr4plus", str(tmp_path / "log.csv"), "--reading", "physical")
    code, out, err = lwr_dyn_command(*command, "--html", str(page))
    assert (code, err) == (0, "")
    assert out.splitlines()[-1] == f"wrote {page}"
    text = page.read_text(encoding="utf-8")
    assert "The table meets the logs as printed" in text
    assert "lwr-dyn identify table." in text
