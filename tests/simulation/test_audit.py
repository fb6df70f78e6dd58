"""Faults planted in the plant, in the channels and in the record: the audit sees every one of them."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.paper_laws import InverseDynamics
from lwr_dyn.dynamics.protocol import mechanical_energy
from lwr_dyn.model.arm import Arm, arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.simulation import flow
from lwr_dyn.simulation.audit import audit, audit_lines, audit_words
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.sample_runs import MIDDLE, Sinusoids, joint_waves, lwr, lwr_dynamics, with_limits

DRAG = np.array([2.0, 2.0, 0.5, 0.5, 0.02, 0.02, 0.01])
GAP = 1e-6
"""[J] A caught fault misses by far more than a sound run (1e-9)."""


def waves():
    return Sinusoids(MIDDLE, joint_waves().amplitude, 2 * joint_waves().w, 1.0)


def sound(plant=None, engine="pinocchio", **options):
    return simulate(lwr(), InverseDynamics(lwr_dynamics(), 900, 60), waves(), plant=plant, engine=engine, **options)


class Faulty:
    """Pinocchio with another forward dynamics; energies are the right ones."""

    def __init__(self, fault):
        self.n, true = 7, lwr_dynamics().ungated
        names = ("mass_matrix", "bias_torque", "mechanical_energy", "gravity_vector")
        self.ungated = SimpleNamespace(**{name: getattr(true, name) for name in names}, forward_dynamics=fault)


def solve(B=None, velocity=1.0, gravity=1.0, torque=None):
    """ddq = B^-1 (T tau - velocity * C dq - gravity * g) with faults in its parts."""
    true = lwr_dynamics().ungated
    change, channel = B or (lambda M: M), np.diag(np.ones(7) if torque is None else torque)

    def forward(q, dq, tau):
        g = true.gravity_vector(q)
        n = velocity * (true.bias_torque(q, dq) - g) + np.asarray(gravity) * g
        return np.linalg.solve(change(true.mass_matrix(q)), channel @ tau - n)

    return forward


def one(joint, value):
    out = np.ones(7)
    out[joint] = value
    return out


def loose_sign(q, dq, tau):
    ddq = lwr_dynamics().ungated.forward_dynamics(q, dq, tau)
    return ddq - 0.02 * np.abs(ddq)


def neighbours(q, dq, tau):
    swapped = tau[[0, 1, 2, 3, 4, 6, 5]]
    return lwr_dynamics().ungated.forward_dynamics(q, dq, swapped)


ONE_PRODUCT = np.zeros((7, 7))
ONE_PRODUCT[[1, 3], [3, 1]] = 1.0

PLANT_FAULTS = {
    "Coriolis torque lost": solve(velocity=0.0),
    "Coriolis torque of the wrong sign": solve(velocity=-1.0),
    "gravity lost": solve(gravity=0.0),
    "gravity of the wrong sign": solve(gravity=-1.0),
    "gravity of one joint of the wrong sign": solve(gravity=one(3, -1.0)),
    "armature lost": solve(B=lambda M: M - 0.9 * np.diag(lwr().armature)),
    "coupling of inertia lost": solve(B=lambda M: np.diag(np.diag(M))),
    "one product of inertia of the wrong sign": solve(B=lambda M: M * (1 - 2 * ONE_PRODUCT)),
    "one torque a tenth of a percent too large": solve(torque=one(1, 1.001)),
    "one torque of half its size": solve(torque=one(3, 0.5)),
    "two torques swapped": neighbours,
    "an acceleration that leans": loose_sign,
}  # fmt: skip


def test_the_same_solver_without_a_fault_is_clean():
    assert audit(sound(engine=Faulty(solve())), lwr_dynamics("newton-euler")).is_closed()


@pytest.mark.parametrize("fault", PLANT_FAULTS)
def test_a_fault_in_the_plant(fault):
    run = sound(engine=Faulty(PLANT_FAULTS[fault]))
    assert audit(run).residual > GAP
    assert "more events than followed" not in {event.kind for event in run.events}


@cache
def eventful():
    """A sound run with every channel at work: friction, stops, saturated torques."""
    arm = with_limits(lwr(), effort=60.0, upper=1.35)
    fast = Sinusoids(MIDDLE, 2 * joint_waves().amplitude, 12 * joint_waves().w, 1.0)
    law = InverseDynamics(lwr_dynamics(), 900, 60)
    run = simulate(arm, law, fast, friction=lambda dq: DRAG * dq, substeps=4)
    assert run.work["friction"][-1] < -0.1
    assert run.work["stop"][-1] < -0.1
    assert (np.abs(run.tau_command) > 60.0).any()
    return run


def works(run, **changed):
    return replace(run, work={**run.work, **changed})


def in_other_words(arm: Arm):
    return lambda run: replace(run, energy=mechanical_energy(lwr_dyn.dynamics_of(arm), run.q, run.dq))


def potential(run):
    return np.array([lwr_dynamics().potential_energy(q) for q in run.q])


def actuator(run, tau, q):
    steps = (tau[:-1] * np.diff(q, axis=0)).sum(axis=1)
    return works(run, actuator=np.concatenate([[0.0], np.cumsum(steps)]))


RECORD_FAULTS = {
    "actuator of the wrong sign": lambda run: works(run, actuator=-run.work["actuator"]),
    "actuator lost": lambda run: works(run, actuator=0 * run.t),
    "actuator one sample late": lambda run: actuator(run, np.roll(run.tau_applied, 1, axis=0), run.q),
    "actuator by the command, not what the motors gave": lambda run: actuator(run, run.tau_command, run.q),
    "actuator of one joint of the wrong sign": lambda run: actuator(run, run.tau_applied * one(5, -1.0), run.q),
    "friction lost": lambda run: works(run, friction=0 * run.t),
    "friction of the wrong sign": lambda run: works(run, friction=-run.work["friction"]),
    "stops lost": lambda run: works(run, stop=0 * run.t),
    "stops of the wrong sign": lambda run: works(run, stop=-run.work["stop"]),
    "one impact counted twice": lambda run: works(run, stop=run.work["stop"] + np.diff(run.work["stop"], prepend=0.0)),
    "kinetic energy lost": lambda run: replace(run, energy=potential(run)),
    "potential energy lost": lambda run: replace(run, energy=run.energy - potential(run)),
    "potential energy of the wrong sign": lambda run: replace(run, energy=run.energy - 2 * potential(run)),
    "energy of an arm with a payload": in_other_words(arm_with_payload(lwr(), 0.01)),
    "energy of a heavier arm": in_other_words(arm_with_scaled_inertia(lwr(), 1.001)),
    "energy of another reading": in_other_words(lwr_dyn.load("lwr4plus", "printed")),
}


@pytest.mark.slow
def test_the_eventful_run_is_clean():
    result = audit(eventful(), lwr_dynamics("newton-euler"))
    assert result.worst_energy <= 1e-7
    assert result.other_road.share <= 1.0
    assert result.other_road.eventful > 0
    assert set(result.channels) == {"actuator", "friction", "stop"}


@pytest.mark.parametrize("fault", RECORD_FAULTS)
def test_a_fault_in_the_record(fault):
    assert audit(RECORD_FAULTS[fault](eventful())).residual > 10 * GAP


@pytest.mark.slow
@pytest.mark.parametrize("column", ["q", "dq", "tau_applied"])
def test_a_falsified_column(column):
    run = eventful()
    bent = np.array(getattr(run, column))
    bent[500:, 3] += 1e-3
    assert audit(replace(run, **{column: bent}), lwr_dynamics("newton-euler")).worst_energy > 10 * GAP


def test_the_words_give_the_largest_gap_not_the_first():
    run = sound()
    bent = np.array(run.tau_applied)
    bent[-100:, 3] += 1e-3
    found = audit(replace(run, tau_applied=bent))
    assert found.residual < 1e-9 < found.actuator_gap
    energy = audit_lines(found.to_json())[0]
    assert f"unexplained {found.actuator_gap:.2g} J: NOT closed" in energy
    assert energy.startswith("energy audit: motors ")
    assert f"NOT closed, residual {found.actuator_gap:.0e} J" in audit_words(found.to_json())


def test_nan_does_not_close():
    run = eventful()
    assert not audit(works(run, stop=np.full(run.t.size, np.nan))).is_closed()


LOOP_FAULTS = {
    "no impact": ("lwr_dyn.simulation.contact.impact", lambda plant, q, dq: SimpleNamespace(
        dq=np.where(plant.at_limit(q) * dq > 0, 0.0, dq), stopped=plant.at_limit(q) * dq > 0, work=np.zeros(7))),
    "bounce": ("lwr_dyn.simulation.contact.impact", lambda plant, q, dq: SimpleNamespace(
        dq=np.where(plant.at_limit(q) * dq > 0, -0.5 * dq, dq), stopped=plant.at_limit(q) * dq > 0, work=np.zeros(7))),
    "euler": ("lwr_dyn.simulation.flow.held_rk4", lambda forward, n, h, *_: (lambda t, now, tau, after: np.copyto(
        after, now + h * np.array([now[1], forward(now[0], now[1], tau)])) or (0.0, 0.0), None)),
}  # fmt: skip


@pytest.mark.parametrize("fault", LOOP_FAULTS)
def test_a_fault_in_the_loop(fault, monkeypatch):
    monkeypatch.setattr(*LOOP_FAULTS[fault])
    run = sound(plant=with_limits(lwr(), upper=1.22), dq0=3.0 * np.eye(7)[1])
    if fault != "euler":
        assert run.events
    assert audit(run).residual > GAP


def test_a_torque_that_is_not_the_one_written_down(monkeypatch):
    true = flow.held_rk4

    def stale(forward, n, h, *more):
        (step, tangent), last = true(forward, n, h, *more), np.zeros(n)

        def late(t, now, tau, after):
            work = step(t, now, last.copy(), after)
            last[:] = tau
            return work

        return late, tangent

    monkeypatch.setattr(flow, "held_rk4", stale)
    assert audit(sound()).residual > GAP
