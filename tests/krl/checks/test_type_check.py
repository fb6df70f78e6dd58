"""Arguments of calls: types against the declared parameters."""

import pytest

from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.program_run import check_program

ROUTINES = """
DEF take(number :IN, name[] :OUT, mode :IN, place :OUT, open)
INT number
CHAR name[]
DECL COLOR mode
DECL FRAME place
number = number + 1
END
"""
DATA = "DEFDAT a\nENUM COLOR RED,GREEN\nDECL FRAME F={X 0}\nCHAR TEXT[9]\nREAL R=0\nDECL COLOR C=#RED\nENDDAT\n"


def told(call):
    program = parse_program(f"DEF a( )\n{call}\nEND\n{ROUTINES}", DATA, "a")
    return [(d.position.line, d.code) for d in check_program(program)]


@pytest.mark.parametrize(
    "call",
    [
        'take(1, "long text", #GREEN, F, TRUE)', "take(R, TEXT[], C, F, 3)", "take()", "take(1, , , F)", "take(R * 2)",
    ],
)  # fmt: skip
def test_arguments_that_fit(call):
    assert told(call) == []


@pytest.mark.parametrize(
    ("call", "code"),
    [
        ("take(TRUE)", "type"),
        ("take(1, 2)", "type"),
        ("take(1, TEXT[], #GREN)", "no-constant"),
        ("take(1, TEXT[], 3)", "type"),
        ("take(1, TEXT[], C, R)", "type"),
        ("take(#RED)", "type"),
        ("take(1, TEXT[], C, F, TRUE, 6)", "arguments"),
    ],
)
def test_arguments_that_do_not_fit(call, code):
    assert told(call) == [(2, code)]


def told_by(*lines):
    data = "DEFDAT a\nCHAR TEXT[9]\nINT N=0\nDECL E6POS P\nDECL E6AXIS AX\nENDDAT\n"
    program = parse_program("\n".join(["DEF a( )", *lines, "END", ""]), data, "a")
    return [(d.position.line, d.severity, d.code) for d in check_program(program)]


@pytest.mark.parametrize(
    ("line", "severity", "code"),
    [
        ('N = STRADD("abc", TEXT[])', "error", "arguments"),
        ("N = STRLEN(5)", "error", "type"),
        ("AX = INVERSE(P, AX, 3)", "error", "arguments"),
        ("AX = INVERSE(AX, AX, N)", "error", "type"),
        ("BAS(#INITMOVQ, 0)", "warning", "no-constant"),
        ("BAS(TRUE, 0)", "warning", "type"),
        ("N = SIN(TEXT[])", "error", "type"),
    ],
)
def test_functions_of_the_controller(line, severity, code):
    assert told_by(line) == [(2, severity, code)]


def test_functions_of_the_controller_that_fit():
    calls = [
        'N = STRADD(TEXT[], "abc")',
        "N = STRLEN(TEXT[])",
        "AX = INVERSE(P, AX, N)",
        "BAS(#INITMOV, 0)",
        "BAS(#FRAMES)",
    ]
    assert told_by(*calls) == []


def test_what_ext_declares_counts():
    external = "EXT OTHER(BAS_COMMAND :IN, CHAR WORDS[] :OUT)"
    assert told_by(external, "OTHER(#INITMOV, TEXT[])") == []
    assert told_by(external, "OTHER(#INITMOVQ, TEXT[])") == [(3, "warning", "no-constant")]
    assert told_by(external, "OTHER(#INITMOV, 3)") == [(3, "error", "type")]
