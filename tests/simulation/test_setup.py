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
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop, prepare, versions
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


def test_continuous_needs_the_true_state_and_no_hidden_memory():
    with pytest.raises(OptionError, match="encoder"):
        simulate(lwr(), no_torque, joint_waves(), continuous=True, encoder=Encoder())

    class Counting:
        def reset(self): ...

        def __call__(self, t, q, *reference):
            return np.zeros_like(q)

    with pytest.raises(OptionError, match="continuous"):
        simulate(lwr(), Counting(), joint_waves(), continuous=True)


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
