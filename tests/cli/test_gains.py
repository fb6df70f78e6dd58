"""`lwr-dyn gains`: inertias beside a grid, gains by their definition, what is proven and searched, bad input."""

from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.cli.gains import ON_TASK, _margin_search, places, searched
from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.design.gain_search import PEAK, largest_omega_n, margin_gains
from lwr_dyn.design.loop_judgement import LoopCase
from lwr_dyn.design.sampled_loop import Sampling
from lwr_dyn.design.sampled_stability import SampledStability
from lwr_dyn.foundation.tables import Table
from lwr_dyn.model.transmission import chosen_elasticity

LOOPS = {"pd": SampledStability(Sampling(500.0, 2), 8, 3, np.zeros(3), 1.25, 600.0)}
NOTHING = "would do nothing here; allowed:"


@pytest.fixture
def own(folder):
    """Of joints that turn, slide and turn."""
    (folder / "own.toml").write_text(template("own.toml", "own", "RPR"), encoding="utf-8")
    return lwr_dyn.load("own.toml")


def test_rows_are_the_largest_inertias_of_a_grid_and_the_gains_that_follow(asked, recorded, printed, own):
    sampled = asked("lwr_dyn.cli.gains.sampled_loops", LOOPS)
    line = ("gains", "own.toml", "--omega-n", "20", "--xi", "0.7", "--rate", "500", "--delay", "2")
    record = recorded(*line)
    q = np.stack(np.meshgrid(*np.linspace(own.lower, own.upper, 9).T), axis=-1).reshape(-1, 3)
    largest = np.diagonal(lwr_dyn.dynamics_of(own).mass_matrix(q), axis1=1, axis2=2).max(axis=0)
    assert [x["b"] for x in record["joints"]] == pytest.approx(largest)
    assert [x["Kp"] for x in record["joints"]] == pytest.approx(20.0**2 * largest)
    assert [x["Kd"] for x in record["joints"]] == pytest.approx(2.0 * 0.7 * 20.0 * largest)
    assert [x["q"] for x in record["joints"]] == [[0.0, own.upper[1], 0.0], [0.0, 0.25, 0.0], [0.0, 0.25, 0.0]]
    assert [x["free"] for x in record["joints"]] == [[True, False, True], [True] * 3, [True] * 3]
    for row in record["joints"]:
        assert row["b"] <= row["certificate"]["upper"] <= row["b"] * (1 + 1e-6)
    assert {key: record[key] for key in ("robot", "reading", "omega_n", "xi", "margin")} == {
        "robot": "own", "reading": "printed", "omega_n": 20.0, "xi": 0.7, "margin": None,
    }  # fmt: skip
    assert (record["sampled"]["pd"]["unstable"], record["sampled"]["pd"]["radius"]) == (3, 1.25)
    (arm, gains, sampling), _ = sampled[0]
    assert (arm.name, sampling.rate, sampling.delay) == ("own", 500.0, 2)
    np.testing.assert_allclose(gains.Kp, 400.0 * largest)
    lines = printed(*line).splitlines()
    assert lines[2] == "own, reading printed: max B_ii over the joint box, omega_n = 20 rad/s, xi = 0.7"
    assert [x.split(maxsplit=4)[4] for x in lines[5:8]] == ["(* 0.5 *)", "(* * *)", "(* * *)"]
    assert len([x for x in lines if x.startswith("certified: nowhere in the joint box more than ")]) == 1
    assert not [x for x in lines if "searched" in x]
    assert lines[-1].split("  ")[0] == "pd"


def maximum(joint, *maximisers, distinct=0, starts=9, share=1.0):
    return SimpleNamespace(joint=joint, maximisers=maximisers, distinct=distinct or len(maximisers), starts=starts,
                           share=share, statement=lambda: f"{starts} climbs; {share:.0%} ended here")  # fmt: skip


