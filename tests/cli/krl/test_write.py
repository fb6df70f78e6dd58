"""`lwr-dyn krl write | check | run`: from a task file to a run that can be replayed, and one line for bad input."""

import tomllib

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.krl.writing.point_program import point_program_of
from lwr_dyn.model.run import Run

TASK = """
name = "TwoPoint"
wait = 1.0
[[point]]
name = "Point1"
xyz = [91, -1139, 1392]
wait = 2.0
[[point]]
name = "Point2"
xyz = [91, -1117, 1447]
motion = "LIN"
"""


def test_a_task_says_little_and_has_the_rest():
    """Points are PTP to the tool's own axes without a wait; speeds 100 % and 0.25 m/s, home as mastered."""
    arm = lwr_dyn.load("kr30ha")
    program = point_program_of(tomllib.loads(TASK), arm)
    first, second = program.points
    assert (first.name, first.pose, first.motion, first.wait) == ("Point1", (91, -1139, 1392, 0, 0, 0), "PTP", 2.0)
    assert (second.pose, second.motion, second.wait) == ((91, -1117, 1447, 0, 0, 0), "LIN", 0.0)
    assert (program.name, program.tool, program.base) == ("TwoPoint", (0,) * 6, (0,) * 6)
    assert (program.ptp_percent, program.lin_speed, program.wait) == (100, 0.25, 1.0)
    assert program.home_deg == pytest.approx(np.degrees(arm.mastering))
    for change, says in (
        ({"point": []}, "one or more [[point]] tables"), ({"ptp_percent": 101}, "ptp_percent"),
        ({"ptp_percent": 0}, "ptp_percent"), ({"lin_speed": 10.1}, "lin_speed"), ({"wait": -1.0}, "wait"),
        ({"tool": [0.0] * 5}, "6 finite numbers"), ({"point": [{"name": "XHOME", "xyz": [1, 2, 3]}]}, "XHOME"),
        ({"point": [{"name": "p", "xyz": [1, 2, 3]}] * 2}, "a name that is there twice"),
        ({"point": [{"name": "p", "xyz": [1, 2, 3], "abc": [1, 2, 3, 4]}]}, "3 finite numbers"),
        ({"point": [{"name": "p", "xyz": [1, 2, 3, 4]}]}, "3 finite numbers"), ({"colour": 1}, "colour"),
        ({"point": [{"name": "1p", "xyz": [1, 2, 3]}]}, "a name of KRL"),
    ):  # fmt: skip
        with pytest.raises(PaperError) as refusal:
            point_program_of(tomllib.loads(TASK) | change, arm)
        assert says in str(refusal.value)
    for limit in ({"ptp_percent": 1}, {"lin_speed": 10.0}, {"wait": 0.0}, {"lin_speed": 0.001}):
        assert point_program_of(tomllib.loads(TASK) | limit, arm).points == program.points


@pytest.fixture
def written(printed, folder):
    (folder / "task.toml").write_text(TASK)
    assert "wrote TwoPoint.src and TwoPoint.dat" in printed("krl", "write", "task.toml")
    return folder


def test_write_check_run(written, printed, recorded):
    assert recorded("krl", "check", "TwoPoint.src") == {"file": "TwoPoint.src", "holds": True, "diagnoses": []}
    record = recorded("krl", "run", "TwoPoint.src", "--out", "run.npz", "--html", "run.html")
    assert [m["motion"] for m in record["motions"]] == ["PTP (start)", "WAIT", "PTP", "WAIT", "LIN", "PTP", "WAIT"]
    assert record["motions"][4]["flange"][:3] == pytest.approx([91, -1117, 1447], abs=1e-6)
    run = Run.load(written / "run.npz")
    assert run.t[-1] == pytest.approx(record["cycle_time"])
    assert run.meta["robot"] == "kr30ha"
    assert (written / "run.html").stat().st_size > 100_000
    printed("replay", "run.npz", "--html", "again.html")


def test_the_text_gives_cycle_motions_and_torques(written, printed):
    out = printed("krl", "run", "TwoPoint.src")
    assert "TwoPoint.src on kr30ha: " in out
    assert "dynamic N m" in out
    assert "assumed: 0.4 s to rated speed" in out


