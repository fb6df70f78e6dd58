"""Logs keep what they hold through files, in any unit that is declared; what cannot be used is refused in one line."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import FileAccessError, LogError
from lwr_dyn.identification.friction.identify_friction import identify_friction, identify_friction_files
from lwr_dyn.identification.logs.joint_log import JointLog, log_of_run, read_log, write_log
from lwr_dyn.identification.logs.log_columns import declared_units
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from lwr_dyn.model.friction import symmetric
from tests.identification.simulated import ideal_cruise

FRICTION = [symmetric(2.0, 0.5), symmetric(1.0, 0.3)]


def rows(columns, dq=(0.1, -0.2), count=200):
    """A log as CSV text, columns by name -> values."""
    log = ideal_cruise(FRICTION, dq, duration=count / 100)
    values = {"time": log.t, "q1": log.q[:, 0], "q2": log.q[:, 1], "tau1": log.tau[:, 0], "tau2": log.tau[:, 1]}
    values |= columns(values) if callable(columns) else columns
    lines = [",".join(values)]
    return (
        "\n".join(lines + [",".join(repr(float(x)) for x in row) for row in zip(*values.values(), strict=True)]) + "\n"
    )


def changed(text, line, cell, value):
    lines = text.splitlines()
    cells = lines[line].split(",")
    cells[cell] = value
    lines[line] = ",".join(cells)
    return "\n".join(lines) + "\n"


GOOD = rows({})
STILL = rows({}, dq=(0.0, 0.0))
BAD = {
    "empty": ("", "head: the file is empty; needed: a line of column names"),
    "head only": ("time,q1,tau1\n", "rows: none below the column names"),
    "no torque": (GOOD.replace("tau2", "current"), "columns: tau2 missing; the file has time, q1, q2, tau1, current"),
    "no time": (GOOD.replace("time", "clock"), "columns: time missing"),
    "twice": (GOOD.replace("q2", "q1"), "column q1: stands twice; needed: each column once"),
    "unknown unit": (
        GOOD.replace("q1", "q1 [turns]"),
        "column q1 [turns]: unit [turns]; needed: one of rad, deg, m, mm",
    ),
    "text": (changed(GOOD, 17, 3, "n/a"), "row 17 (line 18), column tau1: 'n/a'; needed: a number"),
    "empty cell": (changed(GOOD, 17, 3, ""), "row 17 (line 18), column tau1: empty; needed: a number"),
    "nan": (changed(GOOD, 17, 2, "nan"), "row 17 (line 18), column q2: nan; needed: finite numbers"),
    "infinite": (changed(GOOD, 5, 4, "-inf"), "row 5 (line 6), column tau2: -inf; needed: finite numbers"),
    "short row": (GOOD + "2.5,0\n", "row 202 (line 203): not as many cells as columns; needed: 5 cells in every row"),
    "long row": (changed(GOOD, 17, 1, "0,1"), "row 17 (line 18): 6 cells; needed: 5 cells in every row"),
    "long last row": (GOOD + "2.5,0,0,0,0,7", "row 202 (line 203): 6 cells; needed: 5 cells in every row"),
    "unsorted": (changed(GOOD, 17, 0, "0.1"), "row 17 (line 18), column time: 0.1 s goes back by 0.05 s"),
    "repeated": (changed(GOOD, 17, 0, "0.15"), "row 17 (line 18), column time: 0.15 s repeats the time before"),
    "ms as s": (
        rows(lambda v: {"time": 1e3 * v["time"]}),
        "column time: 10 s from row to row, as [s] is declared; needed: "
        "5e-05 to 0.5 s; declare the unit it is in (ms would fit)",
    ),
    "s as ms": (GOOD.replace("time", "time [ms]"), "column time: 1e-05 s from row to row, as [ms] is declared"),
    "deg as rad": (
        rows(lambda v: {"q1": np.degrees(v["q1"] + 1)}),
        "column q1: 57.3 to 68.75 rad, as [rad] is declared; needed: within 3 turns",
    ),
    "speed in deg/s": (
        rows(lambda v: {"dq1": np.full(201, np.degrees(0.1)), "dq2": np.full(201, np.degrees(-0.2))}),
        "column dq1: 57.3 times the slope of q1, as [rad/s] and [rad] are declared",
    ),
    "one row": ("time,q1,tau1\n0,0,0\n", "rows: 1; needed: a recording of at least a second"),
    "no cruise": (STILL, "columns q1, q2: no cruise in 2 s, 201 rows; needed: 0.5 s at constant speed"),
    "short cruise": (rows({}, count=80), "column q1: the longest cruise takes 0.4 s; needed: 0.5 s at constant speed"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_log_that_cannot_be_used_is_refused_in_one_line_and_the_good_ones_count(name, tmp_path):
    text, message = BAD[name]
    bad = tmp_path / "bad.csv"
    bad.write_text(text)
    good = []
    for i, dq in enumerate([(0.1, 0.1), (0.2, 0.2), (-0.1, -0.1), (-0.2, -0.2)]):
        good.append(tmp_path / f"good_{i}.csv")
        good[-1].write_text(rows({}, dq))
    found = identify_friction_files([good[0], bad, *good[1:]])
    (fault,) = found.faults
    assert str(fault).startswith(f"{bad}: ")
    assert message in str(fault)
    assert "\n" not in str(fault)
    assert isinstance(fault, LogError)
    assert len(found.fits) == 4
    assert found.friction()[1].positive.coulomb == pytest.approx(2.0)


def test_limits_of_a_robot_reveal_degrees_and_millinewtons(wam, tmp_path):
    log = ideal_cruise(wam.friction, np.full(7, 0.1), wam)
    path = tmp_path / "log.csv"
    write_log(path, JointLog("", log.joints, log.t, np.degrees(log.q), log.tau))
    with pytest.raises(
        LogError, match=r"column q1: 0 to 11.46 rad, as .rad. is declared; needed: -2.6 to 2.6.*deg would fit"
    ):
        read_log(path, arm=wam)
    write_log(path, JointLog("", log.joints, log.t, log.q, 1e3 * log.tau))
    with pytest.raises(
        LogError,
        match=r"column tau1: reaches 4622 N m, as .N m. is declared; needed: at most 3 t.*mN m would fit",
    ):
        read_log(path, arm=wam)
    write_log(path, JointLog("", (1, 2), log.t, log.q[:, :2], log.tau[:, :2]))
    with pytest.raises(LogError, match=r"columns: joints 1, 2; needed: q1..q7 and tau1..tau7, the joints of wam7"):
        read_log(path, arm=wam)
    path.write_text(path.read_text().replace("q1 [rad]", "q1 [mm]"))
    with pytest.raises(LogError, match="columns: joints 1, 2"):
        read_log(path, arm=wam)


def test_a_slide_may_be_long_where_no_robot_says_its_limits(tmp_path):
    path = tmp_path / "log.csv"
    long = rows(lambda x: {"q1": x["q1"] + 40.0})
    path.write_text(long.replace("q1", "q1 [m]", 1).replace("tau1", "tau1 [N]", 1))
    assert read_log(path).q[:, 0].min() > 39.0
    path.write_text(long)
    with pytest.raises(LogError, match="within 3 turns"):
        read_log(path)


def test_sliding_units_do_not_fit_a_turning_joint(wam, tmp_path):
    path = tmp_path / "log.csv"
    write_log(path, ideal_cruise(wam.friction, np.full(7, 0.1), wam))
    path.write_text(path.read_text().replace("q3 [rad]", "q3 [mm]"))
    with pytest.raises(LogError, match=r"column q3: \[mm\], but the joint turns; needed: rad, deg, N m for a turning"):
        read_log(path, arm=wam)


def test_one_direction_and_one_speed_are_too_little_for_that_joint_only():
    logs = [ideal_cruise(FRICTION, dq, source=f"run {i}") for i, dq in enumerate([(0.1, 0.1), (0.2, 0.2), (0.1, -0.2)])]
    found = identify_friction(logs)
    assert [(f.joint, f.sign) for f in found.fits] == [(1, 1), (2, 1)]
    one_way, one_speed = (str(f) for f in found.faults)
    assert one_way == (
        "run 0, run 1, run 2: column q1: no cruise in the negative direction; "
        "needed: cruises at two or more speeds in either direction"
    )
    assert (
        "run 2: column q2, negative direction: 1 speed (0.2 to 0.2 rad/s) in 1 cruise; needed: two or more" in one_speed
    )


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_files_keep_every_bit(suffix, tmp_path):
    log = LogSensors(0.05, 1e-5, 1e-6).through(ideal_cruise(FRICTION, (0.1, -0.2)), 1)
    log = JointLog(log.source, log.joints, log.t, log.q, log.tau, np.gradient(log.q, 0.01, axis=0))
    write_log(tmp_path / f"log{suffix}", log)
    back = read_log(tmp_path / f"log{suffix}")
    for name in ("t", "q", "tau", "dq"):
        assert (getattr(back, name) == getattr(log, name)).all()
    assert back.joints == (1, 2)


def test_units_become_si_from_the_name_or_from_what_is_declared(tmp_path):
    log = ideal_cruise(FRICTION, (0.1, -0.2))
    text = rows({"time": 1e3 * log.t, "q1": np.degrees(log.q[:, 0]), "q2": np.degrees(log.q[:, 1])})
    (tmp_path / "declared.csv").write_text(text)
    head, _, body = text.partition("\n")
    head = head.replace("time", "time [ms]").replace("q1", "q1 [deg]").replace("q2", " q2[deg]")
    (tmp_path / "named.csv").write_text(f"# made by hand\n{head},note\n" + body.replace("\n", ",-\n"))
    for name, units in (("declared", declared_units("time=ms,q=deg")), ("named", None)):
        back = read_log(tmp_path / f"{name}.csv", units)
        assert np.abs(back.q - log.q).max() < 1e-15
        assert np.abs(back.t - log.t).max() < 1e-15


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda p: read_log(p / "none.csv"), "no such file or directory"),
        (lambda p: read_log(p / "none.parquet"), "no such file or directory"),
        (lambda p: read_log(p / "log.txt"), "ends in '.txt'; allowed: a log that ends in .csv or .parquet"),
        (lambda p: read_log(p / "broken.parquet"), "not a whole Parquet file"),
        (lambda p: read_log(p), "ends in"),
        (lambda p: write_log(p / "log.txt", ideal_cruise(FRICTION, (0.1, 0.1))), "allowed: a path that ends in .csv"),
    ],
)
def test_files_that_are_none(call, message, tmp_path):
    (tmp_path / "broken.parquet").write_bytes(b"PAR1 and then nothing")
    with pytest.raises(FileAccessError, match=message):
        call(tmp_path)


def test_a_unit_declared_against_the_file_is_refused(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(GOOD.replace("q1", "q1 [deg]"))
    with pytest.raises(LogError, match=r"column q1 \[deg\]: \[deg\] in the file, rad declared; needed: one unit"):
        read_log(path, {"q": "rad"})


def test_an_arm_of_wider_joints_is_not_taken_for_degrees(wam, tmp_path):
    log = ideal_cruise(wam.friction, np.full(7, 0.1), wam)
    write_log(tmp_path / "log.csv", JointLog("", log.joints, log.t, log.q + 2.7 * np.eye(7)[0], log.tau))
    with pytest.raises(LogError, match=r"column q1: .*the limits of joint_1; .*or take the robot") as wrong:
        read_log(tmp_path / "log.csv", arm=wam)
    assert "deg" not in str(wrong.value)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    arm = lwr_dyn.load("lwr4plus")
    start, end = np.zeros(7), np.full(7, 0.5)
    move = lwr_dyn.reference("point-to-point", arm, start=start, end=end, duration=0.5)
    found = lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), move)
    path = tmp_path_factory.mktemp("run") / "run.npz"
    found.save(path)
    return found, path


def test_a_run_file_is_read_at_each_sample_with_the_torque_around_it(run):
    found, path = run
    log = read_log(path, arm=lwr_dyn.load("lwr4plus"))
    mine = log_of_run(found, 1000.0)
    assert (log.source, log.joints) == (str(path), tuple(range(1, 8)))
    assert (log.t == found.t).all()
    assert (log.q == found.q).all()
    assert (log.tau == mine.tau).all()
    held, k = found.tau_applied, 100
    assert log.tau[k] == pytest.approx((held[k - 1] + held[k]) / 2)
    assert np.abs(log.tau - held).max() > 1e-3


def test_another_robot_s_run_and_what_a_run_does_not_have_are_refused(run, tmp_path):
    _, path = run
    with pytest.raises(LogError, match="joints 1, 2, 3, 4, 5, 6, 7"):
        read_log(path, arm=lwr_dyn.load("kr30ha"))
    with pytest.raises(LogError, match=r"no qm1.. in a run"):
        read_log(path, needs=("qm", "i"))
    (tmp_path / "x.npz").write_bytes(b"no run")
    with pytest.raises(FileAccessError, match=r"x\.npz"):
        read_log(tmp_path / "x.npz")
