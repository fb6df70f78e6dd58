"""What `simulate` says of a sampled loop: before the run, of the simulated plant, nothing if it is stable."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.design.loop_judgement import LoopCase, sampled_loops, sampling_text, stability_lines
from lwr_dyn.design.sampled_loop import Sampling
from lwr_dyn.model.arm import JointGains
from tests.simulation.sample_runs import lwr, one_joint

AUTHORS = ("lwr4plus", "--reading", "computed")
"""With their rotors, a hundred times too light, the wrist shakes."""
HOLD = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.05")


def notes(err):
    return [line for line in err.splitlines() if line.startswith("note: ")]


def test_before_the_run_the_box_and_the_reference_are_judged(lwr_dyn_command):
    code, _, err = lwr_dyn_command("simulate", *AUTHORS, *HOLD)
    first, second = err.splitlines()
    assert code == 0
    assert first.startswith("note: sampled at 1000 Hz, this loop is unstable at rest in 22.9 +- 0.9 % of the joint box")
    assert first.endswith("from 6920 Hz on it is stable in all of them")
    assert second == "note: at the poses of this reference (51 of them) it is stable"


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        ("--reading", "physical"),
        ("--controller", "inverse-dynamics"),
        ("--continuous",),
        ("--rate", "7000"),
    ],
)
def test_a_loop_that_is_stable_everywhere_or_not_judged_gets_no_line(options, lwr_dyn_command):
    assert notes(lwr_dyn_command("simulate", *AUTHORS, *HOLD, *options)[2]) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "rate"),
    [
        (("--plant-scale", "0.5"), 1860),
        (("--plant-scale", "0.5", "--continuous"), None),
        (("--plant-scale", "0.5", "--controller", "inverse-dynamics"), None),
        (("--rate", "700", "--controller", "pd-gravity"), 957),
        (("--rate", "700", "--plant-scale", "2"), None),
        (("--delay", "1"), 1930),
        (("--rate", "930", "--payload", "3"), None),
    ],
)
def test_the_reference_is_judged_on_the_simulated_plant(options, rate, lwr_dyn_command):
    """Not on the controller's model: a lighter plant chatters where the model would not, a heavier one does not."""
    code, _, err = lwr_dyn_command("simulate", *AUTHORS, *HOLD, *options)
    unstable = [line for line in notes(err) if "poses of this reference it is unstable" in line]
    assert code == 0
    assert [f"from {rate} Hz on it is stable there" in line for line in unstable] == ([True] if rate else [])


@pytest.mark.slow
def test_the_record_of_a_run_has_it_too(lwr_dyn_command):
    record = json.loads(lwr_dyn_command("simulate", *AUTHORS, *HOLD, "--delay", "1", "--json")[1])
    judged = record["sampled_loop"]
    assert record["meta"]["options"]["delay"] == 1
    assert judged["in_box"]["share"] == pytest.approx(0.4995)
    assert judged["along_reference"]["unstable"] == judged["along_reference"]["poses"] == 51
    own = json.loads(lwr_dyn_command("simulate", *AUTHORS, *HOLD, "--continuous", "--json")[1])
    assert own["sampled_loop"] is None


def test_the_words_of_a_sampling():
    assert sampling_text(Sampling(500.0)) == "500 Hz"
    assert sampling_text(Sampling(500.0, 1)) == "500 Hz with a delay of 1 sample"
    assert stability_lines(lwr(), None) == []


def test_gains_that_hold_at_no_rate_and_slow_growth_are_said(lwr_dyn_command):
    hold = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.01")
    box, path = notes(lwr_dyn_command("simulate", *AUTHORS, *hold, "--omega-n", "1", "--payload", "20")[2])
    assert box.endswith("; no rate up to 1e+06 Hz makes it stable in all of them")
    assert path.endswith(
        "where a deviation grows by 0.33 % with each sample; no rate up to 1e+06 Hz makes it stable there"
    )


def test_a_controller_without_a_linear_form_is_named_as_not_judged(lwr_dyn_command, tmp_path):
    mine = str(tmp_path / "mine.py")
    assert lwr_dyn_command("new", "controller", mine)[0] == 0
    err = lwr_dyn_command("simulate", *AUTHORS, *HOLD, "--controller", mine)[2]
    assert notes(err) == [
        "note: whether sampling makes this loop unstable is not judged: the controller has no linear_feedback(q)"
    ]
    assert notes(lwr_dyn_command("simulate", *AUTHORS, *HOLD, "--controller", mine, "--continuous")[2]) == []


