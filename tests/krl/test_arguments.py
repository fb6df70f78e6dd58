"""Arguments of calls: types against the declared parameters."""

import pytest

from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.run import check_program

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
