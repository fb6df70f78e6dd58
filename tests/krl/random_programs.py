"""Random programs as data: every kind of statement and expression, seeded."""

import random

from lwr_dyn.krl.language import declarations as d
from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.language import statements as s
from lwr_dyn.krl.language.source import SourceFile, SourceLine

NAMES = ("a", "B2", "Point_1", "$VEL", "step", "path", "$BASE", "x", "P")
COMPONENTS = list("XYZABCST")
KEYWORD_MEMBERS = ("IN", "OUT", "ON", "OFF", "TO", "SEC", "DO", "PUBLIC", "LIN", "TRUE", "NOT", "END", "WAIT")
"""Keywords, which are names as components and as constants of an enumeration."""
PLAIN = (
    "BRAKE", "BRAKE F", "ON_ERROR_PROCEED", "END", "ENDFCT", "ENDDAT", "ELSE", "ENDIF", "LOOP", "ENDLOOP", "REPEAT",
    "HALT", "EXIT", "CONTINUE",
)  # fmt: skip
OPERATORS = tuple(e.PRIORITY)


class Writer:
    """Random records from a seed; `depth` bounds how deep expressions nest."""

    def __init__(self, seed: int) -> None:
        self.r = random.Random(seed)

    def name(self) -> str:
        return self.r.choice(NAMES)

    def reference(self, depth: int = 1) -> e.Reference:
        kind = self.r.randrange(4) if depth else 0
        if kind == 1:
            return e.Component(self.reference(depth - 1), self.r.choice(("X", "CP", "c", *KEYWORD_MEMBERS)))
        if kind == 2 and self.r.random() < 0.2:
            return e.Index(self.reference(0), tuple(self.expression(0) for _ in range(self.r.randint(1, 2))), row=True)
        if kind == 2:
            return e.Index(self.reference(0), tuple(self.expression(0) for _ in range(self.r.randint(0, 2))))
        return e.Name(self.name())

    def literal(self) -> e.Literal:
        r = self.r
        return r.choice((
            lambda: e.Integer(r.randrange(2**31)), lambda: e.Integer(r.randrange(8), 2, 3),
            lambda: e.Integer(r.randrange(256), 16, 2),
            lambda: e.Real(r.choice((0.0, 91.0, 1e-7, 2.5, 1e30, r.random(), r.uniform(0, 1e6)))),
            lambda: e.Bool(r.random() < 0.5), lambda: e.Text(r.choice(("", "a", "two words", "; no comment", "'{"))),
            lambda: e.EnumLiteral(r.choice(("INITMOV", "red", "BASE"))),
        ))()  # fmt: skip

    def expression(self, depth: int = 3) -> e.Expression:
        kind = self.r.randrange(7) if depth else self.r.randrange(2)
        if kind == 0:
            return self.literal()
        if kind == 1:
            return self.reference(depth > 0)
        if kind == 2:
            return e.Unary(self.r.choice(("+", "-", "NOT", "B_NOT")), self.expression(depth - 1))
        if kind == 3:
            few = [None if self.r.random() < 0.1 else self.expression(depth - 1) for _ in range(self.r.randint(0, 3))]
            # one argument that is left out is no argument
            return e.FunctionCall(self.r.choice(("SIN", "f")), () if few == [None] else tuple(few))
        if kind == 4:
            return self.aggregate(depth - 1)
        return e.Binary(self.r.choice(OPERATORS), self.expression(depth - 1), self.expression(depth - 1))

    def aggregate(self, depth: int = 0) -> e.Aggregate:
        names = self.r.sample([*COMPONENTS, *KEYWORD_MEMBERS], self.r.randint(1, 8))
        items = [e.Item(n, self.expression(depth)) for n in names]
        if self.r.random() < 0.2:
            items.append(e.Item("POINT", e.Text("P1"), ()))
        return e.Aggregate(tuple(items), self.r.choice((None, "E6POS")))

    def assign(self) -> s.Assign:
        return s.Assign(self.reference(2), self.expression())

    def invoke(self) -> s.Invoke:
        return s.Invoke(e.FunctionCall("f", tuple(self.expression(1) for _ in range(self.r.randint(0, 3)))))

    def declarators(self) -> tuple[d.Declarator, ...]:
        def one() -> d.Declarator:
            sizes = self.r.choice((None, (), (e.Integer(3),), (e.Integer(2), e.Integer(4))))
            commas = self.r.choice((0, 0, 1, 2)) if sizes == () else 0
            return d.Declarator(self.name(), sizes, self.r.choice((None, self.expression(1))), commas)

        return tuple(one() for _ in range(self.r.randint(1, 3)))

    def statement(self) -> s.Statement:
        r, x = self.r, self.expression
        makers = (
            self.assign, self.invoke, lambda: d.Header("&REL 7"),
            lambda: d.Def("f", (d.Parameter("a", "IN"), d.Parameter("b", None, 2)), is_global=r.random() < 0.5),
            lambda: d.Def("g", (), "CHAR", r.choice((None, (), (e.Integer(15),)))),
            lambda: d.DefDat("d", r.random() < 0.5), lambda: s.Plain(r.choice(PLAIN)),
            lambda: d.Declaration(r.choice((None, "INT", "E6POS")), self.declarators(), True, r.random() < 0.3),
            lambda: d.Declaration("REAL", self.declarators(), False, False, r.random() < 0.3),
            lambda: d.EnumType("col", ("red", *r.sample(KEYWORD_MEMBERS, 2))),
            lambda: d.StructType("t", (("REAL", tuple(d.Declarator(x) for x in r.sample(KEYWORD_MEMBERS, 2))),)),
            lambda: d.Def("h", (d.Parameter("t", "OUT", 1, (e.Integer(80),)),), "CHAR", (e.Integer(15),)),
            lambda: d.Signal("$OFF", e.Bool(False), None, r.random() < 0.5),
            lambda: d.Channel("SER_1", "SER_2", self.reference(0)),
            lambda: d.External("own", r.choice((None, "INT")), ("CHAR text[80]:IN", "INT:OUT"), None, True),
            lambda: d.External("far", "CHAR", ("INT:IN",), r.choice(((), (e.Integer(15),)))),
            lambda: s.Invoke(e.FunctionCall("COPEN", (e.ChannelName("SER_3"), self.reference(0)))),
            lambda: s.Confirm(x(1)),
            lambda: d.StructType("t", (("INT", (d.Declarator("a"), d.Declarator("b", (e.Integer(2),)))),
                                       ("FRAME", (d.Declarator("f"),)))),
            lambda: d.Signal("lamp", e.Index(e.Name("$OUT"), (e.Integer(1),)), r.choice((None, self.reference(0)))),
            lambda: d.External("far", r.choice((None, "INT")), ("INT:IN", "REAL[]:OUT")),
            lambda: s.Move(r.choice(("PTP", "LIN", "LIN_REL", "SPTP")), x(2), blends=r.choice(((), ("C_PTP", "C_DIS"))),
                           frame=r.choice((None, "TOOL"))),
            lambda: s.Move("SLIN", x(1), settings=(self.assign(), self.assign()), blends=("C_SPL",)),
            lambda: s.Move("CIRC", x(1), auxiliary=x(1), angle=r.choice((None, x(1))),
                           blends=r.choice(((), ("C_DIS",)))),
            lambda: s.SplineBlock("SPLINE", r.choice(((), (self.assign(),)))),
            lambda: s.EndSpline(r.choice(((), ("C_SPL",)))), lambda: s.Wait(r.choice(("SEC", "FOR")), x()),
            lambda: s.Condition(r.choice(("IF", "WHILE", "UNTIL", "SWITCH")), x()),
            lambda: s.CaseBranch(tuple(x(1) for _ in range(r.randint(1, 3)))),
            lambda: s.For(e.Name("i"), x(1), x(1), r.choice((None, x(1)))),
            lambda: s.Jump("there"), lambda: s.Label("there"), lambda: s.Return(r.choice((None, x()))),
            lambda: s.InterruptDeclaration(x(0), x(2), r.choice((self.assign, self.invoke))(), r.random() < 0.5,
                                           r.random() < 0.3),
            lambda: s.InterruptSwitch(r.choice(("ON", "OFF", "ENABLE", "DISABLE")), r.choice((None, e.Integer(3)))),
            lambda: s.Trigger(r.choice(("DISTANCE", "PATH")), x(1), x(1), self.invoke(), r.choice((None, x(1))),
                              r.random() < 0.5),
            lambda: s.ConstantSpeed(r.choice(("START", "END")), x(1), r.random() < 0.5),
            lambda: s.TimeBlock("START"), lambda: s.TimeBlock(r.choice(("PART", "END")), x(1)),
            lambda: s.ConditionalStop(x(1), x(2), r.random() < 0.5),
            lambda: s.Analog("ANOUT", "ON", self.reference(1), x(1),
                             r.choice(((), (s.Assign(e.Name("DELAY"), x(0)),)))),
        )  # fmt: skip
        return r.choice(makers)()

    def file(self) -> SourceFile:
        def line() -> SourceLine:
            comment = self.r.choice((None, None, " why; not", "FOLD INI", "Größe"))
            statement = None if self.r.random() < 0.1 else self.statement()
            # a header line is whole: it takes no comment
            return SourceLine(statement, None if isinstance(statement, d.Header) else comment)

        return SourceFile("random.src", tuple(line() for _ in range(self.r.randint(1, 12))))
