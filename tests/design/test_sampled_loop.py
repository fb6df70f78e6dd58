"""The linear map of the sampled loop against the simulated, nonlinear loop, and against cases known by hand."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lwr_dyn
from lwr_dyn.control.gains import LinearFeedback
from lwr_dyn.control.paper_laws import PID, InverseDynamics, PDGravity
from lwr_dyn.design import sampled_loop
from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, RestingPlant, Sampling, law_at_rest, rigid_plant
from lwr_dyn.foundation.errors import DivergenceError, OptionError
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.simulate import simulate
from tests.design import margin_cases as cases
from tests.design.margin_cases import BENT
from tests.simulation.sample_runs import MIDDLE, WORST_CASE, Still, lwr, lwr_dynamics, one_joint

UPRIGHT = np.array([0.3, 0.02, -0.5, -0.1, 0.8, 0.4, 0.0])
TWO = np.array([BENT, 0.4 * BENT])
KP, KD = 2500 * WORST_CASE, 100 * WORST_CASE


def pd(dynamics=None):
    return PDGravity(dynamics or lwr_dynamics(), KP, KD)


def pid():
    return PID(KP, KD, np.full(7, np.inf), 5 * 50 * KP, lwr_dynamics())


def unit_masses():
    return InverseDynamics(lwr_dynamics(), 2500, 100)


def id_without_gravity():
    return InverseDynamics(lwr_dynamics(), 1600, 80, gravity=False)


def test_slopes_of_gravity_are_computed_once_where_the_law_s_model_is_the_plant(monkeypatch):
    asked, own = [], sampled_loop.gravity_stiffness
    monkeypatch.setattr(sampled_loop, "gravity_stiffness", lambda *given: (asked.append(given[0]), own(*given))[1])
    dynamics, q = lwr_dynamics(), np.array([UPRIGHT, BENT])
    one, rows = RestingLoop.of(dynamics, pd(dynamics), q), np.array([1])
    assert asked == [dynamics]
    for other in (lwr_dyn.dynamics_of(lwr()), lwr_dyn.dynamics_of(arm_with_payload(lwr(), 2.0))):
        two = RestingLoop.of(dynamics, pd(other), q)
        assert asked.pop() is other
        same = two.feedback.position.tobytes() == one.feedback.position.tobytes()
        assert same == (other.inverse_dynamics(BENT, BENT, BENT) == dynamics.inverse_dynamics(BENT, BENT, BENT)).all()
    again = RestingLoop.of_plant(one.plant.at(rows), pd(dynamics).linear_feedback(q[rows]), q[rows])
    assert again.feedback.position.tobytes() == one.feedback.position[rows].tobytes()


def simulated_and_linear(controller, q, sampling, plant=None, encoder=None):
    """Small deviations (k, 14) from rest, simulated, and by powers of the map, up to where they are no longer small."""
    offset = 1e-9 * np.arange(1, 8)
    try:
        run = simulate(
            lwr(), controller, Still(q, 0.3), q0=q + offset, rate=sampling.rate, delay=sampling.delay,
            encoder=encoder, plant=plant, saturate=False, position_limits=False,
        )  # fmt: skip
    except DivergenceError as fault:
        run = fault.run
    loop = RestingLoop.of(lwr_dyn.dynamics_of(plant or lwr()), controller, q[None])
    step, law = loop.step_matrices(sampling)[0], loop.feedback
    z = np.zeros(len(step))
    z[:7] = offset
    if sampling.cutoff_hz:
        z[14:21] = offset
    if sampling.delay:  # the first command acts until it arrives
        z[-7 * sampling.delay :] = np.tile(-law.position[0] @ offset, sampling.delay)
    rows = []
    for _ in run.t:
        rows.append(z[:14])
        z = step @ z
    small = np.abs(run.dq).max(axis=1) < 1e-4
    end = len(small) if small.all() else int(np.argmin(small))
    return np.hstack([run.q - q, run.dq])[:end], np.array(rows)[:end], loop.radius(sampling)[0]


@pytest.mark.parametrize(
    ("make", "pose", "sampling", "unstable"),
    [
        (pd, UPRIGHT, Sampling(1000.0), True),
        (pd, UPRIGHT, Sampling(8000.0), False),
        (pd, BENT, Sampling(1000.0), False),
        (pd, BENT, Sampling(1000.0, 3), True),
        (pid, BENT, Sampling(500.0, 1), True),
        (unit_masses, BENT, Sampling(1000.0, 14), True),
    ],
)
def test_small_deviations_of_the_simulated_loop_follow_the_map(make, pose, sampling, unstable):
    found, linear, radius = simulated_and_linear(make(), pose, sampling)
    assert (radius > GROWS) is np.bool_(unstable)
    assert len(found) > 3
    assert (np.abs(found[-1]).max() > 10 * np.abs(found[0]).max()) is np.bool_(unstable)
    np.testing.assert_allclose(found, linear, atol=1e-3 * np.abs(linear).max())


def test_the_plants_payload_and_the_velocity_filter_are_in_the_map():
    carrying, sampling = arm_with_payload(lwr(), 5.0), Sampling(300.0, 1, 100.0)
    controller = pd(lwr_dyn.dynamics_of(carrying))
    found, linear, radius = simulated_and_linear(controller, BENT, sampling, carrying, Encoder(0.0, 0.0, 100.0))
    assert radius > 1.05
    assert len(found) > 10
    np.testing.assert_allclose(found, linear, atol=1e-3 * np.abs(linear).max())
    unfiltered = simulated_and_linear(controller, BENT, Sampling(300.0, 1), carrying)[1]
    rows = min(len(found), len(unfiltered))
    assert np.abs(found[:rows] - unfiltered[:rows]).max() > 0.1 * np.abs(linear).max()


@pytest.mark.slow
@pytest.mark.parametrize("make", [pd, pid, id_without_gravity])
def test_the_matrix_of_one_step_is_the_derivative_of_the_simulated_step(make):
    """By central differences at rest, where the plant's gravity is held exactly."""
    controller, h = make(), 1e-4
    loop = RestingLoop.of(lwr_dynamics(), controller, BENT[None])
    A, b = loop.plant.held(1e-3)
    gravity = lwr_dynamics().gravity_vector(BENT)
    law = loop.feedback

    def after(x, v):
        tau = gravity - law.position[0] @ x - law.velocity[0] @ v
        run = simulate(lwr(), lambda *_: tau, Still(BENT, 1e-3), q0=BENT + x, dq0=v, substeps=8, saturate=False)
        return np.concatenate([run.q[-1] - BENT, run.dq[-1]])

    columns = [(after(*(h * e).reshape(2, 7)) - after(*(-h * e).reshape(2, 7))) / (2 * h) for e in np.eye(14)]
    step = A[0] - b[0] @ np.hstack([law.position[0], law.velocity[0]])
    np.testing.assert_allclose(np.array(columns).T, step, atol=1e-6 * np.abs(step).max())
    command = controller(0.0, BENT + h * np.eye(7)[3], h * np.eye(7)[1], BENT, *np.zeros((2, 7)))
    back = make()(0.0, BENT - h * np.eye(7)[3], -h * np.eye(7)[1], BENT, *np.zeros((2, 7)))
    expected = -(law.position[0][:, 3] + law.velocity[0][:, 1])  # less dg/dq where the controller adds g
    np.testing.assert_allclose((command - back) / (2 * h), expected, rtol=1e-5, atol=1e-4)


