"""Friction on the command line: its form, the passive refit, the warning, and bad combinations."""

import pytest

MOVE = ("simulate", "wam7", "--task", "lspb", "--from-deg", "0,-60,0,90,0,0,0", "--own-gains", "--velocity-error")
FAST = (*MOVE, "--to-deg", "0,-60,0,130,0,0,0", "--duration", "1.0", "--blend", "0.3")


@pytest.mark.slow
def test_friction_that_drives_is_warned_of(printed):
    out = printed(*FAST)
    assert "friction: set-valued; accelerations computed" in out
    assert "warning: friction of joint_4 feeds energy in from" in out


@pytest.mark.slow
def test_a_passive_refit_shows_its_cost_and_drives_no_more(printed, recorded):
    record = recorded(*FAST, "--passive-refit")
    assert "friction feeds energy in" not in [event["kind"] for event in record["events"]]
    changes = record["meta"]["note"]["passive_refit"]
    assert [(c["joint"], c["side"]) for c in changes] == [
        ("joint_2", "negative"), ("joint_4", "positive"), ("joint_4", "negative"), ("joint_5", "positive"),
    ]  # fmt: skip
    assert changes[1]["rms"] == pytest.approx(0.312, abs=1e-3)
    assert record["meta"]["friction_law"]["viscous"][0][3] == 0.0
    assert "passive refit of joint_4, positive: F_c 1.5414" in printed(*FAST, "--passive-refit")


def test_a_refit_of_an_arm_without_friction_is_refused(refused):
    allowed = "--passive-refit: lwr4plus has no friction; allowed: with an arm whose friction is known"
    assert allowed in refused("simulate", "lwr4plus", "--passive-refit")


@pytest.mark.slow
def test_without_friction(printed):
    assert "friction:" not in printed(*FAST, "--friction", "none")


BAD = {
    "refit of nothing": (("--passive-refit", "--friction", "none"), "--passive-refit: with --friction none; allowed:"),
    "too stiff": (("--friction", "smooth"), "allowed: substeps from"),
    "own gains of another controller": (
        ("--controller", "pid"),
        "--own-gains: would do nothing here; allowed: with --controller pd-gravity",
    ),
    "no such form": (("--friction", "dry"), "'dry' is not one of"),
    "blend too long": (("--blend", "0.7"), "blend"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(refused, case):
    arguments, message = BAD[case]
    assert message in refused(*FAST, *arguments)


def test_an_arm_without_gains_is_refused(refused):
    err = refused("simulate", "lwr4plus", "--task", "hold", "--from-deg", "0,0,0,0,0,0,0", "--own-gains")
    assert "lwr4plus: controller gains not given; needed for own_gains (--own-gains)" in err
