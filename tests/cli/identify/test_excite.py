"""`lwr-dyn excite`: options reach the search, the loop to identification, and what it refuses in one line."""

import dataclasses
import json
import os
import shlex
import signal
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.cli.identify.excite import _next
from lwr_dyn.cli.main import main
from lwr_dyn.cli.options import Loading
from lwr_dyn.foundation.document import Document
from lwr_dyn.identification.excitation import motion_design
from lwr_dyn.identification.excitation.design import DURATION, HARMONICS, NOISE, STARTS, NoMotionError, without_friction
from lwr_dyn.identification.excitation.motion_design import MotionDesign
from lwr_dyn.identification.excitation.motion_limits import MotionLimits, clearance_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import arm_with_payload
from tests.json_schemas import faults

QUICK = ("--reading", "physical", "--starts", "1", "--duration", "6", "--harmonics", "3")
SEARCH = "lwr_dyn.identification.excitation.design.design_excitation"
FOUND = SimpleNamespace(document=Document("", "a motion", ()), faults=(), ended="starts")
SIZES = {"duration": DURATION, "objective": "d", "starts": STARTS, "harmonics": HARMONICS, "seed": 0, "seconds": 30.0}
CHOSEN = {"duration": 6.0, "objective": "cond", "starts": 2, "harmonics": 3, "seed": 5, "seconds": 7.0}
OPTIONS = ("--duration", 6, "--objective", "cond", "--starts", 2, "--harmonics", 3, "--seed", 5, "--search-seconds", 7)


@pytest.mark.parametrize(
    ("options", "sizes", "load", "noise", "limits", "clearance"),
    [
        ((), SIZES, 0.0, [NOISE] * 7, (), ()),
        ((*OPTIONS, "--noise", "1,2,3,4,5,6,7", "--payload", 1, "--joint-speed", 1.5, "--speed-share", 0.7,
          "--torque-share", 0.6, "--margin-deg", 9, "--keep", 0.03, "--floor", -0.2, "--column", 0.1),
         CHOSEN, 1.0, range(1, 8), (np.radians(9.0), 0.7, 0.6, 1.5), (0.03, -0.2, 0.1)),
    ],
)  # fmt: skip
def test_options_reach_the_search(asked, lwr_dyn_command, options, sizes, load, noise, limits, clearance):
    calls = asked(SEARCH, FOUND)
    code, out, _ = lwr_dyn_command("excite", "lwr4plus", *options)
    assert (code, out) == (0, "a motion\n")
    (arm,), given = calls[0]
    assert {name: given[name] for name in SIZES} == sizes
    own = lwr_dyn.load("lwr4plus")
    assert arm.bodies()[6].mass == (arm_with_payload(own, load) if load else own).bodies()[6].mass
    np.testing.assert_array_equal(np.broadcast_to(given["noise"], 7), [*noise])
    assert repr(given["limits"]) == repr(MotionLimits.of(arm, *limits))
    assert repr(given["clearance"]) == repr(clearance_of(arm, *clearance))


def test_the_motion_is_written_while_and_after_it_is_searched_and_its_exit_code_says_what_it_is(
    asked, lwr_dyn_command, folder
):
    written = asked("lwr_dyn.identification.excitation.motion_file.write_excitation")
    bad = SimpleNamespace(
        document=FOUND.document, faults=("near",), ended="starts", starts=(), arm=lwr_dyn.load("wam7")
    )
    stopped = SimpleNamespace(document=FOUND.document, faults=(), ended="stopped")
    line = ("excite", "lwr4plus", "--out", "e.csv", "--rate", 50)
    then = "lwr-dyn simulate lwr4plus --task csv --file e.csv --controller inverse-dynamics --out e_run.npz"
    next_line = f"a motion\nwrote e.csv; simulate a log:  {then}\n"
    for result, more, code, out, err in (
        (FOUND, (), 0, next_line, ""),
        (bad, (), 1, "a motion\nwrote e.csv\n", ""),
        (NoMotionError(bad), (), 1, "a motion\nwrote e.csv\n", ""),
        (stopped, (), 130, next_line, "lwr-dyn: stopped: this is the best motion so far\n"),
        (FOUND, ("--json",), 0, '{\n  "caveats": []\n}\n', ""),
    ):
        calls = asked(SEARCH, result)
        assert lwr_dyn_command(*line, *more) == (code, out, err)
        calls[0][1]["better"]("a better one")
        shown = result.best if isinstance(result, NoMotionError) else result
        assert written[-2:] == [(("e.csv", shown, 50.0), {}), (("e.csv", "a better one", 50.0), {})]


