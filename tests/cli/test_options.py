"""Parts of several subcommands: lists of numbers, named axes, locks, degrees to SI."""

import click
import numpy as np
import pytest

from lwr_dyn.cli.options import NAMED_AXES, NUMBERS, Loading
from lwr_dyn.foundation.errors import OptionError, ShapeError
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
