"""Each rule on a small table: it finds its fault and accepts a correct table."""

import pytest

from lwr_dyn.checks.tables.formulas import equalities
from lwr_dyn.checks.tables.rules import lint
from lwr_dyn.checks.tables.sheet import TableError, sheet_of_csv
from lwr_dyn.checks.tables.toml_sheet import sheet_of_toml


def rules(text, kind="csv"):
    sheet = sheet_of_csv(text, "x.csv", "t") if kind == "csv" else sheet_of_toml(text, "x.toml")
    return [f.rule for f in lint(sheet) if f.counts]


GAINS = """[gains]
omega = 10.0
b = ["2.0", "3.0", "4.0", "5.0"]
Kp = ["200", "300", "400", {}]
[gains.lint]
formula = ["Kp = omega^2 * b"]
"""


@pytest.mark.parametrize(
    ("cell", "expected"), [('"500"', []), ('"512"', ["formula"]), ('"50.0"', ["power-of-ten"]), ('"-500"', ["sign"])]
)
def test_a_declared_formula(cell, expected):
    # the ratio of the columns shows a power of ten as well
    assert list(dict.fromkeys(rules(GAINS.format(cell), "toml"))) == expected


def test_rows_of_a_formula_shifted():
    text = "# formula: y = x^2\ni,x,y\n1,2.0,4.0\n2,3.0,4.0\n3,5.0,9.0\n4,7.0,25.0\n5,11.0,49.0\n"
    assert rules(text) == ["rows-shifted"]


def test_columns_of_two_tables_shifted():
    text = "[a]\nd = [0, 0.4, 0, 0.39, 0, 0.078, 0.1]\n[b]\nd = {}\n"
    assert rules(text.format("[0, 0, 0.4, 0, 0.39, 0, 0.078]"), "toml") == ["rows-shifted"]
    assert rules(text.format("[0, 0.4, 0, 0.39, 0, 0.078, 0.1]"), "toml") == []


def test_totals():
    text = "link;mass [kg]\n1;2.7\n2;3.1\n3;1.4\ntotal;{}\n"
    assert rules(text.format("7.2")) == []
    assert rules(text.format("7.3")) == []  # each cell may be off by half a unit
    assert rules(text.format("7.5")) == ["total"]
    (finding,) = lint(sheet_of_csv(text.format("7.2").replace("3.1", "31.0"), "x.csv", "t"))
    assert finding.suspected == "t, row 2, mass is 3.1 (a factor 1e-1) and not 31.0"


def test_masses_of_a_robot_against_its_data_sheet():
    text = "base.mass.values = 3.0\ninertial.mass.values = [1.0, 2.0]\nratings.mass.values = {}"
    assert rules(text.format("6"), "toml") == []
    assert rules(text.format("7"), "toml") == ["total"]


TWICE = """[point_2]
theta_1 = "-103.01"
theta_3 = "-88.2"
[table_5]
rows = ["theta_1", "theta_2", "theta_3"]
point_2 = ["{}", "67.62", "-88.18"]
"""


def test_a_value_printed_twice():
    assert rules(TWICE.format("-103.01"), "toml") == []
    assert rules(TWICE.format("-103.0"), "toml") == []
    (finding,) = lint(sheet_of_toml(TWICE.format("-103.06"), "x.toml"))
    assert (finding.rule, set(finding.cells)) == ("printed-twice", {"table_5, row 1, point_2", "point_2, theta_1"})


def test_symmetry():
    text = "inertia = [[1.5, 0.2, 0.1], [0.2, 1.1, 0.3], [0.1, {}, 1.2]]"
    assert rules(text.format("0.3"), "toml") == []
    assert rules(text.format("-0.3"), "toml") == ["not-symmetric"]
    assert rules("rotation = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]", "toml") == []


def test_copied_digits():
    text = "i,x,y,z\n1,0.4471,1.2931,{}\n2,-0.1173,0.2287,0.00437543\n3,0.0922,-0.7713,0.0517\n"
    assert rules(text.format("0.004375432")) == ["copied"]
    assert rules(text.format("0.00437243")) == []
    assert rules(text.format("0")) == []


def test_digits_repeat_in_rows_that_are_alike_anyhow():
    text = "i,x,y,z\n1,0.4471,1.2931,0.004375432\n2,-0.4473,1.2929,0.00437543\n3,0.0922,-0.7713,0.0517\n"
    assert rules(text) == []


def test_equal_masses_and_mirror_images_are_not_copies():
    rows = "1,2.7782,0,-0.07653715\n2,2.7782,0,0.07653715\n3,2.7782,0,-0.07653715\n"
    assert rules("link,mass,x,y\n" + rows) == []


@pytest.mark.parametrize(("formula", "wrong"), [("T = F * l", False), ("T = F / l", True), ("T = F + l", True)])
def test_dimensions_of_a_formula(formula, wrong):
    text = f"# formula: {formula}\ni,F [N],l [mm],T [N m]\n1,0,0,0\n2,0,0,0\n"
    assert ("dimension" in rules(text)) is wrong


def test_units_enter_a_formula_in_si():
    text = "# formula: T = F * l\ni,F [N],l [mm],T [N m]\n1,3.0,200,{}\n2,4.0,500,2.0\n"
    assert rules(text.format("0.6")) == []
    assert rules(text.format("600")) == ["power-of-ten"]


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("350 + 820 = 1170, 815 + 850 + 145 = 1810", []),
        ("atan2(-1139, 91) = -85.43 deg and atan2(-1117, 91) = -85.34 deg", []),
        ("acos(0.021391) = 88.774 deg", []),
        ("1/2 x 0.0106 x 0.05^2 = 1.325e-7", ["power-of-ten"]),
        ("the sum 3 + 4 = 8", ["arithmetic"]),
        ("a + 3 * 2 = 7", []),
        ("3 + 4 = 7 + x, q2(3) = 4, K = 5, x == 3 + 3", []),
        ("12.3 + 4.56 = 16.9", []),
    ],
)
def test_sentences(text, wrong):
    assert rules(f'why = "{text}"', "toml") == wrong


def test_sentences_are_not_run():
    assert not list(equalities("__import__('os').system('x') = 3"))
    assert not list(equalities("9 ^ 9 ^ 9 ^ 9 = 3"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2\n3\n", "row 2: 1 cells; allowed: 2"),
        ("a,a\n1,2\n", "'a' twice"),
        ("a,b\n", "1 lines"),
        ("", "0 lines"),
        ("# formula: a = c\na,b\n1,2\n", "no column or value 'c'"),
        ("# formula: a = __import__('os')\na,b\n1,2\n", "allowed: NAME = numbers"),
    ],
)
def test_bad_csv(text, message):
    with pytest.raises(TableError, match=message):
        lint(sheet_of_csv(text, "x.csv", "t"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a = ", "TOML"),
        ("[t]\nlint = 3", "a table"),
        ("[t.lint]\nformulas = []", "unknown; allowed: formula"),
        ("[t.lint]\nformula = 3", "a list"),
    ],
)
def test_bad_toml(text, message):
    with pytest.raises(TableError, match=message):
        lint(sheet_of_toml(text, "x.toml"))
