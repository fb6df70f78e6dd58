"""Blocks: a lost end is named where its block opens, by indentation; deep nesting ends; unreadable lines count."""

import time

from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.program_run import check_program
from tests.krl.short_programs import program_of, told


def test_deep_nesting_is_told_once_and_ends():
    start = time.perf_counter()
    found = told("LOOP", *["IF TRUE THEN"] * 5000, *["EXIT"] * 5000, *["ENDFOR"] * 5000)
    assert [code for _, _, code in found].count("deep-nesting") == 1
    assert time.perf_counter() - start < 10.0


def missing(text):
    lines = text.strip("\n").split("\n")
    return [(d.position.line - 1, d.code, d.hint) for d in check_program(program_of(*lines))]


def test_a_lost_end_is_told_where_its_block_opens_by_indentation():
    inner = """
IF TRUE THEN
  IF FALSE THEN
    HALT
ENDIF
"""
    assert missing(inner) == [(2, "missing-end", "close it with ENDIF before line 5")]
    other_branch = """
IF TRUE THEN
  IF FALSE THEN
    HALT
ELSE
  HALT
ENDIF
"""
    assert missing(other_branch) == [(2, "missing-end", "close it with ENDIF before line 5")]
    in_a_case = """
SWITCH 1
  CASE 1
    IF TRUE THEN
      HALT
  CASE 2
    HALT
ENDSWITCH
"""
    assert missing(in_a_case) == [(3, "missing-end", "close it with ENDIF before line 6")]
    one_after_another = """
  IF TRUE THEN
    HALT
  IF FALSE THEN
    HALT
  ENDIF
   IF FALSE THEN
  ELSE
    HALT
  ENDIF
"""
    assert missing(one_after_another) == [(1, "missing-end", "close it with ENDIF before line 4")]
    opener_lost = """
IF TRUE THEN
    HALT
  ENDIF
ENDIF
"""
    assert [x[:2] for x in missing(opener_lost)] == [(3, "stray-end")]


def test_without_indentation_blocks_are_paired_in_order():
    flat = """
IF TRUE THEN
IF FALSE THEN
HALT
ENDIF
"""
    assert [x[:2] for x in missing(flat)] == [(1, "missing-end")]


def test_wrong_indentation_alone_is_no_fault():
    assert missing("    IF TRUE THEN\nIF FALSE THEN\n  HALT\n        ENDIF\nENDIF") == []


def test_an_unreadable_line_still_opens_and_closes_its_block():
    assert [x[:2] for x in missing("IF TRUE THN\n  HALT\nENDIF")] == [(1, "syntax")]
    assert [x[:2] for x in missing("REPEAT\n  HALT\nUNTIL (TRUE")] == [(3, "open-bracket")]


def test_after_an_unreadable_def_its_lines_are_not_outside():
    text = "DEF a( )\nHALT\nEND\nGLOBAL DEFFCT INT f(n :IM)\nRETURN 1\nENDFCT\nDEF b( )\nEND\n"
    assert [(d.position.line, d.code) for d in check_program(parse_program(text, name="a"))] == [(4, "syntax")]


def test_several_statements_outside_are_one_fault():
    text = "DEF a( )\nEND\nHALT\nHALT\nEND\nHALT\n"
    found = [(d.position.line, d.code) for d in check_program(parse_program(text, name="a"))]
    assert found == [(3, "outside-routine"), (5, "stray-end"), (6, "outside-routine")]
