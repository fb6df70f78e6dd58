"""Faults that the pendant refuses, one tiny program a kind, each with its mended twin of which nothing is told.

The kinds are those of the planted faults that `krl check` of version 0.2.0 passed.
"""

import pytest

from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.program_run import check_program

ROUTINES = "DEF sub( )\nHALT\nEND\nDEF give(N:OUT)\nINT N\nN = 1\nEND\n"


def kind(name, bad, line, code, good, hint="", /):
    """Lines of `a.src` with a fault in `line` (from 1), the code and what its help names, and the mended lines."""
    texts = (x if x.startswith("DEF a(") else f"DEF a( )\n{x}\nEND\n{ROUTINES}" for x in (bad, good))
    return name, *texts, line, code, hint


SPLINE, PTP_SPLINE = "SPLINE\nSPL {X 1}\n%s\nENDSPLINE", "PTP_SPLINE\nSPTP {A1 1}\n%s\nENDSPLINE"
SWITCH = "INT N\nN = 1\nSWITCH N\n%s\nENDSWITCH"
INTERRUPT = "INTERRUPT DECL %s WHEN $IN[1] DO sub()"
ZERO = "{X 0, Y 0, Z 0, A 0, B 0, C 0}"

KINDS = [
    kind("a $ name one letter off", f"$TOLL = {ZERO}", 2, "system-name", f"$TOOL = {ZERO}", "$TOOL"),
    kind("a $ name with a letter more", "$OV_PROG = 50", 2, "system-name", "$OV_PRO = 50", "$OV_PRO"),
    kind("a command of BAS as $ name", "$VEL_PTP = 50", 2, "system-name", "$VEL_AXIS[1] = 50", "BAS(#VEL_PTP"),
    kind("a component as $ name", "$VEL_CP = 0.5", 2, "system-name", "$VEL.CP = 0.5", "$VEL.CP"),
    kind("a short $ name", "WAIT FOR $INP[3]", 2, "system-name", "WAIT FOR $IN[3]", "$IN"),
    kind("a parameter never declared", "DEF a(N:IN)\nHALT\nEND\n", 1, "parameter-type",
         "DEF a(N:IN)\nINT N\nEND\n", "INT N"),
    kind("two letters of $IN swapped", "WAIT FOR $NI[3]", 2, "system-name", "WAIT FOR $IN[3]", "$IN"),
    kind("a letter of $IN left out", "WAIT FOR $I[3]", 2, "system-name", "WAIT FOR $IN[3]", "$IN"),
    kind("an underscore twice", "$TIMER__STOP[1] = TRUE", 2, "system-name", "$TIMER_STOP[1] = TRUE", "$TIMER_STOP"),
    kind("writes an input", "$IN[3] = TRUE", 2, "read-only", "$OUT[3] = TRUE", "$OUT[3]"),
    kind("writes the actual position", f"$POS_ACT = {ZERO}", 2, "read-only", f"$BASE = {ZERO}"),
    kind("writes the running time", "$ROBRUNTIME = 3", 2, "read-only", "$TIMER[1] = 3"),
    kind("writes a state of the controller", "$STOPMESS = FALSE", 2, "read-only", "$OUT[1] = $STOPMESS"),
    kind("writes a signal of an input", "SIGNAL S $IN[3]\nS = TRUE", 3, "read-only",
         "SIGNAL S $OUT[3]\nS = TRUE", "$OUT"),
    kind("a trigger writes an input", "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $IN[3]=TRUE", 2, "read-only",
         "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[3]=TRUE"),
    kind("a loop counts in an input", "FOR $ANIN[1] = 1 TO 3\nENDFOR", 2, "read-only",
         "INT K\nFOR K = 1 TO 3\nENDFOR"),
    kind("a pulse on an input", "PULSE($IN[1], TRUE, 1)", 2, "read-only", "PULSE($OUT[1], TRUE, 1)", "$OUT[1]"),
    kind("writes a constant", "CONST INT K\nK = 2", 3, "read-only", "INT K\nK = 2", "CONST"),
    kind("an interrupt never declared", "INTERRUPT ON 11", 2, "interrupt", INTERRUPT % 11 + "\nINTERRUPT ON 11",
         "INTERRUPT DECL 11"),
    kind("a priority too large", INTERRUPT % 200, 2, "interrupt", INTERRUPT % 128, "128"),
    kind("a priority of the controller", INTERRUPT % 50, 2, "interrupt", INTERRUPT % 81, "81"),
    kind("a priority of the controller for a trigger", "TRIGGER WHEN DISTANCE=0 DELAY=0 DO sub() PRIO=60", 2,
         "interrupt", "TRIGGER WHEN DISTANCE=0 DELAY=0 DO sub() PRIO=-1", "81"),
    kind("a priority of no trigger", "TRIGGER WHEN DISTANCE=0 DELAY=0 DO sub() PRIO=0", 2, "interrupt",
         "TRIGGER WHEN DISTANCE=0 DELAY=0 DO sub() PRIO=1", "1 to 39"),
    kind("an output inside SPLINE", SPLINE % "$OUT[1] = TRUE", 4, "in-spline",
         SPLINE % "TRIGGER WHEN PATH=0 DELAY=0 DO $OUT[1]=TRUE\nSPL {X 2}", "TRIGGER WHEN PATH"),
    kind("a pause inside SPLINE", SPLINE % "WAIT SEC 1", 4, "in-spline", SPLINE % "SPL {X 2}" + "\nWAIT SEC 1"),
    kind("PTP inside SPLINE", SPLINE % "PTP {A1 1}", 4, "in-spline", SPLINE % "SLIN {X 2}", "SLIN"),
    kind("SLIN inside PTP_SPLINE", PTP_SPLINE % "SLIN {X 1}", 4, "in-spline", PTP_SPLINE % "SPTP {A1 2}", "SPTP"),
    kind("CONST_VEL outside SPLINE", "CONST_VEL START = 10", 2, "in-spline", "SPLINE\nCONST_VEL START = 10 ONSTART\n"
         "SPL {X 1}\nCONST_VEL END = -5\nENDSPLINE", "SPLINE"),
    kind("CONST_VEL of no number", SPLINE % "CONST_VEL END = TRUE", 4, "type", SPLINE % "CONST_VEL END = 2.5", "REAL"),
    kind("TIME_BLOCK without its end", SPLINE % "TIME_BLOCK START", 4, "in-spline",
         "SPLINE\nTIME_BLOCK START\nSPL {X 1}\nTIME_BLOCK PART = 20\nSPL {X 2}\nTIME_BLOCK END = 2.5\nENDSPLINE",
         "TIME_BLOCK END"),
    kind("TIME_BLOCK without its start", PTP_SPLINE % "TIME_BLOCK END = 2", 4, "in-spline",
         "PTP_SPLINE\nTIME_BLOCK START\nSPTP {A1 1}\nTIME_BLOCK END = 2\nENDSPLINE", "TIME_BLOCK START"),
    kind("a start with a time", SPLINE % "TIME_BLOCK START = 3", 4, "syntax",
         SPLINE % "TIME_BLOCK START\nTIME_BLOCK END = 3", "TIME_BLOCK END = seconds"),
    kind("an unknown bound", SPLINE % "CONST_VEL STOP1 = 3", 4, "syntax", SPLINE % "CONST_VEL END = 3", "START, END"),
    kind("STOP WHEN on a number", "STOP WHEN PATH = 5 IF 3", 2, "type",
         "STOP WHEN PATH = 5 ONSTART IF $IN[1]\nSLIN {X 1}",
         "BOOL"),
    kind("SWITCH on REAL", "REAL R\nR = 1\nSWITCH R\nCASE 1\nENDSWITCH", 4, "switch", SWITCH % "CASE 1", "INT"),
    kind("a statement before the first CASE", SWITCH % "N = 2\nCASE 1", 5, "switch", SWITCH % "CASE 1\nN = 2", "CASE"),
    kind("CASE after DEFAULT", SWITCH % "DEFAULT\nCASE 1", 6, "switch", SWITCH % "CASE 1\nDEFAULT", "DEFAULT"),
    kind("GOTO into a loop", "GOTO IN1\nLOOP\nIN1:\nENDLOOP", 2, "goto", "LOOP\nIN1:\nGOTO IN1\nENDLOOP"),
    kind("GOTO into an IF", "GOTO IN1\nIF $IN[1] THEN\nIN1:\nENDIF", 2, "goto",
         "IF $IN[1] THEN\nGOTO OUT1\nENDIF\nOUT1:"),
    kind("a text without brackets", 'CHAR T[10]\nT = "abc"', 3, "text-brackets", 'CHAR T[10]\nT[] = "abc"', "T[]"),
    kind("a text of a component without brackets", 'DECL KRLMSG_T M\nM.MSG_TXT = "abc"', 3, "text-brackets",
         'DECL KRLMSG_T M\nM.MSG_TXT[] = "abc"', 'M.MSG_TXT[] = "abc"'),
    kind("a constant for OUT", "give(3)", 2, "arguments", "INT K\ngive(K)", "variable"),
    kind("a sum for OUT", "INT K\nK = 1\ngive(K + 1)", 4, "arguments", "INT K\ngive(K)", "variable"),
]  # fmt: skip