@pytest.mark.slow
@pytest.mark.parametrize(("encoders", "unstable"), [("link", 2000), ("motor", 0)])
def test_elastic_joints_are_judged_as_such(encoders, unstable, lwr_dyn_command):
    """Rigid, this loop holds; on springs PD holds from the motors' side, and nowhere from the links'."""
    options = ("--reading", "physical", "--elastic", "1e4", "--encoders", encoders)
    code, out, err = lwr_dyn_command("simulate", *AUTHORS, *HOLD, *options)
    found = notes(err)
    assert code == 0
    assert "limits of position, speed and torque: kept" in out  # the run itself does not show it
    assert len(found) == (2 if unstable else 0)
    if unstable:
        assert f"this loop is unstable at rest in {unstable} of 2000 poses of the joint box; " in found[0]
        assert found[1].startswith("note: at 51 of 51 poses of this reference it is unstable; ")


@pytest.mark.slow
def test_what_is_said_of_elastic_joints_agrees_with_the_margins(lwr_dyn_command):
    options = ("--reading", "physical", "--controller", "inverse-dynamics", "--elastic", "file", "--json")
    judged = json.loads(lwr_dyn_command("simulate", *AUTHORS, *HOLD, *options)[1])["sampled_loop"]
    report = lwr_dyn.margins(lwr_dyn.load("lwr4plus", reading="physical"), "inverse-dynamics", elasticity="file")
    assert 0 < report.stability.unstable < report.stability.poses
    assert judged["in_box"]["unstable"] == report.stability.unstable
    assert judged["in_box"]["least_rate"] == pytest.approx(report.stability.least_rate)
    assert judged["along_reference"]["unstable"] == 0


@pytest.mark.slow
def test_what_is_known_of_elastic_joints_is_said_of_a_run_that_diverges_too(lwr_dyn_command):
    elastic = ("--reading", "physical", "--elastic", "1e4", "--encoders", "link", "--no-saturation", "--no-stops")
    move = ("--task", "point-to-point", "--from-deg", "0,30,0,-60,0,30,0", "--to-deg", "9,30,0,-60,0,30,0")
    code, out, err = lwr_dyn_command("simulate", *AUTHORS, *move, "--duration", "0.5", *elastic)
    assert (code, out) == (2, "")
    assert len(notes(err)) == 2
    assert err.splitlines()[-1].startswith("lwr-dyn: ")


@pytest.mark.slow
def test_gains_tell_the_unstable_share_of_each_controller(lwr_dyn_command):
    code, out, _ = lwr_dyn_command("gains", *AUTHORS)
    rows = {line.split()[0]: line for line in out.splitlines() if line}
    assert code == 0
    assert "of 2000 poses drawn evenly from the joint box (seed 0); linear, without friction and torque limits" in out
    assert "22.9 +- 0.9 %" in rows["pd-gravity"]
    assert "6920 Hz" in rows["pid"]
    assert "none (at 95 %: below 0.15 %)" in rows["inverse-dynamics"]
    assert ") deg" in rows["pd-gravity"]


def test_gains_as_json_with_rate_and_delay(lwr_dyn_command):
    record = json.loads(lwr_dyn_command("gains", *AUTHORS, "--rate", "500", "--delay", "1", "--json")[1])["sampled"]
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
    code, out, err = lwr_dyn_command("gains", *AUTHORS, *options)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert fault in err


def test_gains_of_the_file_are_judged_as_they_are():
    arm = replace(one_joint(mass=2.0), gains=JointGains(np.array([1.0]), np.array([5000.0])))
    judged = sampled_loops(arm, second_order_gains([2.0], 50.0, 1.0), Sampling(1000.0))
    assert judged["pd-gravity"].share == 0.0  # T 2 xi omega_n = 0.1
    assert judged["pd-gravity --own-gains"].share == 1.0  # T Kd / m = 2.5


def test_a_slider_of_unknown_limits_is_judged_within_a_metre():
    arm = one_joint(mass=2.0)
    judged = sampled_loops(arm, second_order_gains([2.0], 50.0, 1.0), Sampling(40.0))
    assert {found.unknown_limits for found in judged.values()} == {("joint_1",)}
    assert {found.share for found in judged.values()} == {1.0}  # T 2 xi omega_n = 2.5


@pytest.mark.parametrize(
    ("case", "words"),
    [
        (LoopCase(), "rigid, 1000 Hz"),
        (LoopCase(500.0, 1, 30.0), "rigid, 500 Hz, delay of 1 sample, speeds filtered at 30 Hz"),
        (LoopCase(delay=2, elasticity=1e4), "elastic (10000 N m/rad, motor encoders), 1000 Hz, delay of 2 samples"),
        (LoopCase(elasticity="file", encoders="link"), "elastic (link encoders), 1000 Hz"),
    ],
)
def test_a_case_in_words(case, words):
    assert case.words == words
