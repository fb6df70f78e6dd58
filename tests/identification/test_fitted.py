"""A fitted arm goes out as a data file and as a URDF, and every command takes it; a share of the count of such."""

import hashlib
import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.checks.arm.model_laws import fit_verdicts
from lwr_dyn.foundation.errors import FileAccessError, MissingDataError
from lwr_dyn.foundation.files import write_folder
from lwr_dyn.identification import fitted, fitted_files, log_digests
from lwr_dyn.identification.logs.joint_log import read_log, write_log
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.identification.motion.motion_result import MotionRule, expected
from lwr_dyn.identification.regression.samples import SampleRule
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.friction import friction_torque
from tests.identification.model_study import study
from tests.identification.plants import perturbed_plant, random_motion, simulated_log

NOISE = 0.1


def fit(robot, reading, folder, rule=MotionRule(), seconds=8.0, form="directions", stribeck=None):  # noqa: B008
    arm, paper = load_with_paper(robot, reading)
    rng = np.random.default_rng(1)
    plant = perturbed_plant(TorqueColumns(arm.chain, form, stribeck), arm, rng)
    path = folder / ("moves.csv" if robot == "lwr4plus" else f"{robot}.csv")
    log = simulated_log(plant, random_motion(arm, seconds, rng, rate=250.0), NOISE, rng, 1e-5, str(path))
    write_log(path, log)
    return identify_motion([log], arm, rule), paper


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fitted")


@pytest.fixture(scope="module")
def lwr(folder):
    result, paper = fit("lwr4plus", "physical", folder)
    fitted_files.write_fitted(folder / "arm.toml", result, paper)
    return result, paper


def torques(arm, states):
    q, dq, ddq = states
    return lwr_dyn.dynamics_of(arm, "newton-euler").inverse_dynamics(q, dq, ddq)


def random_states(n):
    return np.random.default_rng(4).uniform(-1.0, 1.0, (3, 6, n))


def check_agreement(result, arm):
    """The written arm's torques are those of the fit's parameters, friction included."""
    states = random_states(arm.n)
    parameters, columns = result.consistent.parameters, result.columns
    predicted = columns(*states) @ parameters
    total = torques(arm, states) + friction_torque(arm.friction_models(), states[1])
    assert np.abs(total - predicted).max() < 1e-11 * np.abs(predicted).max()


def test_a_data_file_has_the_torques_of_the_fit(lwr, folder):
    arm = lwr_dyn.load(folder / "arm.toml")
    check_agreement(lwr[0], arm)
    assert (arm.reading, arm.name, arm.digest == "") == ("fitted", "lwr4plus", False)
    assert all(np.linalg.eigvalsh(link.body.inertia_com)[0] > 0.0 for link in arm.chain.links)
    own = lwr[0].arm
    assert np.array_equal([arm.lower, arm.upper, arm.effort], [own.lower, own.upper, own.effort])
    assert arm.elasticity.stiffness.tolist() == own.elasticity.stiffness.tolist()


def read(path):
    return tomllib.loads(path.read_text(encoding="utf-8"))


def test_numbers_have_kind_error_and_logs_with_digests(lwr, folder):
    result, paper = lwr
    raw = read(folder / "arm.toml")
    for table, column in (("inertial", "mass"), ("inertial", "com"), ("inertial", "inertia"), ("rotors", "inertia"),
                          ("friction", "positive_coulomb"), ("friction", "negative_viscous")):  # fmt: skip
        cells = raw[table][column]
        assert (cells["kind"], "moves.csv" in cells["where"]) == ("fitted", True)
        assert np.shape(cells["sigma"]) == np.shape(cells["values"])
    masses = raw["inertial"]["mass"]["sigma"]
    assert masses == ["unknown" if sigma is None else sigma for sigma in result.shown_sigma[0:70:10]]
    assert masses[0] == "unknown"  # no torque of an arm on a floor shows it: it is the table's
    assert masses[3] == result.consistent.sigma[30]
    document = raw["document"]
    assert hashlib.sha256((folder / "moves.csv").read_bytes()).hexdigest() in document["logs"]
    assert all(words in document["origin"] for words in (f"reading physical of {paper.file}", paper.digest))
    for name in (f"{table}.{name}" for table in ("dh", "limits", "frames") for name in raw[table]):
        if name != "dh.convention":
            was, (table, own) = paper.columns[name], name.split(".")
            column = raw[table][own]
            assert (column["kind"], column["where"].startswith(was.where)) == (was.kind, True)
    assert "table2-rows" in raw["frames"]["origin"]["where"]


