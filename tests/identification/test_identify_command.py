"""`lwr-dyn identify` as a user types it."""

import json
import sys

import numpy as np
import pytest
from pyarrow import csv, table

from lwr_dyn.cli.main import main
from lwr_dyn.identification.logs.joint_log import JointLog, write_log
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from tests.identification.simulated import ideal_cruise

ROWS = 200_000
"""A fifth of what `scripts/soak.py` times."""


@pytest.fixture
def lwr_dyn_command(capsys):
    def run(*arguments):
        with pytest.raises(SystemExit) as stop:
            main([str(a) for a in arguments])
        out, err = capsys.readouterr()
        return stop.value.code, out, err

    return run


@pytest.fixture
def logs(tmp_path, one_joint_at_a_time):
    paths = [tmp_path / f"{i:02d}.csv" for i in range(len(one_joint_at_a_time))]
    for path, log in zip(paths, one_joint_at_a_time, strict=True):
        write_log(path, log)
    return paths


def test_friction_as_json_and_as_a_plot(lwr_dyn_command, logs, tmp_path):
    out_file = tmp_path / "map"
    code, out, err = lwr_dyn_command("identify", "friction", *logs, "--robot", "wam7", "--json", "--plot", out_file)
    found = json.loads(out)
    assert (code, err) == (0, "")
    assert len(found["fits"]) == 14
    assert len(found["map"]) == 56
    first = found["fits"][0]
    assert first["parameters"]["coulomb"]["value"] == pytest.approx(4.4748)
    assert {"standard_error", "three_sigma", "bias_of_averaging"} <= set(first["parameters"]["viscous"])
    assert first["speeds"] == pytest.approx([0.05, 0.3])
    assert first["residual_rms"] < 1e-9
    assert out_file.with_suffix(".png").read_bytes()[:4] == b"\x89PNG"
    assert b"<svg" in out_file.with_suffix(".svg").read_bytes()


