"""Designed motions: executable, better than random ones, what stands against them; as files."""

import dataclasses
import json
import re

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.column_files import NOTES
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError
from lwr_dyn.foundation.tables import json_text
from lwr_dyn.identification.excitation import design, motion_design
from lwr_dyn.identification.excitation.design import (
    NoMotionError,
    design_excitation,
    ended_words,
    rows_of,
    sigma_table,
    use_table,
)
from lwr_dyn.identification.excitation.motion_file import run_of_excitation, write_excitation
from lwr_dyn.identification.excitation.motion_limits import MotionLimits, clearance_of
from lwr_dyn.identification.excitation.objectives import fourier_basis, motion_score
from lwr_dyn.identification.logs.joint_log import read_log
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.model.run import Run
from lwr_dyn.trajectory.references.recorded_motion import csv_reference

SHORT = {"duration": 5.0, "starts": 1, "harmonics": 2}


@pytest.fixture(scope="module")
def designed(lwr):
    return design_excitation(lwr, starts=1)


@pytest.fixture(scope="module")
def slender(designed):
    return design_excitation(designed.arm, starts=1, objective="cond")


def _best_random(arm, columns, count):
    """The best scores of random motions that fill the limits and are clear at 100 Hz."""
    rng, limits, space = np.random.default_rng(9), MotionLimits.of(arm), clearance_of(arm)
    basis, scores = fourier_basis(10.0, 5, 1000), []
    while len(scores) < count:
        X = rng.normal(size=(basis.count, arm.n))
        X[0] = rng.uniform(limits.lower, limits.upper)
        X = limits.fitted(X, basis, fill=True)
        if space.of(basis.position @ X).min() > 0.0:
            scores.append(motion_score(columns, rows_of(basis.motion(X)), np.full(arm.n, 0.1)))
    return min(s.d for s in scores), min(s.condition for s in scores)


@pytest.mark.parametrize("fixture", ["designed", pytest.param("slender", marks=pytest.mark.slow)])
def test_it_is_executable_at_1_khz(fixture, request, lwr):
    found = request.getfixturevalue(fixture)
    m, limits = found.sampled(1000.0), MotionLimits.of(lwr)
    assert len(m.t) == 10001
    assert max(np.abs(m.dq[[0, -1]]).max(), np.abs(m.ddq[[0, -1]]).max()) < 1e-10
    assert ((m.q >= limits.lower - 1e-9) & (m.q <= limits.upper + 1e-9)).all()
    assert (np.abs(m.dq) <= limits.speed + 1e-9).all()
    tau = lwr_dyn.dynamics_of(lwr, "newton-euler").inverse_dynamics(m.q, m.dq, m.ddq)
    assert (np.abs(tau) <= 0.8 * lwr.effort).all()
    middle, half = (lwr.upper + lwr.lower) / 2.0, (lwr.upper - lwr.lower) / 2.0
    for use, share in (
        (found.torque_use, np.abs(tau) / lwr.effort), (found.speed_use, np.abs(m.dq) / lwr.velocity),
        (found.position_use, np.abs(m.q - middle) / half),
    ):  # fmt: skip
        assert use == pytest.approx(share.max(axis=0), rel=1e-9)
    distances = clearance_of(lwr, kept=0.0)
    nearest = distances.of(m.q)
    assert nearest.min() >= 0.05
    assert found.clear == pytest.approx(nearest.min(), abs=1e-9)
    assert found.nearest == distances.names[nearest.min(axis=0).argmin()]


OF_A_KIND = {"masses": "m_", "first moments": r"m[xyz]_", "tensors": "I", "armature": "armature", "coulomb": "coulomb",
             "viscous": "viscous", "offset": "offset"}  # fmt: skip