def diagnosed(text, data=None):
    return check_program(parse_program(text, data, "a"))


@pytest.mark.parametrize(("bad", "good", "line", "code", "hint"), [x[1:] for x in KINDS], ids=[x[0] for x in KINDS])
def test_each_fault_is_diagnosed_at_its_line_and_nothing_is_said_of_the_mended_program(bad, good, line, code, hint):
    found = diagnosed(bad)
    assert [(d.position.line, d.code) for d in found] == [(line, code)]
    assert hint in found[0].hint
    assert found[0].hint
    assert [str(d) for d in diagnosed(good)] == []


@pytest.mark.parametrize(
    ("line", "number", "first", "codes"),
    [("", 16, "=16", []), ("", 11, "=16", ["interrupt"]), ("", 11, "", []), ("LEVEL = 11\n", 11, "=16", [])],
)
def test_an_interrupt_declared_by_the_first_value_of_a_variable(line, number, first, codes):
    text = f"DEF a( )\n{line}INTERRUPT DECL LEVEL WHEN $IN[1] DO sub()\nINTERRUPT ON {number}\nEND\n{ROUTINES}"
    found = diagnosed(text, f"DEFDAT a\nINT LEVEL{first}\nENDDAT\n")
    assert [d.code for d in found if d.code == "interrupt"] == codes


