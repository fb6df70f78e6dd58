"""The plant: rotors that are too light, friction on the motors' side, stops on the links' side."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.errors import MissingDataError, OptionError, RatingWarning
from lwr_dyn.simulation.arm_friction import ArmFriction, chosen_friction
from lwr_dyn.simulation.elastic.plant import elastic_plant, motor_friction
from lwr_dyn.simulation.setup import Loop, prepare
from tests.simulation.elastic.elastic_arms import FRICTION, law, physical
from tests.simulation.sample_runs import joint_waves

COMPUTED = lwr_dyn.load("lwr4plus")


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
