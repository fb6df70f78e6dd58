"""Each rule on a small table: it finds its fault, says it with its place, and accepts a correct table."""

import pytest

from lwr_dyn.checks.tables.formulas import corrections, equalities, exchanges, scale_or_sign
from lwr_dyn.checks.tables.rules import lint
from lwr_dyn.checks.tables.sheet import SheetColumn, SheetTable, TableError, sheet_of_csv
from lwr_dyn.checks.tables.toml_sheet import sheet_of_toml
from lwr_dyn.model.printed_number import printed_number


def lines(text):
    """What is found in a text, CSV where it begins so: "place: severity rule: sentence"."""
    toml = text.startswith("[") or (" = " in text.splitlines()[0] and not text.startswith("#"))
    findings = lint(sheet_of_toml(text, "x") if toml else sheet_of_csv(text, "x", "t"))
    return [f.line().removeprefix("x:") for f in findings if f.counts]


GAINS = """[gains]
omega = 10.0
b = ["2.0", "3.0", "4.0", "5.0"]
Kp = ["200", "300", "400", "{}"]
[gains.lint]
formula = ["Kp = omega^2 * b"]
"""
SHIFTED = "# formula: y = x^2\ni,x,y\n1,2.0,{}\n2,3.0,4.0\n3,5.0,9.0\n4,7.0,25.0\n5,11.0,49.0\n"
SWAPPED = "# formula: y = 2 * x\ni,x,y\n1,2.0,4.0\n2,3.0,10\n3,5.0,6.0\n"
TWO_TABLES = "[a]\nd = [0, 0.4, 0, 0.39, 0, 0.078, 0.1]\n[b]\nd = {}\n"
TOTAL = "link;mass [kg]\n1;2.7\n2;{};\n3;1.4\ntotal;{}\n".replace("{};", "{}")
ROBOT = "base.mass.values = 3.0\ninertial.mass.values = [1.0, 2.0]\nratings.mass.values = {}"
TWICE = """[point_2]
theta_1 = "-103.01"
theta_3 = "-88.2"
[table_5]
rows = ["theta_1", "theta_2", "theta_3"]
point_2 = ["{}", "67.62", "-88.18"]
"""
TENSOR = "inertia = [[1.5, 0.2, 0.1], [0.2, 1.1, 0.3], [0.1, {}, 1.2]]"
OTHER = "matrix = [[1.55, 0.211, 0.123], [0.211, 1.1, 0.345], [{}, {}, 1.2]]"
COPIED = "i,x,y,z\n1,0.4471,1.2931,{}\n2,{},0.00437543\n3,0.0922,-0.7713,0.0517\n"
UNITS = "# formula: T = {}\ni,F [N],l [mm],T [N m]\n1,3.0,200,{}\n2,4.0,500,2.0\n"
CASES = [
    (GAINS.format(500), []),
    (GAINS.format(512), ["gains, row 4, Kp: error formula: prints 512 where Kp = omega^2 * b gives 500: off by 12"]),
    (GAINS.format("50.0"), ["gains, row 4, b: error power-of-ten: ", "gains, row 4, Kp: error power-of-ten: prints 50.0"
     " where Kp = omega^2 * b gives 500: off by 1e1"]),
    (GAINS.format(-500), ["gains, row 4, Kp: error sign: prints -500 where Kp = omega^2 * b gives 500: the sign is"]),
    (GAINS.format(512).replace("omega^2", "mo_tors.omega^2") + '[mo-tors]\nomega = 16\n', [
        "gains, row 1, Kp: error formula: prints 200 where Kp = mo_tors.omega^2 * b gives 512: off by -312",
        "gains, row 2, Kp: ", "gains, row 3, Kp: ", "gains, row 4, Kp: "]),
    (SHIFTED.format("4.0"), ["t, row 2, y: error rows-shifted: 4 rows of y print what y = x^2 gives one row above"]),
    (SWAPPED, ["t, row 2, y: error swapped: t, row 2, y prints 10 where 6 follows, t, row 3, y prints 6.0 where 10 "
     "follows (y = 2 * x): the two are exchanged"]),
    (TWO_TABLES.format("[0, 0, 0.4, 0, 0.39, 0, 0.078]"), ["a.d: error rows-shifted: "]),
    (TWO_TABLES.format("[0, 0.4, 0, 0.39, 0, 0.078, 0.1]"), []),
    # each cell and the total may be off by half a unit
    (TOTAL.format("3.1", "7.2"), []), (TOTAL.format("3.1", "7.4"), []),
    (TOTAL.format("3.1", "7.5"), ["t, total of mass: error total: 7.5 is printed, the 3 cells add up to 7.2, -0.3 off "
     "where rounding allows 0.2"]),
    (TOTAL.format("31.0", "7.2"), ["t, total of mass: error total: 7.2 is printed, the 3 cells add up to 35.1, +27.9 "
     "off where rounding allows 0.2; it adds up if t, row 2, mass is 3.1 (a factor 1e-1) and not 31.0"]),
    (ROBOT.format(6), []),
    (ROBOT.format(7), ["base.mass and inertial.mass against ratings.mass, total of mass: error total: 7 is"]),
    (TWICE.format("-103.01"), []), (TWICE.format("-103.0"), []),
    (TWICE.format("-103.06"), ["table_5, row 1, point_2: error printed-twice: table_5, row 1, point_2 prints -103.06, "
     "point_2, theta_1 prints -103.01: the same value twice, off by -0.05"]),
    (TENSOR.format(0.3), []), ("rotation = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]", []),
    (TENSOR.format(-0.3), ["inertia[2,3]: error not-symmetric: (2,3) prints 0.3 and (3,2) prints -0.3 in a matrix that "
     "has to be symmetric: their signs differ"]),
    (TENSOR.format(30), ["inertia[2,3]: error not-symmetric: (2,3) prints 0.3 and (3,2) prints 30 in a matrix that has "
     "to be symmetric: they differ by 1e2"]),
    (OTHER.format(0.123, 0.346), []), (OTHER.format(0.12, 0.35), []),  # fewer digits
    (COPIED.format("0.004375432", "-0.1173,0.2287"), ["t, row 1, z: warning copied: 0.004375432 and 0.00437543 in t.z, "
     "rows 1 and 2, share their first 6 digits (by accident about once in 5e+04 such columns), while the rest"]),
    (COPIED.format("0.00437543", "-0.1173,0.2287"), ["t, row 1, z: warning copied: 0.00437543 and 0.00437543 in t.z"]),
    (COPIED.format("0.00437243", "-0.1173,0.2287"), []), (COPIED.format("0", "-0.1173,0.2287"), []),
    (COPIED.format("0.004375432", "-0.4473,1.2929"), []),  # rows that are alike anyhow
    ("link,mass,x,y\n1,2.7782,0,-0.07653715\n2,2.7782,0,0.07653715\n3,2.7782,0,-0.07653715\n", []),  # mirror images
    ("i,u,v,w,x\n1,1.2345,2.3456,3.4567,4.5678\n2,1.2345,-2.3456,3.4567,4.5778\n3,9.8765,8.7654,7.6543,6.5432\n",
     ["t, row 1, x: warning one-digit: rows 1 and 2 of t are equal up to signs in 3 numbers; x differs in one digit: "
      "4.5678 and 4.5778"]),
    (UNITS.replace("3.0", "0").replace("4.0", "0").replace("2.0", "0").format("F / l", 0),
     ["t, T: error dimension: T = F / l: m^2 kg s^-2 on the left, kg s^-2 on the right"]),
    (UNITS.format("F + l", "3.2").replace("2.0", "4.5"),
     ["t, T: error dimension: T = F + l: m kg s^-2 and m are added"]),
    (UNITS.format("F * l", "0.6"), []),  # in SI
    (UNITS.format("F * l", "600"), ["t, row 1, T: error power-of-ten: prints 600 where T = F * l gives 0.6: off by"]),
    *((f'why = "{text}"', found) for text, found in (
        ("350 + 820 = 1170, 815 + 850 + 145 = 1810", []), ("acos(0.021391) = 88.774 deg", []),
        ("atan2(-1139, 91) = -85.43 deg and atan2(-1117, 91) = -85.34 deg", []),
        ("a + 3 * 2 = 7", []), ("3 + 4 = 7 + x, q2(3) = 4, K = 5, x == 3 + 3", []), ("12.3 + 4.56 = 16.9", []),
        ("1/2 x 0.0106 x 0.05^2 = 1.325e-7", ["why: error power-of-ten: 1/2 x 0.0106 x 0.05^2 = 1.325e-05, printed as "
         "1.325e-7: off by 1e2"]),
        ("the sum 3 + 4 = 8 or 9", ["why: error arithmetic: 3 + 4 = 7, printed as 8 or 9: off by -1"]))),
]  # fmt: skip


