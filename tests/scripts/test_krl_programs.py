"""The study of public KRL programs on three invented repositories: what counts as false, and the rates."""

import tomllib

import pytest

from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition
from scripts.studies.krl_programs import counts, program_paths, rates, study, table
from scripts.studies.krl_verdicts import Judge, corpus_names, declared_words, judgements

GOOD = "&ACCESS RVP\nDEF good( )\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\nEND\n"
MORE = "DEF more( )\nEND\nGLOBAL DEFFCT INT twice(A :IN)\nRETURN 2*A\nENDFCT\nDEF hidden( )\nEND\n"
FILES = {
    "ann+cell/KRC/R1/Program/good.src": GOOD,
    "ann+cell/KRC/R1/Program/calls.src": "DEF calls( )\nlent( )\nEND\n",
    "ann+cell/KRC/R1/System/lent.src": "DEF lent( )\nEND\n",
    "ann+cell/KRC/R1/Program/more.sub": MORE,
    "ann+cell/KRC/R1/TP/option.dat": "DEFDAT OPTION PUBLIC\nDECL GLOBAL INT ODD_OPTION=1\nENDDAT\n",
    "bob+one/copy.src": GOOD.replace("&ACCESS RVP\n", "&REL 7\n").upper(),
    "bob+one/broken.src": "DEF broken( )\nX = = 1\nEND\n",
    "bob+one/names.src": "DEF names( )\nodd_option = 2\nNOWHERE = 1\nKERNEL_ONLY = 3\nEND\n",
    "cat+two/operate.dat": "DEFDAT OPERATE PUBLIC\nGLOBAL STRUC KSTRUC INT MEMBER\nDECL KSTRUC KERNEL_ONLY\nENDDAT\n",
}


@pytest.fixture
def folder(tmp_path):
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="latin-1")
    return tmp_path


def an_error(code, message, line=2):
    return Diagnostic(SourcePosition("x.src", line), "error", code, message)


def test_a_program_counts_once_with_the_names_that_other_modules_see_and_no_values_or_members(folder):
    names = [path.stem for path in program_paths(folder)]
    assert names == ["calls", "good", "lent", "broken", "names"]
    assert corpus_names(folder).shared["ann+cell"] == {"GOOD", "CALLS", "LENT", "MORE", "INT", "TWICE", "ODD_OPTION"}
    text = b"DECL INT A, B[3]\nDECL FRAME F={X 1}\nDEF up(P :IN )\nSTRUC S INT M\nENUM E ON\nX = 1 ; DECL INT NO\n"
    assert declared_words(text) == {"INT", "A", "B", "FRAME", "F", "UP", "S", "E"}


@pytest.mark.parametrize(
    ("name", "alone", "verdict"),
    [
        *((name, False, "missing") for name in ("NOWHERE", "MEMBER")),
        *((name, False, "false") for name in ("kernel_only", "$NEW_ONE", "EKI_Init", "names")),
        *((name, False, "unclear") for name in ("MsgNotify", "odd_option")),
        ("names", True, "missing"),
    ],
)
def test_the_verdict_of_an_unknown_name(folder, name, alone, verdict):
    judge = Judge(corpus_names(folder), [])
    for message in (f"{name} is not declared", f"the subprogram {name} is not known", f"{name} is no type (3 times)"):
        assert judge.verdict("bob+one", "x.src", an_error("undeclared", message), alone=alone) == verdict
    assert judge.undecided == []


def test_a_row_decides_first_and_an_error_that_nothing_decides_counts_as_false(folder):
    row = {"repository": "bob+*", "file": "A/*.src", "code": "syntax", "verdict": "true", "why": "so", "lines": [2]}
    judge = Judge(corpus_names(folder), judgements([row]))
    for repository, line, verdict in (("bob+one", 2, "true"), ("bob+one", 3, "false"), ("ann+cell", 2, "false")):
        assert judge.verdict(repository, "a/x.src", an_error("syntax", "so", line), alone=False) == verdict
    assert [where for where, _ in judge.undecided] == ["bob+one/a/x.src", "ann+cell/a/x.src"]


def test_rates_by_program_and_by_repository_and_counts_of_the_manifest(folder):
    alone, together, judge = study(folder, [])
    assert {x.file: x.passes() for x in alone} == {
        "KRC/R1/Program/calls.src": (True, True, True, False),
        "KRC/R1/Program/good.src": (True, True, True, True),
        "KRC/R1/System/lent.src": (True, True, True, True),
        "broken.src": (False, False, False, False),
        "names.src": (True, False, False, False),
    }
    assert next(x for x in together if x.file.endswith("calls.src")).errors == ()
    assert len(judge.undecided) == 2  # the broken line, alone and together
    assert rates(alone) == [80.0, 60.0, 60.0, 40.0]
    assert "no false alarm                60.0 %    50.0 % by repository" in table(alone, "alone")
    alone, together, _ = study(folder, [])
    found = {x["name"]: x for x in tomllib.loads(counts(folder, alone, together))["repository"]}
    wanted = {"programs": 3, "files": 5, "alone": [3, 3, 3, 2], "together": [3, 3, 3, 3]}
    assert {key: found["ann/cell"][key] for key in wanted} == wanted
    assert found["bob/one"]["together"] == [1, 0, 0, 0]
