"""What cannot be simulated is refused before anything moves, in one line that says what is allowed."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import (
    DivergenceError,
    LwrDynError,
    MissingDataError,
    NotPhysicalError,
    OptionError,
    ShapeError,
    UnknownNameError,
)
from lwr_dyn.model.arm import arm_with_scaled_inertia
from lwr_dyn.model.chain import Body, with_bodies
from lwr_dyn.model.run import Run
from lwr_dyn.simulation import setup
from lwr_dyn.simulation.arm_friction import chosen_friction
from lwr_dyn.simulation.integrators import rk4
from lwr_dyn.simulation.plant import Encoder, plant_of
from lwr_dyn.simulation.setup import (
    STABLE,
    Loop,
    friction_rate,
    known_motion,
    prepare,
    sampled_reference,
    start_state,
    versions,
)
from lwr_dyn.simulation.simulate import free_swing, no_torque, simulate
from tests.simulation.sample_runs import Still, controllers, joint_waves, lwr, lwr_dynamics, one_joint

OPTIONS = [
    ("rate", 0.0), ("rate", -1.0), ("rate", np.nan), ("rate", np.inf), ("rate", "fast"), ("substeps", 0),
    ("substeps", 1.5), ("rtol", 0.0), ("method", "euler"), ("duration", 0.0), ("duration", -1.0), ("duration", np.inf),
    ("payload", -1.0), ("payload", np.nan), ("seed", -1), ("q0", np.full(7, 3.0)), ("q0", np.full(7, -3.0)),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value"), OPTIONS)
def test_an_option_outside_what_is_allowed(name, value):
    with pytest.raises(OptionError, match=f"{name}.*allowed: ") as error:
        simulate(lwr(), no_torque, joint_waves(), **{name: value})
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "options",
    [{"q0": np.zeros(6)}, {"dq0": [np.nan] * 7}, {"payload": 1.0, "payload_com": [0, 0]}, {"engine": "two joints"}],
)
def test_another_shape(options):
    if "engine" in options:
        options = {"engine": lwr_dyn.dynamics_of(one_joint())}
    with pytest.raises(ShapeError):
        simulate(lwr(), no_torque, joint_waves(), **options)


def test_a_reference_for_another_arm():
    with pytest.raises(ShapeError, match="reference"):
        simulate(lwr(), no_torque, Still(np.zeros(3), 1.0))


@pytest.mark.parametrize("torque", [np.zeros(6), 0.0, np.zeros((1, 7)), "none", [[1.0], [2.0, 3.0]]])
@pytest.mark.parametrize("continuous", [False, True])
def test_a_controller_that_gives_something_else(torque, continuous):
    with pytest.raises(ShapeError, match="torque of the controller"):
        simulate(lwr(), lambda *state: torque, joint_waves(), duration=0.01, continuous=continuous)


def test_a_list_of_numbers_is_a_torque():
    run = simulate(lwr(), lambda *state: [1.0] * 7, joint_waves(), duration=0.01)
    assert (run.tau_command == 1.0).all()


def test_an_engine_that_does_not_exist():
    with pytest.raises(UnknownNameError, match="pinocchio"):
        simulate(lwr(), no_torque, joint_waves(), engine="ode")


def test_an_arm_without_masses():
    arm = lwr_dyn.load("lwr4")
    with pytest.raises(MissingDataError, match="masses"):
        simulate(arm, no_torque, Still(np.zeros(arm.n), 1.0))


def test_an_infeasible_arm_is_refused_unless_allowed():
    bodies = list(lwr().chain.bodies)
    bodies[2] = Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.5]))
    arm = lwr().with_chain(with_bodies(lwr().chain, bodies))
    with pytest.raises(NotPhysicalError, match="link_3"):
        free_swing(arm, duration=0.01, engine="newton-euler")
    assert free_swing(arm, duration=0.01, engine="newton-euler", allow_unphysical=True).t.size == 11


@pytest.mark.parametrize("option", [{"resolution": -1.0}, {"noise": -1.0}, {"noise": np.nan}])
def test_an_encoder_that_cannot_be(option):
    with pytest.raises(OptionError, match="encoder"):
        Encoder(**option)


def test_an_encoder_too_slow_for_the_loop():
    with pytest.raises(OptionError, match="cut-off"):
        simulate(lwr(), no_torque, joint_waves(), rate=100.0, encoder=Encoder(cutoff_hz=80.0))


def test_a_continuous_run_is_checked_with_its_controller():
    with pytest.raises(OptionError, match="encoder"):
        simulate(lwr(), no_torque, joint_waves(), continuous=True, encoder=Encoder())


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan])
def test_masses_cannot_be_scaled_away(factor):
    with pytest.raises(OptionError, match="mass factor"):
        arm_with_scaled_inertia(lwr(), factor)


class TestDivergence:
    @pytest.mark.slow
    @pytest.mark.parametrize("method", ["rk4", "dop853"])
    @pytest.mark.parametrize("position_limits", [False, True])
    def test_it_names_time_and_joint_and_keeps_its_samples(self, method, position_limits):
        def push_joint_6(t, q, dq, *reference):
            return lwr_dynamics().gravity_vector(q) + np.where(np.arange(7) == 5, 1e3 * np.sign(dq) * (1 + dq**2), 0.0)

        start = np.where(np.arange(7) == 5, 0.1, 0.0)
        with pytest.raises(DivergenceError, match=r"t = 0\.\d+ s: joint_6") as error:
            simulate(
                lwr(), push_joint_6, joint_waves(), dq0=start, saturate=False, duration=1.0, method=method,
                position_limits=position_limits, rtol=1e-6,
            )  # fmt: skip
        run = error.value.run
        assert isinstance(run, Run)
        assert run.t[-1] == error.value.t < 1.0
        assert np.isfinite(run.q).all()
        assert run.meta["diverged"]["joint"] == error.value.joint == "joint_6"
        assert all(np.shape(w) == run.t.shape for w in run.work.values())

    @pytest.mark.parametrize("continuous", [False, True])
    @pytest.mark.parametrize("at", [0.0, 0.005, 0.02])
    def test_a_torque_that_is_not_a_number(self, continuous, at):
        def fails(t, q, *state):
            return np.where((np.arange(7) == 2) & (t >= at), np.nan, 0.0)

        with pytest.raises(DivergenceError, match="joint_3: torque command nan") as error:
            simulate(lwr(), fails, joint_waves(), duration=0.02, continuous=continuous, method="rk4")
        assert error.value.t == pytest.approx(at, abs=0.0011)
        assert error.value.run.t[-1] == error.value.t
        assert isinstance(error.value, LwrDynError)

    def test_unstable_gains(self):
        law = controllers()["inverse-dynamics"]
        law.Kd = np.full(7, 5000.0)
        with pytest.raises(DivergenceError, match="higher rate or lower gains"):
            simulate(lwr(), law, joint_waves(), saturate=False, q0=joint_waves().middle + 0.01)


def test_a_setup_is_its_record_and_may_have_another_plant():
    heavy = arm_with_scaled_inertia(lwr(), 1.5)
    setup = prepare(lwr(), no_torque, joint_waves(0.1), Loop(plant=heavy, payload=1.0, meta={"task": "waves"}))
    record = json.loads(str(setup))
    assert record == json.loads(json.dumps(setup.record()))
    assert (record["robot"], record["options"]["rate"], record["note"]) == ("lwr4plus", 1000.0, {"task": "waves"})
    assert record["payload"] == {"mass": 1.0, "com": [0.0, 0.0, 0.0], "inertia": None}
    assert record["versions"] == versions()
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


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ({"rate": 0.0}, "rate: 0.0; allowed: a number above 0"),
        ({"rtol": np.nan}, "rtol: nan; allowed: a number above 0"),
        ({"method": "euler"}, "method: 'euler'; allowed: rk4, dop853, radau"),
        ({"substeps": 1001}, "substeps: 1001; allowed: a whole number from 1 to 1000"),
        ({"seed": -1}, "seed: -1; allowed: a whole number from 0 on"),
        ({"seed": 0.5}, "seed: 0.5; allowed: a whole number from 0 on"),
    ],
)
def test_a_value_outside_what_is_allowed(option, message):
    with pytest.raises(OptionError) as fault:
        Loop(**option)
    assert str(fault.value) == message


@pytest.mark.parametrize(("duration", "samples"), [(0.1, 101), (0.1 + 1e-13, 101), (0.1001, 102), (1e-9, 2)])
def test_samples_are_on_the_grid_and_the_last_is_not_before_the_end(duration, samples):
    t = Loop(rate=1000.0).times(duration)
    assert t.size == samples
    np.testing.assert_array_equal(t, np.arange(samples) / 1000.0)
    assert t[-1] >= duration * (1 - 1e-9)


def test_durations_that_cannot_be_sampled():
    for duration in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(OptionError, match=r"duration: .*; allowed: a number above 0, in s"):
            Loop().times(duration)
    with pytest.raises(OptionError, match=r"1000 samples a second over 10001 s; allowed: at most 1e\+07 samples"):
        Loop().times(10001.0)


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
    with pytest.raises(OptionError, match=r"q0 of joint_1: 1\.5; allowed: -1 to 1, or position_limits=False"):
        start_state(plant, motion, [1.5], None)
    with pytest.raises(ShapeError, match="dq0"):
        start_state(plant, motion, None, [0.0, 0.0])
    with pytest.raises(ShapeError, match=r"reference q: shape \(3, 1\); allowed: \(3, 2\)"):
        sampled_reference(Still(np.array([0.4]), 1.0), np.arange(3.0), 2)


def test_continuous_runs_take_controllers_that_keep_no_hidden_memory():
    class Remembers:
        def reset(self):
            """It has a state that no integrator sees."""

    for name in ("pid", "pd-gravity"):
        Loop(continuous=True).check(controllers()[name])
    with pytest.raises(OptionError, match="encoder: given for a continuous run"):
        Loop(continuous=True, encoder=Encoder.of_bits(12)).check(controllers()["pid"])
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


def test_a_delay_longer_than_the_run_is_refused():
    options = Loop(delay=5)
    assert options.times(0.005).size == 6
    with pytest.raises(OptionError, match="delay: 5 samples in a run of 4; allowed: a delay shorter than the run"):
        options.times(0.004)


def counted(reference, monkeypatch):
    """How often the reference is sampled by two runs' preparations."""
    seen, sample = [], type(reference).sample
    monkeypatch.setattr(type(reference), "sample", lambda self, t: seen.append(1) or sample(self, t))
    times = np.arange(11) / 100.0
    first, second = known_motion(reference, times), known_motion(reference, times)
    assert np.array_equal(first.q, second.q)
    known_motion(reference, np.arange(12) / 100.0)
    return len(seen)


def test_a_motion_that_cannot_change_is_followed_once(monkeypatch):
    arm = lwr_dyn.load("lwr4plus")
    assert counted(lwr_dyn.reference("ist", arm), monkeypatch) == 2  # of 11 and of 12 samples


def test_a_users_function_is_followed_every_time(monkeypatch):
    arm, size = lwr_dyn.load("lwr4plus"), [0.2]
    own = lwr_dyn.reference(lambda t: [size[0] * t**3] * 7, arm, duration=1.0)
    assert counted(own, monkeypatch) == 3


def test_few_motions_are_kept():
    arm = lwr_dyn.load("lwr4plus")
    path = lwr_dyn.reference("ist", arm)
    for count in range(2, 30):
        known_motion(path, np.arange(count) / 100.0)
    assert len(setup._motions) <= 16
