"""The engine "kernels": single states and rows beside Pinocchio and road B; its compiled step beside the integrator."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.held_step import step_table
from lwr_dyn.codegen.kernels.single_state import closed_because
from lwr_dyn.control.paper_laws import InverseDynamics
from lwr_dyn.dynamics.protocol import FUNCTIONS, mechanical_energy
from lwr_dyn.foundation.errors import ShapeError, SingularMassError
from lwr_dyn.model.chain import Body
from lwr_dyn.simulation.flow import FastStep
from lwr_dyn.simulation.integrators import held_rk4
from tests.codegen.kernels.evaluate import states
from tests.codegen.rollouts.beside import first_joints

ARM = lwr_dyn.load("lwr4plus")
ENGINE, PINOCCHIO, ROAD_B = (lwr_dyn.dynamics_of(ARM, name) for name in ("kernels", "pinocchio", "newton-euler"))
Q, DQ, X = states(ARM.n, 24)


def assert_close(function, found, expected, share):
    """Of energies only differences mean something."""
    if function == "potential_energy":
        found, expected = found - found.flat[0], expected - expected.flat[0]
    assert np.abs(found - expected).max() <= share * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("function", FUNCTIONS)
def test_single_states_are_those_of_pinocchio(function):
    rows = (Q, DQ, X)[: len(FUNCTIONS[function][0])]
    found = np.array([getattr(ENGINE, function)(*state) for state in zip(*rows, strict=True)])
    assert_close(function, found, getattr(PINOCCHIO, function)(*rows), 1e-11)


SLOW = [pytest.param(x, marks=pytest.mark.slow) for x in FUNCTIONS if x != "bias_torque"]


@pytest.mark.parametrize("function", ["bias_torque", *SLOW])
def test_rows_of_any_form_give_the_numbers_of_road_b(function):
    arguments, call = (Q, DQ, X)[: len(FUNCTIONS[function][0])], getattr(ENGINE, function)
    expected = getattr(ROAD_B, function)(*arguments)
    for form in (
        np.array, np.ndarray.tolist, np.asfortranarray, lambda x: np.repeat(x, 2, axis=1)[:, ::2],
        lambda x: x.astype(np.longdouble),
    ):  # fmt: skip
        assert_close(function, call(*map(form, arguments)), expected, 1e-12)
    assert np.array_equal(call(*(x.reshape(2, 12, 7) for x in arguments)).reshape(expected.shape), call(*arguments))
    assert len(call(*(x[:0] for x in arguments))) == 0
    one = call(Q, *(x[0] for x in arguments[1:]))
    assert np.array_equal(one, call(Q, *(np.tile(x[0], (24, 1)) for x in arguments[1:])))
    bad = [x.copy() for x in arguments]
    bad[-1][13, 4] = np.inf
    with pytest.raises(ShapeError, match=rf"{FUNCTIONS[function][0][-1]}: inf at index \(13, 4\)"):
        call(*bad)


def test_what_it_does_not_have_is_an_attribute_error():
    for of in (ENGINE, ENGINE.ungated):
        with pytest.raises(AttributeError, match="jacobian"):
            _ = of.jacobian


def test_its_functions_without_a_gate_can_be_pickled():
    again = pickle.loads(pickle.dumps(ENGINE.ungated))
    assert np.array_equal(again.forward_dynamics(Q[0], DQ[0], X[0]), ENGINE.forward_dynamics(Q[0], DQ[0], X[0]))


@pytest.mark.parametrize("function", ["mass_matrix", pytest.param("gravity_vector", marks=pytest.mark.slow)])
def test_a_large_angle_gives_the_number_of_its_turn(function):
    far = Q + 2.0 * np.pi * 1e7
    for call in (getattr(ENGINE, function), getattr(ENGINE.ungated, function)):
        assert np.abs(call(far[0]) - call(Q[0])).max() < 1e-6
    call = getattr(ENGINE, function)
    assert np.abs(call(far) - call(Q)).max() < 1e-6


@pytest.mark.slow
def test_without_a_gate_a_state_that_is_not_finite_gives_nan():
    bad = np.where(np.arange(ARM.n) == 2, np.inf, Q[0])
    assert np.isnan(ENGINE.ungated.inverse_dynamics(bad, DQ[0], X[0])).any()
    with pytest.raises(ShapeError, match="inf at index"):
        ENGINE.inverse_dynamics(bad, DQ[0], X[0])


def test_the_energy_is_that_of_its_parts():
    expected = mechanical_energy(PINOCCHIO, Q, DQ)
    single = np.array([ENGINE.ungated.mechanical_energy(q, dq) for q, dq in zip(Q, DQ, strict=True)])
    for found in (mechanical_energy(ENGINE, Q, DQ), single):
        assert np.abs((found - found[0]) - (expected - expected[0])).max() < 1e-11


@pytest.mark.slow
def test_accelerations_that_are_not_determined():
    short = first_joints(2)
    first, last = short.chain.links
    links = (first, replace(last, body=Body.massless(), rotor=None))
    arm = replace(short, chain=replace(short.chain, links=links))
    with pytest.raises(SingularMassError, match="joint 2"):
        lwr_dyn.dynamics_of(arm, "kernels").forward_dynamics(Q[:, :2], DQ[:, :2], X[:, :2])


FREE = np.array([np.full((2, ARM.n), -1e6), np.full((2, ARM.n), 1e6)])
open_here = pytest.mark.skipif(bool(closed_because()), reason=closed_because() or "open")


@open_here
@pytest.mark.parametrize("substeps", [1, 3])
def test_it_is_the_step_of_the_integrator(substeps):
    step = ENGINE.ungated.held_step(1e-3, substeps, FREE)
    usual, _ = held_rk4(ENGINE.ungated.forward_dynamics, ARM.n, 1e-3, substeps)
    for state in np.random.default_rng(1).uniform(-2.0, 2.0, (50, 3, ARM.n)):
        now, tau, ours, theirs = state[:2].copy(), 50.0 * state[2], *np.empty((2, 2, ARM.n))
        assert step(now, tau, ours) is None
        usual(0.0, now, tau, theirs)
        assert np.abs(ours - theirs).max() < 1e-14
        assert np.array_equal(now, state[:2])


@open_here
@pytest.mark.parametrize("substeps", [1, 2])
def test_an_end_outside_its_bounds_is_refused(substeps):
    now, tau, after = np.zeros((2, ARM.n)), np.full(ARM.n, 5.0), np.zeros((2, ARM.n))
    assert ENGINE.ungated.held_step(1e-3, substeps, FREE)(now, tau, after) is None
    for side, row, joint in ((0, 0, 2), (0, 1, 6), (1, 0, 0), (1, 1, 3)):
        bounds = FREE.copy()
        bounds[side, row, joint] = after[row, joint] + (1e-9 if side == 0 else -1e-9)
        assert ENGINE.ungated.held_step(1e-3, substeps, bounds)(now, tau, np.zeros((2, ARM.n))) is False
        bounds[side, row, joint] = after[row, joint]
        assert ENGINE.ungated.held_step(1e-3, substeps, bounds)(now, tau, np.zeros((2, ARM.n))) is None


@open_here
@pytest.mark.slow
def test_a_state_that_is_not_finite_is_refused_and_a_large_angle_is_not():
    step, after = ENGINE.ungated.held_step(1e-3, 1, FREE * np.inf), np.zeros((2, ARM.n))
    bad, far = np.zeros((2, 2, ARM.n))
    bad[1, 4], far[0, 1] = np.nan, 1e7 * np.pi
    assert step(bad, np.zeros(ARM.n), after) is False
    assert step(far, np.zeros(ARM.n), after) is None
    assert np.isfinite(after).all()


def test_the_numbers_of_the_table_are_those_of_the_method():
    assert np.array_equal(step_table(1.0)[:2], [0.5, 0.5])
    assert step_table(0.5).size == step_table(1.0).size


def run_with(engine, seconds=0.3):
    law = InverseDynamics(lwr_dyn.dynamics_of(ARM, engine), 2500.0, 100.0)
    return lwr_dyn.simulate(ARM, law, lwr_dyn.reference("ist", ARM), engine=engine, duration=seconds)


@open_here
@pytest.mark.slow
def test_a_run_is_that_of_the_default_engine():
    usual, ours = run_with("pinocchio"), run_with("kernels")
    assert np.abs(usual.q - ours.q).max() < 1e-14
    assert ours.meta["audit"]["closed"]
    assert ours.meta["evaluations"] == usual.meta["evaluations"]


@open_here
def test_a_run_takes_the_compiled_step_and_gives_what_the_usual_one_gives(monkeypatch):
    taken = []
    take = FastStep.take

    def seen(self, *given):
        taken.append(self._own is not None if self._mode is not None else None)
        return take(self, *given)

    monkeypatch.setattr(FastStep, "take", seen)
    ours = run_with("kernels", 0.05)
    assert all(taken[1:])
    monkeypatch.setattr(type(ENGINE.ungated), "held_step", lambda *_: None)
    usual = run_with("kernels", 0.05)
    assert np.abs(usual.q - ours.q).max() < 1e-15
    assert np.array_equal(usual.work["actuator"], ours.work["actuator"]) or np.abs(usual.q - ours.q).max() > 0.0
