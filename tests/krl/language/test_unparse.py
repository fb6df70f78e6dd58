"""Forms of lines that real programs hold: each is read as meant, and what is written of it is read back the same."""

from dataclasses import fields, is_dataclass

import pytest
from lark import Lark

from lwr_dyn.krl.language import declarations as d
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.lexer import GRAMMAR, KEYWORDS, LONGEST, LineError, tokens_of
from lwr_dyn.krl.language.line_parser import RULES, parse_line
from lwr_dyn.krl.language.unparse import statement_text


def name(text):
    return e.Name(text)


FORMS = {
    'tool_name[1,]="Gripper"': s.Assign(e.Index(name("tool_name"), (e.Integer(1),), row=True), e.Text("Gripper")),
    'grid[1,2,]="x"': s.Assign(e.Index(name("grid"), (e.Integer(1), e.Integer(2)), row=True), e.Text("x")),
    "STRUC slot INT OUT, REAL IN, BOOL INT": d.StructType(
        "slot", (("INT", (d.Declarator("OUT"),)), ("REAL", (d.Declarator("IN"),)), ("BOOL", (d.Declarator("INT"),)))),
    "GLOBAL STRUC pair INT ON, OFF": d.StructType("pair", (("INT", (d.Declarator("ON"), d.Declarator("OFF"))),), True),
    "GLOBAL ENUM lamp ON, OFF, WAIT": d.EnumType("lamp", ("ON", "OFF", "WAIT"), True),
    "box.IN.S1 = box.OUT": s.Assign(e.Component(e.Component(name("box"), "IN"), "S1"), e.Component(name("box"), "OUT")),
    "slot = {OUT 1, IN 2.5, SUB {ON TRUE, OFF FALSE}}": s.Assign(name("slot"), e.Aggregate((
        e.Item("OUT", e.Integer(1)), e.Item("IN", e.Real(2.5)),
        e.Item("SUB", e.Aggregate((e.Item("ON", e.Bool(True)), e.Item("OFF", e.Bool(False)))))))),
    "DEFFCT CHAR[15] label_of(n:IN)": d.Def("label_of", (d.Parameter("n", "IN"),), "CHAR", (e.Integer(15),)),
    "GLOBAL DEFFCT CHAR[] text_of()": d.Def("text_of", (), "CHAR", (), True),
    "DEF fill(text[80]:OUT, table[,]:IN)": d.Def(
        "fill", (d.Parameter("text", "OUT", 1, (e.Integer(80),)), d.Parameter("table", "IN", 2))),
    "DEF old(a:INOUT)": d.Def("old", (d.Parameter("a", "INOUT"),)),
    "EXTFCT CHAR[15] label_of(INT:IN)": d.External("label_of", "CHAR", ("INT:IN",), (e.Integer(15),)),
    "EXTP raise_it(ERROR_T what:OUT)": d.External("raise_it", None, ("ERROR_T what:OUT",), None, True),
    "EXTFCTP INT length_of(CHAR text[80]:IN)": d.External("length_of", "INT", ("CHAR text[80]:IN",), None, True),
    "SIGNAL $WORKSTATE1 FALSE": d.Signal("$WORKSTATE1", e.Bool(False)),
    "CHANNEL :SER_1 :SER_1 $PSER_1": d.Channel("SER_1", "SER_1", name("$PSER_1")),
    "COPEN(:SER_3, handle)": s.Invoke(e.FunctionCall("COPEN", (e.ChannelName("SER_3"), name("handle")))),
    "BRAKE": s.Plain("BRAKE"),
    "BRAKE F": s.Plain("BRAKE F"),
    "INTERRUPT WITH BRAKE DECL 2 WHEN $IN[3] DO stop()": s.InterruptDeclaration(
        e.Integer(2), e.Index(name("$IN"), (e.Integer(3),)), s.Invoke(e.FunctionCall("stop")), with_brake=True),
    "CONFIRM nr": s.Confirm(name("nr")),
    "ON_ERROR_PROCEED": s.Plain("ON_ERROR_PROCEED"),
    "DECL INT V[,]": d.Declaration("INT", (d.Declarator("V", (), commas=1),)),
    "CHAR text[]": d.Declaration("CHAR", (d.Declarator("text", ()),), False),
    "PTP P1 C_DIS": s.Move("PTP", name("P1"), blends=("C_DIS",)),
    "SLIN P1 C_DIS": s.Move("SLIN", name("P1"), blends=("C_DIS",)),
    "DEFDAT points() PUBLIC": d.DefDat("points", True),
    "TRIGGER WHEN PATH = 5 ONSTART DELAY = 20 DO go() PRIO = -1": s.Trigger(
        "PATH", e.Integer(5), e.Integer(20), s.Invoke(e.FunctionCall("go")), e.Unary("-", e.Integer(1)), True),
    "TRIGGER WHEN DISTANCE = 0 DELAY = n DO x = 1": s.Trigger(
        "DISTANCE", e.Integer(0), name("n"), s.Assign(name("x"), e.Integer(1))),
    "STOP WHEN PATH = 50 ONSTART IF b": s.ConditionalStop(e.Integer(50), name("b"), True),
    "STOP WHEN PATH = 50 IF b": s.ConditionalStop(e.Integer(50), name("b")),
    "CONST_VEL START = 10 ONSTART": s.ConstantSpeed("START", e.Integer(10), True),
    "CONST_VEL END = 5": s.ConstantSpeed("END", e.Integer(5)),
    "ANOUT ON x = y DELAY = 0.2 MINIMUM = 0.3": s.Analog("ANOUT", "ON", name("x"), name("y"), (
        s.Assign(name("DELAY"), e.Real(0.2)), s.Assign(name("MINIMUM"), e.Real(0.3)))),
    "ANIN OFF x": s.Analog("ANIN", "OFF", name("x")),
    "CIRC p, q, CA 90 C_DIS": s.Move("CIRC", name("q"), name("p"), e.Integer(90), blends=("C_DIS",)),
    "SLIN p WITH v = 1, a = 2 C_SPL": s.Move("SLIN", name("p"), blends=("C_SPL",), settings=(
        s.Assign(name("v"), e.Integer(1)), s.Assign(name("a"), e.Integer(2)))),
    "LIN_REL p #TOOL": s.Move("LIN_REL", name("p"), frame="TOOL"),
    "FOR i = 1 TO n STEP 2": s.For(name("i"), e.Integer(1), name("n"), e.Integer(2)),
    "err = f(# STATE)": s.Assign(name("err"), e.FunctionCall("f", (e.EnumLiteral("STATE"),))),
}  # fmt: skip


