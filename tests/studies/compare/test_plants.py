"""A plant is the model changed in what its name says, and in nothing else."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.studies.compare.plants import PLANTS, plant_case
from tests.random_arms import random_arm

RIGID, BITS = {"friction": "none"}, 2 * np.pi / 4096


@pytest.mark.parametrize(
    ("text", "words", "options"),
    [
        ("nominal", (), {}), ("payload=3", (), {"payload": 3.0}),
        ("elastic", ("elastic joints",), {"elasticity": "file"}),
        ("delay=1", ("delay of 1 sample",), {"delay": 1}), ("delay=1000", ("delay of 1000 samples",), {"delay": 1000}),
        ("noise=1e-4", ("encoder noise of 0.0001 rad or m",), {"encoder": Encoder(noise=1e-4)}),
        ("encoder=12", ("encoder of 12 bits",), {"encoder": Encoder(resolution=BITS)}),
        ("encoder=40", ("encoder of 40 bits",), {"encoder": Encoder.of_bits(40)}),
        ("encoder=12+noise=1e-5", ("encoder of 12 bits", "encoder noise of 1e-05 rad or m"),
         {"encoder": Encoder.of_bits(12, 1e-5)}),
        ("noise=1e-5+encoder=12", ("encoder noise of 1e-05 rad or m", "encoder of 12 bits"),
         {"encoder": Encoder.of_bits(12, 1e-5)}),
        ("elastic=5e3+encoders=link", ("elastic joints, 5000 N m/rad", "encoders on the link side"),
         {"elasticity": 5e3, "encoders": "link"}),
    ],
)  # fmt: skip
def test_each_name_changes_its_own(text, words, options, arm):
    case = plant_case(arm, text)
    assert (case.words, dict(case.options)) == (words, RIGID | options)
    assert case.plant is arm


def test_names_of_another_arm_or_a_table(arm):
    heavier, printed, table = (plant_case(arm, text) for text in ("scale=1.1", "reading=printed", "table=-0.1"))
    for a, b in zip(heavier.plant.chain.bodies, arm.chain.bodies, strict=True):
        assert a.mass == pytest.approx(1.1 * b.mass, rel=1e-15)
    assert (heavier.words, printed.words) == (("masses times 1.1",), ("reading printed",))
    assert printed.plant.reading == "printed"
    wall = table.options["external"]
    assert (wall.place.tolist(), wall.normal.tolist()) == ([0.0, 0.0, -0.1], [0.0, 0.0, 1.0])
    assert table.words == ("a table at -0.1 m",)


def test_friction_is_the_arms_own_else_a_share_of_the_torque_limits(arm):
    wam = lwr_dyn.load("wam7")
    assert plant_case(wam, "friction").options["friction"] == "set-valued"
    for robot, text, share, words in (
        (arm, "friction", 0.05, "assumed Coulomb friction, 5 % of the torque limits"),
        (arm, "friction=0.02", 0.02, "Coulomb friction, 2 % of the torque limits"),
        (wam, "friction=0.1", 0.1, "Coulomb friction, 10 % of the torque limits"),
    ):
        case = plant_case(robot, text)
        assert [model.torque(1.0).item() for model in case.options["friction"]] == (share * robot.effort).tolist()
        assert case.words == (words,)


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
    "many bits": ("encoder=41", "plant encoder: '41'; allowed: a number of bits from 1 to 40"),
    "no delay": ("delay=0", "plant delay: '0'; allowed: a number of samples from 1 to 1000"),
    "late": ("delay=1001", "plant delay: '1001'; allowed"),
    "side of no name": ("elastic+encoders", "plant encoders: no value; allowed: motor or link"),
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