def test_at_all_poses_the_damping_alone_is_unstable_where_its_product_with_a_sample_passes_two():
    q = np.random.default_rng(3).uniform(lwr().lower, lwr().upper, (300, 7))
    loop = RestingLoop.of(lwr_dynamics(), PDGravity(lwr_dynamics(), 1e-9, KD), q)
    unstable = loop.radius(Sampling(1000.0)) > GROWS
    assert 0.1 < unstable.mean() < 0.4
    np.testing.assert_array_equal(unstable, loop.damping_rates() / 1000.0 > 2.0)


def test_a_slider_known_by_hand():
    """m dv = -Kd v held: v' = (1 - T Kd / m) v. Late by one sample: z^2 - z + T Kd / m, unstable above 1."""
    dynamics = SimpleNamespace(mass_matrix=lambda q: np.full((len(q), 1, 1), 2.0),
                               gravity_vector=lambda q: 0.0 * q)  # fmt: skip
    for plant in (dynamics, lwr_dyn.dynamics_of(one_joint(mass=2.0))):

        def radius(Kd, delay, plant=plant):
            law = LinearFeedback(np.zeros((1, 1, 1)), np.full((1, 1, 1), Kd))
            loop = RestingLoop.of(plant, SimpleNamespace(linear_feedback=lambda q: law), np.zeros((1, 1)))
            return loop.radius(Sampling(100.0, delay))[0]

        assert radius(500.0, 0) == pytest.approx(1.5)  # |1 - 2.5|
        assert radius(0.0, 0) == pytest.approx(1.0, abs=1e-7)
        assert radius(0.0, 3) <= GROWS
        assert radius(240.0, 1) == pytest.approx(np.sqrt(1.2))
        assert radius(160.0, 1) <= GROWS