def test_errors_of_centres_of_mass_are_those_of_draws(lwr):
    values, result = fitted.fitted_values(lwr[0]), lwr[0]
    assert values.where == "fitted to moves.csv; digests in [document]"
    assert values.covered == pytest.approx(np.where(result.samples.used, np.abs(result.samples.dq), 0.0).max(axis=0))
    root = np.linalg.cholesky(result.consistent.covariance[30:34, 30:34])
    draws = result.consistent.parameters[30:34] + np.random.default_rng(0).normal(size=(4000, 4)) @ root.T * 0.1
    assert (draws[:, 1:] / draws[:, :1]).std(axis=0) == pytest.approx(0.1 * values.com.sigma[3], rel=0.06)


def test_errors_of_friction_and_how_it_was_fitted_are_those_of_the_fit(lwr):
    result, values = lwr[0], fitted.fitted_values(lwr[0])
    fit, names, sigma = result.consistent, result.columns.names, values.friction_sigma
    for name, column in (("positive_coulomb", "coulomb+"), ("negative_viscous", "viscous-")):
        at = [names.index(f"{column}_{j}") for j in range(1, 8)]
        assert sigma[name] == pytest.approx(np.sqrt(np.diag(fit.covariance)[at]))
    assert sigma["positive_static"] == pytest.approx(sigma["positive_coulomb"])  # no Stribeck term
    assert np.isnan(sigma["offset"]).all()
    head = (
        f"bodies near reading physical, expected off it {expected(fit)}, {result.equations} equations, "
        f"{result.identified} of {result.base.count} base parameters identified, friction directions"
    )
    tail = (
        f", positions through {result.rule.samples.cutoff} Hz, price {np.nanmax(fit.price.rms):.2g} N m (N) RMS at the "
        "worst joint; sigma: one standard error, unknown where the number is that of the table"
    )
    assert values.about == head + tail
    more = replace(result, rule=replace(result.rule, stribeck=True, gains=0.1))
    assert fitted.fitted_values(more).about == f"{head} with Stribeck terms, gains known to 0.1{tail}"


def test_a_urdf_has_the_same_bodies_and_its_sidecar_the_errors(lwr, folder):
    result, _ = lwr
    files = fitted_files.write_fitted(folder / "arm.urdf", result, None)
    assert [file.name for file in files] == ["arm.urdf", "arm.provenance.json", "arm.srdf", "arm.xml"]
    arm = lwr_dyn.load(folder / "arm.urdf")
    states = random_states(7)
    bodies = torques(lwr_dyn.load(folder / "arm.toml"), states)
    assert np.abs(torques(arm, states) - bodies).max() < 1e-11 * np.abs(bodies).max()
    sidecar = json.loads((folder / "arm.provenance.json").read_text(encoding="utf-8"))
    (mass,) = sidecar["quantities"]["link_3.mass"]
    assert (mass["kind"], mass["sigma"]) == ("fitted", result.consistent.sigma[20])
    assert mass["value"] == result.consistent.parameters[20]
    coulomb = result.consistent.parameters[result.columns.of_joint(1)][1]
    assert sidecar["friction"]["joint_2"]["positive"]["coulomb"] == pytest.approx(coulomb)
    for name in ("viscous", "coulomb"):
        mean = [(x["positive"][name] + x["negative"][name]) / 2 for x in sidecar["friction"].values()]
        assert [getattr(x, name) for x in arm.limits] == pytest.approx(np.maximum(mean, 0.0))


