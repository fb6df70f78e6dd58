"""Each number or unit that cannot be right is refused with its field; the columns of the papers pass."""

import math

import pytest

from lwr_dyn.arms.papers.columns import check_plausibility, read_columns
from lwr_dyn.arms.papers.schema import SIDES, Column
from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.model.chain import JointKind

KINDS = (JointKind.REVOLUTE, JointKind.PRISMATIC)
UNITS = {
    "rotors.inertia": ("kg m^2", "kg m^2"), "limits": ("rad", "m"), "limits.velocity": ("rad/s", "m/s"),
    "inertial.mass": ("kg", "kg"), "friction": ("N m", "N"), "base.gravity": ("m/s^2",),
    "inertial.inertia": ("kg m^2", "kg m^2"), "rotors.armature": ("kg m^2", "kg"),
}  # fmt: skip
NUMBERS = ("1", "1")


def check(**tables):
    """Checks columns `table__column` of an arm with a turning and a sliding joint."""
    columns = {}
    for key, values in tables.items():
        name = key.replace("__", ".")
        unit = UNITS.get(name, UNITS.get(name.partition(".")[0], NUMBERS))
        if name.endswith("viscous"):
            unit = ("N m s/rad", "N s/m")
        columns[name] = Column(name, tuple(values), unit, "p. 1", "printed")
    check_plausibility(columns, ("A1", "A2"), KINDS, "own.toml")


