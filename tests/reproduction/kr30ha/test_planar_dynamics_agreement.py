"""Symbols against Pinocchio at random arms and states, 100 of the first two joints; a wrong equation is seen."""

from dataclasses import replace

import pytest
import sympy as sp

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.reproduction.kr30ha import planar_dynamics
from lwr_dyn.reproduction.kr30ha.planar_dynamics import SYMBOLIC, symbolic_verdicts

CASES = {
    "first two": ("kr30ha", ("A1", "A2"), None, 100),
    "first three": ("kr30ha", ("A1", "A2", "A3"), None, 10),
    "shoulder and wrist": ("kr30ha", ("A2", "A5"), {"A1": 0.0, "A3": 1.0, "A4": 0.0}, 10),
    "the LWR's first two": ("lwr4plus", ("joint_1", "joint_2"), None, 100),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_symbols_equal_pinocchio_to_1e_10_at_random_states_and_parameters(case):
    robot, joints, held, count = CASES[case]
    verdicts = symbolic_verdicts(lwr_dyn.load(robot), open_paper(robot), joints, held, count)
    assert len(verdicts) == 5
    assert [v.name for v in verdicts if not v.holds] == []
    assert verdicts[0].tolerance == SYMBOLIC == 1e-10


def test_a_lost_term_is_seen(monkeypatch):
    right = planar_dynamics.equations_of_motion

    def without_product_terms(*arguments):
        part = right(*arguments)
        C = part.equations.C.copy()
        C[0, 1] = sp.Integer(0)
        return replace(part, equations=replace(part.equations, C=C))

    monkeypatch.setattr(planar_dynamics, "equations_of_motion", without_product_terms)
    verdicts = symbolic_verdicts(lwr_dyn.load("kr30ha"), open_paper("kr30ha"), ("A1", "A2"), count=2)
    assert [v.holds for v in verdicts] == [True, False, True, True, False]
