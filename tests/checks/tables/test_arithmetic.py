"""Formulas, units and dimensions as text: values, refusals, and columns whose unit is not that of their quantity."""

import math

import pytest

from lwr_dyn.checks.tables import arithmetic
from lwr_dyn.checks.tables.sheet import sheet_of_csv

NAMES = {"x": 3.0, "t.y": 0.5}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 x 3", 7.0), ("-x^2", -9.0), ("(x - 1) / 4", 0.5), ("+x * t.y", 1.5),
        ("2 \u00d7 3 \u00b7 4 \u2212 1", 23.0),
        ("sqrt(x + 1)", 2.0), ("hypot(3, 4)", 5.0), ("2^20", 2.0**20), ("abs(-x)", 3.0),
        ("1/0", math.nan), ("sqrt(-1)", math.nan), ("unknown", math.nan), ("2^21", math.nan), ("sqrt(1, 2)", math.nan),
        ("1e308 * 10", math.nan),
    ],
)  # fmt: skip
def test_values(text, value):
    assert arithmetic.value_of(arithmetic.parsed(text), NAMES) == pytest.approx(value, nan_ok=True, rel=1e-15)


def test_angles_in_degrees_where_asked():
    values = [arithmetic.value_of(arithmetic.parsed(text), {}, degrees) for text, degrees in (
        ("sin(30)", True), ("atan2(1, 1)", True), ("sqrt(4)", True), ("atan2(1, 1)", False))]  # fmt: skip
    assert values == pytest.approx([0.5, 45.0, 2.0, math.pi / 4])


@pytest.mark.parametrize(
    "text",
    ["", "   ", "x +", "f(1)", "sqrt(x=1)", "True", "'a'", "x % 2", "not x", "[1]", "x if x else 1",
     "1" * (arithmetic.LONGEST + 1), "sqrt('a')", "(1).real + f().y"],
)  # fmt: skip
def test_what_is_no_formula(text):
    assert arithmetic.parsed(text) is None


def test_names_and_lengths():
    assert list(arithmetic.names_in(arithmetic.parsed("a * hypot(t.b, 2) - c"))) == ["a", "t.b", "c"]
    assert arithmetic.parsed("1" * arithmetic.LONGEST) is not None
    assert arithmetic.parsed("g(1)", functions=("g",)) is not None


@pytest.mark.parametrize(
    ("text", "powers", "factor"),
    [
        ("kg m^2", (2, 1, 0, 0), 1.0), ("[g mm2]", (2, 1, 0, 0), 1e-9), ("N m/(rad s)", (2, 1, -3, -1), 1.0),
        ("m/s/s", (1, 0, -2, 0), 1.0), ("s-1", (0, 0, -1, 0), 1.0), ("\u00b0/s", (0, 0, -1, 1), math.pi / 180),
        ("rpm", (0, 0, -1, 1), math.pi / 30), ("%", (0, 0, 0, 0), 1e-2), ("kg\u00b7m\u00b2", (2, 1, 0, 0), 1.0),
        ("kN/mm", (0, 1, -2, 0), 1e6), ("W h", (2, 1, -2, 0), 3600.0), ("", (0, 0, 0, 0), 1.0),
        ("N m s/rad", (2, 1, -1, -1), 1.0), ("mrad/s", (0, 0, -1, 1), 1e-3),
    ],
)  # fmt: skip
def test_units(text, powers, factor):
    unit = arithmetic.unit_of(text)
    assert unit.powers == powers
    assert unit.factor == pytest.approx(factor, rel=1e-12)


def test_unknown_and_endless_units():
    assert arithmetic.unit_of("furlong") is arithmetic.unit_of("m" + " m" * 20) is None
    assert arithmetic.unit_of("m" + " m" * 19).powers == (20, 0, 0, 0)


POWERS = {name: arithmetic.unit_of(text).powers for name, text in {"l": "m", "m": "kg", "t": "s", "one": "1"}.items()}


