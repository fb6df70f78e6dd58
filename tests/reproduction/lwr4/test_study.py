"""The LWR-IV exercise: matrices, wrist centre, tool point."""

import json

import numpy as np

import lwr_dyn
from lwr_dyn.reproduction.lwr4 import study
from lwr_dyn.reproduction.lwr4.study import exercise


def test_the_seven_matrices_are_symbolically_the_printed_ones():
    assert exercise().identical == (True,) * 7


def test_both_routes_give_one_wrist_and_the_short_one_costs_less():
    e = exercise()
    assert e.routes_agree
    assert (e.wrist_short.multiplications, e.wrist_short.additions) == (12, 5)
    assert e.wrist_full.multiplications > 5 * e.wrist_short.multiplications


def test_the_symbols_give_the_numbers_of_forward_kinematics():
    e = exercise()
    names = {f"q{i + 1}": x for i, x in enumerate(np.random.default_rng(0).uniform(-1, 1, 7))}
    q = [names[f"q{i + 1}"] for i in range(7)]
    wrist = [float(x) for x in e.wrist_short.value.subs(names | {"L": 0.40, "M": 0.39})][:3]
    assert np.abs(lwr_dyn.forward_kinematics(lwr_dyn.load("lwr4"), q)[:3, 3] - wrist).max() < 1e-15


def test_the_tool_point():
    # by hand: frame 7 stands at (-0.4, -0.39, 0), its y and z axes along -z and x of frame 0
    assert np.abs(exercise().tool - [-0.4 + 0.1, -0.39, -0.05]).max() < 1e-15


def test_a_wrong_matrix_is_seen(monkeypatch):
    right = study.printed_tables("lwr4")
    wrong = json.loads(json.dumps(right))
    wrong["matrices"]["A3"][2][3] = "-L"
    monkeypatch.setattr(study, "printed_tables", lambda _: wrong)
    e = exercise()
    assert e.identical == (True, True, False, True, True, True, True)
    assert not e.holds
