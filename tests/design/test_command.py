"""`lwr-dyn gains` as a user types it."""

import json

import pytest


def test_gains_as_json(lwr_dyn_command):
    rows = json.loads(lwr_dyn_command("gains", "lwr4plus", "--json")[1])["joints"]
    for row in rows:
        assert row["Kp"] == pytest.approx(2500 * row["b"])
        assert row["Kd"] == pytest.approx(100 * row["b"])


def test_a_slider_is_fully_out_where_the_joint_before_it_feels_most(lwr_dyn_command, tmp_path):
    own = str(tmp_path / "own.toml")
    lwr_dyn_command("new", "arm", own, "--joints", "RPR")
    assert "0.5" in lwr_dyn_command("gains", own)[1].splitlines()[3]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("lwr4plus", "--omega-n", "-1"), "omega_n: -1.0; allowed: a number above 0"),
        (("nothing", "--xi", "0"), "xi: 0.0; allowed: a number above 0"),  # before the robot is loaded
        (("lwr4",), "masses and inertias not given"),
    ],
)
def test_bad_input_is_one_line(words, message, lwr_dyn_command):
    code, out, err = lwr_dyn_command("gains", *words)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert message in err


def test_how_the_maxima_were_searched_is_said_once(lwr_dyn_command):
    lines = lwr_dyn_command("gains", "lwr4plus")[1].splitlines()
    assert [line for line in lines if "searched" in line] == [
        "searched from 129 to 256 starts a joint; all ended at these values"
    ]


def test_joints_whose_search_ended_elsewhere_too_are_named(lwr_dyn_command):
    lines = lwr_dyn_command("gains", "kr30ha")[1].splitlines()
    at = lines.index("searched from 129 to 256 starts a joint; all ended at these values, except:")
    assert lines[at + 1].startswith("  A2: 81% ended here")
    assert lines[at + 2] == ""
