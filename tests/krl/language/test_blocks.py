"""Blocks: a lost end is named where its block opens, by indentation; deep nesting ends; unreadable lines count."""

import time

import pytest

from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.program_run import check_program
from tests.krl.short_programs import program_of, told


def test_deep_nesting_is_told_once_and_ends():
    start = time.perf_counter()
    nested = told(*["IF TRUE THEN"] * 201, "ELSE", "ELSE", *["ENDIF"] * 201)
    assert nested == [(202, "error", "deep-nesting")]
    assert told(*["IF TRUE THEN"] * 200, *["ENDIF"] * 200) == []
    found = told("LOOP", *["IF TRUE THEN"] * 5000, *["EXIT"] * 5000, *["ENDFOR"] * 5000)
    assert [code for _, _, code in found].count("deep-nesting") == 1
    assert time.perf_counter() - start < 10.0


CLOSE = "missing-end", "close it with ENDIF before line "
INDENTED = {
    "in another": ("IF TRUE THEN\n  IF FALSE THEN\n    HALT\nENDIF", [(2, CLOSE[0], CLOSE[1] + "5")]),
    "before another branch": (
        "IF TRUE THEN\n  IF FALSE THEN\n    HALT\nELSE\n  HALT\nENDIF", [(2, CLOSE[0], CLOSE[1] + "5")]),
    "in a case": (
        "SWITCH 1\n  CASE 1\n    IF TRUE THEN\n      HALT\n  CASE 2\n    HALT\nENDSWITCH",
        [(3, CLOSE[0], CLOSE[1] + "6")]),
    "one after another": (
        "  IF TRUE THEN\n    HALT\n  IF FALSE THEN\n    HALT\n  ENDIF\n   IF FALSE THEN\n  ELSE\n    HALT\n  ENDIF",
        [(1, CLOSE[0], CLOSE[1] + "4")]),
    "the opener is lost": ("IF TRUE THEN\n    HALT\n  ENDIF\nENDIF", [(3, "stray-end", "remove it, or open with IF")]),
    "without indentation in order": (
        "IF TRUE THEN\nIF FALSE THEN\nHALT\nENDIF", [(1, CLOSE[0], CLOSE[1] + "3")]),
    "wrong indentation alone": ("    IF TRUE THEN\nIF FALSE THEN\n  HALT\n        ENDIF\nENDIF", []),
}  # fmt: skip


def missing(text):
    return [(d.position.line - 1, d.code, d.hint) for d in check_program(program_of(*text.split("\n")))]


@pytest.mark.parametrize(("text", "expected"), INDENTED.values(), ids=INDENTED)
def test_a_lost_end_is_told_where_its_block_opens_by_indentation(text, expected):
    assert missing(text) == expected


def test_an_unreadable_line_still_opens_and_closes_its_block():
    assert [x[:2] for x in missing("IF TRUE THN\n  HALT\nENDIF")] == [(1, "syntax")]
    assert [x[:2] for x in missing("REPEAT\n  HALT\nUNTIL (TRUE")] == [(3, "open-bracket")]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("DEF a( )\nHALT\nEND\nGLOBAL DEFFCT INT f(n :IM)\nRETURN 1\nENDFCT\nDEF b( )\nEND\n", [(4, "syntax")]),
        ("DEF a( )\nEND\nDEF b( )\nEND\nDEF A( )\nEND\n", [(5, "duplicate-name")]),
        ("DEF a( )\nEND\nHALT\nHALT\nEND\nHALT\n", [(3, "outside-routine"), (5, "stray-end"), (6, "outside-routine")]),
    ],
)
def test_several_statements_outside_are_one_fault_and_those_of_an_unreadable_def_are_not_outside(text, expected):
    assert [(d.position.line, d.code) for d in check_program(parse_program(text, name="a"))] == expected