def test_a_slower_ramp_takes_longer(written, recorded):
    times = [recorded("krl", "run", "TwoPoint.src", "--ramp", r)["cycle_time"] for r in "12"]
    assert times[1] > times[0]


def test_faults_make_exit_code_1_and_a_run_of_them_2(written, lwr_dyn_command):
    source = written / "TwoPoint.src"
    source.write_text(source.read_text().replace("PTP Point1", "PTP Pont1"))
    code, out, err = lwr_dyn_command("krl", "check", "TwoPoint.src")
    assert (code, err) == (1, "")
    assert "TwoPoint.src:17:5: error undeclared: Pont1 is not declared (did you mean Point1?)" in out
    code, out, err = lwr_dyn_command("krl", "run", "TwoPoint.src")
    assert (code, out) == (2, "")
    assert err == "lwr-dyn: TwoPoint.src:17:5: Pont1 is not declared; did you mean Point1?\n"


BAD = {
    "no file": (("check", "none.src"), "none.src: no such file or directory; allowed: a KRL file"),
    "no source": (("check", "TwoPoint.dat"), "TwoPoint.dat: ends in '.dat'; allowed: a .src or .sub file"),
    "other ending": (("run", "TwoPoint.src", "--out", "x.txt"), "x.txt: does not end in .npz"),
    "no folder": (("run", "TwoPoint.src", "--out", "none/x.npz"), "no directory none"),
    "ramp": (("run", "TwoPoint.src", "--ramp", "0"), "ramp: 0.0; allowed: a number from 0.001"),
    "value": (("check", "TwoPoint.src", "--set", "x"), "--set: 'x'; allowed: NAME=VALUE"),
    "robot": (("check", "TwoPoint.src", "--robot", "lwr4plus"), "robot: lwr4plus; allowed: an arm with KUKA's axes"),
    "included": (("check", "TwoPoint.src", "--with", "none.dat"), "none.dat: no such file"),
    "no task": (("write", "none.toml"), "none.toml: no such file"),
    "name": (("write", "task.toml", "--out", "other.src"), "allowed: a path that ends in TwoPoint.src"),
    "of a path": (("write", "task.toml", "--stop"), "--stop: given for a .toml of points; allowed: none"),
}


@pytest.mark.parametrize(("arguments", "message"), BAD.values(), ids=BAD)
def test_bad_input_is_one_line(written, refused, arguments, message):
    assert message in refused("krl", *arguments)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("xyz = [91, -1139, 1392]", "xyz = [91, -1139]"), "xyz: [91, -1139]; allowed: 3 finite numbers"),
        (("xyz = [91, -1139, 1392]", "xyz = [9100, 0, 0]"), "out of reach"),
        (('name = "Point2"', 'name = "point1"'), "a name that is there twice"),
        (('name = "Point2"', 'name = "2 b"'), "allowed: a name of KRL"),
        (('motion = "LIN"', 'motion = "FLY"'), "motion: 'FLY'; allowed: one of PTP, LIN"),
        (("wait = 1.0", "wayt = 1.0"), "wayt: unknown field"),
        (("wait = 1.0", "wait = 'x"), "TOML: "),
    ],
)
def test_a_wrong_task_file_is_one_line(written, refused, change, message):
    (written / "task.toml").write_text(TASK.replace(*change))
    assert message in refused("krl", "write", "task.toml")


def test_a_run_that_is_cut_has_no_cycle_time(folder, lwr_dyn_command, recorded):
    (folder / "long.src").write_text(
        "DEF long( )\nPTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}\nWAIT SEC 5\nPTP_REL {A1 10}\nEND\n"
    )
    for more, whole in (((), True), (("--seconds", "2"), False)):
        code, out, _ = lwr_dyn_command("krl", "run", "long.src", *more)
        assert (code, "cut after 2.000 s, so no cycle time" in out.splitlines()[1]) == (0, not whole)
        assert out.startswith("kr30ha (kuka): masses, centres of mass and inertias estimated from drawn solids\n")
        record = recorded("krl", "run", "long.src", *more)
        assert record["cycle_time"] == (record["duration"] if whole else None)
    assert record["duration"] == 2.0
