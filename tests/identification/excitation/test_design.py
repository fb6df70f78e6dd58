"""Designed motions: executable, better than random ones, and what stands against them."""

import dataclasses

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError
from lwr_dyn.identification.excitation import design, motion_design
from lwr_dyn.identification.excitation.design import NoMotionError, design_excitation, ended_words, rows_of
from lwr_dyn.identification.excitation.motion_limits import MotionLimits, clearance_of
from lwr_dyn.identification.excitation.objectives import fourier_basis, motion_score
from lwr_dyn.model.arm import arm_with_payload

SHORT = {"duration": 5.0, "starts": 1, "harmonics": 2}


@pytest.fixture(scope="module")
def designed(lwr):
    return design_excitation(lwr, starts=1)


@pytest.fixture(scope="module")
def slender(designed):
    return design_excitation(designed.arm, starts=1, objective="cond")


def _best_random(arm, columns, count):
    """The best scores of random motions that fill the limits and are clear at 100 Hz."""
    rng, limits, space, basis = np.random.default_rng(9), MotionLimits.of(arm), clearance_of(arm), None
    basis = fourier_basis(10.0, 5, 1000)
    scores = []
    while len(scores) < count:
        X = rng.normal(size=(basis.count, arm.n))
        X[0] = rng.uniform(limits.lower, limits.upper)
        X = limits.fitted(X, basis, fill=True)
        if space.of(basis.position @ X).min() > 0.0:
            scores.append(motion_score(columns, rows_of(basis.motion(X)), np.full(arm.n, 0.1)))
    return min(s.d for s in scores), min(s.condition for s in scores)


@pytest.mark.slow
@pytest.mark.parametrize("fixture", ["designed", "slender"])
def test_it_is_executable_at_1_khz(fixture, request, lwr):
    found = request.getfixturevalue(fixture)
    m, limits = found.sampled(1000.0), MotionLimits.of(lwr)
    assert len(m.t) == 10001
    assert max(np.abs(m.dq[[0, -1]]).max(), np.abs(m.ddq[[0, -1]]).max()) < 1e-10
    assert (m.q >= limits.lower - 1e-9).all()
    assert (m.q <= limits.upper + 1e-9).all()
    assert (np.abs(m.dq) <= limits.speed + 1e-9).all()
    tau = lwr_dyn.dynamics_of(lwr, "newton-euler").inverse_dynamics(m.q, m.dq, m.ddq)
    assert (np.abs(tau) <= 0.8 * lwr.effort).all()
    assert found.torque_use == pytest.approx(np.abs(tau).max(axis=0) / lwr.effort, rel=1e-9)
    assert found.speed_use == pytest.approx(np.abs(m.dq).max(axis=0) / lwr.velocity, rel=1e-9)
    nearest = clearance_of(lwr, kept=0.0).of(m.q)
    assert nearest.min() >= 0.05
    assert found.clear == pytest.approx(nearest.min(), abs=1e-9)


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
    limits = tuple(
        dataclasses.replace(x, effort=0.9 * need * x.effort) if j == 1 else x for j, x in enumerate(lwr.limits)
    )
    weak = dataclasses.replace(lwr, limits=limits)
    found = design_excitation(weak, **SHORT)
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
    assert found.faults == ()
    assert found.ended == "searched"
    assert clearance_of(iiwa).of(found.sampled(1000.0).q).min() >= 0.0
    assert "link_5 and link_3 are never far apart: they keep 0.01" in found.document.text()
    columns = found.columns
    assert found.score.d < _best_random(iiwa, columns, 5)[0]


@pytest.mark.slow
def test_a_search_ends_with_its_time_and_has_a_motion(lwr):
    kept, said = [], []
    found = design_excitation(lwr, starts=500, seconds=3.0, better=kept.append, report=said.append)
    assert found.ended == "seconds"
    assert 1 <= len(found.starts) < 500
    assert found.faults == ()
    assert ended_words(found) in found.document.text()
    assert ended_words(found).startswith("ended early (its time was over): ")
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
    assert found.ended == "stopped"
    assert len(found.starts) == 2
    assert found.faults == ()
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


@pytest.mark.parametrize(
    ("bad", "error"),
    [
        ({"objective": "e"}, OptionError), ({"starts": 0}, OptionError), ({"seed": -1}, OptionError),
        ({"duration": 0.0}, OptionError), ({"duration": np.nan}, OptionError), ({"harmonics": 1}, OptionError),
        ({"noise": 0.0}, OptionError), ({"noise": [1.0, 2.0]}, ShapeError), ({"starts": True}, OptionError),
    ],
)  # fmt: skip
def test_bad_numbers_are_refused(lwr, bad, error):
    with pytest.raises(error):
        design_excitation(lwr, **{"starts": 1, **bad})


def test_an_arm_without_masses_is_refused():
    with pytest.raises(MissingDataError):
        design_excitation(lwr_dyn.load("lwr4"), starts=1)