@pytest.mark.parametrize(
    ("out", "loading", "payload", "words"),
    [
        ("e.parquet", Loading(further={"trust_xacro": False}), 0.0, ""),
        ("an e.csv", Loading("physical", None, ("joint_7=0.5",), {"tool": ("xyz=0,0,0.1",), "trust_xacro": False}), 3.0,
         "--reading physical --lock joint_7=0.5 --payload 3.0 --tool xyz=0,0,0.1"),
        ("e.csv", Loading(None, "hand", (), {"xacro_args": ("a:=1", "b:=2"), "rotor": None, "mount": ("wall",),
                                             "trust_xacro": True}), 0.0,
         "--tip hand --xacro-arg a:=1 --xacro-arg b:=2 --mount wall --trust-xacro"),
    ],
)  # fmt: skip
def test_the_proposed_simulation_is_of_the_same_arm(out, loading, payload, words):
    run = f"{out.removesuffix('.csv')}_run.npz"
    rest = ["--task", "csv", "--file", out, "--controller", "inverse-dynamics", "--out", run]
    expected = f"; simulate a log:  {shlex.join(['lwr-dyn', 'simulate', 'panda', *words.split(), *rest])}"
    assert _next(out, "panda", loading, payload) == (expected if words else "")


@pytest.mark.slow
def test_excite_simulate_identify(lwr_dyn_command, printed, recorded, tmp_path):
    motion, log = str(tmp_path / "e.csv"), str(tmp_path / "e_run.npz")
    line = printed("excite", "lwr4plus", *QUICK, "--out", motion).split("simulate a log:  lwr-dyn ")[1].split()
    assert lwr_dyn_command(*line)[0] == 0
    assert recorded("identify", "motion", "lwr4plus", log, "--reading", "physical")["parameters"]


@pytest.mark.slow
def test_the_record_says_what_the_motion_is(recorded):
    record = recorded("excite", "lwr4plus", *QUICK, "--objective", "cond", "--floor", "-1")
    series = record["series"]
    w = 2 * np.pi / record["duration"] * np.arange(1, 4)
    end = np.array(series["centre"]) - (np.array(series["cosines"]) / w[:, None]).sum(axis=0)
    arm = lwr_dyn.load("lwr4plus")
    assert ((end > arm.lower) & (end < arm.upper)).all()
    assert (len(record["parameters"]), record["check_rate"]) == (69, pytest.approx(1000.0))
    assert record["clearance"] >= 0.05
    sigma = [one["sigma"] for one in record["parameters"]]
    assert record["mean_sigma"] == pytest.approx(np.exp(np.log(sigma).mean()))


def rows_of(file):
    """Rows of numbers of a whole motion."""
    return np.loadtxt(file, delimiter=",", skiprows=sum(x[0] in "#t" for x in file.read_text().splitlines()))


@pytest.fixture
def interrupted(monkeypatch):
    """A function that has Ctrl-C pressed when a start begins for the time that is given, counted from 1."""

    def at(count):
        draw, begun = motion_design.random_start, []

        def start(*arguments):
            begun.append(1)
            if len(begun) == count:
                os.kill(os.getpid(), signal.SIGINT)
            return draw(*arguments)

        monkeypatch.setattr(motion_design, "random_start", start)
        return begun

    return at


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2])
def test_ctrl_c_leaves_the_best_motion_so_far_whole(count, interrupted, lwr_dyn_command, tmp_path):
    begun, file = interrupted(count), tmp_path / "e.csv"
    code, out, err = lwr_dyn_command("excite", "lwr4plus", *QUICK[2:], "--starts", "9", "--out", str(file))
    assert (code, err, len(begun)) == (130, "lwr-dyn: stopped: this is the best motion so far\n", count)
    assert f"ended early (stopped): {count} of 9 starts searched; the best motion so far" in out
    assert f"wrote {file}" in out
    assert rows_of(file).shape == (601, 22)
    assert ("DO NOT RUN IT" in out) == file.read_text().startswith("# DO NOT RUN IT")
    assert [*tmp_path.iterdir()] == [file]


@pytest.mark.slow
def test_seconds_leave_the_best_motion_so_far_whole(recorded, tmp_path):
    file = tmp_path / "e.csv"
    record = recorded("excite", "lwr4plus", "--starts", "900", "--search-seconds", "4", "--out", str(file))
    assert (record["ended"], record["may_be_run"]) == ("seconds", True)
    assert record["seconds"] < 8.0
    assert 1 <= len(record["starts"]) < 900
    assert rows_of(file).shape == (1001, 22)


