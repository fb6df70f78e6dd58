"""`lwr-dyn identify motion`: options reach the fit, its result is what is shown and written, and what is refused."""

import json
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from pyarrow import csv, table

from lwr_dyn.identification.fitted_files import write_fitted
from lwr_dyn.identification.logs.joint_log import JointLog, write_log
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import MotionRule, motion_document
from lwr_dyn.identification.payload.identify_load import CUTOFFS
from lwr_dyn.identification.regression.samples import SampleRule
from lwr_dyn.identification.report.motion_report import motion_page
from lwr_dyn.identification.slips.slip_tables import table_card
from lwr_dyn.pages.document import page_html
from tests.identification.simulated import ideal_cruise

ROWS = 200_000
"""A fifth of what `scripts/soak.py` times."""
SENSORS = LogSensors(0.05, 1e-5)
FIT = "lwr_dyn.cli.identify.motion.identify_motion"
MISSING = "lwr-dyn: none.csv: no such file or directory; allowed: a log (.csv or .parquet)\n"


@pytest.mark.parametrize(
    ("options", "rule"),
    [
        ((), MotionRule(cutoffs=CUTOFFS)),
        (("--stribeck",), MotionRule(SampleRule(slowest=0.01), cutoffs=CUTOFFS, stribeck=True)),
        (("--stribeck", "--slowest", 0.05, "--cutoff", 8, "--link-side"),
         MotionRule(SampleRule(8.0, slowest=0.05, link_side=True), stribeck=True)),
        (("--fit-friction", "symmetric", "--load-friction", "--deviation", "30%", "--folds", 3, "--known", "m_2 = 2",
          "--known", "total mass = 4"),
         MotionRule(SampleRule(), "symmetric", load_friction=True, folds=3, deviation=0.3, cutoffs=CUTOFFS,
                    known=("m_2 = 2", "total mass = 4"))),
        (("--gains", "10%", "--uncoupled"), MotionRule(gains=0.1, coupled=False, cutoffs=CUTOFFS)),
    ],
)  # fmt: skip
def test_options_reach_the_fit(asked, lwr_dyn_command, two, options, rule):
    fit = asked(FIT)
    assert lwr_dyn_command("identify", "motion", two.file, *two.paths, *options) == (0, "", "")
    (logs, arm, found, commands), _ = fit[0]
    found = ([x.source for x in logs], arm.name, repr(found), commands)
    assert found == ([*map(str, two.paths)], "two", repr(rule), [])


def test_columns_units_and_as_logged_reach_the_logs(asked, lwr_dyn_command, two):
    read = asked("lwr_dyn.cli.identify.log_options.joint_logs", ([], []))
    options = ("--columns", "q=pos_*", "--units", "q=deg", "--as-logged", "--validate", "b.csv")
    assert lwr_dyn_command("identify", "motion", two.file, "a.csv", *options) == (0, "", "")
    found = [(paths, dict(units), arm.name, *more) for (paths, units, arm, *more), _ in read]
    assert found == [((name,), {"q": "deg"}, "two", None, ("q=pos_*",), True) for name in ("a.csv", "b.csv")]


def test_commanded_motions_reach_the_fit_and_one_that_cannot_be_read_ends_it(asked, lwr_dyn_command, two):
    fit = asked(FIT)
    line = ("identify", "motion", two.file, two.paths[0], "--instruments")
    assert lwr_dyn_command(*line, two.paths[1]) == (0, "", "")
    (command,) = fit[0][0][3]
    np.testing.assert_array_equal(command.q, two.logs[1].q)
    assert lwr_dyn_command(*line, "none.csv") == (2, "", MISSING)
    assert len(fit) == 1


def test_a_log_that_is_fitted_validates_nothing_and_one_that_is_not_there_is_a_fault(asked, lwr_dyn_command, two):
    fit = asked(FIT)
    line = ("identify", "motion", two.file, two.paths[0], "--validate", two.paths[0], "--validate", "none.csv")
    code, out, err = lwr_dyn_command(*line)
    assert (code, out, len(fit)) == (2, "", 1)
    assert err.startswith(MISSING)
    assert f"{two.paths[0]}, which is fitted; needed: logs that the fit does not see\n" in err


def test_record_page_and_model_are_those_of_the_library(two, lwr_dyn_command, as_recorded, folder):
    result = identify_motion(two.logs[:1], two.arm, MotionRule(SampleRule(12.0), folds=3))
    checked, name = result.validated_on(two.logs[1:]), str(two.paths[1])
    document = motion_document(result, robot=str(two.file), unseen=checked, files=name)
    line = ("identify", "motion", two.file, two.paths[0], "--validate", name, "--cutoff", 12, "--folds", 3)
    code, out, err = lwr_dyn_command(*line, "--json", "--html", "x.html", "--out", "fit.toml")
    assert (code, json.loads(out)) == (0, as_recorded(document))
    written = ["wrote x.html", "wrote fit.toml; next: lwr-dyn check fit.toml"]
    assert err.splitlines() == written
    code, out, err = lwr_dyn_command(*line, "--html", "x.html", "--out", "fit.toml")
    assert (code, out, err) == (0, "\n".join([document.text(), *written, ""]), "")
    card = table_card(result.information, two.paper)
    assert Path("x.html").read_text(encoding="utf-8") == page_html(motion_page(result, unseen=checked, more=card))
    (folder / "by_hand").mkdir()
    write_fitted("by_hand/fit.toml", result, two.paper)
    assert Path("fit.toml").read_bytes() == Path("by_hand/fit.toml").read_bytes()


