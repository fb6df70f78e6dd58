"""What cannot be simulated is refused before anything moves, in one line that says what is allowed."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import (
    DivergenceError,
    MissingDataError,
    NotPhysicalError,
    OptionError,
    ShapeError,
    UnknownNameError,
)
from lwr_dyn.model.arm import arm_with_scaled_inertia
from lwr_dyn.model.chain import Body, with_bodies
from lwr_dyn.model.friction import symmetric
from lwr_dyn.model.run import Run
from lwr_dyn.model.transmission import JointElasticity
from lwr_dyn.simulation import setup
from lwr_dyn.simulation.arm_friction import chosen_friction
from lwr_dyn.simulation.integrators import rk4
from lwr_dyn.simulation.plant import Encoder, plant_of
from lwr_dyn.simulation.setup import (
    STABLE,
    Loop,
    arm_record,
    friction_rate,
    known_motion,
    prepare,
    sampled_reference,
    start_state,
    versions,
)
from lwr_dyn.simulation.simulate import free_swing, no_torque, simulate
from tests.simulation.sample_runs import Still, controllers, joint_waves, lwr, lwr_dynamics, one_joint

NUMBER, WHOLE = "allowed: a number above 0", "allowed: a whole number from"
METHODS = "allowed: rk4, dop853, radau"
OPTIONS = [
    *(({"rate": bad}, OptionError, f"^rate: {bad}; {NUMBER}") for bad in (0.0, -1.0, np.nan, np.inf, "fast")),
    *(({"rtol": bad}, OptionError, f"^rtol: {bad}; {NUMBER}") for bad in (0.0, np.nan)),
    *(({"substeps": bad}, OptionError, f"^substeps: {bad}; {WHOLE} 1 to 1000") for bad in (0, 1.5, 1001)),
    *(({"seed": bad}, OptionError, f"^seed: {bad}; {WHOLE} 0 on") for bad in (-1, 0.5)),
    *(({"duration": bad}, OptionError, f"^duration: {bad}; {NUMBER}, in s") for bad in (0.0, -1.0, np.inf)),
    ({"method": "euler"}, OptionError, f"^method: 'euler'; {METHODS}"),
    ({"payload": -1.0}, OptionError, "^payload mass: -1.0; allowed: a number >= 0, in kg"),
    ({"payload": np.nan}, OptionError, "^payload mass: nan; allowed: a number >= 0, in kg"),
    ({"q0": np.full(7, 3.0)}, OptionError, "^q0 of joint_1: 3; allowed: -2.96706 to 2.96706, or position_limits=False"),
    ({"q0": np.full(7, -3.0)}, OptionError, "^q0 of joint_1: -3; allowed: -2.96706 to 2.96706, or"),
    ({"q0": np.zeros(6)}, ShapeError, "^q0: 6 numbers; allowed: 7 numbers"),
    ({"dq0": [np.nan] * 7}, ShapeError, "^dq0: nan"),
    ({"payload": 1.0, "payload_com": [0, 0]}, ShapeError, "2 numbers; allowed: 3 numbers"),
    ({"engine": lwr_dyn.dynamics_of(one_joint())}, ShapeError, "engine"),
    ({"engine": "ode"}, UnknownNameError, "pinocchio"),
    ({"rate": 100.0, "encoder": Encoder(cutoff_hz=80.0)}, OptionError, "cut-off"),
    ({"continuous": True, "encoder": Encoder()}, OptionError, "^encoder: given for a continuous run"),
]


@pytest.mark.parametrize(("options", "error", "words"), OPTIONS, ids=[words for *_, words in OPTIONS])
def test_an_option_outside_what_is_allowed(options, error, words):
    with pytest.raises(error, match=words) as fault:
        simulate(lwr(), no_torque, joint_waves(), **options)
    assert "\n" not in str(fault.value)


def test_a_reference_for_another_arm_and_an_arm_without_masses():
    with pytest.raises(ShapeError, match="reference"):
        simulate(lwr(), no_torque, Still(np.zeros(3), 1.0))
    with pytest.raises(MissingDataError, match="masses"):
        simulate(lwr_dyn.load("lwr4"), no_torque, Still(np.zeros(7), 1.0))
    with pytest.raises(OptionError, match="arm: 'lwr4plus'"):
        prepare("lwr4plus", no_torque, joint_waves(), Loop())


@pytest.mark.parametrize("torque", [np.zeros(6), 0.0, np.zeros((1, 7)), "none", [[1.0], [2.0, 3.0]]])
@pytest.mark.parametrize("continuous", [False, True])
def test_a_controller_that_gives_something_else(torque, continuous):
    with pytest.raises(ShapeError, match="torque of the controller"):
        simulate(lwr(), lambda *state: torque, joint_waves(), duration=0.01, continuous=continuous)


def test_an_infeasible_arm_is_refused_unless_allowed_and_an_encoder_that_cannot_be():
    bodies = list(lwr().chain.bodies)
    bodies[2] = Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.5]))
    arm = lwr().with_chain(with_bodies(lwr().chain, bodies))
    with pytest.raises(NotPhysicalError, match="link_3"):
        free_swing(arm, duration=0.01, engine="newton-euler")
    assert free_swing(arm, duration=0.01, engine="newton-euler", allow_unphysical=True).t.size == 11
    for option in ({"resolution": -1.0}, {"noise": -1.0}, {"noise": np.nan}):
        with pytest.raises(OptionError, match="encoder"):
            Encoder(**option)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["rk4", "dop853"])
@pytest.mark.parametrize("position_limits", [False, True])
def test_a_run_that_diverges_names_time_and_joint_and_keeps_its_samples(method, position_limits):
    sixth = np.eye(7)[5]

    def push_joint_6(t, q, dq, *reference):
        return lwr_dynamics().gravity_vector(q) + sixth * 1e3 * np.sign(dq) * (1 + dq**2)

    with pytest.raises(DivergenceError, match=r"t = 0\.\d+ s: joint_6") as error:
        simulate(
            lwr(), push_joint_6, joint_waves(), dq0=0.1 * sixth, saturate=False, duration=1.0, method=method,
            position_limits=position_limits, rtol=1e-6,
        )  # fmt: skip
    run = error.value.run
    assert isinstance(run, Run)
    assert run.t[-1] == error.value.t < 1.0
    assert np.isfinite(run.q).all()
    assert run.meta["diverged"]["joint"] == error.value.joint == "joint_6"
    assert " rad/s at the last sample that can be followed, beyond reach at the next" in run.meta["diverged"]["found"]
    assert {np.shape(w) for w in run.work.values()} == {run.t.shape}


@pytest.mark.parametrize("continuous", [False, True])
@pytest.mark.parametrize("at", [0.0, 0.005, 0.02])
def test_a_torque_that_is_not_a_number_ends_the_run(continuous, at):
    def fails(t, q, *state):
        return np.where((np.arange(7) == 2) & (t >= at), np.nan, 0.0)

    with pytest.raises(DivergenceError, match="joint_3: torque command nan") as error:
        simulate(lwr(), fails, joint_waves(), duration=0.02, continuous=continuous, method="rk4")
    assert error.value.t == pytest.approx(at, abs=0.0011)
    assert error.value.run.t[-1] == error.value.t


def test_unstable_gains_end_the_run():
    law = controllers()["inverse-dynamics"]
    law.Kd = np.full(7, 5000.0)
    with pytest.raises(DivergenceError, match="higher rate or lower gains"):
        simulate(lwr(), law, joint_waves(), saturate=False, q0=joint_waves().middle + 0.01)


def wind(t, q, dq):
    return np.full(7, 0.1)


def test_a_setup_is_its_record_and_may_have_another_plant():
    heavy = arm_with_scaled_inertia(lwr(), 1.5)
    setup = prepare(lwr(), no_torque, joint_waves(0.1), Loop(plant=heavy, payload=1.0, meta={"task": "waves"}))
    record, robot = json.loads(str(setup)), arm_record(lwr())
    none = {"encoder": None, "external": None, "elasticity": None, "loop": None}
    options = {
        "rate": 1000.0, "method": "rk4", "substeps": 1, "rtol": 1e-12, "continuous": False, "saturate": True,
        "position_limits": True, "allow_unphysical": False, "seed": 0, "delay": 0,
    }  # fmt: skip
    assert record == {
        **robot, **none, "plant": arm_record(heavy), "payload": {"mass": 1.0, "com": [0.0] * 3, "inertia": None},
        "controller": {"name": "no_torque", "label": "no_torque", "parameters": {}}, "engine": "pinocchio",
        "reference": {"name": "Sinusoids", "duration": 0.1, "about": {}}, "options": options, "seed": 0,
        "friction": False, "friction_law": {"form": "none", "rate": 0.0}, "versions": versions(),
        "note": {"task": "waves"},
    }  # fmt: skip
    assert robot | {"errata": 0, "digest": 0} == {
        "robot": "lwr4plus", "reading": "computed", "digest": 0, "errata": 0, "joint_units": ["rad"] * 7, "file": None,
        "loaded_with": {},
    }  # fmt: skip
    springs = JointElasticity(np.full(7, 9e3), np.full(7, 5.0), "guessed")
    asked = Loop(
        elasticity=springs, encoders="link", encoder=Encoder(1e-3, 1e-5, 80.0), external=wind, loop="elastic", seed=3,
        friction=[symmetric(1.0, 0.5)] * 7,
    )  # fmt: skip
    record = prepare(lwr(), no_torque, joint_waves(0.1), asked).record()
    wanted = {
        "encoder": {"resolution": 1e-3, "noise": 1e-5, "cutoff_hz": 80.0}, "friction": True, "loop": "elastic",
        "elasticity": {"stiffness": [9e3] * 7, "damping": [5.0] * 7, "source": "guessed", "encoders": "link"},
        "external": {"name": "wind", "label": "wind", "parameters": {}}, "seed": 3, "payload": None, "note": {},
    }  # fmt: skip
    assert {name: record[name] for name in wanted} == wanted
    assert (record["friction_law"]["form"], record["friction_law"]["rate"]) == ("set-valued", 0.0)
    masses = [sum(link.body.mass for link in arm.chain.links) for arm in (setup.arm, setup.plant.arm)]
    assert masses[1] == pytest.approx(1.5 * masses[0] + 1.0)


def test_the_start_cannot_be_changed_and_sensors_are_fresh():
    setup = prepare(lwr(), no_torque, joint_waves(0.1), Loop(encoder=Encoder.of_bits(12), seed=3))
    with pytest.raises(ValueError, match="read-only"):
        setup.start[0, 0] = 1.0
    q, dq = setup.start
    first, second = setup.sensor(), setup.sensor()
    assert first is not second
    np.testing.assert_array_equal(first(q, dq)[0], second(q, dq)[0])
    exact = prepare(lwr(), no_torque, joint_waves(0.1), Loop()).sensor()
    np.testing.assert_array_equal(exact(q, dq), setup.start)  # without an encoder it is the true state


def slider(friction="none", **limits):
    arm = one_joint(**limits)
    return plant_of(arm, lwr_dyn.dynamics_of(arm), chosen_friction(arm, friction))


@pytest.mark.parametrize(("duration", "samples"), [(0.1, 101), (0.1 + 1e-13, 101), (0.1001, 102), (1e-9, 2)])
def test_samples_are_on_the_grid_and_the_last_is_not_before_the_end(duration, samples, monkeypatch):
    np.testing.assert_array_equal(Loop(rate=1000.0).times(duration), np.arange(samples) / 1000.0)
    monkeypatch.setattr(setup, "MOST_SAMPLES", 16)
    assert Loop(rate=64.0).times(0.25).size == 17
    with pytest.raises(OptionError, match=r"64 samples a second over 0\.26 s; allowed: at most 2e"):
        Loop(rate=64.0).times(0.26)


@pytest.mark.parametrize(
    ("loop", "duration", "words"),
    [
        (Loop(), np.nan, "duration: nan; allowed: a number above 0, in s"),
        (Loop(), 10001.0, r"1000 samples a second over 10001 s; allowed: at most 1e\+07 samples"),
        (Loop(delay=5), 0.004, "delay: 5 samples in a run of 4; allowed: a delay shorter than the run"),
    ],
)
def test_durations_that_cannot_be_sampled(loop, duration, words):
    with pytest.raises(OptionError, match=words):
        loop.times(duration)
    assert loop.times(0.005).size == 6


def test_the_integrator_is_that_of_the_method_with_its_substeps():
    def rates(t, y):
        return -y

    y = np.ones(1)
    three = Loop(substeps=3).integrator()(rates, 0.0, y, 1.0)
    np.testing.assert_array_equal(three, rk4(3)(rates, 0.0, y, 1.0))
    adaptive = Loop(method="dop853", rtol=1e-10).integrator()(rates, 0.0, y, 1.0)
    assert 0.0 < abs(adaptive[0] - np.exp(-1.0)) < 1e-9 < abs(three[0] - np.exp(-1.0))


def test_a_run_starts_on_its_reference_or_where_it_is_put_inside_the_limits():
    plant = slider(lower=-1.0, upper=1.0)
    motion = sampled_reference(Still(np.array([0.4]), 1.0), np.arange(3.0), 1)
    assert start_state(plant, motion, None, None).tolist() == [[0.4], [0.0]]
    assert start_state(plant, motion, [1.0], [2.0]).tolist() == [[1.0], [2.0]]
    for q0, dq0, error, words in (
        ([1.5], None, OptionError, r"q0 of joint_1: 1\.5; allowed: -1 to 1, or position_limits=False"),
        (None, [0.0, 0.0], ShapeError, "dq0"),
    ):
        with pytest.raises(error, match=words):
            start_state(plant, motion, q0, dq0)
    with pytest.raises(ShapeError, match=r"reference q: shape \(3, 1\); allowed: \(3, 2\)"):
        sampled_reference(Still(np.array([0.4]), 1.0), np.arange(3.0), 2)


def test_continuous_runs_take_controllers_that_keep_no_hidden_memory():
    class Remembers:
        def reset(self):
            """It has a state that no integrator sees."""

    for name in ("pid", "pd-gravity"):
        Loop(continuous=True).check(controllers()[name])
    with pytest.raises(OptionError, match="continuous: with a controller that remembers between calls"):
        Loop(continuous=True).check(Remembers())
    Loop().check(Remembers())


def test_the_rate_of_viscous_friction_is_that_of_a_braked_mass_and_bounds_the_step_of_rk4():
    damping, mass = 500.0, 2.0
    plant = slider("set-valued", viscous=damping, coulomb=0.0)
    stiff = slider("smooth", viscous=damping, coulomb=1000.0)
    q = np.zeros(1)
    assert friction_rate(slider(), q, Loop()) == 0.0
    assert friction_rate(plant, q, Loop()) == pytest.approx(damping / mass)
    rate = friction_rate(stiff, q, Loop(method="dop853"))
    need = int(np.ceil(rate / 1000.0 / STABLE))
    assert friction_rate(stiff, q, Loop(substeps=need)) == rate
    with pytest.raises(OptionError, match=f"smooth, .*substeps from {need} on, method dop853, or friction set"):
        friction_rate(stiff, q, Loop(substeps=need - 1))


def counted(reference, monkeypatch):
    """How often the reference is sampled by two runs' preparations."""
    seen, sample = [], type(reference).sample
    monkeypatch.setattr(type(reference), "sample", lambda self, t: seen.append(1) or sample(self, t))
    times = np.arange(11) / 100.0
    first, second = known_motion(reference, times), known_motion(reference, times)
    assert np.array_equal(first.q, second.q)
    known_motion(reference, np.arange(12) / 100.0)
    return len(seen)


def test_a_motion_that_cannot_change_is_followed_once_and_a_users_function_every_time(monkeypatch):
    arm, size = lwr_dyn.load("lwr4plus"), [0.2]
    own = lwr_dyn.reference(lambda t: [size[0] * t**3] * 7, arm, duration=1.0)
    path = lwr_dyn.reference("ist", arm)
    assert [counted(move, monkeypatch) for move in (path, own)] == [2, 3]  # of 11 and of 12 samples
    for count in range(2, 30):
        known_motion(path, np.arange(count) / 100.0)
    assert [count for _, count, _ in setup._motions] == list(range(14, 30))  # the last 16
