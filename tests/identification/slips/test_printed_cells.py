"""The cells of a table: what they stand for, what motions show of them, how far an arm may be."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.identification.slips.printed_cells import Cell, link_discrepancies, printed_cells

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


def test_the_discrepancy_of_a_link_moves_its_centre_alike_in_all_directions():
    """By 5 cm times the share and more, also where the link is thin; masses and rotors by the share."""
    table, off = printed_cells(open_paper("lwr4plus", "physical")), 0.04
    spread = link_discrepancies(table, off, range(table.n))
    mass, rotors = table.values[:, 0], table.parameters()[70:]
    for one in spread:
        assert np.linalg.eigvalsh(one)[0] > -1e-12
    # the part of the first moment that is not the mass's: of a centre that moves
    moved = spread[:, 1:4, 1:4] - np.einsum("na,nb,n->nab", spread[:, 0, 1:4], spread[:, 0, 1:4], 1 / spread[:, 0, 0])
    assert (np.linalg.eigvalsh(moved) >= (0.05 * off * mass[:, None]) ** 2 * (1.0 - 1e-9)).all()
    assert (np.sqrt(spread[:, 0, 0]) >= off * mass).all()
    np.testing.assert_allclose(np.sqrt(spread[:, 10, 10]), off * np.abs(rotors))


def test_some_links_have_the_discrepancies_that_they_have_among_all():
    table = printed_cells(open_paper("lwr4plus", "physical"))
    every = link_discrepancies(table, 0.05, range(table.n))
    np.testing.assert_array_equal(link_discrepancies(table, 0.05, [4, 1]), every[[4, 1]])
    massless = table.with_values(np.where(np.arange(7)[:, None] == 2, 0.0, table.values))
    assert not link_discrepancies(massless, 0.05, [2]).any()
    slipped = table.with_cell(Cell(3, 9), -0.5)  # no body has it
    assert np.isfinite(link_discrepancies(slipped, 0.05, [3])).all()


def test_ten_cells_show_in_no_motion_and_ten_only_as_pairs(study):
    assert [c.name for c in study.shown.hidden] == HIDDEN
    assert [[c.name for c in group] for group in study.shown.together] == PAIRS
    assert len(study.shown.alone) == 57
    assert study.shown.like(Cell(4, 3)) == (Cell(4, 3), Cell(5, 2))
