"""Slips of a table traced by a log: the cells and what they stand for, what motions show, planted slips found."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.slips.hypotheses import as_printed, impossible_links, largest_pull, log_evidence
from lwr_dyn.identification.slips.printed_cells import Cell, printed_cells
from lwr_dyn.identification.slips.slip_tables import slip_document, table_against_log
from lwr_dyn.identification.slips.trace import trace_cells, trace_slips
from tests.identification.slip_study import exchanged_faults, shares, single_faults
from tests.identification.table_study import OFF, TableStudy


@pytest.mark.parametrize("off", [0.0, 0.01, 0.05])
def test_a_right_table_meets_the_log(study, off):
    rng = np.random.default_rng(11)
    for _ in range(5):
        assert trace_cells(study.log(off, rng), study.table, deviation=2 * off).fits


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ur5", "random6"])
@pytest.mark.parametrize("off", OFF)
def test_right_tables_of_other_arms_meet_their_logs(name, off):
    """A seeded share of the soak line `right_tables`: centres are 3 mm off whatever the links' thickness."""
    arm = TableStudy.of(name)
    assert all(arm.printed(off, "white", run).fits for run in range(4))


@pytest.mark.slow
def test_one_cell_six_sigma_off_is_found(study):
    """Within chi^2 of 50 directions, and yet not by chance."""
    log, seen = study.log(0.0, np.random.default_rng(4)), []
    for row in table_against_log(log, open_paper("lwr4plus", "physical"), deviation=0.05)[2::9]:
        if np.isfinite(row.sigma) and not row.like:
            wrong = study.table.with_cell(row.cell, row.value - 6.0 * row.sigma)
            printed = as_printed(log_evidence(log, wrong, 0.05), wrong)
            pull = largest_pull(printed)
            assert not printed.fits
            assert pull.sigmas > pull.limit
            seen.append((printed.chi2 < printed.log.limit(), pull.cell == row.cell))
    assert len(seen) > 3
    assert np.mean(seen, axis=0).min() > 0.5


def test_no_explanation_has_a_link_that_no_body_can_be(study):
    """A log whose accelerations are noise asks for negative moments of inertia: no such table is an answer."""
    table, log = study.table, study.log(0.0, np.random.default_rng(6))
    own = log.columns.own(study.arm)
    own[10 * 5 + 9] -= 3.0 * table.value(Cell(5, 9))  # Izz of link 6 of the arm: below 0
    away = replace(log, values=log.values + log.base.of(own) - log.base.of(log.columns.own(study.arm)))
    report = trace_cells(away, table, deviation=0.05, most=2)
    assert not report.fits
    asked = {row.cell.name: row.value for row in table_against_log(away, study.arm, deviation=0.05)}
    assert asked["I6zz"] < 0.0  # what the log says of that cell alone, which is said
    for one in (*report.explanations, report.nearest):
        assert not (impossible_links(one.table) & ~impossible_links(table)).any()


def test_what_only_a_nearer_arm_would_show_is_said_with_the_deviation_that_shows_it(study):
    """A cell 3 sigma off is explained by an arm 5 % off; by one 2 % off it is not."""
    log = study.log(0.0, np.random.default_rng(4))
    right = trace_cells(log, study.table, deviation=0.05)
    assert right.fits
    assert right.closer is None
    rows = {row.cell.name: row for row in table_against_log(log, study.arm, deviation=0.05)}
    row = rows["c4z"]
    report = trace_cells(log, study.table.with_cell(row.cell, row.value - 3.0 * row.sigma), deviation=0.05)
    assert report.fits
    assert report.closer == 0.02
    assert not trace_cells(log, report.printed.table, deviation=report.closer, most=1).fits
    assert not trace_cells(study.log(0.2, np.random.default_rng(1)), study.table, deviation=0.0, most=1).fits
    said = "an arm 0.05 off a right table explains what is left; one 0.02 off would not: --deviation 0.02 looks further"
    assert said in slip_document(report, ()).text()
    assert "looks further" not in slip_document(right, ()).text()


def test_the_copied_cell_of_the_paper_is_named_with_its_partner(study):
    printed = study.table.with_cell(Cell(4, 3), -0.004375432)
    report = trace_cells(study.log(0.02, np.random.default_rng(0)), printed, deviation=0.05)
    best = report.explanations[0]
    assert (report.fits, {c.name for c in report.cells}) == (False, {"c5z", "c6y"})
    assert best.repairs[0].text.endswith("which repeats c6z")
    assert abs(best.table.value(Cell(4, 3)) + 0.0238) < 0.002
    of_one_arm = study.log(0.0, np.random.default_rng(0))
    assert trace_cells(of_one_arm, printed, deviation=0.0).common_factor is None  # a slip is no factor


@pytest.mark.slow
@pytest.mark.parametrize(("off", "traced", "one"), [(0.0, 0.95, 0.8), (0.05, 0.9, 0.7)])
def test_planted_slips_are_traced(study, off, traced, one):
    rng = np.random.default_rng(7)
    faults = [*single_faults(study.table)[3::15], *exchanged_faults(study.table)[5::18]]
    outcomes = [study.outcome(fault, off, rng) for fault in faults]
    seen = [o for o in outcomes if o.seen]
    assert len(seen) > 12
    assert sum(o.listed for o in seen) >= traced * len(seen), shares(outcomes)
    assert sum(o.one for o in seen) >= one * len(seen), shares(outcomes)


@pytest.mark.slow
def test_the_errata_of_the_paper_are_found_in_its_printed_tables(study):
    information = study.log(0.01, np.random.default_rng(2))
    report = trace_slips(information, open_paper("lwr4plus", "printed"), deviation=0.02)
    best = [r.text for r in report.explanations[0].repairs]
    assert [text for text in best if text.startswith("c5z")]
    assert {text for text in best if not text.startswith("c5z")} == {
        "rotor of all links times 100", "tensor of all links about the link's origin",
        "products of inertia of all links of the other sign", "axes y and z of the tensor of link 2 exchanged",
        "axes y and z of the tensor of link 4 exchanged",
    }  # fmt: skip
    assert any(r.text.startswith("c6y") for other in report.explanations[1:] for r in other.repairs)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.8, 1.25])
def test_a_heavier_arm_is_said_beside_the_cell_that_the_search_would_blame(study, factor):
    heavier = study.table.values / np.where(np.isin(np.arange(11), [1, 2, 3, 10]), 1.0, factor)
    report = trace_cells(study.log(0.01, np.random.default_rng(3)), study.table.with_values(heavier), deviation=0.05)
    assert not report.fits
    assert report.common_factor == pytest.approx(factor, rel=0.02)
    assert "or no cell is wrong: the table meets the log with all masses" in slip_document(report, ()).text()


@pytest.mark.parametrize("deviation", [-0.1, 1.0, float("nan")])
def test_a_deviation_that_is_no_share_and_a_source_without_masses_are_refused(study, deviation):
    with pytest.raises(OptionError, match=f"deviation: {deviation}; allowed: a share from 0 to below 1"):
        trace_slips(study.information, study.arm, deviation=deviation)
    with pytest.raises(OptionError, match="gives no mass"):
        printed_cells(open_paper("lwr4"))
