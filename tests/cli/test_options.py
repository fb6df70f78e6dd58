"""Parts of several subcommands: lists of numbers, named axes, locks, degrees to SI; options of rows."""

from typing import Annotated

import click
import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.cli.options import NAMED_AXES, NUMBERS, Loading, OptionRule, refuse_unused, row_options
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.foundation.registry import Option, Quantity, Registry, Row
from lwr_dyn.model.arm import from_degrees
from tests.random_arms import random_arm


def test_numbers_and_named_axes_are_read_and_pass_when_they_are_read_already():
    assert NUMBERS.convert("-90, 1e-3,0", None, None) == (-90.0, 1e-3, 0.0)
    assert NUMBERS.convert((1.0,), None, None) == (1.0,)
    assert NAMED_AXES.convert("A1=10, A2 =-90", None, None) == {"A1": 10.0, "A2": -90.0}
    assert NAMED_AXES.convert({"A1": 1.0}, None, None) == {"A1": 1.0}


@pytest.mark.parametrize(
    ("kind", "text", "message"),
    [
        (NUMBERS, "1;2", "'1;2' is not a list of numbers; allowed: numbers separated by commas"),
        (NUMBERS, "", "'' is not a list of numbers"),
        (NAMED_AXES, "A1", "'A1' is not a list of axes; allowed: NAME=DEG"),
        (NAMED_AXES, "A1=x", "'A1=x' is not a list of axes"),
    ],
)
def test_other_texts_are_refused(kind, text, message):
    with pytest.raises(click.BadParameter) as fault:
        kind.convert(text, None, None)
    assert fault.value.message.startswith(message)


def test_degrees_are_of_turning_joints_only():
    arm = random_arm(3, "RPR")
    np.testing.assert_array_equal(from_degrees(arm, (180.0, 0.5, -90.0), "--q-deg"), [np.pi, 0.5, -np.pi / 2])
    with pytest.raises(ShapeError, match="--q-deg: 2 numbers; allowed: 3 numbers: random has 3 joints"):
        from_degrees(arm, (1.0, 2.0), "--q-deg")


def test_a_robot_is_loaded_with_its_locks_and_its_paper():
    arm, paper = Loading("printed").arm_and_paper("lwr4plus")
    assert (arm.reading, paper.reading.name) == ("printed", "printed")
    locked = Loading(locks=(f"{arm.joint_names[2]}=0.5",)).arm("lwr4plus")
    assert locked.joint_names == tuple(name for name in arm.joint_names if name != arm.joint_names[2])
    with pytest.raises(OptionError, match="--lock: 'finger'; allowed: JOINT=VALUE"):
        Loading(locks=("finger",)).arm("lwr4plus")


ARM = lwr_dyn.load("lwr4plus")
Gain = Annotated[float, Option(float, "Gain, 1/s.", unless="auto")]
Place = Annotated[tuple, Option(Quantity.JOINT_POSITIONS, "Where it is.", flag="at-deg")]


def first(
    *,
    gain: Gain = 2.0,
    auto: Annotated[bool, Option(bool, "Finds the gain.")] = False,
    filtered: Annotated[bool, Option(bool, "Without a filter.")] = True,
):
    """Two flags and a number."""


def second(
    *,
    place: Place,
    lean: Annotated[float, Option(Quantity.ANGLE, "Lean.")] = 0.0,
    gain: Gain = 3.0,
    auto: Annotated[int, Option(int, "Another kind than the first row's.")] = 4,
    out: Annotated[str, Option(str, "Taken by the command.")] = "",
):
    """Angles; two names that it cannot have."""


CHOICES = Registry("choice", {name: Row(f"{__name__}:{name}", name) for name in ("first", "second")})
OUT = click.Option(["--out"])
OPTIONS = row_options(CHOICES, "choice", [OUT])


def chosen(row, *arguments):
    """The keywords that the arguments set for a row."""

    def run(**given):
        OPTIONS.refuse_unused(row)
        refuse_unused((OptionRule("out", lambda _: row == "first", "with --choice first"),), given)
        return OPTIONS.values(row, given, ARM)

    command = click.Command("c", params=[OUT, *OPTIONS.click_options()], callback=run)
    return command.main(list(arguments), standalone_mode=False)


def test_only_what_is_typed_reaches_the_factory_in_si():
    assert chosen("first") == {}
    assert chosen("first", "--gain", "5", "--no-filtered") == {"gain": 5.0, "filtered": False}
    assert chosen("first", "--auto", "--out", "x") == {"auto": True}
    second_row = chosen("second", "--at-deg", "-90,0,0,0,0,0,180", "--lean-deg", "-45")
    assert second_row["lean"] == pytest.approx(-np.pi / 4)
    assert second_row["place"] == pytest.approx([-np.pi / 2, 0, 0, 0, 0, 0, np.pi])


REFUSED = {
    "of another row": (
        ("first", "--lean-deg", "3"),
        "--lean-deg: would do nothing here; allowed: with --choice second",
    ),
    "of another kind": (("second", "--auto"), "--auto: would do nothing here; allowed: with --choice first"),
    "beside another": (("first", "--gain", "1", "--auto"), "--gain: would do nothing here; allowed: without --auto"),
    "by a rule": (("second", "--out", "x"), "--out: would do nothing here; allowed: with --choice first"),
    "missing": (("second",), "--at-deg: not given; allowed: 7 joint positions, deg"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_an_option_without_effect_is_refused(case):
    arguments, message = REFUSED[case]
    with pytest.raises(OptionError) as fault:
        chosen(*arguments)
    assert message in str(fault.value)


def test_help_names_the_rows_and_their_defaults():
    texts = {option.name: option.help for option in OPTIONS.click_options()}
    assert texts["gain"] == "Gain, 1/s.  [default: 2.0 (first), 3.0 (second)]"
    assert texts["no_filtered"] == "first: Without a filter."
    assert texts["at_deg"] == "second: Where it is."
    assert "out" not in texts
