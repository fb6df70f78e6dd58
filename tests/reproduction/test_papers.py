"""Studies: every part that a record names can be loaded; no paper is named outside its own folder.

What stands both in a data file and among the printed results is the same in both.
"""

import ast
from pathlib import Path

import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import UnknownNameError
from lwr_dyn.reproduction.case import PaperFormula
from lwr_dyn.reproduction.paper_study import paper_study
from lwr_dyn.reproduction.papers import ALL, check_options, option_keywords, printed_tables, studies, study_of, takers

PACKAGE = Path(lwr_dyn.__file__).parent
SHARED = [
    *PACKAGE.glob("reproduction/*.py"),
    *PACKAGE.glob("reproduction/report/*.py"),
    *PACKAGE.glob("checks/**/*.py"),
]


@pytest.mark.parametrize("paper", studies())
def test_every_part_can_be_loaded(paper):
    study = study_of(paper)
    assert callable(study.load("run"))
    formulas = study.load("formulas")
    assert formulas
    assert all(isinstance(formula, PaperFormula) for formula in formulas.values())
    if study.proofs:
        assert all(callable(proof) for proof in study.load("proofs").values())


def test_papers_are_in_their_order_and_others_are_refused():
    assert [study.order for study in studies().values()] == sorted(study.order for study in studies().values())
    with pytest.raises(UnknownNameError, match="no paper to reproduce named 'none'"):
        study_of("none")


def test_options_belong_to_the_papers_that_take_them():
    assert option_keywords() == ("timing", "fit_arm_angle", "sensitivity")
    assert list(takers("sensitivity")) == ["lwr4plus", "wam7"]
    check_options("lwr4plus", {"timing": "quintic", "sensitivity": True})
    check_options(ALL, {"sensitivity": True})


@pytest.mark.slow
@pytest.mark.parametrize("path", SHARED, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_paper_is_named_outside_its_folder(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    bodies = [node.body for node in ast.walk(tree) if hasattr(node, "body") and isinstance(node.body, list)]
    statements = [s for body in bodies for s in body if isinstance(s, ast.Expr)]
    docstrings = {id(s.value) for s in statements}  # examples may name a robot
    texts = [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings
    ]
    assert [text for text in texts if any(paper in text for paper in studies())] == []


def test_table_ii_of_the_lwr4plus():
    origins = paper_study("lwr4plus").data.tables["frames"]["origin"]["values"]
    printed = printed_tables("lwr4plus")["table_ii"]["r"]
    assert [[float(x) for x in row] for row in printed] == [[float(x) for x in row] for row in origins]


def test_what_the_text_repeats_of_tables_vii_and_viii():
    tables = printed_tables("lwr4plus")
    assert tables["table_iv"]["b"] == tables["table_iv_configurations"]["at_most"]
    assert tables["table_iv_configurations"]["at_most"] == tables["table_iv_configurations"]["at_least"]


def test_appendix_a_of_the_kr30ha():
    ratings, printed = paper_study("kr30ha").data.tables["ratings"], printed_tables("kr30ha")["appendix_a"]
    assert float(printed["reach"][0]) == ratings["reach"]["values"]
    assert float(printed["volume"][0]) == ratings["envelope_volume"]["values"]


def test_expressions_of_the_kr30ha():
    block = paper_study("kr30ha").data.results.blocks["expressions"]
    listed = printed_tables("kr30ha", "motion")["expression"]
    texts = ["; ".join(e["printed"]) if isinstance(e["printed"], list) else e["printed"] for e in listed]
    assert [cell.printed for cell in block.cells] == texts
    assert [cell.row for cell in block.cells] == [e["name"] for e in listed]
    assert set(block.errata) == {fault["erratum"] for e in listed for fault in e["errors"]}


def test_points_of_the_kr30ha():
    tables, program = printed_tables("kr30ha"), printed_tables("kr30ha", "program")
    for k, name in enumerate(("point_1", "point_2")):
        assert tables["coordinates"][name] == tables[name]["xyz"] == program["points"][k]["xyz"]