def test_two_maximisers_are_shown_and_the_rest_is_counted(own):
    free, turned = (np.nan, 0.25, np.pi / 2), (-np.pi, 0.12345, np.nan)
    assert places(own, maximum(0, free)) == "(* 0.25 90)"
    assert places(own, maximum(0, free, turned)) == "(* 0.25 90) (-180 0.123 *)"
    assert places(own, maximum(0, free, turned, free, distinct=5)) == "(* 0.25 90) (-180 0.123 *) and 3 more"


def test_the_search_is_said_once_and_joints_whose_climbs_ended_elsewhere_are_named(own):
    first = maximum(0, starts=5)
    assert searched(own, [first, maximum(1)]) == [
        "searched from 5 to 9 starts a joint; all ended at these values"
    ]  # fmt: skip
    assert searched(own, [first, maximum(2, share=0.81)]) == [
        "searched from 5 to 9 starts a joint; all ended at these values, except:", "  joint_3: 81% ended here",
    ]  # fmt: skip


def test_the_margin_is_searched_for_rigid_and_elastic_joints_at_poses_of_the_task(asked):
    arm, gains = lwr_dyn.load("lwr4plus", "physical"), second_order_gains(np.ones(7), 50.0)
    calls = asked("lwr_dyn.design.gain_search.margin_gains")
    _margin_search(arm, (500.0, 2), 1.5, "ist", "1e4", "link")(gains)
    _margin_search(arm, (500.0, 2), 1.5, None, None, "motor")(gains)
    (found, limit, cases, same, q), _ = calls[0]
    assert (found is arm, limit, same is gains) == (True, 1.5, True)
    elasticity = chosen_elasticity(arm, 1e4)
    assert repr(cases) == repr([LoopCase(500.0, 2), LoopCase(500.0, 2, None, elasticity, "link")])
    ist = lwr_dyn.reference("ist", arm)
    np.testing.assert_array_equal(q, ist.sample(np.linspace(0.0, ist.duration, ON_TASK)).q)
    assert (calls[1][0][2:3], calls[1][0][4]) == (([LoopCase(500.0, 2)],), None)


@pytest.mark.parametrize(("typed", "limit"), [((), PEAK), (("1.4",), 1.4)])
def test_the_margin_that_is_asked_for_stands_in_text_and_record(asked, recorded, printed, own, typed, limit):
    """Without a number it is the usual one."""
    asked("lwr_dyn.cli.gains.sampled_loops", LOOPS)
    found = SimpleNamespace(table=Table("the margin", ("a",), [("b",)]), record=lambda: None)
    calls = asked("lwr_dyn.design.gain_search.margin_gains", found)
    line = ("gains", "own.toml", "--delay", "1", "--margin", *typed)
    assert "the margin\n" in printed(*line)
    assert recorded(*line)["margin"] is None
    assert [(call[0][1], call[0][2][0].delay) for call in calls] == [(limit, 1)] * 2


@pytest.mark.slow
def test_with_a_margin_the_largest_omega_n_of_each_controller_is_added(recorded):
    words = ("--reading", "physical", "--delay", "1", "--margin", "--task", "ist", "--elastic", "1e4")
    record = recorded("gains", "lwr4plus", *words)["margin"]
    found = {(row["controller"], row["case"].split()[0]): row["omega_n"] for row in record["controllers"]}
    assert record["limit"] == 1.7
    rigid = {name: omega_n for (name, case), omega_n in found.items() if case == "rigid,"}
    assert rigid == pytest.approx({"pd-gravity": 50.0, "pid": 50.0, "inverse-dynamics": 164.0}, rel=0.02)
    assert all(found[name, "elastic"] < 0.3 * omega_n for name, omega_n in rigid.items())


