"""`lwr-dyn identify` as a user types it."""

import json
from importlib.resources import files

import numpy as np
import pytest
from pyarrow import csv, table

from lwr_dyn.identification.logs.joint_log import JointLog, write_log
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from tests.identification.simulated import ideal_cruise

ROWS = 200_000
"""A fifth of what `scripts/soak.py` times."""


@pytest.mark.slow
def test_motion_from_the_command_line(recorded, wam, fourier, tmp_path):
    write_log(tmp_path / "log.parquet", fourier(wam, wam.friction))
    found = recorded("identify", "motion", "wam7", tmp_path / "log.parquet")
    assert found["validation"][1]["held_out"] < 0.02 * found["validation"][1]["measured"]
    assert found["consistent"]["physical"] == [True] * 7
    assert found["validated_on"] == []


@pytest.mark.slow
def test_motion_says_what_is_identified_and_what_no_bodies_can_have(lwr_dyn_command, printed, wam, fourier, tmp_path):
    """With noise a third of the parameters and some moments are not to be had from 20 s; bodies near the table are."""
    path, other = tmp_path / "log.parquet", tmp_path / "other.csv"
    write_log(path, LogSensors(0.05, 1e-5).through(fourier(wam, wam.friction), 3))
    write_log(other, LogSensors(0.05, 1e-5).through(fourier(wam, wam.friction, seed=5), 4))
    command = ("identify", "motion", "wam7", path, "--validate", other)
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
    out = printed(*command)
    assert out.startswith(f"{len(known)} of 76 base parameters identified, from ")
    assert out.splitlines()[1] == "NO BODIES CAN HAVE THESE VALUES"
    assert "impossible: Izz_7 = -" in out
    assert "widened where residuals" in out
    assert "left, unseen" in out
    assert "bodies near the table: 7 of 7 links are bodies" in out
    assert f"validation, RMS in N m (N): {other}, which no fit has seen" in out
    assert "not identified yet; what would do it" in out


@pytest.mark.slow
def test_a_log_to_validate_that_cannot_be_read_is_a_fault(lwr_dyn_command, wam, fourier, tmp_path):
    write_log(tmp_path / "log.csv", fourier(wam, wam.friction))
    code, out, err = lwr_dyn_command("identify", "motion", "wam7", tmp_path / "log.csv", "--validate", "no.csv")
    assert code == 2
    assert "bodies near the table" in out
    assert err == "lwr-dyn: no.csv: no such file or directory; allowed: a log (.csv or .parquet)\n"


@pytest.mark.slow
def test_a_column_of_the_wrong_sign_is_named_and_not_fitted(lwr_dyn_command, refused, wam, fourier, tmp_path):
    log = LogSensors(0.05, 1e-5).through(fourier(wam, wam.friction), 3)
    tau = log.tau.copy()
    tau[:, 1] *= -1.0
    write_log(tmp_path / "log.csv", JointLog("log", log.joints, log.t, log.q, tau))
    command = ("identify", "motion", "wam7", tmp_path / "log.csv")
    err = refused(*command)
    assert "tau2" in err
    assert "sign" in err
    code, out, err = lwr_dyn_command(*command, "--as-logged")
    assert code == 0
    assert err.startswith("lwr-dyn: warning: ")
    assert "base parameters identified" in out


@pytest.mark.slow
def test_a_model_that_its_log_contradicts_is_written_only_when_accepted(lwr_dyn_command, wam, fourier, tmp_path):
    log = LogSensors(0.05, 1e-5).through(fourier(wam, wam.friction), 3)
    tau = log.tau.copy()
    tau[:, 1] *= -1.0
    write_log(tmp_path / "log.csv", JointLog("log", log.joints, log.t, log.q, tau))
    model = tmp_path / "arm.toml"
    command = ("identify", "motion", "wam7", tmp_path / "log.csv", "--as-logged", "--out", model)
    code, out, err = lwr_dyn_command(*command)
    assert code == 2
    assert "THE LOG CONTRADICTS THE BODIES NEAR THE TABLE: " in "\n".join(out.splitlines()[:3])
    assert "not written: " in err
    assert not model.exists()
    code, out, _ = lwr_dyn_command(*command, "--accept")
    assert code == 0
    code, out, _ = lwr_dyn_command("check", model)
    assert code == 1
    assert "logs that contradict the fitted bodies: " in out