@pytest.mark.parametrize(("text", "found"), CASES)
def test_a_rule_finds_its_fault_and_accepts_a_correct_table(text, found):
    said = lines(text)
    assert len(said) == len(found), said
    assert all(line.startswith(words) for line, words in zip(said, found, strict=True)), said


def test_sentences_are_not_run():
    assert not list(equalities("__import__('os').system('x') = 3"))
    assert not list(equalities("9 ^ 9 ^ 9 ^ 9 = 3"))


@pytest.mark.parametrize(
    ("read", "text", "message"),
    [
        ("csv", "a,b\n1,2\n3\n", "row 2: 1 cells; allowed: 2"), ("csv", "a,a\n1,2\n", "'a' twice"),
        ("csv", "a,b\n", "1 lines"), ("csv", "", "0 lines"),
        ("csv", "# formula: a = c\na,b\n1,2\n", "no column or value 'c'"),
        ("csv", "# formula: a = __import__('os')\na,b\n1,2\n", "allowed: NAME = numbers"),
        ("toml", "a = ", "TOML"), ("toml", "[t]\nlint = 3", "a table"), ("toml", "[t.lint]\nformula = 3", "a list"),
        ("toml", "[t.lint]\nformulas = []", "unknown; allowed: formula"),
        ("toml", "[t]\na = [1, 2]\nb = [1, 2, 3]\n[t.lint]\nformula = ['a = b']", "b has 3 rows; allowed: 2, as a has"),
    ],
)  # fmt: skip
def test_bad_text(read, text, message):
    with pytest.raises(TableError, match=message):
        lint(sheet_of_csv(text, "x.csv", "t") if read == "csv" else sheet_of_toml(text, "x.toml"))


def test_single_faults_that_explain_wrong_cells():
    numbers = {i: printed_number(text) for i, text in enumerate(("3", "2", "1"))}
    assert exchanges(numbers, lambda new: all(n.value == i + 1 for i, n in new.items())) == [(0, 2)]
    signed = ("sign", "the sign is the other one")
    assert [scale_or_sign(value, [printed_number(x) for x in texts], slack) for value, texts, slack in (
        (25.0, ["2.5"], 0.0), (-2.5, ["7", "2.5"], 0.0), (2.6, ["2.5"], 0.0), (2.56, ["-2.5"], 0.02))] == [
        ("power-of-ten", "off by 1e1"), signed, None, signed]  # fmt: skip
    values = {value for value, _ in corrections(printed_number("1.23"))}
    assert values == {1.23e-3, 1.23e-2, 0.123, 12.3, 123.0, 1230.0, -1.23, 1.32}
    assert list(corrections(printed_number("0.0"))) == []


def test_rows_are_those_of_the_columns_and_none_without_columns():
    table = SheetTable("t", (SheetColumn("a", ("1", "2", "3"), "m"),))
    assert (table.rows, SheetTable("empty", ()).rows, table.place(2, "a")) == (3, 0, "t, row 3, a")