SOUND = [
    # RSI on KSS 8.5 takes the axes of the correction too
    "DEF a( )\nINT R\nR = RSI_ON(#ABSOLUTE, #IPO, #BASE)\nEND\n",
    "DEF a( )\nDECL STARCDAT_T W\nTS_CorrOff()\nArcMainNG(#ArcOnBeforeMoveStd, W)\nEND\n",
    "DEF a(N:IN)\nEND\n",  # a stub
    "DEF a( )\nINTERRUPT OFF 11\nINTERRUPT ON\nEND\n",
    "DEF a( )\nINT K\nK = 11\nINTERRUPT DECL K WHEN $IN[1] DO sub()\nINTERRUPT ON 11\nEND\nDEF sub( )\nHALT\nEND\n",
    "DEF a( )\nBOOL STOP\nINT START, PART\nSTOP = TRUE\nSTART = 1\nPART = START\nEND\n",
    "DEF a( )\nON1:\nIF $IN[1] THEN\nGOTO ON1\nENDIF\nEND\n",
    "DEF a( )\nSWITCH $MODE_OP\nCASE #T1\nGOTO ON1\nON1:\nDEFAULT\nENDSWITCH\nEND\n",
    "DEF a( )\nPTP_SPLINE\nSPTP_REL {A1 1}\nENDSPLINE\nEND\n",
    # a subprogram may be given an input and a text for OUT
    'DEF a( )\nask($IN[3])\nsay("abc")\nEND\nDEF ask(B:OUT)\nBOOL B\nEND\nDEF say(T[]:OUT)\nCHAR T[]\nEND\n',
]


@pytest.mark.parametrize("text", SOUND)
def test_nothing_is_said_of_sound_programs(text):
    assert [str(d) for d in diagnosed(text)] == []


def test_a_dat_gives_read_only_variables_their_first_value_but_an_output_of_machine_data_stays_read_only():
    assert diagnosed("DEF a( )\nEND\n", "DEFDAT a\n$MODE_OP=#T1\nCONST INT K=3\nENDDAT\n") == ()
    data = "DEFDAT a\nSIGNAL $PERI_RDY $OUT[1012]\nSIGNAL LAMP $OUT[12]\nENDDAT\n"
    found = diagnosed("DEF a( )\nLAMP = TRUE\n$PERI_RDY = TRUE\nEND\n", data)
    assert [(d.position.line, d.code, d.severity) for d in found] == [(3, "read-only", "error")]
    assert [d.code for d in diagnosed("DEF a( )\nSPLINE\nSPL {X 1}\nHALT\nEND\n")] == ["missing-end"]
