"""The full model: against the recursion with rotors "full", its energy, its runs, what it changes on IST."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.model.chain import Rotor
from lwr_dyn.simulation.elastic.plant import ElasticDynamics, FullElasticDynamics, elastic_plant
from tests.simulation.elastic.elastic_arms import FRICTION, physical, short_run, states

TAU = np.concatenate([np.linspace(-1.0, 1.0, 7), np.linspace(20.0, -3.0, 7)])


def model(arm=None):
    arm = arm or physical()
    return FullElasticDynamics(arm, physical().elasticity)


@pytest.fixture(scope="module")
def full():
    return dynamics_of(physical(), "newton-euler", rotors="full")


def test_both_sides_together_are_the_recursion_with_full_rotors(full):
    for x, dx in states(3):
        q, dq, ddq = np.tile(x[:7], 2), np.tile(dx[:7], 2), np.linspace(-1.0, 2.0, 7)
        sides = model().mass_matrix(q) @ np.tile(ddq, 2) + model().bias_torque(q, dq)
        assert sides[:7] + sides[7:] == pytest.approx(full.inverse_dynamics(x[:7], dx[:7], ddq), rel=1e-12, abs=1e-12)


def test_accelerations_solve_the_equation_of_motion():
    for x, dx in states(4):
        ddx = model().forward_dynamics(x, dx, TAU)
        assert model().mass_matrix(x) @ ddx + model().bias_torque(x, dx) == pytest.approx(TAU, abs=1e-9)


def test_the_power_is_that_of_the_torques_and_the_dampers():
    elastic, step = model(), 1e-6
    for x, dx in states(5):
        ddx = elastic.forward_dynamics(x, dx, TAU)
        ahead, behind = (elastic.energies((x + s * dx)[None], (dx + s * ddx)[None])[0] for s in (step, -step))
        assert (ahead - behind) / (2 * step) == pytest.approx(TAU @ dx + elastic.damper_power(dx), rel=1e-6)


def test_rotors_known_only_at_the_joint_have_no_products():
    links = tuple(replace(x, rotor=Rotor(1.0, x.rotor.armature, reflected=True)) for x in physical().chain.links)
    arm = physical().with_chain(replace(physical().chain, links=links))
    plain = ElasticDynamics(physical(), physical().elasticity)
    for x, dx in states(6):
        assert model(arm).forward_dynamics(x, dx, TAU) == pytest.approx(plain.forward_dynamics(x, dx, TAU), rel=1e-9)


@pytest.mark.slow
def test_an_engine_with_full_rotors_runs_the_full_model(full):
    ist = lwr_dyn.reference("ist", physical())
    reduced, coupled, fine = (
        short_run(reference=ist, **options)
        for options in ({}, {"engine": full}, {"engine": full, "method": "radau", "substeps": 2})
    )
    assert elastic_plant(coupled.setup).model.rotors == "full"
    assert coupled.audit["closed"]
    assert np.abs(coupled.q - fine.q).max() <= 1e-8
    assert 1e-7 < np.abs(coupled.q - reduced.q).max() < 1e-4


@pytest.mark.slow
def test_its_motors_stick_too(full):
    run = short_run(engine=full, friction=FRICTION, duration=0.03)
    assert (run.signals["dtheta"] == 0.0).any()
    assert run.audit["closed"]
