"""Controllers against the formulas of the paper, written out with B, C and g."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.paper_laws import PID, InverseDynamics, PDGravity, default_integral_gain
from lwr_dyn.control.protocol import WithMemory, describe, reset
from lwr_dyn.foundation.errors import OptionError, ShapeError

ROUNDING = 1e-11
"""[N m] Torques of hundreds of N m, by two orders of summation."""
ARM = lwr_dyn.load("lwr4plus")
ROAD_A, ROAD_B = (lwr_dyn.dynamics_of(ARM, engine) for engine in ("pinocchio", "newton-euler"))
RNG = np.random.default_rng(3)
q, dq, q_ref, dq_ref, ddq_ref = RNG.uniform(-1, 1, (5, 7))
STATE = (q, dq, q_ref, dq_ref, ddq_ref)
Kp, Kd = RNG.uniform(1, 100, (2, 7))
e, de = q_ref - q, dq_ref - dq


def close(found, expected):
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("model", [ROAD_A, ROAD_B], ids=["pinocchio", "newton-euler"])
class TestFormulas:
    def test_pd_gravity_is_the_papers(self, model):
        close(PDGravity(model, Kp, Kd)(0.0, *STATE), ROAD_B.gravity_vector(q) + Kp * e - Kd * dq)

    def test_pd_with_velocity_error(self, model):
        controller = PDGravity(model, Kp, Kd, velocity_error=True)
        close(controller(0.0, *STATE), ROAD_B.gravity_vector(q) + Kp * e + Kd * de)

    @pytest.mark.parametrize("feedforward", [True, False])
    @pytest.mark.parametrize("gravity", [True, False])
    def test_inverse_dynamics(self, model, feedforward, gravity):
        controller = InverseDynamics(model, Kp, Kd, feedforward=feedforward, gravity=gravity)
        y = Kp * e + Kd * de + feedforward * ddq_ref
        n = ROAD_B.coriolis_matrix(q, dq) @ dq + gravity * ROAD_B.gravity_vector(q)
        close(controller(0.0, *STATE), ROAD_B.mass_matrix(q) @ y + n)

    def test_pid_with_gravity(self, model):
        controller = PID(Kp, Kd, np.full(7, np.inf), dynamics=model)
        close(controller(0.0, *STATE), ROAD_B.gravity_vector(q) + Kp * e - Kd * dq)


class TestPID:
    def test_default_integral_gain_is_a_tenth_of_omega_cubed_b(self):
        b = np.array([2.0, 3.0])
        np.testing.assert_allclose(default_integral_gain(50.0**2 * b), 50.0**3 * b / 10, rtol=1e-15)

    def test_integral_is_the_sum_of_errors(self):
        controller = PID(Kp, Kd, np.full(7, np.inf), Ki=7.0)
        errors = RNG.uniform(-1, 1, (5, 7))
        for k, error in enumerate(errors):
            tau = controller(k * 0.01, q, dq, q + error, dq_ref, ddq_ref)
            close(tau, Kp * error + 7.0 * 0.01 * errors[:k].sum(axis=0) - Kd * dq)

    def test_back_calculation_pulls_the_integral_to_the_limit(self):
        limit, T_t, T = 1.0, 0.1, 1e-3
        controller = PID([10.0], [1.0], [limit], Ki=5.0, tracking_time=T_t)
        one, still, memory = np.ones(1), np.zeros(1), 0.0
        for k in range(3000):
            tau = controller(k * T, still, still, one, still, still)
            assert tau[0] == pytest.approx(10.0 + memory, abs=1e-12)
            memory += T * (5.0 + (limit - tau[0]) / T_t)
        # at rest: Ki e = (tau - limit) / T_t
        assert tau[0] == pytest.approx(limit + 5.0 * T_t, abs=1e-9)

    def test_without_a_limit_it_winds_up(self):
        controller = PID([10.0], [1.0], [np.inf], Ki=5.0)
        one, still = np.ones(1), np.zeros(1)
        for k in range(1001):
            tau = controller(k * 1e-3, still, still, one, still, still)
        assert tau[0] == pytest.approx(15.0, abs=1e-9)

    def test_reset_forgets(self):
        controller = PID(Kp, Kd, ARM.effort)
        first = controller(0.0, *STATE)
        assert not np.allclose(controller(0.5, *STATE), first)
        reset(controller)
        close(controller(0.9, *STATE), first)
        close(controller.integral, 0.0)

    def test_has_a_continuous_form(self):
        controller = PID(Kp, Kd, np.full(7, np.inf), Ki=3.0)
        assert isinstance(controller, WithMemory)
        tau, rate = controller.torque_and_rate(np.ones(7), *STATE)
        close(tau, Kp * e + 1.0 - Kd * dq)
        close(rate, 3.0 * e)

    @pytest.mark.parametrize("effort", [[1.0, 0.0], [1.0, np.nan], 3.0])
    def test_limits_are_checked(self, effort):
        with pytest.raises(OptionError, match="effort"):
            PID(1.0, 1.0, effort)


BUILDERS = {
    "pd-gravity": lambda **gains: PDGravity(ROAD_A, **gains),
    "pid": lambda **gains: PID(effort=ARM.effort, **gains),
    "inverse-dynamics": lambda **gains: InverseDynamics(ROAD_A, **gains),
}


@pytest.mark.parametrize("name", BUILDERS)
class TestAnyController:
    @pytest.mark.parametrize("gain", ["Kp", "Kd"])
    @pytest.mark.parametrize("bad", [0.0, -1.0, [1, 1, 1, -1, 1, 1, 1]])
    def test_gains_not_positive(self, name, gain, bad):
        with pytest.raises(OptionError, match=gain):
            BUILDERS[name](**({"Kp": 1.0, "Kd": 1.0} | {gain: bad}))

    @pytest.mark.parametrize("bad", [[1.0, 2.0], np.nan, "many"])
    def test_gains_of_another_shape(self, name, bad):
        with pytest.raises(ShapeError, match="Kp"):
            BUILDERS[name](Kp=bad, Kd=1.0)

    def test_describes_itself_in_json(self, name):
        import json

        record = json.loads(json.dumps(describe(BUILDERS[name](Kp=2.0, Kd=3.0))))
        assert record["name"] == name
        assert record["parameters"]["Kp"] == [2.0] * 7

    def test_leaves_its_arguments_alone(self, name):
        controller = BUILDERS[name](Kp=2.0, Kd=3.0)
        before = [x.copy() for x in STATE]
        controller(0.0, *STATE)
        for x, y in zip(before, STATE, strict=True):
            np.testing.assert_array_equal(x, y)


@pytest.mark.parametrize("option", [{"Ki": 0.0}, {"Ki": -1.0}, {"omega_n": 0.0}, {"tracking_time": -0.1}])
def test_pid_options(option):
    with pytest.raises(OptionError):
        PID(1.0, 1.0, ARM.effort, **option)


def test_a_plain_function_is_described_by_its_name():
    def damper(t, q, dq, q_ref, dq_ref, ddq_ref):
        return -dq

    assert describe(damper) == {"name": "damper", "label": "damper", "parameters": {}}
    reset(damper)