@pytest.mark.parametrize("bad", [{"rate": 0.0}, {"rate": float("nan")}, {"delay": -1}, {"delay": 101}, {"delay": 1.5}])
def test_bad_sampling_and_a_singular_mass_matrix_are_refused(bad):
    with pytest.raises(OptionError, match="allowed"):
        Sampling(**bad)
    flat = SimpleNamespace(mass_matrix=lambda q: np.zeros((len(q), 2, 2)), gravity_vector=lambda q: 0.0 * q)
    with pytest.raises(OptionError, match="mass matrix: singular"):
        RestingLoop.of(flat, pd(), np.zeros((1, 2)))


@pytest.mark.parametrize("T", [1e-3, 0.3])
def test_a_pendulum_and_a_falling_one_known_by_hand(T):
    w = np.array([30.0, 5.0])
    A, B = np.zeros((2, 2, 2)), np.zeros((2, 2, 1))
    A[:, 0, 1], A[:, 1, 0], B[:, 1, 0] = 1.0, [-(w[0] ** 2), w[1] ** 2], 1.0
    Ad, Bd = RestingPlant(A, B, np.eye(1, 2), np.eye(1, 2, 1)).held(T)
    c, s = np.array([np.cos(w[0] * T), np.cosh(w[1] * T)]), np.array([np.sin(w[0] * T), np.sinh(w[1] * T)])
    square = np.array([w[0] ** 2, -(w[1] ** 2)])
    np.testing.assert_allclose(Ad[:, 0, 0], c, rtol=1e-12)
    np.testing.assert_allclose(Ad[:, 0, 1], s / w, rtol=1e-12)
    np.testing.assert_allclose(Bd[:, 0, 0], (1 - c) / square, rtol=1e-9)
    np.testing.assert_allclose(Bd[:, 1, 0], s / w, rtol=1e-12)


def test_a_part_of_the_poses_is_the_plant_of_these_poses():
    q = np.random.default_rng(2).uniform(-1, 1, (5, 7))
    part, alone = rigid_plant(lwr_dynamics(), q).at(np.array([3])), rigid_plant(lwr_dynamics(), q[3:4])
    np.testing.assert_allclose(part.held(1e-3)[0], alone.held(1e-3)[0], rtol=1e-9, atol=1e-12)
    assert (part.size, part.n) == (14, 7)


def test_a_held_step_is_that_of_the_equations_of_motion():
    """The held step is what the equations of motion do near rest."""
    plant, dynamics, T, h = rigid_plant(lwr_dynamics(), MIDDLE[None]), lwr_dynamics(), 0.02, 1e-6
    Ad, Bd = plant.held(T)
    z, u = h * np.linspace(-1, 1, 14), h * np.linspace(2, 3, 7)
    tau = dynamics.gravity_vector(MIDDLE) + u

    def rate(t, y):
        return np.concatenate([y[7:], dynamics.forward_dynamics(y[:7], y[7:], tau)])

    end = solve_ivp(rate, (0, T), np.concatenate([MIDDLE, np.zeros(7)]) + z, rtol=1e-12, atol=1e-16).y[:, -1]
    found = end - np.concatenate([MIDDLE, np.zeros(7)])
    expected = Ad[0] @ z + Bd[0] @ u
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())


