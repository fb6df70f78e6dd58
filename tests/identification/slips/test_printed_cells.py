"""The cells of a table: what they stand for, what motions show of them, how far an arm may be."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.identification.slips.printed_cells import Cell, link_discrepancies, printed_cells
from tests.identification.plants import pseudo_inertia

READINGS = [("lwr4plus", "printed"), ("lwr4plus", "physical"), ("wam7", None), ("kr30ha", None)]


@pytest.mark.parametrize(("robot", "reading"), READINGS)
def test_the_cells_stand_for_the_parameters_of_the_arm(robot, reading):
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


def test_the_derivative_is_exact():
    table = printed_cells(open_paper("lwr4plus", "printed"))  # about the centres of mass: squares of the cells
    D = table.derivatives(table.cells)
    for k in (1, 3, 30, 58, 76):
        cell = table.cells[k]
        step = 1e-7
        up, down = (table.with_cell(cell, table.value(cell) + s).parameters() for s in (step, -step))
        np.testing.assert_allclose(D[:, k], (up - down) / (2 * step), atol=1e-7)


HIDDEN = ["m1", "c1x", "c1y", "c1z", "I1xx", "I1xy", "I1xz", "I1yz", "I1zz", "c2y"]
PAIRS = [["I1yy", "rotor1"], ["m2", "c2z"], ["I2yy", "rotor2"], ["c3z", "c4y"], ["c5z", "c6y"]]


def test_the_discrepancy_is_the_inverse_hessian_of_the_log_det():
    table = printed_cells(open_paper("lwr4plus", "physical"))
    P, spread = table.pseudo_inertias(), link_discrepancies(table)
    units = np.eye(77).reshape(77, 77)[: 10 * table.n]
    for i in range(table.n):
        E = np.array([pseudo_inertia(units[10 * i + a, 10 * i : 10 * i + 10]) for a in range(10)])
        inverse = np.linalg.inv(P[i])
        hessian = np.einsum("ij,ajk,kl,bli->ab", inverse, E, inverse, E)
        np.testing.assert_allclose(spread[i, :10, :10] @ hessian, np.eye(10), atol=1e-8)
        assert spread[i, 10, 10] == pytest.approx(table.parameters()[70 + i] ** 2)


def test_ten_cells_show_in_no_motion_and_ten_only_as_pairs(study):
    assert [c.name for c in study.shown.hidden] == HIDDEN
    assert [[c.name for c in group] for group in study.shown.together] == PAIRS
    assert len(study.shown.alone) == 57
    assert study.shown.like(Cell(4, 3)) == (Cell(4, 3), Cell(5, 2))