def test_its_document_says_what_it_shows_uses_and_knows(designed, lwr):
    score, document, q = designed.score, designed.document, np.degrees(designed.sampled().q)
    with pytest.raises(OptionError, match=r"rate: 0\.0"):
        designed.sampled(0.0)
    own = designed.columns.base().of(designed.columns.own(lwr))
    assert document.text().splitlines()[:5] == [
        "lwr4plus, reading physical: 10 s at rest at both ends, 5 harmonics, objective d, best of 1 start in "
        f"{designed.seconds:.1f} s",
        f"-log det of the information per parameter: {score.d:.3f} (69 base parameters)",
        f"geometric mean of their sigmas: {score.mean_sigma:.3g} (SI)",
        f"condition number of the scaled columns: {score.condition:.2f}",
        f"checked at 1 kHz: at least {designed.clear:.3f} m between {designed.nearest}",
    ]
    uses = [[f"{x:.0f} %" for x in 100 * getattr(designed, f"{of}_use")] for of in ("position", "speed", "torque")]
    ranges = [f"{low:.4g} to {high:.4g} deg" for low, high in zip(q.min(axis=0), q.max(axis=0), strict=True)]
    assert use_table(designed).cells == tuple(zip(lwr.joint_names, ranges, *uses, strict=True))
    assert score.mean_sigma == pytest.approx(np.exp(np.log(score.sigma).mean()))
    rows = []
    for kind, begins in OF_A_KIND.items():
        at = [i for i, name in enumerate(score.names) if re.match(begins, name)]
        if at:
            sigma, worst = score.sigma[at], max(at, key=lambda i: score.sigma[i])
            rows.append((kind, len(at), np.median(sigma), sigma.max(), score.names[worst], np.abs(own[at]).max()))
    assert sigma_table(designed).rows == tuple(rows)
    assert sigma_table(designed).title == "Sigma from torque noise of 0.1 N m, 100 rows a second"
    record, motion, start = document.record(), designed.motion, designed.starts[0]
    rows = zip(score.names, designed.columns.base().statements(), own, score.sigma, strict=True)
    assert [tuple(row.values()) for row in record.pop("parameters")] == [*rows]
    assert json.loads(json_text(record)) == {
        "robot": "lwr4plus", "reading": "physical", "duration": 10.0, "harmonics": 5, "objective": "d",
        "noise": [0.1] * 7, "seconds": designed.seconds, "ended": "searched", "may_be_run": True, "caveats": [],
        "faults": [], "d": score.d, "mean_sigma": score.mean_sigma, "condition": score.condition, "check_rate": 1000.0,
        "clearance": designed.clear, "nearest": designed.nearest,
        "series": {key: getattr(motion, key).tolist() for key in ("centre", "sines", "cosines")},
        "joints": [dict(zip(("joint", "position", "speed", "torque"), row, strict=True)) for row in zip(
            lwr.joint_names, designed.position_use, designed.speed_use, designed.torque_use, strict=True)],
        "starts": [{"value": start.value, "clearance": start.clear, "seconds": start.seconds}],
    }  # fmt: skip


@pytest.mark.slow
def test_each_objective_is_best_at_its_own_and_both_beat_random_motions(designed, slender, lwr):
    d, condition = _best_random(lwr, designed.columns, 20)
    assert np.exp((d - designed.score.d) / 2.0) > 1.5
    assert condition / slender.score.condition > 1.7
    assert designed.score.d < slender.score.d - 0.4
    assert slender.score.condition < designed.score.condition / 1.5


@pytest.mark.slow
def test_the_same_seed_gives_the_same_motion_and_another_one_another(lwr):
    one, same, other = (design_excitation(lwr, **SHORT, seed=s).motion for s in (3, 3, 4))
    assert np.array_equal(one.sines, same.sines)
    assert not np.allclose(one.sines, other.sines, atol=1e-2)


@pytest.mark.slow
def test_torques_bind_where_motors_are_weak(lwr):
    need = design_excitation(lwr, **SHORT).torque_use[1]
    weak = [dataclasses.replace(x, effort=(0.9 * need if j == 1 else 1.0) * x.effort) for j, x in enumerate(lwr.limits)]
    found = design_excitation(dataclasses.replace(lwr, limits=tuple(weak)), **SHORT)
    assert need > 0.2
    assert found.torque_use[1] <= 0.8