def test_a_step_with_delays_is_what_u_does_piece_by_piece():
    """The step with delays of a sample and a part is what u, piece by piece, does to the plant."""
    loop = RestingLoop.of(cases.dynamics(), cases.law("pd-gravity"), BENT[None])
    sampling, f = Sampling(1000.0, 2), 0.3e-3
    step = loop.step_matrices(sampling, f)[0]
    rng = np.random.default_rng(0)
    z, sent = rng.normal(size=14), rng.normal(size=(3, 7))  # newest first
    state = np.concatenate([z, sent.ravel()])
    for _ in range(4):
        u = -loop.feedback.position[0] @ z[:7] - loop.feedback.velocity[0] @ z[7:]
        for T, torque in ((f, sent[2]), (1e-3 - f, sent[1])):
            A, b = loop.plant.held(T)
            z = A[0] @ z + b[0] @ torque
        sent = np.array([u, *sent[:2]])
        state = step @ state
        np.testing.assert_allclose(state, np.concatenate([z, sent.ravel()]), rtol=1e-9, atol=1e-9)
    twice = RestingLoop.of(cases.dynamics(), cases.law("pd-gravity"), BENT[None]).step_matrices(Sampling(), scale=2.0)
    A, b = loop.plant.held(1e-3)
    law_rows = np.hstack([loop.feedback.position[0], loop.feedback.velocity[0]])
    np.testing.assert_allclose(twice[0], A[0] - 2 * b[0] @ law_rows, atol=1e-9)


def plain(controller):
    """The same controller as a function that knows nothing of linear forms."""
    return lambda *state: controller(*state)


def test_differences_find_the_feedback_of_a_law_and_how_it_bends():
    for name in ("pd-gravity", "inverse-dynamics"):
        own = RestingLoop.of(cases.dynamics(), cases.law(name), TWO)
        found = law_at_rest(plain(cases.law(name)), TWO)
        assert found.by_differences
        loop = RestingLoop.of_plant(own.plant, found.feedback, TWO)
        for matrix in ("position", "velocity"):
            mine, exact = getattr(loop.feedback, matrix), getattr(own.feedback, matrix)
            np.testing.assert_allclose(mine, exact, atol=2e-6 * np.abs(exact).max())
        np.testing.assert_allclose(loop.radius(Sampling(1000.0, 1)), own.radius(Sampling(1000.0, 1)), atol=1e-7)
        assert found.bend < 1e-3
    assert law_at_rest(cases.law("pd-gravity"), TWO).notes == ()
    sided = law_at_rest(lambda *s: 100 * (s[3] - s[1]) - 20 * np.maximum(s[2], 0.0), TWO)
    assert sided.bend == pytest.approx(0.2)
    weak = law_at_rest(lambda *s: -0.5 * np.maximum(s[2], 0.0), TWO)
    assert weak.bend == pytest.approx(2.0)  # sides 0.5 and 0 about a middle of 0.25


def test_a_law_that_is_not_smooth_at_rest_is_named():
    def dry(t, q, dq, q_ref, dq_ref, ddq_ref):
        return 100 * (q_ref - q) - 20 * dq - 0.5 * np.sign(dq)

    notes = law_at_rest(dry, TWO).notes
    assert "linearised by central differences" in notes[0]
    bent = law_at_rest(lambda *s: -100 * (s[1] - s[3]) - 20 * np.maximum(s[2], 0.0), TWO)
    assert bent.bend == pytest.approx(0.2)
    assert "not smooth at rest" in bent.notes[1]


class Counting:
    """An integral that only its answers show."""

    def __init__(self):
        self.sum = 0.0

    def __call__(self, t, q, dq, q_ref, dq_ref, ddq_ref):
        self.sum = self.sum + (q_ref - q)
        return self.sum - dq


class WithReset(Counting):
    def reset(self):
        self.sum = 0.0


@pytest.mark.parametrize("make", [Counting, WithReset])
def test_a_controller_with_memory_is_refused(make):
    with pytest.raises(
        OptionError, match=r"remembers between calls.*allowed: a controller without memory, or with lin"
    ):
        law_at_rest(make(), TWO)


@pytest.mark.parametrize(
    ("answer", "fault"), [(np.zeros(3), "shape"), (np.full(7, np.nan), "not finite"), (1.0, "shape")]
)
def test_torques_that_are_no_torques_are_refused(answer, fault):
    with pytest.raises(OptionError, match=fault):
        law_at_rest(lambda *_: answer, TWO)
