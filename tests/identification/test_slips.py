"""Slips of a table traced by a log: the cells and what they stand for, what motions show, planted slips found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.slips.hypotheses import as_printed, link_discrepancies, log_evidence, table_pseudo_inertias
from lwr_dyn.identification.slips.printed_cells import Cell, printed_cells
from lwr_dyn.identification.slips.repairs import exchanges, of_cells, of_columns
from lwr_dyn.identification.slips.slip_tables import OFF, slip_lines, table_against_log
from lwr_dyn.identification.slips.trace import trace_cells, trace_slips
from tests.identification.slip_study import SlipStudy, exchanged_faults, shares, single_faults

READINGS = [("lwr4plus", "printed"), ("lwr4plus", "physical"), ("wam7", None), ("kr30ha", None)]
HIDDEN = ["m1", "c1x", "c1y", "c1z", "I1xx", "I1xy", "I1xz", "I1yz", "I1zz", "c2y"]
PAIRS = [["I1yy", "rotor1"], ["m2", "c2z"], ["I2yy", "rotor2"], ["c3z", "c4y"], ["c5z", "c6y"]]


@pytest.fixture(scope="module")
def study() -> SlipStudy:
    return SlipStudy.of(lwr_dyn.load("lwr4plus", "physical"), open_paper("lwr4plus", "physical"))


@pytest.mark.parametrize(("robot", "reading"), READINGS)
def test_the_cells_stand_for_the_parameters_of_the_arm(robot: str, reading: str | None) -> None:
    paper, arm = open_paper(robot, reading), lwr_dyn.load(robot, reading)
    for source in (paper, arm):
        table = printed_cells(source)
        for i, link in enumerate(arm.chain.links):
            assert link.body is not None
            own = body_parameters(link.body)
            known = ~table.open_parameters[i, :10]
            got = table.parameters()[10 * i : 10 * i + 10]
            np.testing.assert_allclose(got[known], own[known], rtol=1e-12, atol=1e-12 * abs(own).max())
            if link.rotor is not None:
                np.testing.assert_allclose(table.parameters()[10 * arm.n + i], link.rotor.armature, rtol=1e-12)


def test_the_derivative_is_exact() -> None:
    table = printed_cells(open_paper("lwr4plus", "printed"))  # about the centres of mass: squares of the cells
    D = table.derivatives(table.cells)
    for k in (1, 3, 30, 58, 76):
        cell = table.cells[k]
        step = 1e-7
        up, down = (table.with_cell(cell, table.value(cell) + s).parameters() for s in (step, -step))
        np.testing.assert_allclose(D[:, k], (up - down) / (2 * step), atol=1e-7)


def test_the_discrepancy_is_the_inverse_hessian_of_the_log_det() -> None:
    table = printed_cells(open_paper("lwr4plus", "physical"))
    P, spread = table_pseudo_inertias(table), link_discrepancies(table)
    units = np.eye(77).reshape(77, 77)[: 10 * table.n]
    for i in range(table.n):
        E = np.array([_pseudo_inertia_of(units[10 * i + a, 10 * i : 10 * i + 10]) for a in range(10)])
        inverse = np.linalg.inv(P[i])
        hessian = np.einsum("ij,ajk,kl,bli->ab", inverse, E, inverse, E)
        np.testing.assert_allclose(spread[i, :10, :10] @ hessian, np.eye(10), atol=1e-8)
        assert spread[i, 10, 10] == pytest.approx(table.parameters()[70 + i] ** 2)


def _pseudo_inertia_of(pi: np.ndarray) -> np.ndarray:
    m, mx, my, mz, xx, xy, xz, yy, yz, zz = pi
    half = (xx + yy + zz) / 2
    return np.array([[half - xx, -xy, -xz, mx], [-xy, half - yy, -yz, my], [-xz, -yz, half - zz, mz], [mx, my, mz, m]])


def test_chi2_is_that_of_the_log_with_friction_at_its_best(study: SlipStudy) -> None:
    rng = np.random.default_rng(3)
    information = study.log(0.0, rng)
    fault = single_faults(study.table)[40]
    evidence = log_evidence(information, fault.table, 0.0)
    columns, base, R = information.columns, information.base, information.factor
    own = [*range(70), *columns.rotor_indices]
    others = np.setdiff1d(np.arange(columns.count), own)
    away = R @ (base.grouping[:, own] @ fault.table.parameters() - information.values)
    friction = np.linalg.lstsq(R @ base.grouping[:, others], -away, rcond=None)[0]
    left = away + R @ base.grouping[:, others] @ friction
    assert as_printed(evidence, fault.table).chi2 == pytest.approx(left @ left, rel=1e-7)
    assert evidence.directions == 48  # bodies with rotors: 69 with viscous, Coulomb and offset


def test_ten_cells_show_in_no_motion_and_ten_only_as_pairs(study: SlipStudy) -> None:
    assert [c.name for c in study.shown.hidden] == HIDDEN
    assert [[c.name for c in group] for group in study.shown.together] == PAIRS
    assert len(study.shown.alone) == 57
    assert study.shown.like(Cell(4, 3)) == (Cell(4, 3), Cell(5, 2))


@pytest.mark.parametrize("reading", ["printed", "physical"])
def test_a_repair_done_again_on_what_it_made_is_said_and_changes_something(reading: str) -> None:
    table = printed_cells(open_paper("lwr4plus", reading))
    for repair in exchanges(table):
        again = repair.again(repair.table)
        if "exchanged" in repair.text:
            np.testing.assert_array_equal(again.table.values, table.values)
        assert repair.cells
    for repair in of_cells(table):
        assert (repair.table.parameters() != table.parameters()).any()
    for repair in (*of_cells(table), *of_columns(table)):
        again = repair.again(table)
        assert again.text == repair.text
        np.testing.assert_array_equal(again.table.parameters(), repair.table.parameters())


@pytest.mark.parametrize("off", [0.0, 0.01, 0.05])
def test_a_right_table_meets_the_log(study: SlipStudy, off: float) -> None:
    rng = np.random.default_rng(11)
    for _ in range(5):
        assert trace_cells(study.log(off, rng), study.table, deviation=2 * off).fits


def test_without_deviation_an_arm_off_its_table_would_have_slips(study: SlipStudy) -> None:
    assert not trace_cells(study.log(0.2, np.random.default_rng(1)), study.table, deviation=0.0, most=1).fits


def test_the_copied_cell_of_the_paper_is_named_with_its_partner(study: SlipStudy) -> None:
    rng = np.random.default_rng(0)
    printed = study.table.with_cell(Cell(4, 3), -0.004375432)
    report = trace_cells(study.log(0.02, rng), printed, deviation=0.05)
    assert {c.name for c in report.cells} == {"c5z", "c6y"}
    assert report.explanations[0].repairs[0].text.endswith("which repeats c6z")
    value = report.explanations[0].table.value(Cell(4, 3))
    assert abs(value + 0.0238) < 0.002
    assert not report.fits


@pytest.mark.parametrize(("off", "traced", "one"), [(0.0, 0.95, 0.8), (0.05, 0.9, 0.7)])
def test_planted_slips_are_traced(study: SlipStudy, off: float, traced: float, one: float) -> None:
    rng = np.random.default_rng(7)
    faults = [*single_faults(study.table)[3::15], *exchanged_faults(study.table)[5::18]]
    outcomes = [study.outcome(fault, off, rng) for fault in faults]
    seen = [o for o in outcomes if o.seen]
    assert len(seen) > 12
    assert sum(o.listed for o in seen) >= traced * len(seen), shares(outcomes)
    assert sum(o.one for o in seen) >= one * len(seen), shares(outcomes)


def test_the_errata_of_the_paper_are_found_in_its_printed_tables(study: SlipStudy) -> None:
    information = study.log(0.01, np.random.default_rng(2))
    report = trace_slips(information, open_paper("lwr4plus", "printed"), deviation=0.02)
    best = [r.text for r in report.explanations[0].repairs]
    assert [text for text in best if text.startswith("c5z")]
    assert {text for text in best if not text.startswith("c5z")} == {
        "rotor of all links times 100", "tensor of all links about the link's origin",
        "products of inertia of all links of the other sign", "axes y and z of the tensor of link 2 exchanged",
        "axes y and z of the tensor of link 4 exchanged",
    }  # fmt: skip
    assert any(r.text.startswith("c6y") for repairs in report.alternatives for r in repairs)


@pytest.mark.parametrize("factor", [0.8, 1.25])
def test_a_heavier_arm_is_said_beside_the_cell_that_the_search_would_blame(study: SlipStudy, factor: float) -> None:
    heavier = study.table.values.copy()
    heavier[:, :1] *= 1.0 / factor
    heavier[:, 4:10] *= 1.0 / factor
    report = trace_cells(study.log(0.01, np.random.default_rng(3)), study.table.with_values(heavier), deviation=0.05)
    assert not report.fits
    assert report.common_factor == pytest.approx(factor, rel=0.02)
    assert "or no cell is wrong: the table meets the log with all masses" in slip_lines(report)[-1]


def test_of_a_table_with_a_slip_no_factor_is_said(study: SlipStudy) -> None:
    printed = study.table.with_cell(Cell(4, 3), -0.004375432)
    assert trace_cells(study.log(0.0, np.random.default_rng(0)), printed, deviation=0.0).common_factor is None


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


def test_bad_input(study: SlipStudy) -> None:
    for deviation in (-0.1, 1.0, float("nan")):
        with pytest.raises(OptionError, match="deviation"):
            trace_slips(study.information, study.arm, deviation=deviation)
    with pytest.raises(OptionError, match="gives no mass"):
        printed_cells(open_paper("lwr4"))
