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


def test_a_joint_without_a_rotor_and_an_engine_of_ones_own_are_refused():
    links = list(physical().chain.links)
    links[2] = replace(links[2], rotor=None)
    arm = physical().with_chain(replace(physical().chain, links=tuple(links)))
    with pytest.raises(MissingDataError, match="rotor inertia of joint_3 not given; needed for elastic joints"):
        elastic_plant(setup(arm, allow_unphysical=True))
    with pytest.raises(OptionError, match="engine: own with elastic joints; allowed: pinocchio, newton-euler"):
        elastic_plant(replace(setup(), loop=replace(setup().loop, engine="own")))


@pytest.mark.parametrize(
    "given",
    [ArmFriction.of(FRICTION), ArmFriction.function("smooth", 7, lambda dq: 3.0 * dq, np.full(7, 3.0)),
     chosen_friction(physical(), "none")],
    ids=lambda given: given.form,
)  # fmt: skip
def test_friction_acts_on_the_motors(given):
    wide, still = motor_friction(given, 7), np.zeros(7, dtype=bool)
    assert (wide.form, wide.slope.tolist()) == (given.form, [*[0.0] * 7, *given.slope])
    assert wide.directional.tolist() == [False] * 7 + [given.form == "set-valued"] * 7
    dx = np.linspace(-1.0, 2.0, 14) + 0.01
    torque = wide.torque(np.sign(dx).astype(int), np.tile(still, 2))
    if given.form == "none":
        assert torque is None
    else:
        expected = given.torque(np.sign(dx[7:]).astype(int), still)(dx[7:])
        assert np.array_equal(torque(dx), [*[0.0] * 7, *expected])


TAU = np.concatenate([np.linspace(-1.0, 1.0, 7), np.linspace(20.0, -3.0, 7)])


def check_laws(elastic, rigid):
    """Both sides together are the rigid arm; accelerations solve the equations; the power is that of the torques."""
    step = 1e-6
    for x, dx in states(8, 2):
        same, speed, ddq = np.tile(x[:7], 2), np.tile(dx[:7], 2), np.linspace(-1.0, 2.0, 7)
        sides = elastic.mass_matrix(same) @ np.tile(ddq, 2) + elastic.bias_torque(same, speed)
        assert sides[:7] + sides[7:] == pytest.approx(rigid.inverse_dynamics(x[:7], dx[:7], ddq), rel=1e-11, abs=1e-11)
        ddx = elastic.forward_dynamics(x, dx, TAU)
        assert elastic.mass_matrix(x) @ ddx + elastic.bias_torque(x, dx) == pytest.approx(TAU, abs=1e-8)
        ahead, behind = (elastic.energies((x + s * dx)[None], (dx + s * ddx)[None])[0] for s in (step, -step))
        assert (ahead - behind) / (2 * step) == pytest.approx(TAU @ dx + elastic.damper_power(dx), rel=1e-6)


def test_its_laws_and_slopes():
    """With the slopes of the accelerations."""
    elastic, step, numeric = ElasticDynamics(physical(), physical().elasticity), 1e-6, np.zeros((14, 28))
    check_laws(elastic, dynamics_of(physical()))
    for x, dx in states(8, 2):
        for j, e in enumerate(step * np.eye(28)):
            ahead = elastic.forward_dynamics(x + e[:14], dx + e[14:], TAU)
            numeric[:, j] = (ahead - elastic.forward_dynamics(x - e[:14], dx - e[14:], TAU)) / (2 * step)
        slopes, i = np.zeros((14, 28)), np.arange(7)
        elastic.link_rows(x, dx, TAU, slopes[:7])
        for block, slope in enumerate(elastic.motor_slopes()):
            slopes[7 + i, 7 * block + i] = slope
        for rows in (slice(0, 7), slice(7, 14)):
            assert np.abs(slopes[rows] - numeric[rows]).max() <= 1e-7 * np.abs(slopes[rows]).max()


def test_the_laws_with_full_rotors(full):
    elastic = FullElasticDynamics(physical(), physical().elasticity)
    check_laws(elastic, full)
    for x, _ in states(8, 2):
        slopes = np.linalg.inv(ElasticDynamics.mass_matrix(elastic, x))  # of the accelerations over the torques
        elastic.couple(x, slopes)
        np.testing.assert_allclose(slopes, np.linalg.inv(elastic.mass_matrix(x)), rtol=1e-9, atol=1e-9)


def test_two_engines_agree():
    one, other = (ElasticDynamics(physical(), physical().elasticity, x) for x in ("pinocchio", "newton-euler"))
    for x, dx in states():
        expected = other.forward_dynamics(x, dx, TAU)
        assert one.forward_dynamics(x, dx, TAU) == pytest.approx(expected, rel=1e-10, abs=1e-9)
        rows = np.zeros((2, 7, 28))
        for each, out in zip((one, other), rows, strict=True):
            each.link_rows(x, dx, TAU, out)
        assert np.abs(rows[0] - rows[1]).max() <= 1e-6 * np.abs(rows[0]).max()


@pytest.fixture(scope="module")
def full():
    return dynamics_of(physical(), "newton-euler", rotors="full")


def test_rotors_known_only_at_the_joint_have_no_products():
    links = tuple(replace(x, rotor=Rotor(1.0, x.rotor.armature, reflected=True)) for x in physical().chain.links)
    arm = physical().with_chain(replace(physical().chain, links=links))
    full, plain = (kind(arm, physical().elasticity) for kind in (FullElasticDynamics, ElasticDynamics))
    for x, dx in states(6):
        expected = plain.forward_dynamics(x, dx, TAU)
        assert full.forward_dynamics(x, dx, TAU) == pytest.approx(expected, rel=1e-9)


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
