"""What `simulate` says of a sampled loop: before the run, of the simulated plant, nothing if it is stable."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.design.loop_judgement import (
    LoopCase,
    sampled_loops,
    sampling_text,
    stability_lines,
    stability_table,
    unknown_text,
)
from lwr_dyn.design.sampled_loop import Sampling
from lwr_dyn.design.sampled_stability import SampledStability, pose_text, rate_text
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import JointGains
from tests.simulation.sample_runs import lwr, one_joint

AUTHORS = ("lwr4plus", "--reading", "computed")
"""With their rotors, a hundred times too light, the wrist shakes."""
HOLD = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.05")
PHYSICAL, ELASTIC = ("--reading", "physical"), ("--reading", "physical", "--elastic", "1e4", "--encoders")


@pytest.fixture
def simulated(lwr_dyn_command):
    """The command as a function of its options: code, what is printed, the notes on stderr."""

    def run(*options):
        code, out, err = lwr_dyn_command("simulate", *AUTHORS, *HOLD, *options)
        return code, out, [line for line in err.splitlines() if line.startswith("note: ")]

    return run


@pytest.fixture
def record(lwr_dyn_command):
    return lambda *options: json.loads(lwr_dyn_command(*options, "--json")[1])


def test_before_the_run_the_box_and_the_reference_are_judged(simulated):
    code, _, (first, second) = simulated()
    assert code == 0
    assert first.startswith(
        "note: sampled at 1000 Hz, this loop is unstable at rest in 22.9 +- 0.9 % of the joint box (2000 poses);"
        " worst found at ("
    )
    assert first.endswith(" times with each sample; from 6920 Hz on it is stable in all of them")
    assert second == "note: at the poses of this reference (51 of them) it is stable"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "count", "rate"),
    [
        (PHYSICAL, 0, None),
        (("--controller", "inverse-dynamics"), 0, None),
        (("--continuous",), 0, None),
        (("--rate", "7000"), 0, None),
        (("--plant-scale", "0.5"), 2, 1860),
        (("--plant-scale", "0.5", "--continuous"), 0, None),
        (("--plant-scale", "0.5", "--controller", "inverse-dynamics"), 0, None),
        (("--rate", "700", "--controller", "pd-gravity"), 2, 957),
        (("--rate", "700", "--plant-scale", "2"), 0, None),
        (("--delay", "1"), 2, 1930),
        (("--rate", "930", "--payload", "3"), 0, None),
    ],
)
def test_the_reference_is_judged_on_the_simulated_plant(options, count, rate, simulated):
    """Not on the controller's model: a lighter plant chatters where the model would not, a heavier one does not."""
    code, _, notes = simulated(*options)
    assert (code, len(notes)) == (0, count)
    unstable = [line for line in notes if "poses of this reference it is unstable" in line]
    assert [f"from {rate} Hz on it is stable there" in line for line in unstable] == ([True] if rate else [])


@pytest.mark.slow
def test_the_record_of_a_run_has_it_too(record):
    whole = record("simulate", *AUTHORS, *HOLD, "--delay", "1")
    judged = whole["sampled_loop"]
    assert whole["meta"]["options"]["delay"] == 1
    assert judged["in_box"]["share"] == pytest.approx(0.4995)
    assert judged["along_reference"]["unstable"] == judged["along_reference"]["poses"] == 51
    assert record("simulate", *AUTHORS, *HOLD, "--continuous")["sampled_loop"] is None


def test_gains_that_hold_at_no_rate_and_slow_growth_are_said(simulated):
    box, path = simulated("--duration", "0.01", "--omega-n", "1", "--payload", "20")[2]
    assert box.endswith("; no rate up to 1e+06 Hz makes it stable in all of them")
    assert path.endswith(
        "where a deviation grows by 0.33 % with each sample; no rate up to 1e+06 Hz makes it stable there"
    )


def test_a_controller_without_a_linear_form_is_named_as_not_judged(simulated, lwr_dyn_command, tmp_path):
    mine = ("--controller", str(tmp_path / "mine.py"))
    assert lwr_dyn_command("new", "controller", mine[1])[0] == 0
    assert simulated(*mine)[2] == [
        "note: whether sampling makes this loop unstable is not judged: the controller has no linear_feedback(q)"
    ]
    assert simulated(*mine, "--continuous")[2] == []


@pytest.mark.slow
@pytest.mark.parametrize(("encoders", "unstable"), [("link", 2000), ("motor", 0)])
def test_elastic_joints_are_judged_as_such(encoders, unstable, simulated):
    """Rigid, this loop holds; on springs PD holds from the motors' side, and nowhere from the links'."""
    code, out, notes = simulated(*ELASTIC, encoders)
    assert (code, len(notes)) == (0, 2 if unstable else 0)
    assert "limits of position, speed and torque: kept" in out  # the run itself does not show it
    if unstable:
        assert f"this loop is unstable at rest in {unstable} of 2000 poses of the joint box; " in notes[0]
        assert notes[1].startswith("note: at 51 of 51 poses of this reference it is unstable; ")


@pytest.mark.slow
def test_what_is_said_of_elastic_joints_agrees_with_the_margins(record):
    elastic = ("--controller", "inverse-dynamics", "--elastic", "file")
    judged = record("simulate", *AUTHORS, *HOLD, *PHYSICAL, *elastic)["sampled_loop"]
    found = lwr_dyn.margins(lwr_dyn.load("lwr4plus", reading="physical"), "inverse-dynamics", elasticity="file")
    assert 0 < found.stability.unstable < found.stability.poses
    assert judged["in_box"]["unstable"] == found.stability.unstable
    assert judged["in_box"]["least_rate"] == pytest.approx(found.stability.least_rate)
    assert judged["along_reference"]["unstable"] == 0


