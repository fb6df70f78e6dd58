"""`lwr-dyn gains`: what sampling makes of the gains that it prints."""

import json

import pytest

from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.design.loop_judgement import sampled_loops
from lwr_dyn.design.sampled_loop import Sampling
from tests.simulation.sample_runs import one_joint


@pytest.mark.slow
def test_gains_tell_the_unstable_share_of_each_controller(lwr_dyn_command):
    code, out, _ = lwr_dyn_command("gains", "lwr4plus")
    rows = {line.split()[0]: line for line in out.splitlines() if line}
    assert code == 0
    assert "of 2000 poses drawn evenly from the joint box (seed 0); linear, without friction and torque limits" in out
    assert "22.9 +- 0.9 %" in rows["pd-gravity"]
    assert "6920 Hz" in rows["pid"]
    assert "none (at 95 %: below 0.15 %)" in rows["inverse-dynamics"]
    assert ") deg" in rows["pd-gravity"]


@pytest.mark.slow
def test_gains_as_json_with_rate_and_delay(lwr_dyn_command):
    record = json.loads(lwr_dyn_command("gains", "lwr4plus", "--rate", "500", "--delay", "1", "--json")[1])["sampled"]
    assert list(record) == ["pd-gravity", "pid", "inverse-dynamics"]
    assert {(x["rate"], x["delay"]) for x in record.values()} == {(500.0, 1)}
    assert len(record["pid"]["worst"]) == 7


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        (("--rate", "0"), "rate: 0.0; allowed: a number above 0"),
        (("--delay", "-1"), "delay: -1; allowed: a whole number"),
    ],
)
def test_bad_sampling_gets_one_line(options, fault, lwr_dyn_command):
    code, out, err = lwr_dyn_command("gains", "lwr4plus", *options)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert fault in err


def test_a_slider_of_unknown_limits_is_judged_within_a_metre():
    arm = one_joint(mass=2.0)
    judged = sampled_loops(arm, second_order_gains([2.0], 50.0, 1.0), Sampling(40.0))
    assert {found.unknown_limits for found in judged.values()} == {("joint_1",)}
    assert {found.share for found in judged.values()} == {1.0}  # T 2 xi omega_n = 2.5