def test_a_motion_that_is_not_clear_is_refused_with_the_pair_and_kept_in_the_error(lwr, monkeypatch):
    short = motion_design.Resolution(8, 8, 4, 1e-3, np.inf, np.inf)  # searches where nothing is feasible are slow
    monkeypatch.setattr(motion_design, "COARSE", short)
    monkeypatch.setattr(motion_design, "FINE", short)
    monkeypatch.setattr(design, "check_room", lambda *_: None)  # which refuses before any search
    clearance = clearance_of(lwr, kept=0.6)
    words = (
        r"excitation of lwr4plus: in the best of 1 start .* and .* are .* m too near at .* s: 0\.6 m .*; allowed: more"
    )
    with pytest.raises(NoMotionError, match=words) as refused:
        design_excitation(lwr, **SHORT, clearance=clearance)
    best = refused.value.best
    nearest = clearance.of(best.sampled(1000.0).q[:-1])
    assert nearest.min() == pytest.approx(best.clear - 0.6, abs=1e-12)
    assert best.faults[0].startswith(best.nearest)
    assert "DO NOT RUN IT: " + best.faults[0] in best.document.text()
    assert best.document.record()["may_be_run"] is False


@pytest.mark.slow
def test_two_links_that_are_never_far_apart_do_not_stop_the_search(iiwa):
    found = design_excitation(iiwa, starts=1)  # as long and of as many harmonics as the random motions
    assert (found.faults, found.ended) == ((), "searched")
    assert clearance_of(iiwa).of(found.sampled(1000.0).q).min() >= 0.0
    assert "link_5 and link_3 are never far apart: they keep 0.01" in found.document.text()
    assert found.score.d < _best_random(iiwa, found.columns, 5)[0]


@pytest.mark.slow
def test_a_search_ends_with_its_time_and_has_a_motion(lwr):
    kept, said = [], []
    found = design_excitation(lwr, starts=500, seconds=3.0, better=kept.append, report=said.append)
    assert (found.ended, found.faults, 1 <= len(found.starts) < 500) == ("seconds", (), True)
    words = f"ended early (its time was over): {len(found.starts)} of 500 starts searched; the best motion so far"
    assert ended_words(found) == words
    assert words in found.document.text()
    assert kept
    assert [x.score.d for x in kept] == sorted((x.score.d for x in kept), reverse=True)
    assert all(x.faults == () for x in kept)
    assert found.starts[0].value >= min(x.value for x in found.starts)
    shares = [x for x in said if not isinstance(x, str)]
    assert said[0] == "start 1 of 500"
    assert any("best starts" in x for x in said if isinstance(x, str))
    assert shares == sorted(shares)
    assert len(shares) > 10


@pytest.mark.slow
def test_a_search_that_is_asked_to_stop_has_the_best_so_far(lwr):
    begun = []
    one = design_excitation(lwr, **SHORT)
    found = design_excitation(
        lwr, 5.0, starts=3, harmonics=2, stop=lambda: len(begun) > 1,
        report=lambda x: begun.append(x) if isinstance(x, str) else None,
    )  # fmt: skip
    assert begun == ["start 1 of 3", "start 2 of 3"]
    assert (found.ended, len(found.starts), found.faults) == ("stopped", 2, ())
    assert found.starts[0].value == one.starts[0].value


@pytest.mark.slow
def test_any_arm_sliding_joints_and_loads_too(tmp_path, lwr_dyn_command):
    file = tmp_path / "mine.toml"
    assert lwr_dyn_command("new", "arm", str(file), "--joints", "RRPR", "--convention", "modified")[0] == 0
    arm = arm_with_payload(lwr_dyn.load(str(file)), 1.0)
    found = design_excitation(arm, **SHORT, limits=MotionLimits.of(arm, unknown_speed=1.0))
    q = found.sampled(1000.0).q
    assert (q > arm.lower).all()
    assert (q < arm.upper).all()
    assert np.isfinite(found.score.sigma).all()


