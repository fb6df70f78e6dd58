"""Each flag of the command has the effect that its help describes."""

import json

import numpy as np
import pytest

from lwr_dyn.model.run import Run

HOLD = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.3")
MOVE = ("--task", "point-to-point", "--from-deg", "0,30,0,-60,0,30,0", "--to-deg", "9,40,0,-60,0,30,0")


@pytest.fixture
def simulated(lwr_dyn_command):
    def run(*options):
        code, out, _ = lwr_dyn_command("simulate", "lwr4plus", *options, "--json")
        assert code == 0
        return json.loads(out)

    return run


@pytest.mark.slow
def test_velocity_error_takes_the_lag_away(simulated):
    lag, none = (simulated(*MOVE, "--duration", "1", *x)["metrics"]["tip_max_mm"] for x in ((), ("--velocity-error",)))
    assert none < 0.5 * lag


@pytest.mark.slow
def test_a_known_payload_is_compensated(simulated):
    load = ("--reading", "computed", "--payload", "3", "--controller", "inverse-dynamics")
    unknown, known = (simulated(*HOLD, *load, *x)["metrics"]["tip_max_mm"] for x in ((), ("--payload-known",)))
    assert unknown > 5.0
    assert known < 0.01


@pytest.mark.slow
def test_feedforward_and_gravity_can_be_left_out(simulated):
    controller = ("--controller", "inverse-dynamics", "--duration", "1")
    full, paper, droop = (
        simulated(*MOVE, *controller, *x)["metrics"]["tip_max_mm"]
        for x in ((), ("--no-feedforward",), ("--no-gravity",))
    )
    assert full < 0.1 * paper < 0.1 * droop


@pytest.mark.slow
def test_uses_of_limits_stand_in_their_columns(lwr_dyn_command, simulated):
    found = simulated(*MOVE, "--duration", "1")["metrics"]
    text = lwr_dyn_command("simulate", "lwr4plus", *MOVE, "--duration", "1")[1]
    row = next(line.split() for line in text.splitlines() if line.startswith("joint_2"))
    assert row[-3:-1] == [f"{found['torque_use'][1]:.0%}", f"{found['speed_use'][1]:.0%}"]
    assert row[-3] != row[-2]
    assert row[1] == "mrad"
    assert len(row) == 8
    full = lwr_dyn_command("simulate", "lwr4plus", *MOVE, "--duration", "1", "--full")[1]
    row_of_all = next(line.split() for line in full.splitlines() if line.startswith("joint_2"))
    assert (len(row_of_all), row_of_all[-4:], row_of_all[6]) == (14, row[-4:], row[2])


def test_sliding_joints_are_printed_in_their_units(lwr_dyn_command, tmp_path):
    own = str(tmp_path / "own.toml")
    lwr_dyn_command("new", "arm", own, "--joints", "RPR")
    move = ("--task", "hold", "--from-deg", "0,0.2,0", "--duration", "0.05", "--controller", "inverse-dynamics")
    rows = {line.split()[0]: line.split()[1] for line in lwr_dyn_command("simulate", own, *move)[1].splitlines()[4:7]}
    assert rows == {"joint_1": "mrad", "joint_2": "mm", "joint_3": "mrad"}


def test_fk_names_joints_outside_the_limits(lwr_dyn_command):
    code, out, _ = lwr_dyn_command("fk", "lwr4plus", "--q-deg", "0,130,0,0,0,0,0", "--json")
    assert code == 0
    assert json.loads(out)["outside"] == [f"joint_2 is outside its limits by {np.radians(10):.6g}"]
    code, _, err = lwr_dyn_command("fk", "lwr4", "--symbolic", "--json")
    assert (code, err.count("\n")) == (2, 1)


def test_a_file_that_changed_since_the_run_is_not_drawn(lwr_dyn_command, tmp_path):
    own, run = tmp_path / "own.toml", str(tmp_path / "run.npz")
    lwr_dyn_command("new", "arm", str(own), "--joints", "RR")
    move = ("--task", "hold", "--from-deg", "0,0", "--duration", "0.01", "--controller", "inverse-dynamics")
    assert lwr_dyn_command("simulate", str(own), *move, "--out", run)[0] == 0
    own.write_text(own.read_text().replace("values = [0.3, 0]", "values = [0.9, 0]"))
    code, _, err = lwr_dyn_command("replay", run, "--html", str(tmp_path / "x.html"))
    assert code == 2
    assert "has changed since the run was made" in err


@pytest.mark.slow
@pytest.mark.parametrize("field", ["events", "meta", "schema"])
@pytest.mark.parametrize("value", [None, 3, [[1.0]], "x"])
def test_a_foreign_record_is_no_run(lwr_dyn_command, tmp_path, field, value):
    path = tmp_path / "run.npz"
    lwr_dyn_command("simulate", "lwr4plus", *HOLD[:-1], "0.01", "--out", str(path))
    with np.load(path) as stored:
        arrays = dict(stored)
    record = json.loads(arrays["record"].tobytes())
    record[field] = value
    arrays["record"] = np.frombuffer(json.dumps(record).encode(), dtype=np.uint8)
    np.savez(path, **arrays)
    code, _, err = lwr_dyn_command("replay", str(path), "--html", str(tmp_path / "x.html"))
    assert (code, err.count("\n")) == (2, 1)
    with pytest.raises(OSError, match="run file"):
        Run.load(path)


def test_several_files_are_written_together_or_not_at_all(lwr_dyn_command, tmp_path):
    (tmp_path / "x.srdf").mkdir()
    code, _, err = lwr_dyn_command("urdf", "lwr4plus", "--out", str(tmp_path / "x.urdf"))
    assert (code, err.count("\n")) == (2, 1)
    assert [p.name for p in tmp_path.iterdir()] == ["x.srdf"]


@pytest.mark.parametrize(
    "options", [("--rate", "1e9"), ("--omega-n", "1e200"), ("--controller", "pid", "--omega-n", "1e200")]
)
def test_huge_options_are_refused(lwr_dyn_command, options):
    code, _, err = lwr_dyn_command("simulate", "lwr4plus", *HOLD, *options)
    assert (code, err.count("\n")) == (2, 1)
    assert "allowed" in err


@pytest.mark.parametrize(
    ("options", "option", "words"),
    [
        (("--ki", "3"), "--ki", "with --controller pid"),
        (("--payload-known",), "--payload-known", "with --payload"),
        (("--encoder-bits", "16", "--seed", "3"), "--seed", "with --encoder-noise"),
        (("--velocity-cutoff", "50"), "--velocity-cutoff", "with --encoder-bits or --encoder-noise"),
        (("--timing", "quintic"), "--timing", "with --task ist, ist-clear"),
        (("--method", "dop853", "--substeps", "2"), "--substeps", "with --method rk4"),
    ],
)
def test_an_option_that_would_do_nothing_is_refused(lwr_dyn_command, options, option, words):
    code, out, err = lwr_dyn_command("simulate", "lwr4plus", *HOLD, *options)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"lwr-dyn: {option}: would do nothing here; allowed: {words}")  # optional laws may follow


def test_substeps_are_bounded(lwr_dyn_command):
    code, _, err = lwr_dyn_command("simulate", "lwr4plus", *HOLD, "--substeps", "99999999999")
    assert (code, err) == (2, "lwr-dyn: substeps: 99999999999; allowed: a whole number from 1 to 1000\n")
