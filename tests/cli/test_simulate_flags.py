"""Each flag of the command has the effect that its help describes; friction: its form, its refit, its warning."""

import json

import numpy as np
import pytest

from lwr_dyn.cli.main import main
from lwr_dyn.model.run import Run

HOLD = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.3")
MOVE = ("--task", "point-to-point", "--from-deg", "0,30,0,-60,0,30,0", "--to-deg", "9,40,0,-60,0,30,0")


@pytest.fixture
def simulated(recorded):
    return lambda *options: recorded("simulate", "lwr4plus", *options)


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
    lines = lwr_dyn_command("simulate", own, *move)[1].splitlines()
    rows = {line.split()[0]: line.split()[1] for line in lines if line.startswith("joint_")}
    assert rows == {"joint_1": "mrad", "joint_2": "mm", "joint_3": "mrad"}


def test_fk_names_joints_outside_the_limits(recorded, refused):
    outside = recorded("fk", "lwr4plus", "--q-deg", "0,130,0,0,0,0,0")["outside"]
    assert outside == [f"joint_2 is outside its limits by {np.radians(10):.6g}"]
    refused("fk", "lwr4", "--symbolic", "--json")


def test_a_file_that_changed_since_the_run_is_not_drawn(lwr_dyn_command, refused, tmp_path):
    own, run = tmp_path / "own.toml", str(tmp_path / "run.npz")
    lwr_dyn_command("new", "arm", str(own), "--joints", "RR")
    move = ("--task", "hold", "--from-deg", "0,0", "--duration", "0.01", "--controller", "inverse-dynamics")
    assert lwr_dyn_command("simulate", str(own), *move, "--out", run)[0] == 0
    own.write_text(own.read_text().replace("values = [0.3, 0]", "values = [0.9, 0]"))
    assert "has changed since the run was made" in refused("replay", run, "--html", str(tmp_path / "x.html"))


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """What the file of a run holds."""
    path = tmp_path_factory.mktemp("stored") / "run.npz"
    with pytest.raises(SystemExit) as stop:
        main(["simulate", "lwr4plus", *HOLD[:-1], "0.01", "--out", str(path)])
    assert stop.value.code == 0
    with np.load(path) as arrays:
        return dict(arrays)


@pytest.mark.slow
def test_the_record_as_it_was_is_a_run(lwr_dyn_command, tmp_path, stored):
    np.savez(tmp_path / "run.npz", **stored)
    assert lwr_dyn_command("replay", str(tmp_path / "run.npz"), "--html", str(tmp_path / "x.html"))[0] == 0


@pytest.mark.slow
@pytest.mark.parametrize("field", ["events", "meta", "schema"])
@pytest.mark.parametrize("value", [None, 3, [[1.0]], "x"])
def test_a_foreign_record_is_no_run(refused, tmp_path, stored, field, value):
    path, arrays = tmp_path / "run.npz", dict(stored)
    record = json.loads(arrays["record"].tobytes())
    record[field] = value
    arrays["record"] = np.frombuffer(json.dumps(record).encode(), dtype=np.uint8)
    np.savez(path, **arrays)
    refused("replay", str(path), "--html", str(tmp_path / "x.html"))
    with pytest.raises(OSError, match="run file"):
        Run.load(path)


def test_several_files_are_written_together_or_not_at_all(refused, tmp_path):
    (tmp_path / "x.srdf").mkdir()
    refused("urdf", "lwr4plus", "--out", str(tmp_path / "x.urdf"))
    assert [p.name for p in tmp_path.iterdir()] == ["x.srdf"]


@pytest.mark.parametrize(
    "options", [("--rate", "1e9"), ("--omega-n", "1e200"), ("--controller", "pid", "--omega-n", "1e200")]
)
def test_huge_options_are_refused(refused, options):
    assert "allowed" in refused("simulate", "lwr4plus", *HOLD, *options)


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
def test_an_option_that_would_do_nothing_is_refused(refused, options, option, words):
    err = refused("simulate", "lwr4plus", *HOLD, *options)
    assert err.startswith(f"lwr-dyn: {option}: would do nothing here; allowed: {words}")  # optional laws may follow


def test_substeps_are_bounded(refused):
    err = refused("simulate", "lwr4plus", *HOLD, "--substeps", "99999999999")
    assert err == "lwr-dyn: substeps: 99999999999; allowed: a whole number from 1 to 1000\n"


LSPB = ("simulate", "wam7", "--task", "lspb", "--from-deg", "0,-60,0,90,0,0,0", "--own-gains", "--velocity-error")
FAST = (*LSPB, "--to-deg", "0,-60,0,130,0,0,0", "--duration", "1.0", "--blend", "0.3")


@pytest.mark.slow
def test_friction_that_drives_is_warned_of(printed):
    out = printed(*FAST)
    assert "friction of the plant: set-valued\n" in out
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


@pytest.mark.parametrize(("arguments", "message"), BAD.values(), ids=BAD)
def test_bad_input_is_one_line(refused, arguments, message):
    assert message in refused(*FAST, *arguments)


def test_an_arm_without_gains_is_refused(refused):
    err = refused("simulate", "lwr4plus", "--task", "hold", "--from-deg", "0,0,0,0,0,0,0", "--own-gains")
    assert "lwr4plus: controller gains not given; needed for own_gains (--own-gains)" in err
