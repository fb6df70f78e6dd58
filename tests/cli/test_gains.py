"""`lwr-dyn gains` as a user types it."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.design.gain_search import margin_gains
from lwr_dyn.design.loop_judgement import LoopCase


@pytest.mark.slow
def test_gains_as_json(recorded):
    rows = recorded("gains", "lwr4plus")["joints"]
    for row in rows:
        assert row["Kp"] == pytest.approx(2500 * row["b"])
        assert row["Kd"] == pytest.approx(100 * row["b"])


@pytest.mark.slow
def test_a_slider_is_fully_out_where_the_joint_before_it_feels_most(lwr_dyn_command, tmp_path):
    own = str(tmp_path / "own.toml")
    lwr_dyn_command("new", "arm", own, "--joints", "RPR")
    rows = lwr_dyn_command("gains", own)[1].splitlines()
    assert "0.5" in next(row for row in rows if row.startswith("joint_1"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("lwr4plus", "--omega-n", "-1"), "omega_n: -1.0; allowed: a number above 0"),
        (("nothing", "--xi", "0"), "xi: 0.0; allowed: a number above 0"),  # before the robot is loaded
        (("lwr4",), "masses and inertias not given"),
    ],
)
def test_bad_input_is_one_line(words, message, refused):
    assert message in refused("gains", *words)


@pytest.mark.slow
def test_what_is_proven_of_the_maxima_is_said_once(lwr_dyn_command, recorded):
    lines = lwr_dyn_command("gains", "lwr4plus")[1].splitlines()
    said = [line for line in lines if "certified" in line]
    assert len(said) == 1
    assert said[0].startswith("certified: nowhere in the joint box more than ")
    assert not [line for line in lines if "searched" in line]
    rows = recorded("gains", "lwr4plus")["joints"]
    assert all(row["b"] <= row["certificate"]["upper"] <= row["b"] * (1 + 1e-6) for row in rows)


@pytest.mark.slow
def test_joints_whose_bound_is_not_near_are_named(lwr_dyn_command, monkeypatch):
    monkeypatch.setattr("lwr_dyn.control.inertia.certificate.MOST_BOXES", 40)
    lines = lwr_dyn_command("gains", "lwr4plus")[1].splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("certified"))
    assert lines[at].endswith(", except:")
    assert "joint_1: certified: nowhere in the joint box above " in lines[at + 1]
    assert "NOT as asked" in lines[at + 1]


@pytest.fixture
def without_proofs(monkeypatch):
    monkeypatch.setattr("lwr_dyn.design.gain_search.certificates", lambda arm, maxima: None)


@pytest.mark.slow
def test_without_proofs_how_the_maxima_were_searched_is_said_once(lwr_dyn_command, recorded, without_proofs):
    lines = lwr_dyn_command("gains", "lwr4plus")[1].splitlines()
    assert [line for line in lines if "searched" in line] == [
        "searched from 129 to 256 starts a joint; all ended at these values"
    ]
    assert recorded("gains", "lwr4plus")["joints"][0]["certificate"] is None


@pytest.mark.slow
def test_joints_whose_search_ended_elsewhere_too_are_named(lwr_dyn_command, without_proofs):
    lines = lwr_dyn_command("gains", "kr30ha")[1].splitlines()
    at = lines.index("searched from 129 to 256 starts a joint; all ended at these values, except:")
    assert lines[at + 1].startswith("  A2: 81% ended here")
    assert lines[at + 2] == ""


@pytest.mark.slow
def test_with_a_margin_the_largest_omega_n_of_each_controller_is_added(recorded):
    words = ("--reading", "physical", "--delay", "1", "--margin", "--task", "ist", "--elastic", "1e4")
    record = recorded("gains", "lwr4plus", *words)["margin"]
    found = {(row["controller"], row["case"].split()[0]): row["omega_n"] for row in record["controllers"]}
    assert record["limit"] == 1.7
    rigid = {name: omega_n for (name, case), omega_n in found.items() if case == "rigid,"}
    assert rigid == pytest.approx({"pd-gravity": 50.0, "pid": 50.0, "inverse-dynamics": 164.0}, rel=0.02)
    assert all(found[name, "elastic"] < 0.3 * omega_n for name, omega_n in rigid.items())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--margin", "0.5", "--task", "ist"), "margin, the largest |S_ii|: 0.5; allowed: a number above 1"),
        (("--task", "ist"), "--task: would do nothing here; allowed: with --margin"),
        (("--elastic", "1e4"), "--elastic: would do nothing here; allowed: with --margin"),
        (
            ("--margin", "--task", "ist", "--encoders", "link"),
            "--encoders: would do nothing here; allowed: with --elastic",
        ),
        (("--margin", "--task", "ist", "--elastic", "0"), "stiffness"),
        (("--margin", "--task", "hold"), "'hold'"),
    ],
)
def test_a_margin_that_cannot_be_is_one_line(words, message, refused):
    assert message in refused("gains", "lwr4plus", *words)


def test_the_margin_table_names_what_stops_a_larger_frequency():
    arm = lwr_dyn.load("lwr4plus", "physical")
    gains = second_order_gains(np.ones(7), 50.0, 1.0)
    found = margin_gains(arm, 1.5, [LoopCase(delay=2)], gains, np.zeros((1, 7)) + 0.5, most=60.0)
    rows = {row[0]: row for row in found.table.rows}
    assert rows["inverse-dynamics"][2:] == ("over 60", "nothing that was tried")
    assert rows["pd-gravity"][3].endswith("at (29 29 29 29 29 29 29) deg")
    assert "at 1 poses of the task" in found.table.title
