"""The compiled step of a held torque: that of the integrator, bounded, and taken by runs."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.held_step import step_table
from lwr_dyn.codegen.kernels.single_state import closed_because
from lwr_dyn.control.paper_laws import InverseDynamics
from lwr_dyn.simulation.flow import FastStep
from lwr_dyn.simulation.integrators import held_rk4

ARM = lwr_dyn.load("lwr4plus")
ENGINE = lwr_dyn.dynamics_of(ARM, "kernels")
FREE = np.array([np.full((2, ARM.n), -1e6), np.full((2, ARM.n), 1e6)])
pytestmark = pytest.mark.skipif(bool(closed_because()), reason=closed_because() or "open")


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


@pytest.mark.slow
def test_a_run_is_that_of_the_default_engine():
    usual, ours = run_with("pinocchio"), run_with("kernels")
    assert np.abs(usual.q - ours.q).max() < 1e-14
    assert ours.meta["audit"]["closed"]
    assert ours.meta["evaluations"] == usual.meta["evaluations"]


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
