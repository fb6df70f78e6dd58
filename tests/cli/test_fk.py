"""`lwr-dyn fk` of axes by name, and of a KUKA arm without the optional package `krl`."""

import numpy as np
import pytest

from lwr_dyn.cli import fk

BAD = {
    "unknown joint": (("--axes-deg", "A7=3"), "no joint of kr30ha named 'A7'; known: A1, A2"),
    "axes that are none": (("--axes-deg", "A1"), "is not a list of axes; allowed: NAME=DEG"),
    "axis not finite": (("--axes-deg", "A1=nan"), "--axes-deg: nan at index (0,)"),
    "two ways at once": (("--q", "0,0,0,0,0,0", "--axes-deg", "A1=0"), "none or several given"),
}


@pytest.mark.parametrize(("arguments", "message"), BAD.values(), ids=BAD)
def test_bad_input_is_one_line(arguments, message, refused):
    assert message in refused("fk", "kr30ha", *arguments)


def test_named_and_listed_positions_give_the_same_pose_and_its_point(recorded):
    ways = (("--axes-deg", "A3=90,A2=-90"), ("--q-deg", "0,-90,90,0,0,0"))
    records = [recorded("fk", "kr30ha", *way, "--point", "0,0,0.1") for way in ways]
    assert records[0] == records[1]
    pose = np.array(records[0]["T"])
    np.testing.assert_allclose(records[0]["point_in_base"], pose[:3, 3] + 0.1 * pose[:3, 2], atol=1e-12)
    assert {option.name for option in fk.command.params} >= {"q_si", "q_deg", "axes_deg", "point"}
