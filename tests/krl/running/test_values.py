"""Rows of arrays, `T[1,] = "text"`, and VARSTATE, while a program runs."""

import pytest

from lwr_dyn.krl.running.program_run import ProgramError, run_program
from tests.krl.short_programs import HOME, program_of

HEAD = ("DECL INT k", "DECL INT n", "DECL REAL r", "DECL CHAR t[9]", "DECL CHAR words[3,5]", "k = 0")
MOVE = ("BAS(#VEL_PTP, 100)", HOME, "PTP_REL {A1 k}")


def angle(arm, *lines, data='DEFDAT a\nCHAR names[2,4]\nnames[1,]="ab"\nINT given=3\nENDDAT\n'):
    """The A1 to which a program goes after these lines [deg]."""
    run = run_program(program_of(*HEAD, *lines, *MOVE, data=data), arm)
    return round(float(run.executed[-1].q[0]) * 57.29577951)


@pytest.mark.parametrize(
    ("lines", "value"),
    [
        (["k = STRLEN(names[1,])"], 2),
        (['words[2,] = "xyz"', "k = STRLEN(words[2,])"], 3),
        (['words[2,] = "xyz"', 'IF words[2,3] == "z" THEN', "k = 7", "ENDIF"], 7),
        (['words[1,] = "long"', 'words[1,] = "s"', "k = STRLEN(words[1,])"], 1),
        (["t[] = names[1,]", "k = STRLEN(t[])"], 2),
        (['IF VARSTATE("n") == #DECLARED THEN', "k = 4", "ENDIF"], 4),
        (["n = 1", 'IF VARSTATE("n") == #INITIALIZED THEN', "k = 5", "ENDIF"], 5),
        (['IF VARSTATE("given") == #INITIALIZED THEN', "k = 6", "ENDIF"], 6),
        (['IF VARSTATE("nothing") == #UNDEFINED THEN', "k = 8", "ENDIF"], 8),
        (['IF VARSTATE("words[9,9]") == #UNDEFINED THEN', "k = 9", "ENDIF"], 9),
        (["r = 2.4", "k = 10 * r"], 24),
        (["k = 6.5"], 7),
        (['t[] = "n"', "IF VARSTATE(t[]) == #DECLARED THEN", "k = 2", "ENDIF"], 2),
    ],
)
def test_rows_and_states(arm, lines, value):
    assert angle(arm, *lines) == value


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ('words[4,] = "a"', r"index 4 of WORDS; 1 to 3"),
        ('words[1,] = "sixsix"', "is given 6 values; up to 5"),
        ("words[1,] = 3", "is INT|given 3"),
    ],
)
def test_wrong_rows(arm, line, message):
    with pytest.raises(ProgramError, match=message):
        angle(arm, line)