def columns(x):
    """Of a record and all within."""
    if isinstance(x, tuple):
        return [column for part in x for column in columns(part)]
    own = [x.column] if getattr(x, "column", 0) else []
    return own + [y for one in fields(x) for y in columns(getattr(x, one.name))] if is_dataclass(x) else []


@pytest.mark.parametrize("line", FORMS)
def test_a_form_is_read_as_meant_and_survives_writing(line):
    statement, _ = parse_line(line)
    assert statement == FORMS[line]
    name = getattr(statement.target if isinstance(statement, s.Assign) else statement, "name", None)
    assert statement.column == (line.index(name) + 1 if name else 1)
    assert columns(parse_line(f"   {line}")[0]) == [x + 3 for x in columns(statement)]
    assert parse_line(statement_text(statement))[0] == statement
    assert parse_line(line.lower().replace('"gripper"', '"Gripper"'))[0] is not None


FAULTS = {"BRAKE G": 7, "x = T[,1]": 8, "STRUC p INT": 12, "SIGNAL off FALSE": 8, "CHANNEL SER_1": 9, "x = (1 + 2": 5}


@pytest.mark.parametrize("line", FAULTS)
def test_what_is_near_these_forms_is_a_fault_the_same_each_time(line):
    faults = []
    for _ in range(3):
        with pytest.raises(LineError) as fault:
            parse_line(line)
        faults.append(fault.value)
    assert len({(f.column, f.code, f.message, f.hint) for f in faults}) == 1
    assert (faults[0].column, faults[0] is not faults[1]) == (FAULTS[line], True)


DEPTHS = {"x = ": 100, "x = f(": 99, "x = f(1, ": 98, "x = f(g(1, ": 97, "INT a, b = ": 100}


@pytest.mark.parametrize(("before", "most"), DEPTHS.items())
def test_so_many_operators_and_brackets_may_stand_inside_one_another(before, most):
    assert len(tokens_of(f"{before}{'-' * most}1")[0]) > most
    with pytest.raises(LineError) as fault:
        tokens_of(f"{before}{'-' * most}-1")
    assert (fault.value.code, fault.value.column) == ("long-line", len(before) + most + 1)


def test_a_line_of_8192_characters_is_read_and_a_longer_one_is_a_fault():
    items = ", ".join(f"A{i} -{i}.5" for i in range(600))
    line = f"t = {{{items}}}".ljust(LONGEST)
    assert (len(line), len(parse_line(line)[0].value.items)) == (LONGEST, 600)
    assert parse_line(line + ";" + "c" * 50_000)[1] == "c" * 50_000
    for longer in (line + " ", "x = " + "?" * 10_000_000, "y" * 10_000_000):
        with pytest.raises(LineError) as fault:
            parse_line(longer)
        assert fault.value.column <= LONGEST + 1
    assert (fault.value.code, fault.value.column) == ("long-line", LONGEST + 1)


@pytest.mark.slow
def test_each_rule_of_the_grammar_has_a_function_and_no_function_lacks_a_rule():
    rules = Lark(GRAMMAR, parser="lalr", lexer="basic", start="line", maybe_placeholders=True).rules
    named = {x.alias or str(x.origin.name) for x in rules if x.alias or not x.options.expand1}
    assert {name for name in named if not name.startswith("_")} == set(RULES)


def test_keywords_of_the_grammar_are_those_of_the_lexer_and_lines_of_one_shape_take_their_own_tokens():
    kinds = [KEYWORDS.get(x) for x in ("TRIGGER", "SCIRC_REL", "NAME")]
    assert kinds == ["TRIGGER", "CIRCULAR", None]
    for text in ("x = y + 1", "alpha = beta - 22"):
        read, words = parse_line(text)[0], text.split()
        assert [read.target.name, read.value.left.name, read.value.operator] == [words[0], words[2], words[3]]
