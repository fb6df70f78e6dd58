"""A plant is the model changed in what its name says, and in nothing else."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.studies.compare.plants import PLANTS, plant_case
from tests.random_arms import random_arm


def test_nominal_is_the_model_without_friction(arm):
    case = plant_case(arm, "nominal")
    assert case.plant is arm
    assert dict(case.options) == {"friction": "none"}
    assert case.words == ()


def test_each_name_changes_its_own(arm):
    assert plant_case(arm, "payload=3").options["payload"] == 3.0
    heavier = plant_case(arm, "scale=1.1").plant
    for a, b in zip(heavier.chain.bodies, arm.chain.bodies, strict=True):
        assert a.mass == pytest.approx(1.1 * b.mass, rel=1e-15)
    assert plant_case(arm, "reading=printed").plant.reading == "printed"
    assert plant_case(arm, "delay=2").options["delay"] == 2
    table = plant_case(arm, "table=-0.1").options["external"]
    assert (table.place.tolist(), table.normal.tolist()) == ([0.0, 0.0, -0.1], [0.0, 0.0, 1.0])
    assert plant_case(arm, "noise=1e-4").options["encoder"] == Encoder(noise=1e-4)
    assert plant_case(arm, "encoder=12").options["encoder"].resolution == 2 * np.pi / 4096


def test_friction_is_the_arms_own_else_a_share_of_the_torque_limits(arm):
    wam = lwr_dyn.load("wam7")
    assert plant_case(wam, "friction").options["friction"] == "set-valued"
    assumed = plant_case(arm, "friction")
    assert [model.torque(1.0).item() for model in assumed.options["friction"]] == (0.05 * arm.effort).tolist()
    assert assumed.words == ("assumed Coulomb friction, 5 % of the torque limits",)
    assert plant_case(arm, "friction=0.02").words == ("Coulomb friction, 2 % of the torque limits",)


def test_two_changes_add_up(arm):
    case = plant_case(arm, "reading=printed+scale=1.2+payload=1")
    assert case.words == ("reading printed", "masses times 1.2")
    printed = lwr_dyn.load("lwr4plus", reading="printed")
    for a, b in zip(case.plant.chain.bodies, printed.chain.bodies, strict=True):
        np.testing.assert_allclose(a.inertia_com, 1.2 * b.inertia_com, rtol=1e-15)
    assert case.plant.reading == "printed"
    assert case.options["payload"] == 1.0


def test_assumed_friction_of_an_arm_is_that_of_its_plant_and_of_its_laws(arm):
    rough = arm_with_friction(arm, 0.01)
    assert [model.torque(1.0).item() for model in rough.friction_models()] == (0.01 * arm.effort).tolist()
    assert plant_case(rough, "friction").options["friction"] == "set-valued"
    assert plant_case(rough, "nominal").options["friction"] == "none"
    law = lwr_dyn.controller("inverse-dynamics+friction", rough)
    speeds = np.full(7, 1.0)
    added = law(0.0, *[np.zeros(7)] * 3, speeds, np.zeros(7)) - lwr_dyn.controller("inverse-dynamics", arm)(
        0.0, *[np.zeros(7)] * 3, speeds, np.zeros(7)
    )
    np.testing.assert_allclose(added, 0.01 * arm.effort, rtol=1e-9)


@pytest.mark.parametrize(("share", "words"), [(0.0, "friction: 0.0"), (float("nan"), "friction: nan")])
def test_a_share_of_friction_that_cannot_be_is_refused(share, words, arm):
    with pytest.raises(LwrDynError, match=words):
        arm_with_friction(arm, share)


def test_an_arm_with_friction_keeps_its_own():
    with pytest.raises(LwrDynError, match="wam7 has friction of its own"):
        arm_with_friction(lwr_dyn.load("wam7"), 0.01)


def test_elastic_gears_are_those_of_the_file_or_of_a_stiffness(arm):
    assert plant_case(arm, "elastic").options["elasticity"] == "file"
    soft = plant_case(arm, "elastic=5e3+encoders=link")
    assert (soft.options["elasticity"], soft.options["encoders"]) == (5e3, "link")
    assert soft.words == ("elastic joints, 5000 N m/rad", "encoders on the link side")


def test_bits_and_noise_of_an_encoder_go_together_in_any_order(arm):
    ours = [plant_case(arm, text).options["encoder"] for text in ("encoder=12+noise=1e-5", "noise=1e-5+encoder=12")]
    assert ours == [Encoder.of_bits(12, 1e-5)] * 2


def test_every_row_has_a_factory_and_a_line():
    assert all(callable(PLANTS.load(name)) and PLANTS[name].about for name in PLANTS.names)


BAD = {
    "unknown": ("payloat=3", "no plant named 'payloat' (did you mean payload?)"),
    "no value": ("payload", "plant payload: no value; allowed: a mass in kg above 0, as payload=3"),
    "no number": ("payload=a", "plant payload: 'a'; allowed: a mass"),
    "negative": ("scale=-1", "plant scale: '-1'; allowed: a factor above 0"),
    "infinite": ("scale=inf", "plant scale: 'inf'; allowed"),
    "negative noise": ("noise=-1", "plant noise: '-1'; allowed: a standard deviation above 0"),
    "encoders of rigid joints": ("encoders=link", "plant encoders: on rigid joints; allowed: after elastic"),
    "another side": ("elastic+encoders=top", "plant encoders: 'top'; allowed: motor or link"),
    "no stiffness": ("elastic=0", "plant elastic: '0'; allowed: the largest stiffness above 0"),
    "half a bit": ("encoder=1.5", "plant encoder: '1.5'; allowed: a number of bits from 1 to 40"),
    "too late": ("delay=2000", "plant delay: '2000'; allowed: a number of samples from 1 to 1000"),
    "no height": ("table", "plant table: no value; allowed: a height in m, as table=0.1"),
    "value of nominal": ("nominal=1", "plant nominal: with the value '1'; allowed: nominal, without a value"),
    "twice": ("payload=1+payload=2", "payload twice; allowed: each change once"),
    "reading last": ("scale=2+reading=printed", "plant reading: after a change of masses"),
    "no reading": ("reading", "plant reading: no name"),
    "unknown reading": ("reading=x", "no reading of lwr4plus named 'x'"),
    "empty": ("", "no plant named ''"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case, arm):
    text, message = BAD[case]
    with pytest.raises(LwrDynError) as fault:
        plant_case(arm, text)
    assert message in str(fault.value)
    assert "\n" not in str(fault.value)


def test_an_arm_without_torque_limits_has_no_assumed_friction():
    with pytest.raises(LwrDynError, match="random has no friction of its own, and joints without a torque limit"):
        plant_case(random_arm(1, "RR"), "friction")
