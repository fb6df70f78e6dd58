"""The robust law: how its Lyapunov function falls for every load of the set, its largest load, its honest figure."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.laws.adaptive import SlotineLiRegressor, poses_of_box
from lwr_dyn.control.laws.robust import POSES, POSES_SEED, tuned_robust, unrated_load
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.model.chain import with_bodies
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.trajectory.references.ist import ist_clear_reference
from tests.control.laws.lyapunov import ARM, STATES, Instant, missing_load

MODEL = lwr_dyn.dynamics_of(ARM)
OMEGA, MOST = 50.0, 7.0
LOADS = [arm_with_payload(ARM, mass) for mass in (1e-9, 3.0, MOST)]
MIDDLE = arm_with_payload(ARM, MOST / 2)
TRUE = [lwr_dyn.dynamics_of(arm, "newton-euler") for arm in LOADS]
COLUMNS = SlotineLiRegressor(ARM)


@cache
def instants_of_each():
    """Per load the instants of all states; not made when the tests are collected."""
    return [[Instant.of(dynamics, OMEGA, *state) for state in STATES] for dynamics in TRUE]


def test_its_lyapunov_function_falls_but_for_the_layer():
    """dV/dt = -k s^T B s + s^T Y_l (u - error), at most -k s^T B s + rho eps / 4, in the layer and out of it."""
    seen, ends = set(), []
    scale = MOST / 2 * np.r_[1.0, [0.1] * 3, [0.01] * 6]
    for layer in (1.0, 30.0, 1e4):
        law = tuned_robust(ARM, MODEL, omega_n=OMEGA, layer=layer)
        for arm, instants in zip(LOADS, instants_of_each(), strict=True):
            error = missing_load(MIDDLE, arm)
            ends.append(np.linalg.norm(error / scale) / law.rho)
            for at, state in zip(instants, STATES, strict=True):
                tau = law(0.0, *state)
                a = state[4] + OMEGA * (state[3] - state[1]) - OMEGA * at.s
                z = scale * (at.s @ COLUMNS(*state[:2], at.dq_r, a)[:, -10:])
                size = np.linalg.norm(z)
                seen.add(bool(size > layer))
                term = -law.rho * z @ z / max(size, layer)
                fall = at.power(tau) + at.damping
                assert fall == pytest.approx(term - z @ (error / scale), rel=1e-8, abs=1e-8)
                assert fall <= law.rho * layer / 4 + 1e-9
    assert seen == {True, False}
    assert max(ends) == pytest.approx(1 / 1.2, rel=1e-9)  # at the ends of the set, the lightest of which is 1e-9 kg
    assert not hasattr(make_controller("robust", ARM, MODEL), "reset")


@pytest.mark.slow
def test_its_honest_figure():
    """At the ends of the set the robust term takes little off; most comes from the load in the middle of the set."""
    move = ist_clear_reference(ARM, duration=7.0)

    def error(law, mass):
        return metrics(lwr_dyn.simulate(ARM, law, move, payload=mass, duration=3.0), ARM).tip_rms_mm

    empty, middle = (make_controller("inverse-dynamics", arm) for arm in (ARM, MIDDLE))
    law = make_controller("robust", ARM, MODEL)
    at_end = [error(one, MOST) for one in (empty, middle, law)]
    assert at_end[0] > 3.0 * at_end[2]
    assert at_end[1] > 1.05 * at_end[2]
    assert at_end[1] < 3.0 * at_end[2]


def with_limits(arm, effort):
    efforts = [None] * arm.n if effort is None else np.broadcast_to(effort, arm.n).tolist()
    return replace(arm, limits=tuple(replace(x, effort=e) for x, e in zip(arm.limits, efforts, strict=True)))


def test_the_largest_load_of_an_arm_without_a_rating_is_one_that_it_bears():
    assert unrated_load(ARM, MODEL) == MOST
    weak, model = with_limits(ARM, ARM.effort / 2), MODEL
    most = unrated_load(weak, model)
    assert 1.0 < most < 6.0
    q = poses_of_box(weak, POSES, POSES_SEED)
    for share, held in ((0.999, True), (1.001, False)):
        loaded = lwr_dyn.dynamics_of(arm_with_payload(weak, share * most), "newton-euler")
        assert (np.abs(loaded.gravity_vector(q)) <= weak.effort).all() == held
    assert make_controller("robust", weak).scale[0] == most / 2
    assert make_controller("robust", weak, largest_load=3.0).scale[0] == 1.5
    rated = replace(weak, ratings=replace(weak.ratings, payload=5.0))
    assert make_controller("robust", rated).scale[0] == 2.5


def test_the_largest_load_of_a_light_arm_and_of_one_that_does_not_hold_itself_is_a_share_of_its_mass():
    mass = sum(body.mass for body in ARM.chain.bodies)
    bodies = [replace(body, mass=body.mass / 20) for body in ARM.chain.bodies]
    light = with_limits(ARM.with_chain(with_bodies(ARM.chain, bodies)), None)
    assert unrated_load(light, lwr_dyn.dynamics_of(light)) == pytest.approx(0.5 * mass / 20, rel=1e-12)
    assert unrated_load(with_limits(ARM, 1.0), MODEL) == pytest.approx(0.01 * mass, rel=1e-12)