@pytest.mark.slow
def test_an_arm_with_a_motor_map_and_symmetric_friction(folder):
    """The WAM gives rotors at the joints and gains; both ways the same friction with an offset, and a Stribeck term."""
    rule = MotionRule(SampleRule(slowest=0.01), "symmetric", stribeck=True)
    speeds = [np.nan, 0.1, *[np.nan] * 5]
    result, paper = fit("wam7", None, folder, rule, 8.0, "symmetric", speeds)
    fitted_files.write_fitted(folder / "wam.toml", result, paper)
    arm = lwr_dyn.load(folder / "wam.toml")
    check_agreement(result, arm)
    assert arm.transmission.matrix.tolist() == result.arm.transmission.matrix.tolist()
    assert arm.gains.Kp.tolist() == result.arm.gains.Kp.tolist()
    friction = read(folder / "wam.toml")["friction"]
    offsets = [result.consistent.sigma[result.columns.of_joint(j)][3] for j in range(7)]
    assert friction["offset"]["sigma"] == pytest.approx(offsets)
    first = result.columns.of_joint(1).start
    coulomb_and_drop = np.ix_([first + 1, first + 4], [first + 1, first + 4])
    assert result.columns.names[first + 4] == "stribeck_2"
    spread = np.sqrt(result.consistent.covariance[coulomb_and_drop].sum())
    assert friction["negative_static"]["sigma"][1] == pytest.approx(spread)
    assert friction["positive_static"]["values"][1] > friction["positive_coulomb"]["values"][1]
    assert friction["positive_stribeck_velocity"]["values"][1] == pytest.approx(0.1, rel=0.5)


def test_rotors_and_friction_that_were_fitted_to_motors_stay_the_source_s(lwr, folder):
    result, paper = lwr
    values = replace(fitted.fitted_values(result), joints=False)
    (folder / "motors.toml").write_text(fitted_files.fitted_paper_text(paper, values), encoding="utf-8")
    of_file, of_values = lwr_dyn.load(folder / "motors.toml"), fitted.fitted_arm(result.arm, values)
    bodies = lwr_dyn.load(folder / "arm.toml").chain.bodies
    for arm in (of_file, of_values):
        assert arm.armature.tolist() == result.arm.armature.tolist()
        assert arm.friction_models() == result.arm.friction_models()
        for body, own in zip(arm.chain.bodies, bodies, strict=True):
            assert (body.mass, body.com.tolist()) == (own.mass, own.com.tolist())
    raw = read(folder / "motors.toml")
    assert "friction" not in raw
    assert raw["rotors"]["inertia"]["kind"] == paper.columns["rotors.inertia"].kind


def test_what_the_log_contradicts_stays_with_the_model_and_fails_its_check(lwr, folder):
    result, paper = lwr
    assert fitted.fitted_values(result).contradicted == result.contradiction == ""
    values = replace(fitted.fitted_values(result), contradicted="m_7 is 9.0 sigma off")
    (folder / "against.toml").write_text(fitted_files.fitted_paper_text(paper, values), encoding="utf-8")
    write_folder(folder / "against", model_files(fitted.fitted_arm(result.arm, values), "against"))
    for arm in (lwr_dyn.load(folder / "against.toml"), lwr_dyn.load(folder / "against/against.urdf")):
        assert arm.caveats.contradicted == "m_7 is 9.0 sigma off"
        assert "contradicted by the log it was fitted to: m_7 is 9.0 sigma off" in arm.caveat()
        (verdict,) = fit_verdicts(arm)
        assert not verdict.holds


def test_a_second_fit_starts_from_the_first_one(lwr, folder):
    arm, paper = load_with_paper(folder / "arm.toml")
    again = identify_motion([read_log(folder / "moves.csv", arm=lwr[0].arm)], arm)
    fitted_files.write_fitted(folder / "again.toml", again, paper)
    title = read(folder / "again.toml")["title"]
    assert title.count("fitted to logs") == 1
    assert again.consistent.scales.centre < 0.5 * lwr[0].consistent.scales.centre  # it has no reason to leave it
    check_agreement(again, lwr_dyn.load(folder / "again.toml"))