BAD = [
    ("objective", "e", "objective: 'e'; allowed: d, cond"), ("starts", 0, "a whole number from 1 to 1000"),
    ("starts", True, "starts: True"), ("starts", 1001, "starts: 1001"), ("seed", -1, "seed: -1"),
    ("duration", 0.0, "duration: 0.0; allowed: a time above 0 s"), ("duration", 3601.0, "duration: 3601"),
    ("duration", np.nan, "duration: nan"), ("harmonics", 1, "harmonics: 1"), ("seconds", 0.0, "seconds: 0.0"),
    ("noise", 0.0, "noise: 0.0; allowed: above 0"),
    ("noise", [1.0, 2.0], "noise: shape (2,); allowed: one number, or 7"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value", "words"), BAD)
def test_bad_numbers_are_refused(lwr, name, value, words):
    with pytest.raises(OptionError if "shape" not in words else ShapeError) as refused:
        design_excitation(lwr, **{"starts": 1, name: value})
    assert words in str(refused.value)


def test_an_arm_without_masses_is_refused():
    with pytest.raises(MissingDataError):
        design_excitation(lwr_dyn.load("lwr4"), starts=1)


def test_its_file_is_a_reference_and_a_log(designed, lwr, tmp_path):
    table = tmp_path / "e.csv"
    write_excitation(table, designed)
    t = np.linspace(0.0, 10.0, 777)
    read, exact = csv_reference(lwr, file=str(table)).sample(t), designed.motion.sample(t)
    assert np.abs(read.q - exact.q).max() < 1e-7
    assert np.abs(read.dq - exact.dq).max() < 1e-5
    log = read_log(table, arm=lwr, needs=("q",))
    assert np.array_equal(log.q, designed.sampled(100.0).q)
    assert np.array_equal(log.dq, designed.sampled(100.0).dq)
    head = ["time [s]", *(f"{x}{j} [rad{per}]" for x, per in (("q", ""), ("dq", "/s"), ("ddq", "/s^2"))
                          for j in range(1, 8))]  # fmt: skip
    assert table.read_text().splitlines()[0] == ",".join(head)


def test_as_a_run_it_has_the_torques_of_the_table(designed, lwr, tmp_path):
    path = tmp_path / "e.npz"
    write_excitation(path, designed, 50.0)
    run = Run.load(path)
    tau = lwr_dyn.dynamics_of(lwr, "newton-euler").inverse_dynamics(run.q, run.dq, designed.sampled(50.0).ddq)
    assert np.abs(run.tau_applied - tau).max() < 1e-9
    assert (run.meta["robot"], run.meta["task"]) == ("lwr4plus", "excitation (d)")
    assert run.t.size == run_of_excitation(designed, 50.0).t.size == 501


def test_a_motion_that_may_not_be_run_says_so_in_its_file(designed, lwr, tmp_path):
    from pyarrow.parquet import read_schema

    fault = "the flange and the floor are 0.1 m too near at 2.00 s"
    bad, files = (
        dataclasses.replace(designed, faults=(fault,)),
        [tmp_path / f"e.{x}" for x in ("csv", "parquet", "npz")],
    )
    for file in files:
        write_excitation(file, bad)
    for file in files[:2]:
        assert np.array_equal(read_log(file, arm=lwr, needs=("q",)).q, bad.sampled(100.0).q)
    assert files[0].read_text().startswith(f"# DO NOT RUN IT: {fault}\ntime")
    assert csv_reference(lwr, file=str(files[0])).duration == 10.0
    assert read_schema(files[1]).metadata[NOTES.encode()].decode() == f"DO NOT RUN IT: {fault}"
    assert Run.load(files[2]).meta["task"] == f"excitation (d; {fault})"
    write_excitation(files[1], designed)
    assert NOTES.encode() not in (read_schema(files[1]).metadata or {})