@pytest.mark.slow
def test_a_motion_that_is_found_is_written_at_once(tmp_path, monkeypatch):
    """What ends the search by force leaves the best motion that was found before it."""
    file = tmp_path / "e.csv"

    def killed(*_):
        raise MemoryError

    monkeypatch.setattr(MotionDesign, "best_of", killed)
    with pytest.raises(MemoryError):
        main(["excite", "lwr4plus", *QUICK, "--out", str(file)])
    assert rows_of(file).shape == (601, 22)


@pytest.mark.slow
def test_a_motion_that_is_too_near_is_written_and_said_to_be(lwr_dyn_command, tmp_path, monkeypatch):
    """Searches that do nothing end where they begin."""
    monkeypatch.setattr(motion_design.SearchSpace, "solve", lambda self, x, *_: x)
    file = tmp_path / "e.csv"
    options = ("excite", "lwr4plus", *QUICK, "--floor", "0.1", "--out", str(file))
    code, out, err = lwr_dyn_command(*options, "--json")
    record = json.loads(out)
    assert (code, err, faults("excite", record), record["may_be_run"]) == (1, "", [], False)
    assert f"{record['nearest']} are " in record["faults"][0]
    assert file.read_text().startswith(f"# DO NOT RUN IT: {record['faults'][0]}\n")
    assert rows_of(file).shape == (601, 22)
    code, out, _ = lwr_dyn_command(*options)
    assert (code, f"DO NOT RUN IT: {record['faults'][0]}" in out) == (1, True)
    assert out.endswith(f"wrote {file}\n")


def test_a_long_motion_says_the_rate_of_its_check():
    arm = lwr_dyn.load("lwr4plus", "physical")
    columns, limits = TorqueColumns(arm.chain), MotionLimits.of(arm)
    design = MotionDesign(arm, 400.0, 2, "d", np.ones(7), columns, limits, clearance_of(arm))
    assert design.check_rate == pytest.approx(500.0)


def test_only_joints_without_friction_are_named():
    arm = lwr_dyn.load("wam7")
    assert without_friction(arm) == ""
    some = dataclasses.replace(arm, friction=(None, *arm.friction[1:]))
    assert without_friction(some).startswith("torques without friction of joint_1, which")


FLOOR = "joint_4 and the floor overlap at best by 4.67 m; 0.05 m is to be kept; allowed: less"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--objective", "e"), "'e' is not one of 'd', 'cond'"),
        (("--starts", "0"), "starts: 0; allowed: a whole number from 1"),
        (("--noise", "1,2"), "noise: shape (2,); allowed: one number, or 7"),
        (("--noise", "0"), "noise: 0.0; allowed: above 0"),
        (("--duration", "-1"), "duration: -1.0; allowed: a time above 0 s"),
        (("--out", "e.txt"), "does not end in .csv, .parquet, .npz"),
        (("--keep", "-1"), "distance to keep: -1.0; allowed: 0 or more, in m"),
        (("--margin-deg", "200"), "travel of joint_1: -170 deg (-2.97 rad) to 170 deg (2.97 rad)"),
        (("--margin-deg", "-1"), "--margin-deg: -1.0; allowed: 0 or more, in deg"),
        pytest.param(("--floor", "5"), FLOOR, marks=pytest.mark.slow),
        (("--keep", "5"), "link_5 and the column are at best 0.243 m apart; 5 m is to be kept; allowed: less"),
        (("--search-seconds", "0"), "seconds: 0.0; allowed: above 0, in s; inf for no limit"),
        (("--search-seconds", "nan"), "seconds: nan; allowed: above 0, in s; inf for no limit"),
        (("--column", "5"), "column: 5.0; allowed: a radius in m that does not hold the whole arm"),
        (("--duration", "1e9"), "duration: 1000000000.0; allowed: a time above 0 s, at most 3600 s"),
        (("--starts", "100000"), "starts: 100000; allowed: a whole number from 1 to 1000"),
        (("--rate", "1e9", "--out", "e.csv"), "rate: 1000000000.0; allowed: above 0, at most 333333 Hz for 6 s"),
        (("--speed-share", "2"), "speed share: 2.0; allowed: above 0, at most 1"),
        (("--rate", "0", "--out", "e.csv"), "rate: 0.0; allowed"),
    ],
)
def test_bad_options_are_one_line_before_any_search(options, words, refused, folder, monkeypatch):
    monkeypatch.setattr(MotionDesign, "start", lambda *_: pytest.fail("a search was begun"))
    assert words in refused("excite", "lwr4plus", *QUICK, *options)