@pytest.mark.slow
def test_gains_are_fitted_and_written_with_the_model(lwr_dyn_command, wam, fourier, tmp_path):
    log = LogSensors(0.05, 1e-5).through(fourier(wam, wam.friction), 3)
    true = np.array([1.1, 0.95, 1.05, 0.9, 1.0, 1.08, 0.97])
    write_log(tmp_path / "log.csv", JointLog("log", log.joints, log.t, log.q, log.tau * true))
    command = ("identify", "motion", "wam7", tmp_path / "log.csv", "--as-logged", "--gains", "10%")
    code, out, _ = lwr_dyn_command(*command, "--out", tmp_path / "arm.toml")
    assert code == 0
    assert "gains of the torques, known to 10 % before the log" in out
    assert "what tells them apart is that gains are right to 10 % each" in out
    assert "gains known to 0.1" in (tmp_path / "arm.toml").read_text(encoding="utf-8")
    gains = json.loads(lwr_dyn_command(*command, "--json")[1])["gains"]
    off = [(row["gain"] - g) / row["standard_error"] for row, g in zip(gains["joints"], true, strict=True)]
    assert np.abs(off).max() < 3.0
    assert gains["total_mass_error"] > 0.0


def test_gains_that_are_no_share_are_refused_in_a_line(refused, wam, fourier, tmp_path):
    write_log(tmp_path / "log.csv", fourier(wam, wam.friction, seconds=2.0))
    command = ("identify", "motion", "wam7", tmp_path / "log.csv", "--gains")
    assert (
        refused(*command, "0.8")
        == "lwr-dyn: gains: 0.8; allowed: a share above 0 and up to 0.5, such as 0.1 for 10 %\n"
    )
    assert "'ten' is not a share; allowed: a number such as 5% or 0.05" in refused(*command, "ten")
    assert "allowed: without --instruments" in refused(*command, "10%", "--instruments", tmp_path / "log.csv")


@pytest.mark.slow
def test_friction_with_the_load_is_found_printed_and_said_of_the_model(lwr_dyn_command, tmp_path):
    log = files("lwr_dyn.identification.ranking") / "logs" / "ur10_salerno.csv"
    command = ("identify", "motion", "ur10", log, "--load-friction")
    code, out, _ = lwr_dyn_command(*command, "--accept", "--out", tmp_path / "arm.toml")
    assert code == 0
    assert "friction that grows with the torque of bodies and rotors" in out
    assert "; friction of " in (tmp_path / "arm.toml").read_text(encoding="utf-8")
    for more in ((), ("--passive-refit",)):
        code, out, err = lwr_dyn_command("simulate", tmp_path / "arm.toml", "--duration", "0.1", *more)
        assert code == 0
        assert "left out: friction that grows with the load, " in out.partition("\n")[0] + err
    found = json.loads(lwr_dyn_command(*command, "--json")[1])
    assert found["load_friction"][1] > 3.0 * found["load_friction_error"][1]
    assert [p["parameter"] for p in found["parameters"]].count("load_2") == 1


def test_what_does_not_go_with_friction_of_the_load_is_refused_in_a_line(refused, wam, fourier, tmp_path):
    log = fourier(wam, wam.friction, seconds=2.0)
    write_log(tmp_path / "log.csv", log)
    command = ("identify", "motion", "wam7", tmp_path / "log.csv", "--load-friction")
    assert "allowed: without --instruments" in refused(*command, "--instruments", tmp_path / "log.csv")


@pytest.mark.slow
def test_a_joint_that_stands_still_is_named_and_the_others_are_fitted(lwr_dyn_command, wam, fourier, tmp_path):
    log = fourier(wam, wam.friction, joints=(0, 1, 3, 4, 5, 6))
    write_log(tmp_path / "log.csv", log)
    code, out, err = lwr_dyn_command("identify", "motion", "wam7", tmp_path / "log.csv")
    assert code == 0
    assert "not determined: this motion does not show it at all" in out
    assert "joint 3" in err


@pytest.mark.slow
def test_a_long_log_is_read_whole(printed, tmp_path, wam):
    """Forth and back at four speeds, over and over: 15 columns with noise."""
    once = [ideal_cruise(wam.friction, np.full(7, v), wam) for v in (0.1, -0.1, 0.2, -0.2)]
    turn = np.vstack([np.hstack([log.q, log.tau]) for log in once])
    rows = np.tile(turn, (-(-ROWS // len(turn)), 1))[:ROWS] + np.random.default_rng(0).normal(0, 1e-6, (ROWS, 14))
    names = ["time", *(f"{x}{j}" for x in ("q", "tau") for j in range(1, 8))]
    columns = [np.arange(ROWS) / 100, *rows.T]
    csv.write_csv(table(dict(zip(names, columns, strict=True))), tmp_path / "long.csv")
    out = printed("identify", "friction", "wam7", tmp_path / "long.csv", "--subtract", "all")
    assert "4.4748" in out
