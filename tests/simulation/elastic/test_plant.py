"""The plant: rotors that are too light, friction on the motors' side, stops on the links' side."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.errors import MissingDataError, OptionError, RatingWarning
from lwr_dyn.model.chain import Rotor
from lwr_dyn.simulation.arm_friction import ArmFriction, chosen_friction
from lwr_dyn.simulation.elastic.plant import ElasticDynamics, FullElasticDynamics, elastic_plant, motor_friction
from lwr_dyn.simulation.setup import Loop, prepare
from tests.simulation.elastic.elastic_arms import FRICTION, law, physical, short_run, states
from tests.simulation.sample_runs import joint_waves

COMPUTED = lwr_dyn.load("lwr4plus", "computed")


def setup(arm=None, **options):
    return prepare(arm or physical(), law(), joint_waves(), Loop(elasticity="file", **options))


def test_sides():
    plant = elastic_plant(setup())
    assert plant.n == 14
    assert np.array_equal(plant.upper, [*physical().upper, *[np.inf] * 7])
    assert np.array_equal(plant.lower, [*physical().lower, *[-np.inf] * 7])
    assert np.array_equal(plant.effort, [*[np.inf] * 7, *physical().effort])
    assert plant.model.rotor.tolist() == physical().armature.tolist()
    assert np.abs(plant.model.links.mass_matrix(np.zeros(7)) @ np.eye(7)[0])[0] < 3.0 - plant.model.rotor[0]


def test_a_rotor_that_no_sampled_law_can_drive_is_refused_and_the_rate_named():
    with pytest.raises(OptionError, match=r"joint_2 .computed.: rotor of 0.0016 kg m.2 before .* too light") as fault:
        elastic_plant(setup(COMPUTED))
    rate = float(fault.value.allowed.split("a rate from ")[1].split(" Hz")[0])
    heavy = dynamics_of(COMPUTED).mass_matrix(setup(COMPUTED).start[0])[1, 1]
    assert rate == np.ceil(5.0 * heavy / COMPUTED.armature[1])
    assert f"steps of {1 / rate:.2g} s" in fault.value.allowed
    assert elastic_plant(setup(COMPUTED, rate=rate)).n == 14
    assert elastic_plant(setup(COMPUTED, allow_unphysical=True)).n == 14
    with pytest.warns(RatingWarning, match="joint_2: rotor of 0.0016"):
        elastic_plant(setup(COMPUTED, encoders="link"))


def test_a_joint_without_a_rotor_is_refused():
    links = list(physical().chain.links)
    links[2] = replace(links[2], rotor=None)
    arm = physical().with_chain(replace(physical().chain, links=tuple(links)))
    with pytest.raises(MissingDataError, match="rotor inertia of joint_3 not given; needed for elastic joints"):
        elastic_plant(setup(arm, allow_unphysical=True))


def test_an_engine_of_ones_own_is_refused():
    with pytest.raises(OptionError, match="engine: own with elastic joints; allowed: pinocchio, newton-euler"):
        elastic_plant(replace(setup(), loop=replace(setup().loop, engine="own")))


@pytest.mark.parametrize("form", ["set-valued", "smooth", "none"])
def test_friction_acts_on_the_motors(form):
    given = ArmFriction.of(FRICTION) if form == "set-valued" else chosen_friction(physical(), form)
    if form == "smooth":
        given = ArmFriction.function("smooth", 7, lambda dq: 3.0 * dq, np.full(7, 3.0))
    wide = motor_friction(given, 7)
    assert wide.form == given.form
    assert wide.slope.tolist() == [*[0.0] * 7, *given.slope]
    assert not wide.directional[:7].any()
    assert wide.directional[7:].all() == (form == "set-valued")
    dx = np.linspace(-1.0, 2.0, 14) + 0.01
    torque = wide.torque(np.sign(dx).astype(int), np.zeros(14, dtype=bool))
    if form == "none":
        assert torque is None
        return
    expected = given.torque(np.sign(dx[7:]).astype(int), np.zeros(7, dtype=bool))(dx[7:])
    assert np.array_equal(torque(dx), [*[0.0] * 7, *expected])


TAU = np.concatenate([np.linspace(-1.0, 1.0, 7), np.linspace(20.0, -3.0, 7)])


def model(engine="pinocchio"):
    return ElasticDynamics(physical(), physical().elasticity, engine)


def test_two_engines_agree():
    one, other = model(), model("newton-euler")
    for x, dx in states():
        expected = other.forward_dynamics(x, dx, TAU)
        assert one.forward_dynamics(x, dx, TAU) == pytest.approx(expected, rel=1e-10, abs=1e-9)
        rows = np.zeros((2, 7, 28))
        for each, out in zip((one, other), rows, strict=True):
            each.link_rows(x, dx, TAU, out)
        assert np.abs(rows[0] - rows[1]).max() <= 1e-6 * np.abs(rows[0]).max()


def test_slopes_are_those_of_the_accelerations():
    elastic, step = model(), 1e-6
    for x, dx in states(1):
        numeric = np.zeros((14, 28))
        for j in range(28):
            e = step * np.eye(28)[j]
            ahead = elastic.forward_dynamics(x + e[:14], dx + e[14:], TAU)
            numeric[:, j] = (ahead - elastic.forward_dynamics(x - e[:14], dx - e[14:], TAU)) / (2 * step)
        out = np.zeros((7, 28))
        elastic.link_rows(x, dx, TAU, out)
        assert np.abs(out - numeric[:7]).max() <= 1e-7 * np.abs(out).max()
        motors = np.zeros((7, 4, 7))
        motors[np.arange(7), :, np.arange(7)] = elastic.motor_slopes().T
        assert np.abs(motors.reshape(7, 28) - numeric[7:]).max() <= 1e-7 * np.abs(motors).max()


def test_both_sides_together_are_the_rigid_arm():
    elastic, rigid = model(), dynamics_of(physical())
    for x, dx in states(3):
        q, dq, ddq = x[:7], dx[:7], np.ones(7)
        same, still = np.tile(q, 2), np.tile(dq, 2)
        sides = elastic.mass_matrix(same) @ np.tile(ddq, 2) + elastic.bias_torque(same, still)
        assert sides[:7] + sides[7:] == pytest.approx(rigid.inverse_dynamics(q, dq, ddq), rel=1e-11, abs=1e-11)


def full_model(arm=None):
    return FullElasticDynamics(arm or physical(), physical().elasticity)


@pytest.mark.parametrize("made", [model, full_model])
def test_the_power_is_that_of_the_torques_and_the_dampers(made):
    elastic, step = made(), 1e-6
    for x, dx in states(2):
        ddx = elastic.forward_dynamics(x, dx, TAU)
        ahead, behind = (elastic.energies((x + s * dx)[None], (dx + s * ddx)[None])[0] for s in (step, -step))
        assert (ahead - behind) / (2 * step) == pytest.approx(TAU @ dx + elastic.damper_power(dx), rel=1e-6)


@pytest.fixture(scope="module")
def full():
    return dynamics_of(physical(), "newton-euler", rotors="full")


def test_both_sides_together_are_the_recursion_with_full_rotors(full):
    for x, dx in states(3):
        q, dq, ddq = np.tile(x[:7], 2), np.tile(dx[:7], 2), np.linspace(-1.0, 2.0, 7)
        sides = full_model().mass_matrix(q) @ np.tile(ddq, 2) + full_model().bias_torque(q, dq)
        assert sides[:7] + sides[7:] == pytest.approx(full.inverse_dynamics(x[:7], dx[:7], ddq), rel=1e-12, abs=1e-12)


def test_accelerations_solve_the_equation_of_motion():
    for x, dx in states(4):
        ddx = full_model().forward_dynamics(x, dx, TAU)
        assert full_model().mass_matrix(x) @ ddx + full_model().bias_torque(x, dx) == pytest.approx(TAU, abs=1e-9)


def test_rotors_known_only_at_the_joint_have_no_products():
    links = tuple(replace(x, rotor=Rotor(1.0, x.rotor.armature, reflected=True)) for x in physical().chain.links)
    arm = physical().with_chain(replace(physical().chain, links=links))
    plain = ElasticDynamics(physical(), physical().elasticity)
    for x, dx in states(6):
        assert full_model(arm).forward_dynamics(x, dx, TAU) == pytest.approx(
            plain.forward_dynamics(x, dx, TAU), rel=1e-9
        )


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
