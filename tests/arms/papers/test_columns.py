"""Each number or unit that cannot be right is refused with its field; the columns of the papers pass."""

import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper, studied
from lwr_dyn.arms.papers.columns import check_plausibility
from lwr_dyn.arms.papers.schema import Column
from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.model.chain import JointKind

KINDS = (JointKind.REVOLUTE, JointKind.PRISMATIC)
UNITS = {
    "rotors.inertia": ("kg m^2", "kg m^2"), "limits": ("rad", "m"), "limits.velocity": ("rad/s", "m/s"),
    "inertial.mass": ("kg", "kg"), "friction": ("N m", "N"), "base.gravity": ("m/s^2",),
    "inertial.inertia": ("kg m^2", "kg m^2"),
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


BAD = {
    "negative": ({"friction__coulomb": (-1.0, 0.0)}, "friction.coulomb.values[0]: -1.0; allowed: a number of at least"),
    "negative viscous": ({"friction__viscous": (0, -1)}, "friction.viscous.values[1]: -1; allowed: a number of"),
    "negative rotor": (
        {"rotors__gear_ratio": (1, 1), "rotors__inertia": (-1e-6, 0)},
        "rotors.inertia.values[0]: -1e-06; allowed: a number of at least 0",
    ),
    "sign": ({"dh__sign": (1.0, 0.5)}, "dh.sign.values[1]: 0.5; allowed: 1 or -1"),
    "limits crossed": (
        {"limits__lower": (0.0, 1.0), "limits__upper": (1.0, 1.0)},
        "limits.lower.values[1]: 1.0, upper is 1.0; allowed: a lower limit below the upper",
    ),
    "gravity": ({"base__gravity": ((0.0, 0.0, -1001.0),)}, "base.gravity.values: 1001 m/s^2; allowed: at most 1000"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_right_is_refused(case):
    tables, message = BAD[case]
    with pytest.raises(PaperError) as fault:
        check(**tables)
    assert str(fault.value).startswith(f"own.toml: {message}")


def test_units_must_suit_the_kind_of_the_joint():
    column = Column("limits.velocity", (1.0, 1.0), ("rad/s", "rad/s"), "p. 1", "printed")
    with pytest.raises(PaperError, match=r"velocity\.unit: 'rad/s' for A2; allowed: a unit of a prismatic joint"):
        check_plausibility({column.name: column}, ("A1", "A2"), KINDS, "own.toml")


def test_what_is_just_allowed_passes():
    check(
        limits__lower=(0.0, -1.0), limits__upper=(1e-9, 1.0), friction__coulomb=(0.0, 0.0), dh__sign=(-1.0, 1.0),
        base__gravity=((0.0, 0.0, -1000.0),), transmission__signs=((1.0, -1.0), (0.0, 1.0)),
        transmission__ratio=(2.0, 3.0),
    )  # fmt: skip


@pytest.mark.parametrize("robot", studied())
def test_the_papers_pass_under_every_reading(robot):
    for reading in lwr_dyn.readings(robot):
        paper = open_paper(robot, reading)
        check_plausibility(paper.columns, paper.joints, paper.kinds, paper.file)
        assert paper.columns