@pytest.mark.parametrize(
    ("text", "unit"),
    [("m * l^2", "kg m^2"), ("m * l / t^2", "N"), ("sqrt(l^2) + 2 * l - l", "m"), ("l / hypot(l, l)", "1"),
     ("atan2(l, l) + one", "1"), ("-abs(l)", "m"), ("sin(l / l)", "1"), ("sqrt(l * l)", "m"),
     *((text, None) for text in ("l^one", "unknown * l", "unknown + l", "sqrt(unknown)"))],  # open
)  # fmt: skip
def test_dimensions(text, unit):
    assert arithmetic.dimension_of(arithmetic.parsed(text), POWERS) == (unit and arithmetic.unit_of(unit).powers)


@pytest.mark.parametrize(
    ("text", "words"),
    [("l + m", "m and kg are added"), ("hypot(l, t)", "hypot of m and s"), ("sin(m * l)", "sin of m kg"),
     ("atan2(l, m)", "atan2 of m and kg"), ("exp(l^2 / t)", "exp of m^2 s^-1"), ("2 * l + 1", "m and 1 are added")],
)  # fmt: skip
def test_what_does_not_fit(text, words):
    with pytest.raises(arithmetic.UnlikeError) as caught:
        arithmetic.dimension_of(arithmetic.parsed(text), POWERS)
    assert str(caught.value) == words


@pytest.mark.parametrize(
    ("heading", "joints", "found"),
    [
        ("mass [1]", "", None), ("maximum torque [N m/rad]", "", None),
        ("mass [g]", "", None), ("speed [rad/s]", "", None), ("speed [m/s]", "", None), ("torque (N m)", "", None),
        ("mass ratio [m]", "", ("error", "likely", "1")), ("mass [m]", "", ("error", "likely", "kg")),
        ("angle [m]", "", ("error", "likely", "rad")), ("mass [%]", "", None), ("colour [m]", "", None),
        ("stiffness [N m]", "", None), ("stiffness [N]", "", ("error", "likely", "N/m or N m/rad")),
        ("stiffness [N m/rad]", "", None),
        ("error [mm]", "", ("warning", "likely", "mrad")), ("error [mrad]", "", None), ("error [Nm]", "", None),
        ("error [mm]", "revolute", ("error", "certain", "mrad")),
        ("error [cm]", "revolute", ("error", "certain", "rad or deg")),
        ("error [mm]", "prismatic", None), ("error [mrad]", "prismatic", ("error", "certain", "mm")),
    ],
)  # fmt: skip
def test_units_of_columns(heading, joints, found):
    declared = f"# joints: {joints}\n" if joints else ""
    findings = list(arithmetic.unit_sense(sheet_of_csv(f"{declared}joint,{heading}\n1,1.0\n2,2.0\n", "x.csv", "t")))
    assert [(f.severity, f.confidence, f.suspected) for f in findings] == ([found] if found else [])
    assert all(f.rule == "unit" for f in findings)


def test_the_sentence_of_a_unit():
    (error,) = arithmetic.unit_sense(sheet_of_csv("# joints: revolute\njoint,error [mm]\n1,1.0\n", "x.csv", "t"))
    assert error.sentence == "errors of joints are given in mm: these joints turn, so mrad is expected"
    (mass,) = arithmetic.unit_sense(sheet_of_csv("joint,mass [m^2]\n1,1.0\n", "x.csv", "t"))
    assert mass.sentence == "mass is given in m^2 (m^2); mass: kg"
    assert mass.numbers == {"powers": [2.0, 0.0, 0.0, 0.0]}


def test_names_with_indices_only_where_they_are_asked_for():
    texts = ("a[1]", "a.b[1,2]", "-a[1] / sqrt(a[2])")
    assert [(arithmetic.parsed(text), arithmetic.parsed(text, indexed=True) is None) for text in texts] == [
        (None, False)
    ] * 3
    tree = arithmetic.parsed("a.b[1, 2] * c[3] + 1", indexed=True)
    assert list(arithmetic.names_in(tree)) == ["a.b[1,2]", "c[3]"]
    assert arithmetic.value_of(tree, {"a.b[1,2]": 4.0, "c[3]": 0.5}) == 3.0


@pytest.mark.parametrize(
    "text", ["a[-1]", "a[1][2]", "a[1:2]", "a[True]", "a[b]", "a[1.0]", "a[()]", "[1][0]", "a[1].b[2]"]
)
def test_other_indices_are_no_formula(text):
    assert arithmetic.parsed(text, indexed=True) is None
