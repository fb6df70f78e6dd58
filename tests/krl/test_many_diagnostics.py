"""Many faults of one kind: each unknown name once, at most 100 of a kind, blocks named by their indentation."""

import time

from lwr_dyn.krl.diagnostics import MOST, has_no_error
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.project.scope import NEAR_NAMES
from lwr_dyn.krl.running.program_run import check_program


def diagnostics_of(*lines, data=None):
    return check_program(parse_program("\n".join(["DEF a( )", *lines, "END", ""]), data, "a"))


def test_an_unknown_name_is_told_once_with_its_places():
    (only,) = diagnostics_of("x = 1", "X = x + 1", "WAIT SEC x")
    assert (only.position.line, only.position.column) == (2, 1)
    assert only.message == "x is not declared (4 places)"
    (call,) = diagnostics_of("foo(1)", "foo(2)")
    assert call.message == "the subprogram foo is not known (2 places)"
    (kind,) = diagnostics_of("DECL FRAMM p", "DECL FRAMM q")
    assert (kind.message, kind.hint) == ("FRAMM is no type (2 places)", "did you mean FRAME?")


def test_a_name_of_the_data_file_is_told_there_too():
    found = diagnostics_of("n = k", data="DEFDAT a\nINT n=1\nINT m\nm=k\nENDDAT\n")
    assert [(d.position.file, d.position.line) for d in found] == [("a.dat", 4), ("a.src", 2)]


def test_similar_names_are_looked_for_at_the_first_names_only():
    found = diagnostics_of("REAL VALUE", *(f"VALU{i} = 1" for i in range(50)))
    hints = [d.hint for d in found]
    assert hints[:NEAR_NAMES] == ["did you mean VALUE?"] * NEAR_NAMES
    assert "did you mean VALUE?" not in hints[NEAR_NAMES:]
    assert len(hints) == 50


def test_at_most_a_hundred_of_a_kind_are_shown_and_the_rest_is_counted():
    found = diagnostics_of(*["WIAT SEC 1"] * 1000, "WHILE")
    assert [d.code for d in found].count("unknown-keyword") == MOST
    (rest,) = [d for d in found if d.code == "more"]
    assert (rest.severity, rest.position.line) == ("note", MOST + 2)
    assert rest.message == "from here 900 more of severity error and code unknown-keyword, not shown"
    assert [d.code for d in found][-1] == "syntax"
    assert not has_no_error(found)


def test_thirteen_thousand_unknown_names_take_no_minute():
    start = time.perf_counter()
    found = diagnostics_of(*(f"REAL known_{i}" for i in range(500)), *(f"name_{i} = {i}" for i in range(13_000)))
    assert time.perf_counter() - start < 20.0  # 95 s before; 2 s on an idle core
    assert len(found) == MOST + 1


def test_deep_nesting_is_told_once_and_ends():
    start = time.perf_counter()
    found = diagnostics_of("LOOP", *["IF TRUE THEN"] * 5000, *["EXIT"] * 5000, *["ENDFOR"] * 5000)
    assert [d.code for d in found].count("deep-nesting") == 1
    assert time.perf_counter() - start < 10.0


def missing(text):
    lines = text.strip("\n").split("\n")
    return [(d.position.line - 1, d.code, d.hint) for d in diagnostics_of(*lines)]


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


def test_of_an_unknown_type_nothing_more_is_told():
    lines = [
        "DECL BOXES b",
        "DECL BOXES c[3]",
        "b.HIGH = TRUE",
        "c[1].LOW = b.HIGH + 1",
        "b = c[2]",
        "PTP b",
        "c[4] = b",
    ]
    found = [(d.position.line, d.code) for d in diagnostics_of(*lines)]
    assert found == [(2, "unknown-type"), (8, "index-range")]
    inside = diagnostics_of("STRUC S1 BOXES K", "DECL S1 s", "s.K.HIGH = 3", "PTP s.K")
    assert [(d.position.line, d.code) for d in inside] == [(2, "unknown-type")]
    taken = diagnostics_of("take(3)", "END", "DEF take(x :IN)", "DECL BOXES x")
    assert [(d.position.line, d.code) for d in taken] == [(5, "unknown-type")]


def test_an_unknown_system_name_may_be_a_subprogram():
    assert [d.code for d in diagnostics_of("$unheard( )")] == ["unknown-call"]
    assert [d.code for d in diagnostics_of("INT n", "n(3)", "$OV_PRO(3)")] == ["type", "type"]


def test_a_keyword_misspelt_before_a_bracket_is_no_unknown_subprogram():
    (fault,) = [d for d in diagnostics_of("RETRUN (3)") if d.position.line == 2]
    assert (fault.code, fault.hint) == ("unknown-keyword", "did you mean RETURN?")