@pytest.mark.slow
def test_joints_whose_bound_is_not_near_are_named(lwr_dyn_command, monkeypatch):
    monkeypatch.setattr("lwr_dyn.control.inertia.certificate.MOST_BOXES", 40)
    lines = lwr_dyn_command("gains", "lwr4plus")[1].splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("certified"))
    assert lines[at].endswith(", except:")
    assert "joint_1: certified: nowhere in the joint box above " in lines[at + 1]
    assert "NOT as asked" in lines[at + 1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "said"),
    [
        ("lwr4plus", ["searched from 129 to 256 starts a joint; all ended at these values", ""]),
        ("kr30ha", ["searched from 129 to 256 starts a joint; all ended at these values, except:", "  A2: 81% ended"]),
    ],
)
def test_without_proofs_how_the_maxima_were_searched_is_said(lwr_dyn_command, recorded, asked, robot, said):
    asked("lwr_dyn.design.gain_search.certificates")
    lines = lwr_dyn_command("gains", robot)[1].splitlines()
    at = lines.index(said[0])
    assert lines[at + 1].startswith(said[1])
    assert recorded("gains", robot)["joints"][0]["certificate"] is None


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("lwr4plus", "--omega-n", "-1"), "omega_n: -1.0; allowed: a number above 0"),
        (("nothing", "--xi", "0"), "xi: 0.0; allowed: a number above 0"),  # before the robot is loaded
        (("lwr4",), "masses and inertias not given"),
        (("lwr4plus", "--margin", "1"), "margin, the largest |S_ii|: 1.0; allowed: a number above 1"),
        (("lwr4plus", "--task", "ist"), f"--task: {NOTHING} with --margin"),
        (("lwr4plus", "--elastic", "1e4"), f"--elastic: {NOTHING} with --margin"),
        (("lwr4plus", "--margin", "--task", "ist", "--encoders", "link"), f"--encoders: {NOTHING} with --elastic"),
        (("lwr4plus", "--margin", "--task", "ist", "--elastic", "0"), "stiffness"),
        (("lwr4plus", "--margin", "--task", "hold"), "'hold'"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(words, message, refused):
    assert message in refused("gains", *words)


def test_the_margin_table_names_what_stops_a_larger_frequency():
    arm, cases = lwr_dyn.load("lwr4plus", "physical"), [LoopCase(delay=2), LoopCase(rate=500.0, delay=2)]
    gains, q, most = second_order_gains(np.ones(7), 50.0, 0.8), np.zeros((1, 7)) + 0.5, {"most": 60.0}
    margin = margin_gains(arm, 1.5, cases, gains, q, **most)
    rows = {tuple(row[:2]): row[2:] for row in margin.table.rows}
    assert list(rows) == [(law, case.words) for law in ("pd-gravity", "pid", "inverse-dynamics") for case in cases]
    assert rows["inverse-dynamics", cases[0].words] == ("over 60", "nothing that was tried")
    for (law, words), found in margin.found.items():
        of_inertia = {} if law == "inverse-dynamics" else {"inertia": np.ones(7)}
        (case,) = (case for case in cases if case.words == words)
        alone = largest_omega_n(arm, law, [case], q=q, peak=1.5, xi=0.8, **of_inertia, **most)
        assert (found.omega_n, found.peak, found.joint) == (alone.omega_n, alone.peak, alone.joint)
        if not found.at_most:
            where = f"joint_{found.joint + 1} at (29 29 29 29 29 29 29) deg"
            text = "none" if found.omega_n is None else f"{found.omega_n:.1f}"
            assert rows[law, words] == (text, where)
    assert margin.table.title == (
        "Largest omega_n with |S_ii| <= 1.5, at 1 poses of the task; linear and at rest, without friction and torque "
        "limits"
    )
    each = margin.found["pd-gravity", cases[1].words]
    record = margin.record()["controllers"][1]
    assert {k: record[k] for k in ("controller", "case", "omega_n", "joint", "at_most")} == {
        "controller": "pd-gravity", "case": cases[1].words, "omega_n": each.omega_n, "joint": each.joint + 1,
        "at_most": False,
    }  # fmt: skip
    drawn = margin_gains(arm, 1.001, cases[:1], gains, **most, poses=2)
    assert drawn.where == "over the joint box (2 poses)"
    assert {row[2] for row in drawn.table.rows} == {"none"}
