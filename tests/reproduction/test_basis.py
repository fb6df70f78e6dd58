"""What a recomputed number rests on is found by an experiment; no number is compared with itself."""

from collections import Counter
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import pytest

from lwr_dyn.reproduction.basis import _basis, _changed, _drawn, bases, numbers_of, with_bases, with_other_numbers
from lwr_dyn.reproduction.case import COMPUTED, REPEATED, STRUCTURAL, ComparedExpression, PaperFormula
from lwr_dyn.reproduction.compare import ASSUMED, REPRODUCED, recomputed
from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.papers import studies
from tests.reproduction.mutants import usual_judgement

CHOSEN = {"lwr4plus": ("table_vii", "table_viii")}
"""Blocks that choose, of some assumed conditions, those nearest to their own cells."""


@cache
def found(paper):
    return with_bases(paper_study(paper), usual_judgement(paper))


def with_other_cells(case, block):
    """The case with every cell of one block of results replaced, and nothing else."""
    own = case.block(block)
    columns = {cell.column for cell in own.cells}
    cells = {name: _changed(x, name, _drawn(0)) if name in columns else x for name, x in own.printed.items()}
    return replace(
        case, results=replace(case.results, blocks={**case.results.blocks, block: replace(own, printed=cells)})
    )


@pytest.mark.slow
@pytest.mark.parametrize("paper", studies())
def test_no_number_is_compared_with_itself(paper):
    """With every cell of a block changed, and nothing else, its recomputed values stay."""
    study = paper_study(paper)
    sets = {(n.block.name, n.applied) for n in found(paper).numbers if n.verdict != ASSUMED}
    assert len({name for name, _ in sets}) > 3
    for name, applied in sets:
        case = study.data.case(*applied, from_known_maxima=True)
        before, after = (recomputed(study.formulas, c, name) for c in (case, with_other_cells(case, name)))
        assert [_plain(x) for _, x in before.values()] == [_plain(x) for _, x in after.values()], name
        assert before, name


def test_what_is_chosen_by_its_own_print_is_never_called_reproduced():
    for paper, blocks in CHOSEN.items():
        study = paper_study(paper)
        for name in blocks:
            block = study.data.results.blocks[name]
            assert block.needs
            assert study.formulas[block.compute].slow
            assert not study.formulas[block.compute].basis


def _plain(value):
    return value.text if isinstance(value, ComparedExpression) else value


@pytest.mark.slow
@pytest.mark.parametrize("paper", studies())
def test_every_formula_gives_values_with_other_numbers_or_states_its_basis(paper):
    study = paper_study(paper)
    case = with_other_numbers(study.data.reading(), 0)
    for name, block in study.data.results.blocks.items():
        formula = study.formulas[block.compute]
        if formula.slow:
            assert formula.basis or block.needs, name
        elif not formula.basis and not block.reading:
            assert all(value is not None for _, value in recomputed(study.formulas, case, name).values()), name


@pytest.mark.slow
def test_what_stays_is_0_or_1_or_an_entry_with_an_angle():
    for verdicts in map(found, studies()):
        for n in (n for n in verdicts.numbers if n.basis == STRUCTURAL):
            if isinstance(n.value, ComparedExpression):
                assert n.value.text in ("0", "1", "-1") or n.value.text.startswith(("cos(q", "sin(q", "-sin(q"))
            else:
                assert min(abs(n.value - x) for x in (0.0, 1.0, -1.0)) < 1e-9


BASES = {
    ("kr30ha", COMPUTED): "geometry.a2[0] symbolic.A1[0][2] composite.T04[0][3] point_1.theta_1[0]",
    ("kr30ha", REPEATED): "axes.count[0] geometry.d1[0] coordinates.list_1[0] composite.T05[0][3] table_5.point_1[0]",
    ("kr30ha", STRUCTURAL): "symbolic.A1[0][1] composite.T06[0][2]",
    ("lwr4plus", COMPUTED): "figure_1.mass[0] table_iv.b[0]",
    ("lwr4plus", REPEATED): "text_vii.maximum[0] text_vii_joints.joint[0] centralized_gains.Kp[6] limits.effort[0]"
    " table_iv.b[4]",  # c5z was fitted to it
    ("lwr4", REPEATED): "matrices.A3[2][3]",
    ("lwr4", STRUCTURAL): "matrices.A3[3][3] matrices.A7[0][1]",
    ("wam7", REPEATED): "arm.count[0] figure_4.position[0] tensors_about_origin.xx[0]",
    ("wam7", COMPUTED): "figure_4.acceleration[0] cruise.positive[0]",
}


@pytest.mark.parametrize("value", [0.0, 1.0, -1.0, 2.0, 0.5])
def test_a_number_that_stays_is_structural_where_it_is_0_or_1(value):
    number = SimpleNamespace(cell=SimpleNamespace(printed=f"{value:.3f}"))
    assert _basis(number, [value] * 3, None, set()) == (STRUCTURAL if abs(value) in (0.0, 1.0) else REPEATED)


@pytest.mark.parametrize(
    ("paper", "basis"),
    [pytest.param(*key, marks=[pytest.mark.slow] * (key[0] in ("kr30ha", "lwr4plus"))) for key in BASES],
)
def test_the_basis_of_cells(paper, basis):
    known = {n.cell.path: n.basis for n in found(paper).numbers}
    assert [cell for cell in BASES[paper, basis].split() if known[f"results.{cell}"] != basis] == []


@pytest.mark.slow
@pytest.mark.parametrize(("paper", "known", "more"), [("kr30ha", 225, 8), ("lwr4", 86, 16), ("lwr4plus", 16, 0)])
def test_structural_numbers_are_those_that_an_audit_counted_and_cosines_of_a_first_column(paper, known, more):
    """The audit counted 0 and +-1 that are reproduced; places and counts that are 1 by chance are repeated in print."""
    agreeing = [n for n in found(paper).numbers if n.verdict == REPRODUCED and not n.block.derived]
    audited = Counter(n.basis for n in agreeing if n.cell.printed in ("0", "1", "-1"))
    assert audited.total() == known + audited[COMPUTED]
    structural = sum(n.basis == STRUCTURAL for n in agreeing)
    assert structural == known - audited[REPEATED] + more


def test_all_numbers_are_replaced_but_the_form_of_the_arm():
    case = paper_study("kr30ha").data.reading()
    before, after = (numbers_of(c) for c in (case, with_other_numbers(case, 0)))
    still = {path for path in before if before[path] == after[path]}
    assert still == set()
    assert "dh.alpha.values[0]" not in before
    assert {"limits.lower.values[0]", "results.point_1.xyz[0]", "results.table_5.point_1[0]"} <= set(before)
    changed = with_other_numbers(case, 0).tables
    assert changed["dh"]["alpha"]["values"] == case.tables["dh"]["alpha"]["values"]
    tensor = changed["inertial"]["inertia"]["values"][0]
    assert tensor[0][1] == tensor[1][0] != case.tables["inertial"]["inertia"]["values"][0][0][1]


def test_a_formula_that_hands_its_input_back_is_not_computed():
    own = [n for n in usual_judgement("wam7").numbers if n.block.name == "armature"]
    assert set(bases(paper_study("wam7"), own).values()) == {REPEATED}


def test_a_formula_that_reads_its_own_cell_would_be_found():
    case = paper_study("wam7").data.case()
    own = {"motion": PaperFormula(lambda case, _: {"travel": case.numbers("motion", "travel"), "velocity": [0.0]})}
    before, after = (
        recomputed(own, c, "motion")["results.motion.travel[0]"] for c in (case, with_other_cells(case, "motion"))
    )
    assert before != after
