"""Every unit against its definition in SI, and limits moved by a zero in another unit."""

import math

import pytest

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.arms.papers.reader import parse_paper
from lwr_dyn.arms.papers.schema import UNITS, to_si
from lwr_dyn.foundation.errors import PaperError

DEFINED = {
    "deg": math.pi / 180, "mm": 1e-3, "g": 1e-3, "kg mm^2": 1e-3**2, "kg cm^2": 1e-2**2, "N mm": 1e-3,
    "deg/s": math.pi / 180, "rpm": 2 * math.pi / 60, "mm/s": 1e-3,
}  # fmt: skip
GOOD = template("own.toml", "own", "RR")


@pytest.mark.parametrize("unit", DEFINED)
def test_units_are_what_they_are(unit):
    assert to_si(2.5, unit) == pytest.approx(2.5 * DEFINED[unit], rel=1e-15)


def test_no_other_unit_scales():
    assert {unit for unit, (_, factor) in UNITS.items() if factor != 1.0} >= set(DEFINED)
    assert all(factor == 1.0 for unit, (_, factor) in UNITS.items() if unit in ("m", "kg", "N m", "rad", "rad/s", "1"))


@pytest.mark.parametrize(("unit", "zero"), [("deg", 90.0), ("rad", math.pi / 2)])
def test_limits_move_by_the_zero_whatever_its_unit(unit, zero):
    column = f'zero = {{ values = [{zero!r}, 0], unit = "{unit}", where = "here", kind = "assumed" }}\nlower ='
    arm = arm_from_paper(parse_paper(GOOD.replace("lower =", column, 1), "own.toml"))
    assert math.degrees(arm.lower[0]) == pytest.approx(-80.0)
    assert math.degrees(arm.upper[0]) == pytest.approx(260.0)


@pytest.mark.parametrize(
    ("column", "value"),
    [("rotors", "inertia = { values = [-1e-6, 0]"), ("friction", "viscous = { values = [0, -1]")],
)
def test_what_cannot_be_negative_is_refused(column, value):
    unit = {"rotors": "kg m^2", "friction": "N m s/rad"}[column]
    ratio = (
        'gear_ratio = { values = [1, 1], unit = "1", where = "here", kind = "assumed" }\n' if column == "rotors" else ""
    )
    text = f'{GOOD}\n[{column}]\n{ratio}{value}, unit = "{unit}", where = "here", kind = "assumed" }}\n'
    with pytest.raises(PaperError, match="allowed: a number of at least 0"):
        parse_paper(text, "own.toml")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('unit = "kg",', 'unit = [["kg"], "kg"],'),
        ("# names =", 'names = [["A1"], "a"] #'),
        ("# names =", 'names = ["", "a"] #'),
        ("values = [2.0, 2.0]", f"values = [2.0, {10**400}]"),
        ("values = [2.0, 2.0]", "values = [2.0, 1e300]"),
        ('name = "own"', 'name = "a\\u0000b"'),
        ('title = "My arm"', "title = " + "[" * 5000),
    ],
)
def test_odd_values_are_one_error_too(old, new):
    assert old in GOOD
    with pytest.raises(PaperError):
        parse_paper(GOOD.replace(old, new, 1), "own.toml")


@pytest.mark.parametrize("at", ["", "DH", "inertial!!mass??values[0]", "inertial.mass.values[-1]"])
def test_a_patch_needs_a_whole_path(at):
    erratum = f"""
[[erratum]]
id = "x"
where = "w"
printed = "p"
read_as = "r"
why = "y"
effect = "e"
status = "open"
patch = [{{ at = "{at}", printed = 2.0, read = 3.0 }}]
[reading.printed]
about = "all"
errata = ["x"]
"""
    with pytest.raises(PaperError, match="no cell"):
        parse_paper(GOOD + erratum, "own.toml")
    twice = erratum.split("[reading")[0].replace(at or 'at = ""', "inertial.mass.values[0]" if at else 'at = "a.b"')
    with pytest.raises(PaperError, match="'x' twice"):
        parse_paper(GOOD + twice + erratum, "own.toml")