@pytest.fixture
def turned(two, tmp_path):
    """The log of two joints with the signs of its torques turned."""
    log = two.logs[0]
    write_log(tmp_path / "turned.csv", JointLog("log", log.joints, log.t, log.q, -log.tau))
    return tmp_path / "turned.csv"


def test_a_column_of_the_wrong_sign_is_named_and_fitted_only_as_logged(lwr_dyn_command, refused, two, turned):
    command = ("identify", "motion", two.file, turned)
    assert "columns: the arm explains the log with all torques with the opposite sign, or" in refused(*command)
    code, out, err = lwr_dyn_command(*command, "--as-logged")
    assert (code, err.startswith("lwr-dyn: warning: ")) == (0, True)
    assert "base parameters identified" in out


def test_a_model_that_its_log_contradicts_is_written_only_when_accepted(lwr_dyn_command, two, turned, tmp_path):
    model = tmp_path / "arm.toml"
    command = ("identify", "motion", two.file, turned, "--as-logged", "--out", model)
    code, out, err = lwr_dyn_command(*command)
    assert code == 2
    assert "THE LOG CONTRADICTS THE BODIES NEAR THE TABLE: " in "\n".join(out.splitlines()[:3])
    assert f"lwr-dyn: {model}: not written: " in err
    assert not model.exists()
    assert lwr_dyn_command(*command, "--accept")[0] == 0
    code, out, _ = lwr_dyn_command("check", model)
    assert (code, "logs that contradict the fitted bodies: " in out) == (1, True)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--gains", "0.8"), "gains: 0.8; allowed: a share above 0 and up to 0.5, such as 0.1 for 10 %"),
        (("--gains", "ten"), "'ten' is not a share; allowed: a number such as 5% or 0.05"),
        *((option, f"--{option[0].lstrip('-')}: would do nothing here; allowed: without --instruments") for option in (
            ("--gains", "10%", "--instruments", "c.csv"), ("--load-friction", "--instruments", "c.csv"),
            ("--stribeck", "--instruments", "c.csv"), ("--cutoff", "5", "--instruments", "c.csv"),
            ("--folds", "4", "--instruments", "c.csv"), ("--html", "x.html", "--instruments", "c.csv"),
            ("--coupled", "--instruments", "c.csv"), ("--motor-side", "--instruments", "c.csv"))),
        (("--coupled", "--motor-side"), "--coupled: would do nothing here; allowed: without --motor-side"),
        (("--accept",), "--accept: would do nothing here; allowed: with --out"),
        (("--html", "x.txt"), "x.txt: ends in '.txt'; allowed: a path in .html"),
        (("--out", "x.csv"), "x.csv: ends in '.csv'; allowed: a path in .toml or .urdf"),
        (("--lock", "joint_2=0", "--out", "x.toml"), "--lock: given, which changes the arm; allowed: a .urdf with"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(refused, two, folder, options, said):
    assert said in refused("identify", "motion", two.file, "log.csv", *options)
    assert not list(folder.iterdir())


def test_an_arm_without_masses_has_no_model_to_write(refused, folder):
    assert "masses and inertias not given" in refused("identify", "motion", "lwr4", "log.csv", "--out", "x.urdf")


@pytest.mark.slow
def test_a_log_without_noise_gives_the_torques_back_and_bodies(recorded, wam, fourier, tmp_path):
    write_log(tmp_path / "log.parquet", fourier(wam, wam.friction))
    found = recorded("identify", "motion", "wam7", tmp_path / "log.parquet")
    assert found["validation"][1]["held_out"] < 0.02 * found["validation"][1]["measured"]
    assert (found["consistent"]["physical"], found["validated_on"]) == ([True] * 7, [])


@pytest.mark.slow
def test_motion_says_what_is_identified_and_what_no_bodies_can_have(lwr_dyn_command, printed, wam, fourier, tmp_path):
    """With noise a third of the parameters and some moments are not to be had from 20 s; bodies near the table are."""
    path, other = tmp_path / "log.parquet", tmp_path / "other.csv"
    write_log(path, SENSORS.through(fourier(wam, wam.friction), 3))
    write_log(other, SENSORS.through(fourier(wam, wam.friction, seed=5), 4))
    command = ("identify", "motion", "wam7", path, "--validate", other)
    code, out, err = lwr_dyn_command(*command, "--json")
    found = json.loads(out)
    known = [p for p in found["parameters"] if p["identified"]]
    assert (code, len(known)) == (0, found["identified"])
    assert 38 < len(known) < 60
    assert all(abs(p["value"]) > p["three_sigma"] for p in known)
    assert {p["state"] for p in found["parameters"]} <= {"identified", "not excited", "0 within 3 sigma"}
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
    for words in (
        "impossible: Izz_7 = -", "widened where residuals", "left, unseen", "near the table: 7 of 7 links are bodies",
        f"validation, RMS in N m (N): {other}, which no fit has seen", "not identified yet; what would do it",
    ):  # fmt: skip
        assert words in out


@pytest.mark.slow
def test_gains_are_fitted_and_written_with_the_model(lwr_dyn_command, wam, fourier, tmp_path):
    log = SENSORS.through(fourier(wam, wam.friction), 3)
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


@pytest.mark.slow
def test_a_joint_that_stands_still_is_named_and_the_others_are_fitted(lwr_dyn_command, wam, fourier, tmp_path):
    write_log(tmp_path / "log.csv", fourier(wam, wam.friction, joints=(0, 1, 3, 4, 5, 6)))
    code, out, err = lwr_dyn_command("identify", "motion", "wam7", tmp_path / "log.csv")
    assert (code, "joint 3" in err) == (0, True)
    assert "not determined: this motion does not show it at all" in out


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
