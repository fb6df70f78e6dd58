"""Logs keep what they hold through files, in any unit that is declared; what cannot be used is refused in one line."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import FileAccessError, LogError, OptionError
from lwr_dyn.identification.friction.friction_map import map_points
from lwr_dyn.identification.friction.identify_friction import identify_friction_files
from lwr_dyn.identification.log_faults.found_faults import prepared_logs
from lwr_dyn.identification.logs.joint_log import apart_from, digest_of, log_of_run, read_log, write_log
from lwr_dyn.identification.logs.log_columns import declared_units
from lwr_dyn.identification.logs.simulated_logs import LogSensors, cruise_and_back
from lwr_dyn.model.friction import symmetric
from tests.identification.plants import perturbed_plant, random_motion, simulated_log
from tests.identification.simulated import ideal_cruise

FRICTION = [symmetric(2.0, 0.5), symmetric(1.0, 0.3)]


def rows(columns, dq=(0.1, -0.2), count=200):
    """A log as CSV text, columns by name -> values."""
    log = ideal_cruise(FRICTION, dq, duration=count / 100)
    values = {"time": log.t, "q1": log.q[:, 0], "q2": log.q[:, 1], "tau1": log.tau[:, 0], "tau2": log.tau[:, 1]}
    values |= columns(values) if callable(columns) else columns
    cells = zip(*values.values(), strict=True)
    return "\n".join([",".join(values), *(",".join(repr(float(x)) for x in row) for row in cells)]) + "\n"


def changed(text, line, cell, value):
    lines = [row.split(",") for row in text.splitlines()]
    lines[line][cell] = value
    return "\n".join(map(",".join, lines)) + "\n"


GOOD = rows({})
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
    "no cruise": (
        rows({}, dq=(0.0, 0.0)),
        "columns q1, q2: no cruise in 2 s, 201 rows; needed: 0.5 s at constant speed",
    ),
    "short cruise": (rows({}, count=80), "column q1: the longest cruise takes 0.4 s; needed: 0.5 s at constant speed"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_log_that_cannot_be_used_is_refused_in_one_line(name, tmp_path):
    text, message = BAD[name]
    bad = tmp_path / "bad.csv"
    bad.write_text(text)
    with pytest.raises(LogError) as fault:
        map_points(read_log(bad))
    assert str(fault.value).startswith(f"{bad}: ")
    assert message in str(fault.value)
    assert "\n" not in str(fault.value)


def test_beside_a_bad_log_the_good_ones_count(tmp_path):
    paths = [tmp_path / f"{i}.csv" for i in range(5)]
    speeds = [(0.1, 0.1), (0.2, 0.2), (-0.1, -0.1), (-0.2, -0.2)]
    for path, text in zip(paths, ["time", *(rows({}, dq) for dq in speeds)], strict=True):
        path.write_text(text)
    found = identify_friction_files(paths)
    (fault,) = found.faults
    assert (str(fault).startswith(f"{paths[0]}: "), len(found.fits)) == (True, 4)
    assert found.friction()[1].positive.coulomb == pytest.approx(2.0)


def written(path, log, old="", new=""):
    """A log as a file, with some text of it changed."""
    write_log(path, log)
    path.write_text(path.read_text().replace(old, new) if old else path.read_text())
    return path


OF_THE_WAM = {
    "degrees": (
        lambda log: replace(log, q=np.degrees(log.q)), ("", ""),
        "column q1: 0 to 11.46 rad, as [rad] is declared; needed: -2.6 to 2.6, the limits of joint_1; declare the unit "
        "it is in (deg would fit)",
    ),
    "millinewtons": (
        lambda log: replace(log, tau=1e3 * log.tau), ("", ""),
        "column tau1: reaches 4622 N m, as [N m] is declared; needed: at most 3 times 77.3 N m, the limit of joint_1; "
        "declare the unit it is in (mN m would fit)",
    ),
    "two joints": (
        lambda log: replace(log, joints=(1, 2), q=log.q[:, :2], tau=log.tau[:, :2]), ("q1 [rad]", "q1 [mm]"),
        "columns: joints 1, 2; needed: q1..q7 and tau1..tau7, the joints of wam7",
    ),
    "sliding": (
        lambda log: log, ("q3 [rad]", "q3 [mm]"),
        "column q3: [mm], but the joint turns; needed: rad, deg, N m for a turning",
    ),
    "wider": (
        lambda log: replace(log, q=log.q + 2.7 * np.eye(7)[0]), ("", ""),
        "declare the unit it is in, or take the robot that it is a log of",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", OF_THE_WAM)
def test_a_log_that_its_robot_cannot_have_made_is_refused(case, wam, tmp_path):
    change, text, message = OF_THE_WAM[case]
    log = ideal_cruise(wam.friction, np.full(7, 0.1), wam)
    with pytest.raises(LogError) as refused:
        read_log(written(tmp_path / "log.csv", change(log), *text), arm=wam)
    assert message in str(refused.value)


def test_a_slide_may_be_long_where_no_robot_says_its_limits(tmp_path):
    path = tmp_path / "log.csv"
    long = rows(lambda x: {"q1": x["q1"] + 40.0})
    path.write_text(long.replace("q1", "q1 [m]", 1).replace("tau1", "tau1 [N]", 1))
    assert read_log(path).q[:, 0].min() > 39.0
    path.write_text(long)
    with pytest.raises(LogError, match="within 3 turns"):
        read_log(path)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_files_keep_every_bit(suffix, tmp_path):
    log = LogSensors(0.05, 1e-5, 1e-6).through(ideal_cruise(FRICTION, (0.1, -0.2)), 1)
    log = replace(log, dq=np.gradient(log.q, 0.01, axis=0))
    write_log(tmp_path / f"log{suffix}", log)
    back = read_log(tmp_path / f"log{suffix}")
    for name in ("t", "q", "tau", "dq", "joints"):
        assert np.array_equal(getattr(back, name), getattr(log, name))


def test_sensors_add_noise_and_round_to_counts():
    clean = ideal_cruise(FRICTION, (0.1, -0.2), duration=100.0)
    log = LogSensors((0.05, 0.2), 1e-3, 1e-2).through(clean, 1)
    assert (log.tau - clean.tau).std(axis=0) == pytest.approx([0.05, 0.2], rel=0.03)
    assert (log.q - clean.q).std(axis=0) == pytest.approx([1e-2] * 2, rel=0.03)
    assert log.q == pytest.approx(np.round(log.q, 3), abs=1e-12)
    assert np.array_equal(LogSensors((0.05, 0.2), 1e-3, 1e-2).through(clean, 1).q, log.q)
    assert np.array_equal(LogSensors().through(clean, 2).tau, clean.tau)
    geared = replace(clean, motor_q=3.0 * clean.q, dq=clean.q)
    both = LogSensors((0.05, 0.2), 1e-3, 1e-2).through(geared, 1)
    assert (both.dq, np.array_equal(both.q, log.q)) == (None, True)
    off = both.motor_q - geared.motor_q
    assert off.std(axis=0) == pytest.approx([1e-2] * 2, rel=0.03)
    assert np.abs(np.corrcoef(off.T, (log.q - clean.q).T)[:2, 2:]).max() < 0.05
    assert both.motor_q == pytest.approx(np.round(both.motor_q, 3), abs=1e-12)


def test_a_cruise_and_back_has_the_speed_of_its_longest_stroke():
    """Half a metre or rad at 0.2 a second, with blends of a second: 3.5 s each way."""
    arm, start = lwr_dyn.load("lwr4plus"), np.array([0.1, 0.2, 0.0, -0.5, 0.0, 0.3, 0.0])
    stroke = np.array([0.25, -0.5, 0.0, 0.1, 0.0, 0.0, 0.0])
    move = cruise_and_back(arm, start, stroke, 0.2)
    found = move.sample(np.array([0.0, 1.0, 2.5, 3.5, 4.5, 6.0, 7.0]))
    assert move.duration == pytest.approx(7.0)
    np.testing.assert_allclose(found.q[[0, 3, 6]], [start, start + stroke, start], atol=1e-12)
    np.testing.assert_allclose(found.dq[[1, 2, 4, 5]], np.outer([1, 1, -1, -1], 0.2 * stroke / 0.5), atol=1e-12)


def test_units_become_si_from_the_name_or_from_what_is_declared(tmp_path):
    log = ideal_cruise(FRICTION, (0.1, -0.2))
    speeds = {"dq1": np.full(201, 0.1), "dq2": np.full(201, -0.2)}
    text = rows({"time": 1e3 * log.t, "q1": np.degrees(log.q[:, 0]), "q2": np.degrees(log.q[:, 1]), **speeds})
    (tmp_path / "declared.csv").write_text(text)
    head, _, body = text.partition("\n")
    head = head.replace("time", "time [ms]").replace(",q1", ",q1 [deg]").replace(",q2", ", q2[deg]")
    (tmp_path / "named.csv").write_text(f"# made by hand\n{head},note\n" + body.replace("\n", ",-\n"))
    for name, units in (("declared", declared_units("time=ms,q=deg")), ("named", None)):
        back = read_log(tmp_path / f"{name}.csv", units)
        assert max(np.abs(back.q - log.q).max(), np.abs(back.t - log.t).max()) < 1e-15


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


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: declared_units("q=turns"), "units of q: 'turns'; allowed: rad, deg, m, mm"),
        (lambda: declared_units("speed=1"), "units: 'speed=1'; allowed: QUANTITY=UNIT with time, q, dq, tau"),
        (lambda: LogSensors(-1.0), "log torque noise: -1.0; allowed: a number >= 0"),
        (lambda: LogSensors(resolution=np.inf), "log resolution: inf; allowed: a number >= 0"),
    ],
)
def test_options_outside_what_is_allowed(call, message):
    with pytest.raises(OptionError, match=message):
        call()


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
    log, held, k = read_log(path, arm=lwr_dyn.load("lwr4plus")), found.tau_applied, 100
    assert (log.source, log.joints) == (str(path), tuple(range(1, 8)))
    for name, values in (("t", found.t), ("q", found.q), ("tau", log_of_run(found, 1000.0).tau)):
        assert np.array_equal(getattr(log, name), values)
    assert np.array_equal(log_of_run(found, 250.0).q, found.q[::4])
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


@pytest.fixture(scope="module")
def pair(lwr, columns):
    plant, rng = perturbed_plant(columns, lwr, np.random.default_rng(1), 0.05), np.random.default_rng(2)
    return [simulated_log(plant, random_motion(lwr, 4.0, rng, rate=200.0), 0.1, rng, 1e-5) for _ in range(2)]


@pytest.fixture
def files(pair, tmp_path):
    """a.csv, b.csv, and copies of a."""
    for name, log in zip(("a.csv", "b.csv", "copy.csv", "copy.parquet"), [*pair, pair[0], pair[0]], strict=True):
        write_log(tmp_path / name, log)
    return tmp_path


def test_a_digest_is_of_what_was_measured_and_that_cannot_be_changed(pair):
    one, other = pair
    assert not any(array.flags.writeable for array in (one.t, one.q, one.tau))
    touched = one.tau.copy()
    touched[-1, -1] = np.nextafter(touched[-1, -1], np.inf)
    assert digest_of(one) == digest_of(replace(one, source="elsewhere", t=one.t + 7.0, dq=one.q))
    shorter = replace(one, t=one.t[:-1], q=one.q[:-1], tau=one.tau[:-1])
    differ = [one, other, replace(one, tau=touched), shorter, replace(one, current=one.q)]
    assert len({digest_of(log) for log in differ}) == 5


def test_a_copy_is_left_out_and_said(files, pair):
    a, b = files / "a.csv", files / "b.csv"
    assert not prepared_logs([a, b]).errors
    same = f"the same as those of {a}"
    for copy, said in ((files / "copy.csv", same), (files / "copy.parquet", same), (a, "given twice")):
        found = prepared_logs([a, b, copy])
        assert [log.source for log in found.logs] == [str(a), str(b)]
        assert [str(fault) for fault in found.errors] == [f"{copy}: rows: {said}; needed: each recording once"]
    assert apart_from(pair, [pair[1]], "which is fitted")[0] == [pair[0]]


SLOWEST = "no joint is faster than --slowest 1e+09 (rad/s or m/s); needed: a slowest far below the speeds"
COPIES = {
    "validation": (
        ("motion", "a.csv", "b.csv", "--validate", "copy.csv"),
        "{copy}: rows: the same as those of {a}, which is fitted; needed: logs that the fit does not see",
    ),
    "load": (
        ("payload", "a.csv", "--without", "copy.csv"),
        "the same as those of {a}, which is with the load; needed: logs without the load",
    ),
    "friction": (
        ("friction", "a.csv", "copy.csv"), "{copy}: rows: the same as those of {a}; needed: each recording once"
    ),
    "slowest": (("motion", "a.csv", "--slowest", "1e9"), SLOWEST),
}  # fmt: skip


@pytest.mark.parametrize("case", [pytest.param(x, marks=pytest.mark.slow if x in ("validation", "load") else ())
                                  for x in COPIES])  # fmt: skip
def test_commands_take_each_log_once_and_name_the_cause_of_no_equations(case, files, lwr_dyn_command):
    (command, *arguments), message = COPIES[case]
    given = [str(files / x) if x.endswith("csv") else x for x in arguments]
    code, _, err = lwr_dyn_command("identify", command, "lwr4plus", "--reading", "physical", *given)
    assert (code, message.format(a=files / "a.csv", copy=files / "copy.csv") in err) == (2, True), err
