"""Studies: every part that a record names can be loaded; no paper is named outside its own folder."""

import ast
from pathlib import Path

import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, UnknownNameError
from lwr_dyn.reproduction.case import PaperFormula
from lwr_dyn.reproduction.papers import ALL, check_options, option_keywords, studies, study_of, takers

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
    with pytest.raises(OptionError, match="timing: given for all; allowed: only for lwr4plus"):
        check_options(ALL, {"timing": "quintic"})


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