PER_SIDE = {f"friction__{side}_{name}": (2.0, 2.0) for side in SIDES for name in ("coulomb", "viscous")}
SIGMOID = {f"friction__sigmoid_{name}": (1.0, 2.0) for name in ("level", "slope", "shift")}
BAD = {
    "negative": ({"friction__coulomb": (-1.0, 0.0)}, "friction.coulomb.values[0]: -1.0; allowed: a number of at least"),
    "negative viscous": ({"friction__viscous": (0, -1)}, "friction.viscous.values[1]: -1; allowed: a number of"),
    "negative rotor": ({"rotors__gear_ratio": (1, 1), "rotors__inertia": (-1e-6, 0)},
                       "rotors.inertia.values[0]: -1e-06; allowed: a number of at least 0"),
    "sign": ({"dh__sign": (1.0, 0.5)}, "dh.sign.values[1]: 0.5; allowed: 1 or -1"),
    "limits crossed": ({"limits__lower": (0.0, 1.0), "limits__upper": (1.0, 1.0)},
                       "limits.lower.values[1]: 1.0, upper is 1.0; allowed: a lower limit below the upper"),
    "zero speed": ({"limits__velocity": (0.0, 1.0)}, "limits.velocity.values[0]: 0.0; allowed: a number above 0"),
    "a sign of the map": ({"transmission__signs": ((1.0, 0.0), (0.5, 1.0)), "transmission__ratio": (1.0, 1.0)},
                          "transmission.signs.values[1]: [0.5, 1.0]; allowed: 1, 0 or -1 for each joint"),
    "one limit": ({"limits__lower": (0.0, 1.0)}, "limits: only one of lower, upper; allowed: both or neither"),
    "a tensor": ({"inertial__inertia": (((1.0, 0.0, 0.0), (0.0, 1.0, 0.2), (0.0, 0.1, 1.0)), ((math.nan,) * 3,) * 3)},
                 "inertial.inertia.values[0][1][2]: 0.2 against 0.1; allowed: a symmetric tensor"),
    "a singular map": ({"transmission__matrix": ((1.0, 2.0), (2.0, 4.0))},
                       "transmission.matrix: a singular matrix; allowed: as many independent motors as joints"),
    "half a map": ({"transmission__signs": ((1.0, 0.0), (0.0, 1.0))},
                   "transmission: signs; allowed: ratio and signs, with or without stage, or matrix alone"),
    "a map twice": ({"transmission__matrix": ((1.0, 0.0), (0.0, 1.0)), "transmission__ratio": (1.0, 1.0)},
                    "transmission: matrix and ratio; allowed: ratio and signs"),
    "no gear": ({"rotors__gear_ratio": (1.0, 0.0), "rotors__inertia": (1.0, 1.0)},
                "rotors.gear_ratio.values[1]: 0; allowed: a number other than 0; below 0, it reverses"),
    "rotors twice": (
        {"rotors__gear_ratio": (1.0, -1.0), "rotors__inertia": (1.0, 1.0), "rotors__armature": (1.0, 1.0)},
        "rotors: armature and gear_ratio and inertia; allowed: gear_ratio and inertia, or armature alone"),
    "half a sigmoid": ({"friction__sigmoid_level": (1.0, 1.0), "friction__sigmoid_slope": (1.0, 1.0)},
                       "friction: sigmoid_level and sigmoid_slope; allowed: level, slope and shift of a sigmoid"),
    "a sigmoid and more": ({**SIGMOID, "friction__coulomb": (1.0, 1.0)},
                           "friction.coulomb: beside a sigmoid; allowed: the sigmoid alone"),
    "a sigmoid that drives": ({**SIGMOID, "friction__sigmoid_level": (-0.5, 1.0)},
                              "friction.sigmoid_level.values[0]: -0.5; allowed: a number of at least 0"),
    "a flat sigmoid": ({**SIGMOID, "friction__sigmoid_slope": (0.0, 1.0)},
                       "friction.sigmoid_slope.values[0]: 0.0; allowed: a number above 0"),
    "two kinds of friction": (
        {**PER_SIDE, "friction__coulomb": (1.0, 1.0)},
        "friction.coulomb: beside friction.positive_coulomb; allowed: either one pair both ways or columns per"),
    "one direction": ({"friction__positive_coulomb": (1.0, 1.0)},
                      "friction.positive_viscous: missing; allowed: Coulomb and viscous columns of both directions"),
    "a whole load": ({**PER_SIDE, "friction__load": (0.1, 1.0)}, "friction.load.values[1]: 1.0; allowed: a share of"),
    "a negative load": ({**PER_SIDE, "friction__load": (-0.1, 0)}, "friction.load.values[0]: -0.1; allowed: a share"),
    "a load alone": ({"friction__load": (0.1, 0.0)}, "friction.positive_coulomb: missing; allowed: Coulomb and"),
    "an offset alone": ({"friction__offset": (1.0, 1.0)}, "friction.positive_coulomb: missing; allowed: Coulomb and"),
    "a fall at no speed": ({**PER_SIDE, "friction__negative_stribeck_velocity": (0.1, 0.0)},
                           "friction.negative_stribeck_velocity.values[1]: 0.0; allowed: a number above 0"),
    "covered": ({**PER_SIDE, "friction__covered": (0.4, -1.0)}, "friction.covered.values[1]: -1.0; allowed: a num"),
    "no stage": (
        {"transmission__signs": ((1, 0), (0, 1)), "transmission__ratio": (1, 1), "transmission__stage": (1.0, 0.0)},
        "transmission.stage.values[1]: 0.0; allowed: a number above 0"),
    "static below Coulomb": ({**PER_SIDE, "friction__negative_static": (2.0, 1.9)},
                             "friction.negative_static.values[1]: 1.9; allowed: at least Coulomb, 2"),
    "gravity": ({"base__gravity": ((0.0, 0.0, -1001.0),)}, "base.gravity.values: 1001 m/s^2; allowed: at most 1000"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_right_is_refused(case):
    tables, message = BAD[case]
    with pytest.raises(PaperError) as fault:
        check(**tables)
    assert str(fault.value).startswith(f"own.toml: {message}")


def test_what_is_just_allowed_passes():
    check(
        limits__lower=(0.0, -1.0), limits__upper=(1e-9, 1.0), friction__coulomb=(0.0, 0.0), dh__sign=(-1.0, 1.0),
        base__gravity=((0.0, 0.0, -1000.0),), transmission__signs=((1.0, -1.0), (0.0, 1.0)),
        transmission__ratio=(2.0, 3.0), transmission__stage=(1.0, 1.0), ratings__mass=(1e-9,),
        rotors__gear_ratio=(-1.0, 1.0), rotors__inertia=(0.0, 0.0),
        inertial__inertia=(((1.0, 0.1, 0.2), (0.1, 1.0, 0.3), (0.2, 0.3, 1.0)), ((math.nan,) * 3,) * 3),
    )  # fmt: skip
    check(**PER_SIDE, friction__positive_static=(2.0, 3.0), friction__offset=(-1.0, 0.0), friction__covered=(1e-9, 1.0))
    check(**PER_SIDE, friction__load=(0.0, 0.999))
    check(**{name: x for name, x in SIGMOID.items() if "shift" not in name}, friction__sigmoid_shift=(-1.0, 0.0))
    check(transmission__matrix=((1.0, 2.0), (2.0, 4.001)), rotors__armature=(0.0, 1.0))


def read(n=2, column="mass", table="inertial", touched=None, **changes):
    """Columns of one table with one column, `values` and others replaced."""
    given = {"values": [1.0, 2.0], "unit": "kg", "where": "p. 1", "kind": "printed"} | changes
    given = {name: value for name, value in given.items() if value is not None}
    return read_columns({table: {column: given}}, n, touched or {}, "own.toml")


def test_a_column_is_read_with_what_belongs_to_it_and_its_units_must_suit_the_kind_of_the_joint():
    flange = {"column": "xyz", "table": "flange", "unit": "mm"}
    one = read(**flange, values=[1, 2, 3], sigma=[0.1, 0.0, "unknown"], note="n", how="h", symbols=["a"],
               touched={"flange.xyz": {0: ["e"], 1: ["f"]}})["flange.xyz"]  # fmt: skip
    assert (one.name, one.values, one.unit) == ("flange.xyz", ((1.0, 2.0, 3.0),), ("mm",))
    assert (one.where, one.kind, one.note, one.how, one.symbols) == ("p. 1", "printed", "n", "h", ("a",))
    assert one.errata == {0: ("e",)}
    assert one.sigma[0][:2] == (0.1, 0.0)
    assert math.isnan(one.sigma[0][2])
    limits = read(column="velocity", table="limits", values=["unknown", 2], unit=["rad/s", "mm/s"])["limits.velocity"]
    assert math.isnan(limits.values[0])
    assert (limits.values[1], limits.unit, limits.sigma, limits.symbols) == (2.0, ("rad/s", "mm/s"), (), ())
    column = Column("limits.velocity", (1.0, 1.0), ("rad/s", "rad/s"), "p. 1", "printed")
    with pytest.raises(PaperError, match=r"velocity\.unit: 'rad/s' for A2; allowed: a unit of a prismatic joint"):
        check_plausibility({column.name: column}, ("A1", "A2"), KINDS, "own.toml")


READ_BAD = {
    "rows": ({"values": [1.0]}, "inertial.mass.values: 1 rows; allowed: 2 rows, one per joint"),
    "no rows": ({"values": 1.0}, "inertial.mass.values: 1.0; allowed: 2 rows, one per joint"),
    "symbols": ({"symbols": ["a"]}, "inertial.mass.symbols: 1 entries; allowed: 2, one per joint, or none"),
    "units": ({"unit": ["kg"]}, "inertial.mass.unit: 1 units; allowed: one unit, or 2, one per joint"),
    "unit": ({"unit": "m"}, "inertial.mass.unit: 'm'; allowed: kg, g"),
    "no unit": ({"unit": ["kg", 3]}, "inertial.mass.unit: 3; allowed: kg, g"),
    "sigma": ({"sigma": [1.0, -0.1]}, "inertial.mass.sigma: a number below 0; allowed: standard errors, in the unit"),
    "rows of sigma": ({"sigma": [1.0]}, "inertial.mass.sigma: 1 entries; allowed: a list of 2"),
    "text": ({"values": [1.0, "2"]}, "inertial.mass.values[1]: '2'; allowed: a number"),
    "a switch": ({"values": [True, 1.0]}, "inertial.mass.values[0]: True; allowed: a number"),
    "infinite": ({"values": [1.0, math.inf]}, "inertial.mass.values[1]: inf; allowed: a finite number"),
    "a vector": ({"table": "frames", "column": "origin", "unit": "m", "values": [[1, 2, 3], [1, 2]]},
                 "frames.origin.values[1]: 2 entries; allowed: a list of 3"),
    "no vector": ({"table": "frames", "column": "origin", "unit": "m", "values": [[1, 2, 3], 4]},
                  "frames.origin.values[1]: 4; allowed: a list of 3"),
    "unknown": ({"table": "drawing", "column": "radius", "unit": "m", "values": [1.0, "unknown"]},
                "drawing.radius.values[1]: 'unknown'; allowed: a number"),
    "a kind": ({"kind": "guessed"}, "inertial.mass.kind: "),
    "a field": ({"colour": 1}, "inertial.mass.colour"),
    "required": ({"column": "com", "unit": "m", "values": [[1, 2, 3]] * 2}, "inertial.mass: missing; allowed: a col"),
}  # fmt: skip


@pytest.mark.parametrize("case", READ_BAD)
def test_a_column_that_cannot_be_read_is_refused(case):
    changes, message = READ_BAD[case]
    with pytest.raises(PaperError) as fault:
        read(**changes)
    assert str(fault.value).startswith(f"own.toml: {message}")
