"""A table judged by a log: discrepancy, chi squared, what a motion shows."""

from __future__ import annotations

import numpy as np
import pytest

from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.identification.slips.hypotheses import as_printed, link_discrepancies, log_evidence, table_pseudo_inertias
from lwr_dyn.identification.slips.printed_cells import Cell, printed_cells
from tests.identification.slip_study import SlipStudy, single_faults

HIDDEN = ["m1", "c1x", "c1y", "c1z", "I1xx", "I1xy", "I1xz", "I1yz", "I1zz", "c2y"]
PAIRS = [["I1yy", "rotor1"], ["m2", "c2z"], ["I2yy", "rotor2"], ["c3z", "c4y"], ["c5z", "c6y"]]


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