@pytest.mark.slow
def test_what_cannot_be_written_is_refused_before_any_work(folder, wam, fourier):
    words = r"the robot comes from a .urdf; allowed: a .urdf, or a robot from a data"
    with pytest.raises(FileAccessError, match=words):
        fitted_files.check_fitted_path(folder / "x.toml", None)
    bare = identify_motion([fourier(wam, wam.friction)], lwr_dyn.load("lwr4"))
    with pytest.raises(MissingDataError, match="masses"):
        fitted_files.write_fitted(folder / "x.toml", bare, open_paper("lwr4"))
    assert not (folder / "x.toml").exists()


def test_the_digest_of_a_folder_is_of_its_files(tmp_path):
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "b").write_bytes(b"2")
    (tmp_path / "bag" / "a").write_bytes(b"1")
    assert log_digests.digest_of(tmp_path / "bag") == hashlib.sha256(b"12").hexdigest()
    assert log_digests.digest_of(tmp_path / "none") == ""


HOLD = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.05")


LINES = (
    ("check", "arm.toml"), ("check", "arm.urdf"), ("lint", "arm.toml"), ("simulate", "arm.toml", *HOLD),
    ("simulate", "arm.urdf", *HOLD), ("urdf", "arm.toml", "--out", "from_toml.urdf"),
    ("sensitivity", "arm.toml", "arm.urdf", "--task", "joint-move", "--rate", "100", "--poses", "5"),
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("line", LINES, ids=lambda line: " ".join(line[:2]))
def test_commands_take_it(line, lwr, folder, monkeypatch, lwr_dyn_command):
    monkeypatch.chdir(folder)
    if not (folder / "arm.urdf").exists():
        fitted_files.write_fitted(folder / "arm.urdf", *lwr)
    code, out, _ = lwr_dyn_command(*line)
    assert (code, bool(out)) == (0, True)


@pytest.mark.slow
def test_identify_motion_writes_it(lwr, folder, monkeypatch, lwr_dyn_command):
    monkeypatch.chdir(folder)
    common = ("identify", "motion", "lwr4plus", "moves.csv", "--reading", "physical", "--out")
    code, out, _ = lwr_dyn_command(*common, "out.toml")
    assert (code, "wrote out.toml; next: lwr-dyn check out.toml" in out) == (0, True)
    assert lwr_dyn.load("out.toml").reading == "fitted"
    for line, words in (
        (("identify", "motion", "lwr4", "moves.csv", "--out", "bare.toml"), "masses and inertias"),
        ((*common, "none/out.toml"), "none"),
        ((*common, "out.sdf"), "out.sdf: ends in '.sdf'; allowed: a path in .toml or .urdf"),
    ):
        code, _, err = lwr_dyn_command(*line)
        assert (code, words in err) == (2, True)


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "reading"), [("lwr4plus", "physical"), ("wam7", None)])
def test_a_share_of_the_count_of_models(robot, reading, tmp_path):
    """`scripts/soak.py fitted_models` takes 60 plants of each."""
    arm, paper = load_with_paper(robot, reading)
    case = study(arm, paper, 7, 6.0, 200.0, NOISE, tmp_path)
    assert case.off < 1e-11
    assert case.physical
    assert case.seen < case.unseen < 1.6
    assert np.abs(case.promises - 1.0).max() < 0.15


@pytest.mark.slow
def test_a_drawn_arm_whose_masses_are_estimates(tmp_path, lwr_dyn_command):
    """The KR 30 HA: solids, a mastering pose, no rotors; its base's mass was what the estimated links left."""
    arm, paper = load_with_paper("kr30ha")
    case = study(arm, paper, 3, 4.0, 200.0, NOISE, tmp_path)
    assert case.off < 1e-11
    found = lwr_dyn.load(tmp_path / "arm.toml")
    assert (found.drawing, found.mastering, found.ratings.base_mass) == (arm.drawing, arm.mastering, None)
    assert lwr_dyn_command("check", str(tmp_path / "arm.toml"))[0] == 0
