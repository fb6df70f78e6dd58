"""Elastic joints on the command line: simulate, its record, and what is refused in one line."""

import json

import pytest

from tests.json_schemas import faults

pytestmark = pytest.mark.slow

HOLD = ("simulate", "lwr4plus", "--reading", "physical", "--task", "hold", "--from-deg", "0,30,0,-60,0,30,0")
SHORT = (*HOLD, "--duration", "0.02", "--controller", "inverse-dynamics")


def test_a_run_and_its_record(lwr_dyn_command):
    code, out, err = lwr_dyn_command(*SHORT, "--elastic", "file")
    assert code == 0
    assert all(line.startswith("note: ") for line in err.splitlines())  # this law is unstable in some of the box
    assert "damper -" in out
    assert "inverse dynamics by newton-euler and Radau IIA 5 at" in out
    assert "plant elastic joints, motor encoders" in out
    code, out, _ = lwr_dyn_command(*SHORT, "--elastic", "3e4", "--encoders", "link", "--substeps", "2", "--json")
    record = json.loads(out)
    assert code == 0
    assert faults("simulate", record) == []
    assert max(record["meta"]["elasticity"]["stiffness"]) == pytest.approx(3e4)
    assert record["meta"]["elasticity"]["encoders"] == "link"
    assert record["meta"]["options"]["method"] == "exponential"
    assert record["meta"]["note"]["plant"] == "elastic joints of 3e4 N m/rad, link encoders"
    assert record["meta"]["audit"]["closed"]
    assert record["meta"]["cut_share"] == [0.0] * 7


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--elastic", "0"), "--elastic: '0'; allowed: a stiffness above 0 in N m/rad, or file"),
        (("--elastic", "soft"), "--elastic: 'soft'; allowed: a stiffness above 0 in N m/rad, or file"),
        (("--encoders", "link"), "--encoders: would do nothing here; allowed: with --elastic"),
        (("--method", "radau"), "method: would do nothing with rigid joints; allowed: with elastic joints"),
        (("--elastic", "1e4", "--method", "dop853"), "method: dop853 with elastic joints; allowed: rk4"),
        (("--elastic", "1e4", "--continuous"), "continuous: with elastic joints; allowed: a sampled run"),
        (("--elastic", "1e4", "--reading", "computed"), "too light for elastic joints"),
    ],
)
def test_bad_options_are_one_line(options, message, lwr_dyn_command):
    code, out, err = lwr_dyn_command(*SHORT, *options)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_an_arm_without_stiffness_needs_a_number(lwr_dyn_command):
    arm = ("simulate", "wam7", "--task", "hold", "--from-deg", "0,-60,0,90,0,0,0", "--duration", "0.01", "--own-gains")
    code, _, err = lwr_dyn_command(*arm, "--elastic", "file")
    assert (code, err) == (2, "lwr-dyn: wam7: joint stiffness not given; needed for elastic joints\n")
    assert lwr_dyn_command(*arm, "--elastic", "2e4", "--friction", "none")[0] == 0
