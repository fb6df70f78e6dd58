"""The cells of a table, and the parameters they stand for."""

from __future__ import annotations

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.identification.slips.printed_cells import printed_cells

READINGS = [("lwr4plus", "printed"), ("lwr4plus", "physical"), ("wam7", None), ("kr30ha", None)]


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