@pytest.mark.slow
def test_what_is_known_of_elastic_joints_is_said_of_a_run_that_diverges_too(lwr_dyn_command):
    move = ("--task", "point-to-point", "--from-deg", "0,30,0,-60,0,30,0", "--to-deg", "9,30,0,-60,0,30,0")
    free = ("--duration", "0.5", *ELASTIC, "link", "--no-saturation", "--no-stops")
    code, out, err = lwr_dyn_command("simulate", *AUTHORS, *move, *free)
    assert (code, out) == (2, "")
    assert [line.split()[0] for line in err.splitlines()] == ["note:", "note:", "lwr-dyn:"]


def test_gains_as_json_with_rate_and_delay(record, lwr_dyn_command):
    found = record("gains", *AUTHORS, "--rate", "500", "--delay", "1")["sampled"]
    assert [(name, x["rate"], x["delay"], len(x["worst"])) for name, x in found.items()] == [
        (name, 500.0, 1, 7) for name in ("pd-gravity", "pid", "inverse-dynamics")
    ]
    code, out, err = lwr_dyn_command("gains", *AUTHORS, "--delay", "-1")
    assert (code, out, "delay: -1; allowed: a whole number" in err) == (2, "", True)


def test_gains_of_the_file_are_judged_as_they_are_and_unknown_limits_as_a_metre():
    arm, gains = one_joint(mass=2.0), second_order_gains([2.0], 50.0, 1.0)
    own = replace(arm, gains=JointGains(np.array([1.0]), np.array([5000.0])))
    judged = sampled_loops(own, gains, Sampling(1000.0))
    assert {name: found.share for name, found in judged.items()} == {
        "pd-gravity": 0.0, "pid": 0.0, "inverse-dynamics": 0.0,  # T 2 xi omega_n = 0.1
        "pd-gravity --own-gains": 1.0,  # T Kd / m = 2.5
    }  # fmt: skip
    table = stability_table(own, judged)
    assert table.title.startswith("Sampled at 1000 Hz: unstable at rest, of 2000 poses drawn evenly from the joint box")
    assert table.cells == tuple(
        (name, found.share_text, rate_text(found.least_rate), f"{found.radius:.4g}", pose_text(found.worst, own))
        for name, found in judged.items()
    )
    judged = sampled_loops(arm, gains, Sampling(40.0))
    assert {(found.unknown_limits, found.share) for found in judged.values()} == {(("joint_1",), 1.0)}  # T 2 xi w = 2.5
    words = "limits of all joints unknown: +-180 deg (sliding: +-1 m) taken"
    assert unknown_text(judged["pid"], arm) == words
    assert unknown_text(replace(judged["pid"], unknown_limits=("joint_3",)), lwr()) == (
        "limits of joint_3 unknown: +-180 deg taken"
    )
    assert stability_lines(arm, {"in_box": judged["pid"], "along_reference": judged["pid"]})[1] == f"note: {words}"
    assert stability_lines(lwr(), None) == []


def test_lines_of_some_poses_of_all_and_of_slow_growth():
    some = SampledStability(Sampling(500.0, 1), 8, 3, np.zeros(7), 1.1, 600.0)
    every, none = replace(some, unstable=8, radius=1.0999, least_rate=None), replace(some, unstable=0, radius=0.9)
    loop = "note: sampled at 500 Hz with a delay of 1 sample, this loop is unstable at rest in"
    grows = "worst found at (0 0 0 0 0 0 0) deg, where a deviation grows {} with each sample;"
    quick, slow, from_600 = grows.format("1.1 times"), grows.format("by 10 %"), "from 600 Hz on it is stable"
    of_some = f"{loop} {some.share_text} of the joint box (8 poses); {quick} {from_600} in all of them"
    of_all = f"{loop} 8 of 8 poses of the joint box; {slow} {rate_text(None)} makes it stable in all of them"
    holds = "note: at the poses of this reference (8 of them) it is stable"
    fails = f"note: at 3 of 8 poses of this reference it is unstable; {quick} {from_600} there"
    for box, path, lines in ((none, none, []), (some, none, [of_some, holds]), (every, some, [of_all, fails])):
        assert stability_lines(lwr(), {"in_box": box, "along_reference": path}) == lines
    assert stability_lines(lwr(), {"in_box": none, "along_reference": some})[1:] == [fails]


def test_a_case_and_a_sampling_in_words():
    assert [case.words for case in (
        LoopCase(), LoopCase(500.0, 1, 30.0), LoopCase(delay=2, elasticity=1e4),
        LoopCase(elasticity="file", encoders="link"),
    )] == [
        "rigid, 1000 Hz", "rigid, 500 Hz, delay of 1 sample, speeds filtered at 30 Hz",
        "elastic (10000 N m/rad, motor encoders), 1000 Hz, delay of 2 samples", "elastic (link encoders), 1000 Hz",
    ]  # fmt: skip
    late = ["", " with a delay of 1 sample", " with a delay of 2 samples"]
    assert [sampling_text(Sampling(500.0, delay)) for delay in range(3)] == [f"500 Hz{x}" for x in late]


@pytest.mark.parametrize("bad", [{"rate": 0.0}, {"delay": 1.5}, {"cutoff_hz": 600.0}, {"encoders": "both"}])
def test_cases_that_cannot_be_are_refused(bad):
    with pytest.raises(OptionError, match="allowed"):
        LoopCase(**bad)