def test_without_matplotlib_a_plot_is_refused_before_anything_is_printed(lwr_dyn_command, logs, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    code, out, err = lwr_dyn_command("identify", "friction", *logs, "--plot", tmp_path / "map")
    assert (code, out) == (2, "")
    assert "pip install 'lwr_dyn[plots]'" in err
    assert err.count("\n") == 1


def test_the_table_names_the_torques_taken_out(lwr_dyn_command, logs):
    code, out, _ = lwr_dyn_command("identify", "friction", *logs, "--robot", "wam7", "--robust")
    assert code == 0
    assert "56 cruises in 56 files, Huber's loss, taken out of the torques: g" in out
    assert "--subtract all takes it out" in out
    assert out.count("0.05 to 0.3") == 14


def test_good_files_are_reported_and_every_bad_one_gets_a_line(lwr_dyn_command, logs, tmp_path):
    bad = tmp_path / "bad.csv"
    bad.write_text("time,q1\n0,0\n")
    code, out, err = lwr_dyn_command("identify", "friction", bad, *logs, tmp_path / "none.csv", "--robot", "wam7")
    assert code == 2
    assert out.count("0.05 to 0.3") == 14
    assert err.splitlines() == [
        f"lwr-dyn: {bad}: columns: tau1 missing; the file has time, q1; "
        "needed: time, q1.., tau1.. (and dq1.. if measured)",
        f"lwr-dyn: {tmp_path / 'none.csv'}: no such file or directory; allowed: a log (.csv or .parquet)",
    ]


def test_nothing_but_bad_files_prints_no_report(lwr_dyn_command, tmp_path):
    code, out, err = lwr_dyn_command("identify", "friction", tmp_path / "none.csv", "--json")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("friction",), "Missing argument 'LOG...'"),
        (("friction", "x.csv", "--robot", "kuka"), "no robot named 'kuka'"),
        (("friction", "x.csv", "--units", "q=turns"), "units of q: 'turns'; allowed: rad, deg"),
        (("friction", "x.csv", "--model", "lugre"), "'lugre' is not one of"),
        (("friction", "x.csv", "--shortest", "0"), "cruise shortest: 0.0; allowed: a number above 0"),
        (("friction", "x.csv", "--plot", "none/map"), "none"),
        (("friction", "x.csv", "--plot", "m.jpg"), "m.jpg: ends in .jpg; allowed: no suffix, .png or .svg"),
        (("friction", "x.csv", "--subtract", "all"), "--subtract: would do nothing here; allowed: with --robot"),
        (("friction", "x.csv", "--reading", "printed"), "--reading: would do nothing here; allowed: with --robot"),
        (("motion", "x.csv"), "Missing option '--robot'"),
        (("motion", "x.csv", "--robot", "wam7", "--folds", "1"), "folds: 1; allowed: a number of at least 2"),
        (("motion", "x.csv", "--robot", "wam7", "--deviation", "0"), "deviation: 0.0; allowed: a share above 0"),
        (("motion", "x.csv", "--robot", "wam7", "--friction", "lugre"), "'lugre' is not one of"),
    ],
)
def test_bad_input_gets_one_line(lwr_dyn_command, arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = lwr_dyn_command("identify", *arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_motion_from_the_command_line(lwr_dyn_command, wam, fourier, tmp_path):
    write_log(tmp_path / "log.parquet", fourier(wam, wam.friction))
    code, out, _ = lwr_dyn_command("identify", "motion", tmp_path / "log.parquet", "--robot", "wam7", "--json")
    found = json.loads(out)
    assert code == 0
    assert found["validation"][1]["held_out"] < 0.02 * found["validation"][1]["measured"]
    assert found["consistent"]["physical"] == [True] * 7
    assert found["validated_on"] == []


def test_motion_says_what_is_identified_and_what_no_bodies_can_have(lwr_dyn_command, wam, fourier, tmp_path):
    """With noise a third of the parameters and some moments are not to be had from 20 s; bodies near the table are."""
    path, other = tmp_path / "log.parquet", tmp_path / "other.csv"
    write_log(path, LogSensors(0.05, 1e-5).through(fourier(wam, wam.friction), 3))
    write_log(other, LogSensors(0.05, 1e-5).through(fourier(wam, wam.friction, seed=5), 4))
    command = ("identify", "motion", path, "--robot", "wam7", "--validate", other)
    code, out, err = lwr_dyn_command(*command, "--json")
    found = json.loads(out)
    known = [p for p in found["parameters"] if p["identified"]]
    assert code == 0
    assert 38 < len(known) == found["identified"] < 60
    assert all(abs(p["value"]) > p["three_sigma"] for p in known)
    assert {p["state"] for p in found["parameters"]} <= {"identified", "not excited", "0 within 3 sigma"}
    assert "widened where residuals" in found["noise_model"]
    negative = {n["parameter"]: n for n in found["bodies"]["negative_parameters"]}
    assert found["bodies"]["impossible"]
    assert "Izz_7" in negative
    assert err.count("lwr-dyn: warning: impossible: ") == err.count("\n") >= len(negative)
    assert found["consistent"]["physical"] == [True] * 7
    for one in found["validated_on"]:
        assert one["consistent"] < 1.1 * one["held_out"] < 0.1
    code, out, err = lwr_dyn_command(*command)
    assert (code, err) == (0, "")
    assert out.startswith(f"{len(known)} of 76 base parameters identified, from ")
    assert out.splitlines()[1] == "NO BODIES CAN HAVE THESE VALUES"
    assert "impossible: Izz_7 = -" in out
    assert "widened where residuals" in out
    assert "left, unseen" in out
    assert "bodies near the table: 7 of 7 links are bodies" in out
    assert f"validation, RMS in N m (N): {other}, which no fit has seen" in out
    assert "not identified yet; what would do it" in out


def test_a_log_to_validate_that_cannot_be_read_is_a_fault(lwr_dyn_command, wam, fourier, tmp_path):
    write_log(tmp_path / "log.csv", fourier(wam, wam.friction))
    code, out, err = lwr_dyn_command(
        "identify", "motion", tmp_path / "log.csv", "--robot", "wam7", "--validate", "no.csv"
    )
    assert code == 2
    assert "bodies near the table" in out
    assert err == "lwr-dyn: no.csv: no such file or directory; allowed: a log (.csv or .parquet)\n"


def test_a_column_of_the_wrong_sign_is_named_and_not_fitted(lwr_dyn_command, wam, fourier, tmp_path):
    log = LogSensors(0.05, 1e-5).through(fourier(wam, wam.friction), 3)
    tau = log.tau.copy()
    tau[:, 1] *= -1.0
    write_log(tmp_path / "log.csv", JointLog("log", log.joints, log.t, log.q, tau))
    command = ("identify", "motion", tmp_path / "log.csv", "--robot", "wam7")
    code, out, err = lwr_dyn_command(*command)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "tau2" in err
    assert "sign" in err
    code, out, err = lwr_dyn_command(*command, "--as-logged")
    assert code == 0
    assert err.startswith("lwr-dyn: warning: ")
    assert "base parameters identified" in out


def test_a_joint_that_stands_still_is_named_and_the_others_are_fitted(lwr_dyn_command, wam, fourier, tmp_path):
    log = fourier(wam, wam.friction, joints=(0, 1, 3, 4, 5, 6))
    write_log(tmp_path / "log.csv", log)
    code, out, err = lwr_dyn_command("identify", "motion", tmp_path / "log.csv", "--robot", "wam7")
    assert code == 0
    assert "not determined: this motion does not show it at all" in out
    assert "joint 3" in err


def test_a_long_log_is_read_whole(lwr_dyn_command, tmp_path, wam):
    """Forth and back at four speeds, over and over: 15 columns with noise."""
    once = [ideal_cruise(wam.friction, np.full(7, v), wam) for v in (0.1, -0.1, 0.2, -0.2)]
    turn = np.vstack([np.hstack([log.q, log.tau]) for log in once])
    rows = np.tile(turn, (-(-ROWS // len(turn)), 1))[:ROWS] + np.random.default_rng(0).normal(0, 1e-6, (ROWS, 14))
    names = ["time", *(f"{x}{j}" for x in ("q", "tau") for j in range(1, 8))]
    columns = [np.arange(ROWS) / 100, *rows.T]
    csv.write_csv(table(dict(zip(names, columns, strict=True))), tmp_path / "long.csv")
    code, out, _ = lwr_dyn_command(
        "identify", "friction", tmp_path / "long.csv", "--robot", "wam7", "--subtract", "all"
    )
    assert code == 0
    assert "4.4748" in out
