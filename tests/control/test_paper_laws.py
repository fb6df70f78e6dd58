"""Controllers against the formulas of the paper, written out with B, C and g."""

from itertools import product

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.gains import worst_case_gains
from lwr_dyn.control.paper_laws import PID, InverseDynamics, PDGravity, default_integral_gain, tuned_pd_gravity
from lwr_dyn.control.protocol import WithMemory, describe, reset
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError

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
def test_the_formulas_are_those_of_the_paper(model):
    g, free = ROAD_B.gravity_vector(q), np.full(7, np.inf)
    before = [x.copy() for x in STATE]
    close(PDGravity(model, Kp, Kd)(0.0, *STATE), g + Kp * e - Kd * dq)
    close(PDGravity(model, Kp, Kd, velocity_error=True)(0.0, *STATE), g + Kp * e + Kd * de)
    close(PID(Kp, Kd, free, dynamics=model)(0.0, *STATE), g + Kp * e - Kd * dq)
    for feedforward, gravity in product((True, False), repeat=2):
        law = InverseDynamics(model, Kp, Kd, feedforward=feedforward, gravity=gravity)
        y = Kp * e + Kd * de + feedforward * ddq_ref
        close(law(0.0, *STATE), ROAD_B.mass_matrix(q) @ y + ROAD_B.coriolis_matrix(q, dq) @ dq + gravity * g)
    np.testing.assert_array_equal(before, STATE)  # the laws leave their arguments alone


def test_own_gains_are_those_of_the_file_and_an_arm_without_them_has_none():
    wam = lwr_dyn.load("wam7")
    law = tuned_pd_gravity(wam, lwr_dyn.dynamics_of(wam), own_gains=True)
    assert (law.Kp.tolist(), law.Kd.tolist()) == (wam.gains.Kp.tolist(), wam.gains.Kd.tolist())
    assert tuned_pd_gravity(wam, lwr_dyn.dynamics_of(wam)).Kp.tolist() == worst_case_gains(wam).Kp.tolist()
    with pytest.raises(MissingDataError, match="controller gains not given; needed for own_gains"):
        tuned_pd_gravity(ARM, ROAD_A, own_gains=True)


def test_the_integral_of_the_pid_is_the_sum_of_errors_and_reset_forgets_it():
    controller = PID(Kp, Kd, np.full(7, np.inf), Ki=7.0)
    errors = RNG.uniform(-1, 1, (5, 7))
    for _ in range(2):
        for k, error in enumerate(errors):
            tau = controller(k * 0.01, q, dq, q + error, dq_ref, ddq_ref)
            close(tau, Kp * error + 7.0 * 0.01 * errors[:k].sum(axis=0) - Kd * dq)
        reset(controller)
        close(controller.integral, 0.0)
    assert isinstance(controller, WithMemory)
    tau, rate = controller.torque_and_rate(np.ones(7), *STATE)
    close(tau, Kp * e + 1.0 - Kd * dq)
    close(rate, 7.0 * e)
    b = np.array([2.0, 3.0])
    np.testing.assert_allclose(default_integral_gain(50.0**2 * b), 50.0**3 * b / 10, rtol=1e-15)


@pytest.mark.parametrize("limit", [1.0, np.inf])
def test_back_calculation_pulls_the_integral_to_the_limit_and_without_one_it_winds_up(limit):
    T_t, T, one, still, memory = 0.1, 1e-3, np.ones(1), np.zeros(1), 0.0
    controller = PID([10.0], [1.0], [limit], Ki=5.0, tracking_time=T_t)
    for k in range(3000):
        tau = controller(k * T, still, still, one, still, still)
        assert tau[0] == pytest.approx(10.0 + memory, abs=1e-9)
        memory += T * (5.0 + (min(limit - tau[0], 0.0)) / T_t)
    # at rest: Ki e = (tau - limit) / T_t
    assert tau[0] == pytest.approx(limit + 5.0 * T_t if limit < np.inf else 10.0 + 5.0 * 2.999, abs=1e-9)


BUILDERS = {
    "pd-gravity": lambda **gains: PDGravity(ROAD_A, **gains),
    "pid": lambda **gains: PID(effort=ARM.effort, **gains),
    "inverse-dynamics": lambda **gains: InverseDynamics(ROAD_A, **gains),
}
BAD = [
    *(({gain: bad}, OptionError, f"{gain}: .*; allowed: numbers above 0")
      for gain in ("Kp", "Kd") for bad in (0.0, -1.0, [1, 1, 1, -1, 1, 1, 1])),
    ({"Kp": [1.0, 2.0]}, ShapeError, r"Kp: shape \(2,\); allowed: one number, or shape \(7,\)"),
    ({"Kd": np.nan}, ShapeError, "Kd: nan"), ({"Kp": "many"}, ShapeError, "Kp: not an array of numbers"),
]  # fmt: skip


@pytest.mark.parametrize("name", BUILDERS)
@pytest.mark.parametrize(("gains", "error", "words"), BAD)
def test_gains_that_are_none_are_refused(name, gains, error, words):
    assert describe(BUILDERS[name](Kp=2.0, Kd=3.0))["parameters"]["Kp"] == [2.0] * 7
    with pytest.raises(error, match=words):
        BUILDERS[name](**({"Kp": 1.0, "Kd": 1.0} | gains))


@pytest.mark.parametrize(
    ("option", "words"),
    [({"Ki": 0.0}, "Ki"), ({"Ki": -1.0}, "Ki"), ({"omega_n": 0.0}, "omega_n"), ({"tracking_time": -0.1}, "tracking"),
     ({"effort": [1.0, 0.0]}, "effort"), ({"effort": [1.0, np.nan]}, "effort"), ({"effort": 3.0}, "effort")],
)  # fmt: skip
def test_options_of_the_pid_that_cannot_be(option, words):
    with pytest.raises(OptionError, match=words):
        PID(1.0, 1.0, **({"effort": ARM.effort} | option))
