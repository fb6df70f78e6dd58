"""Default gains over the joint box: the shares of the three readings, the worst pose, the least rate."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.gains import LinearFeedback
from lwr_dyn.design import sampled_stability as judge
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, Sampling
from lwr_dyn.design.sampled_stability import SampledStability, joint_box, stability_at
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.chain import JointKind
from tests.simulation.sample_runs import MIDDLE, lwr, lwr_dynamics, one_joint, with_limits

KNOWN = {"computed": 0.2346, "printed": 0.1750}
"""Unstable shares at 1 kHz by T lambda_max(B^-1 Kd) > 2 in 100 000 poses; both to 0.0013."""


@cache
def default(reading):
    arm = lwr_dyn.load("lwr4plus", reading)
    dynamics = lwr_dyn.dynamics_of(arm)
    return arm, dynamics, make_controller("pd-gravity", arm, dynamics)


def stability_in_box(arm, dynamics, controller, sampling, poses=None):
    return judge.box_stability(arm, lambda q: RestingLoop.of(dynamics, controller, q), sampling, poses)


def stability_along(dynamics, controller, sampling, q, places=None):
    rows = judge.places_of(q, judge.judged_count(judge.PLACES, sampling.delay) if places is None else places)
    return stability_at(RestingLoop.of(dynamics, controller, rows), sampling, rows)


@pytest.mark.slow
@pytest.mark.parametrize("reading", ["computed", "printed"])
def test_the_share_of_the_box_is_the_known_one_within_its_error(reading):
    found = stability_in_box(*default(reading), Sampling())
    assert abs(found.share - KNOWN[reading]) <= 3 * found.standard_error
    assert found.standard_error == pytest.approx(np.sqrt(found.share * (1 - found.share) / 2000))
    assert not found.holds


@pytest.mark.slow
def test_with_the_rotors_of_physical_no_pose_is_unstable_and_with_delay_many_are():
    at_once, late = (stability_in_box(*default("physical"), Sampling(1000.0, d), poses=500) for d in (0, 2))
    assert (at_once.unstable, at_once.holds, at_once.share_text) == (0, True, "none (at 95 %: below 0.6 %)")
    assert 700 < at_once.least_rate < 1000 < late.least_rate
    assert late.share == pytest.approx(0.272, abs=3 * late.standard_error)


@pytest.mark.slow
def test_the_least_rate_holds_everywhere_and_a_lower_one_does_not():
    arm, dynamics, controller = default("computed")
    found = stability_in_box(arm, dynamics, controller, Sampling(), poses=400)
    assert 6800 < found.least_rate < 7000
    q = np.random.default_rng(5).uniform(arm.lower, arm.upper, (2000, 7))
    assert not (RestingLoop.of(dynamics, controller, q).radius(Sampling(found.least_rate)) > GROWS).any()
    at_worst = RestingLoop.of(dynamics, controller, found.worst[None])
    assert at_worst.radius(found.sampling)[0] == pytest.approx(found.radius)
    assert at_worst.radius(Sampling(0.99 * found.least_rate))[0] > GROWS
    assert found.radius > RestingLoop.of(dynamics, controller, q[:400]).radius(Sampling()).max() - 1e-6


def test_inverse_dynamics_of_an_exact_model_holds_where_pd_does_not():
    arm, dynamics, _ = default("computed")
    controller = make_controller("inverse-dynamics", arm, dynamics)
    found = stability_in_box(arm, dynamics, controller, Sampling(1000.0, 4), poses=100)
    assert found.holds
    assert 0.95 < found.radius < 0.97


def test_faster_samples_and_less_delay_never_make_it_worse():
    loops = RestingLoop.of(
        lwr_dynamics(), default("computed")[2], np.random.default_rng(0).uniform(-1.5, 1.5, (300, 7))
    )
    by_rate = [(loops.radius(Sampling(rate)) > GROWS).mean() for rate in (500.0, 1000.0, 2000.0, 4000.0)]
    by_delay = [(loops.radius(Sampling(1000.0, d)) > GROWS).mean() for d in range(5)]
    assert by_rate == sorted(by_rate, reverse=True)
    assert by_delay == sorted(by_delay)
    assert by_delay[0] < by_delay[3]


def test_along_a_motion_the_unstable_poses_are_counted():
    controller = default("computed")[2]
    q = np.vstack([np.tile(MIDDLE, (30, 1)), np.zeros((10, 7))])
    found = stability_along(lwr_dynamics(), controller, Sampling(), q)
    assert (found.poses, found.unstable, found.worst.tolist()) == (40, 10, [0.0] * 7)
    assert found.share_text == "25.0 +- 6.8 %"
    assert stability_along(lwr_dynamics(), controller, Sampling(), q[:30]).holds
    assert stability_along(lwr_dynamics(), controller, Sampling(), np.tile(q, (100, 1)), places=50).poses == 50


def law(Kp, Kd):
    return SimpleNamespace(
        linear_feedback=lambda q: LinearFeedback(np.full((len(q), 1, 1), Kp), np.full((len(q), 1, 1), Kd))
    )


@pytest.mark.parametrize("kind", ["PRISMATIC", "REVOLUTE"])
def test_one_joint_without_limits_and_without_gains(kind):
    arm = one_joint(JointKind[kind], mass=2.0, lever=1.0)
    reach = 1.0 if kind == "PRISMATIC" else np.pi
    lower, upper, unknown = joint_box(arm)
    assert (lower.tolist(), upper.tolist(), unknown) == ([-reach], [reach], ("joint_1",))
    dynamics, B = lwr_dyn.dynamics_of(arm), 2.0 if kind == "PRISMATIC" else 2.02
    found = stability_in_box(arm, dynamics, law(0.0, 3.0 * B * 1000), Sampling(), poses=20)
    assert found.unknown_limits == ("joint_1",)
    assert found.share_text == "all (at 95 %: above 85 %)"
    assert found.radius == pytest.approx(2.0)
    assert found.least_rate == pytest.approx(1500.0, rel=2e-4)
    assert stability_in_box(arm, dynamics, law(0.0, 0.0), Sampling(), poses=20).holds
    assert stability_in_box(arm, dynamics, law(-50.0, 1.0), Sampling(), poses=20).least_rate is None  # at any rate
    assert joint_box(with_limits(arm, lower=-0.2, upper=0.3))[:2] == ([-0.2], [0.3])


def test_the_record_says_what_was_drawn_and_a_singular_plant_is_refused():
    arm, dynamics, controller = default("computed")
    record = stability_in_box(arm, dynamics, controller, replace(Sampling(), delay=1), poses=50).to_json()
    told = {"rate": 1000.0, "delay": 1, "poses": 50, "holds": False, "share": record["unstable"] / 50}
    assert told.items() <= record.items()
    assert {"standard_error", "worst", "radius", "least_rate"} <= set(record)
    none = SampledStability(Sampling(), 10, 0, np.zeros(7), 0.9, 700.0)
    with pytest.raises(ValueError, match="read-only"):
        none.worst[0] = 1.0
    squared = 1.959963984540054**2  # z of 95 %; 0 in N: up to z^2 / (N + z^2)
    assert none.interval == pytest.approx((0.0, squared / (10 + squared)), abs=1e-8)
    flat = SimpleNamespace(mass_matrix=lambda q: np.zeros((len(q), 7, 7)))
    with pytest.raises(OptionError, match="singular"):
        stability_in_box(lwr(), flat, controller, Sampling(), poses=2)


def test_the_least_rate_is_that_of_all_poses_though_the_worst_one_is_asked_alone_first(monkeypatch):
    asked, radius = [], RestingLoop.radius
    monkeypatch.setattr(
        RestingLoop, "radius", lambda self, *given: (asked.append(len(self.plant.B)), radius(self, *given))[1]
    )
    dynamics = lwr_dynamics()
    q = np.random.default_rng(3).uniform(-2.0, 2.0, (40, 7))
    for controller in (default("physical")[2], lwr_dyn.controller("pid", lwr())):
        asked.clear()
        least = stability_at(RestingLoop.of(dynamics, controller, q), Sampling(8000.0), q).least_rate
        assert asked.count(1) > asked.count(40) > 3
        alone = [RestingLoop.of(dynamics, controller, row[None]) for row in q]
        grows = {k: [radius(one, Sampling(k * least))[0] > GROWS for one in alone] for k in (0.9998, 1.0)}
        assert (any(grows[0.9998]), any(grows[1.0])) == (True, False)


@pytest.mark.slow
def test_long_delays_are_judged_at_fewer_poses_and_the_search_is_left_out(monkeypatch):
    sizes, matrices = [], RestingLoop.step_matrices
    monkeypatch.setattr(
        RestingLoop, "step_matrices", lambda self, *given: (sizes.append(out := matrices(self, *given)), out)[1]
    )
    monkeypatch.setattr("lwr_dyn.design.sampled_stability._least_rate", lambda loop, sampling: None)
    arm, dynamics, controller = default("computed")
    found = stability_in_box(arm, dynamics, controller, Sampling(1000.0, 20))
    assert found.poses == 64
    assert sum(len(size) for size in sizes) < 150
    path = stability_along(dynamics, controller, Sampling(1000.0, 20), np.tile(found.worst, (500, 1)))
    assert path.poses == 10


def test_many_poses_of_a_long_delay_are_held_in_parts(monkeypatch):
    arm, dynamics, controller = default("computed")
    q = np.random.default_rng(1).uniform(arm.lower, arm.upper, (7, 7))
    loop, scale = RestingLoop.of(dynamics, controller, q), np.linspace(0.5, 1.5, 49).reshape(7, 7)
    at_once = loop.radius(Sampling(1000.0, 2), 1e-4, scale)
    largest, matrices = [], RestingLoop.step_matrices

    def watched(self, *given):
        largest.append(len(self.plant.B))
        return matrices(self, *given)

    monkeypatch.setattr(RestingLoop, "step_matrices", watched)
    monkeypatch.setattr("lwr_dyn.design.sampled_loop.BLOCK", 3 * (14 + 7 * 6) ** 2)
    assert loop.radius(Sampling(1000.0, 2), 1e-4, scale) == pytest.approx(at_once, rel=1e-12)
    assert largest == [3, 3, 1]
