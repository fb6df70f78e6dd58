"""The report's dynamic analysis: each expression against the right one, each fault named, no difference left.

Symbols against Pinocchio at random arms and states, 100 of the first two joints; a wrong equation is seen.
"""

from dataclasses import replace

import pytest
import sympy as sp

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.dynamics.symbolic.link_motion import normal_form
from lwr_dyn.reproduction.kr30ha import planar_dynamics
from lwr_dyn.reproduction.kr30ha.planar_dynamics import SYMBOLIC, finished, motion_report, symbolic_verdicts
from lwr_dyn.reproduction.kr30ha.study import errata_text, motion_tables

RIGHT = {"v_1", "P_1", "P_2"}
OTHER_MODEL = {"planar-model", "unfinished", "lagrangian-label"}
"""Errata of the dynamic analysis that no single expression shows."""


@pytest.fixture(scope="module")
def report():
    return motion_report()


@pytest.mark.slow
def test_every_difference_is_the_sum_of_its_named_faults(report):
    assert report.holds
    assert {c.name for c in report.comparisons if c.agrees} == RIGHT
    assert all(c.explained for c in report.comparisons)


def test_a_fault_without_an_erratum_or_an_erratum_without_a_fault_is_seen(report):
    by_name = {c.name: c for c in report.comparisons}
    assert not replace(by_name["K_1"], added={}).explained
    assert not replace(by_name["K_2"], printed=by_name["K_2"].printed * 2).explained
    assert not replace(by_name["P_1"], added={"k1-half": sp.zeros(1, 1)}).explained


def test_every_fault_is_in_the_errata_ledger_and_every_erratum_of_the_analysis_is_met(report):
    ledger = {e.id for e in open_paper("kr30ha").errata}
    met = {erratum for c in report.comparisons for erratum in c.added}
    assert met | OTHER_MODEL <= ledger
    assert met == set(planar_dynamics._NAMED)


def test_the_planar_model_done_right_is_the_textbooks(report):
    # Siciliano et al., section 7.3.2, two-link planar arm: centres half-way, no motors, gravity along -x
    l1, l2, m1, m2, I1, I2, q2 = sp.symbols("l1 l2 m1 m2 I1 I2 q2")
    b11 = I1 + m1 * l1**2 / 4 + I2 + m2 * (l1**2 + l2**2 / 4 + l1 * l2 * sp.cos(q2))
    b12 = I2 + m2 * (l2**2 / 4 + l1 * l2 / 2 * sp.cos(q2))
    wanted = sp.Matrix([[b11, b12], [b12, I2 + m2 * l2**2 / 4]])
    assert sp.expand(report.planar.B - wanted) == sp.zeros(2, 2)


def test_terms_show_where_printed_and_right_part(report):
    by_name = {c.name: c for c in report.comparisons}
    K2 = {rates: (printed, right) for rates, printed, right in by_name["K_2"].terms()}
    assert K2["dq1**2"][0] == K2["dq1**2"][1]
    assert K2["dq1*dq2"][0] == sp.Symbol("I2") != K2["dq1*dq2"][1]


def test_the_reports_own_lagrangian_finished_lacks_the_coupling_and_a_centrifugal_term(report):
    q, dq2, ddq2 = sp.symbols("q1 q2"), sp.Symbol("dq2"), sp.Symbol("ddq2")
    missing = normal_form(report.planar.tau - report.printed_torques, q)[0]
    m2, l1, l2 = sp.symbols("m2 l1 l2")
    assert sp.expand(missing.coeff(ddq2) - m2 * (l2**2 / 4 + l1 * l2 / 2 * sp.cos(q[1]))) == 0
    assert missing.coeff(dq2**2) == -m2 * l1 * l2 * sp.sin(q[1]) / 2
    assert normal_form(finished(report.planar.lagrangian) - report.planar.tau, q) == sp.zeros(2, 1)


def test_only_the_entries_named_in_the_ledger_are_the_same_for_the_arm(report):
    same = {c.name for c in report.counterparts if not c.why}
    assert same == {"B_22", "C_22"}
    arm = {c.name: c.arm for c in report.counterparts}
    assert (arm["B_12"], arm["g_1"]) == (0, 0)
    assert "only B_22 and C_22" in next(e.effect for e in open_paper("kr30ha").errata if e.id == "planar-model")


def test_the_analysis_in_tables(report):
    verdicts, terms, beside = motion_tables(report)
    assert [row[:2] for row in verdicts.rows] == [
        (c.name, "right" if c.name in RIGHT else ", ".join(c.added)) for c in report.comparisons
    ]  # fmt: skip
    assert all(printed != right for *_, printed, right in terms.rows)
    assert ("K_2", "dq1*dq2", "I2") in {row[:3] for row in terms.rows}
    lines = terms.note.splitlines()
    assert [line[-15:] for line in lines if "tau_" not in line] == ["", " own Lagrangian", "me planar model"]
    found = [sp.sympify(line.partition(" = ")[2].replace("^", "**")) for line in lines if "tau_" in line]
    for text, torque in zip(found, [*report.printed_torques, *report.planar.tau], strict=True):
        assert sp.expand(text - torque, trig=True) == 0
    assert [row[0] for row in beside.rows if row[3] == "the same"] == ["B_22", "C_22"]
    paper = open_paper("kr30ha")
    one = paper.errata[0]
    assert errata_text(paper).splitlines()[:5] == [
        f"Errata ({len(paper.errata)})",
        f"{one.id} ({one.status}), {one.where}",
        *(f"  {line}" for line in (f"printed: {one.printed}", f"read as: {one.read_as}", one.why)),
    ]


def test_the_general_equations_become_the_symmetric_ones_without_their_letters(report):
    general, symmetric = report.general.equations, report.symmetric.equations
    zeros = {s: 0 for s in general.parameters if s not in symmetric.parameters}
    assert {s.name for s in zeros} == {"c1z", "c2y", "c2z", "I2xy", "I2xz", "I2yz"}
    assert normal_form(general.tau.subs(zeros) - symmetric.tau, symmetric.variables.q) == sp.zeros(2, 1)


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
