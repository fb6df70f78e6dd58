"""Faults planted in the plant, in the channels and in the record: the audit sees every one of them.

By energy, and where that is blind by the residual of inverse dynamics, which is rounding for every sound run.
"""

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
from lwr_dyn.simulation.audit import (
    ENERGY_TOLERANCE,
    NODES,
    Intervals,
    audit,
    audit_lines,
    audit_words,
    other_engine,
    other_road,
    uneventful,
)
from lwr_dyn.simulation.plant import plant_of
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.sample_runs import MIDDLE, Sinusoids, controllers, joint_waves, lwr, lwr_dynamics, with_limits

DRAG = np.array([2.0, 2.0, 0.5, 0.5, 0.02, 0.02, 0.01])
GAP = 1e-6
"""[J] A caught fault misses by far more than a sound run (1e-9)."""


def waves(duration=1.0, pace=2, size=1):
    """Fast enough, at a pace of 4, for every joint's inertia and speed torques to show."""
    return Sinusoids(MIDDLE, size * joint_waves().amplitude, pace * joint_waves().w, duration)


def sound(plant=None, engine="pinocchio", **options):
    return simulate(lwr(), InverseDynamics(lwr_dynamics(), 900, 60), waves(), plant=plant, engine=engine, **options)


def faulty(forward):
    """The plant's engine with another forward dynamics; energies are the right ones."""
    true, names = lwr_dynamics().ungated, ("mass_matrix", "bias_torque", "mechanical_energy", "gravity_vector")
    functions = {name: getattr(true, name) for name in names}
    return SimpleNamespace(n=7, ungated=SimpleNamespace(**functions, forward_dynamics=forward))


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
    return lwr_dynamics().ungated.forward_dynamics(q, dq, tau[[0, 1, 2, 3, 4, 6, 5]])


ONE_PRODUCT = np.zeros((7, 7))
ONE_PRODUCT[[1, 3], [3, 1]] = 1.0


@cache
def clean():
    return sound(engine=faulty(solve()))


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


@pytest.mark.parametrize("fault", PLANT_FAULTS)
def test_a_fault_in_the_plant(fault):
    """The same solver without one is clean."""
    run = sound(engine=faulty(PLANT_FAULTS[fault]))
    assert audit(run).residual > GAP
    assert "more events than followed" not in {event.kind for event in run.events}
    assert audit(clean(), lwr_dynamics("newton-euler")).is_closed()


def drag(dq):
    """A user's function of the speeds of one state."""
    assert dq.shape == (7,)
    return DRAG * dq


@cache
def eventful():
    """A sound run with every channel at work: friction, stops, saturated torques."""
    arm = with_limits(lwr(), effort=60.0, upper=1.35)
    law = InverseDynamics(lwr_dynamics(), 900, 60)
    run = simulate(arm, law, waves(1.0, 12, 2), friction=drag, substeps=4)
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
def test_energy_sees_a_falsified_column(column):
    bent = np.array(getattr(eventful(), column))
    bent[500:, 3] += 1e-3
    assert audit(replace(eventful(), **{column: bent}), lwr_dynamics("newton-euler")).worst_energy > 10 * GAP


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
    assert not audit(works(eventful(), stop=np.full(eventful().t.size, np.nan))).is_closed()
    road = other_road(replace(followed(), tau_applied=np.full_like(followed().q, 1e300)))
    assert np.isnan([road.residual, road.gap, road.share]).all()
    assert not road.closed


def stale(forward, n, h, *more):
    """A step under the torque before, not the one that is written down."""
    (step, tangent), last = HELD(forward, n, h, *more), np.zeros(n)

    def late(t, now, tau, after):
        work = step(t, now, last.copy(), after)
        last[:] = tau
        return work

    return late, tangent


HELD = flow.held_rk4
LOOP_FAULTS = {
    "a torque of another sample": ("lwr_dyn.simulation.flow.held_rk4", stale),
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
    assert run.events or "contact" not in LOOP_FAULTS[fault][0]
    assert audit(run).residual > GAP


def simulated(name="pd-gravity", duration=0.5, **options):
    return simulate(lwr(), controllers()[name], waves(duration, 4), **options)


def stopped(**options):
    """A run on which joints meet their stops, and leave them."""
    law, plant = controllers()["inverse-dynamics"], with_limits(lwr(), lower=-1.6, upper=1.35)
    return simulate(lwr(), law, waves(0.3, 20, 2), plant=plant, friction=lambda dq: DRAG * dq, **options)


@cache
def followed():
    return simulated()


def gyroscopic():
    """30 N m s between joints 1 and 2: always across the motion, so it does no work."""
    turn = np.zeros((7, 7))
    turn[0, 1], turn[1, 0] = 30.0, -30.0
    forward = lwr_dynamics().ungated.forward_dynamics
    return simulated(engine=faulty(lambda q, dq, tau: forward(q, dq, tau - turn @ dq)))


def on_another(**changed):
    """An engine of another chain: its motion and its energies fit each other."""
    return simulated(engine=lwr_dyn.dynamics_of(replace(lwr(), chain=replace(lwr().chain, **changed))))


def wrong_rotors():
    links = lwr().chain.links
    return on_another(links=tuple(replace(x, rotor=replace(x.rotor, inertia=2 * x.rotor.inertia)) for x in links))


def swapped(run):
    """Joints 5 and 7 change places in every column."""
    order = [0, 1, 2, 3, 6, 5, 4]
    columns = ("q", "dq", "tau_applied", "tau_command", "tau_friction")
    return replace(run, **{name: getattr(run, name)[:, order] for name in columns})


FAULTS = {
    "a gyroscopic torque": (gyroscopic, 0.5),
    "the time column doubled": (lambda: replace(followed(), t=2 * followed().t), 0.05),
    "the time column stretched by a thousandth": (lambda: replace(followed(), t=1.001 * followed().t), 1e-5),
    "rotors of twice the inertia": (wrong_rotors, 1e-4),
    "two joints swapped in every column": (lambda: swapped(followed()), 1e-4),
    "gravity that leans": (lambda: on_another(gravity=np.array([0.1, 0.0, -9.8])), 0.1),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_to_which_energy_is_blind(fault):
    make, torque = FAULTS[fault]
    result = audit(make())
    assert result.worst_energy <= ENERGY_TOLERANCE
    assert result.other_road.residual > torque
    assert not result.is_closed()
    assert "NOT closed" in audit_lines(result.to_json())[1]


@pytest.mark.parametrize("column", ["q", "dq", "tau_applied", "tau_friction"])
def test_the_other_road_sees_a_falsified_column_and_late_torques(column):
    bent = np.array(getattr(followed(), column))
    bent[250:, 0] += 1e-4  # about the first axis neither weight nor inertia changes
    result = other_road(replace(followed(), **{column: bent}), most=500)
    if column.startswith("tau"):
        bent[250:, 4] += 1e-3
        assert other_road(replace(followed(), **{column: bent})).joint == 4
    assert result.share > 100.0
    assert result.judged == 500
    late = np.vstack([followed().tau_applied[:1], followed().tau_applied[:-1]])
    assert other_road(replace(followed(), tau_applied=late)).residual > 1e-2


def test_the_torque_of_a_continuous_run_is_a_polynomial_through_as_many_samples_on_both_sides():
    tau, rows = np.sin(np.arange(40.0))[:, None], np.array([0, 5, 38])
    run = SimpleNamespace(t=np.arange(40.0), tau_applied=tau)
    part = SimpleNamespace(loop=SimpleNamespace(continuous=True), rows=rows, run=run)
    np.testing.assert_allclose(Intervals.torque(part, 0.25, 2), 0.75 * tau[rows] + 0.25 * tau[rows + 1])
    np.testing.assert_allclose(Intervals.torque(part, 0.5, 4)[1], (9 * tau[[5, 6]].sum() - tau[[4, 7]].sum()) / 16)


SOUND = {
    "held": {},
    "payload": {"payload": 3.0},
    "road B": {"engine": "newton-euler", "duration": 0.03},
    "adaptive": {"method": "dop853"},
    "slow, substeps": {"rate": 200.0, "substeps": 5},
    "delay": {"delay": 1},
    "drag": {"friction": lambda dq: DRAG * dq},
    "continuous": {"continuous": True},
    "continuous, adaptive": {"continuous": True, "method": "dop853"},
}


@pytest.mark.slow
@pytest.mark.parametrize("options", SOUND.values(), ids=SOUND)
def test_a_sound_run_leaves_rounding(options):
    result = other_road(simulated("inverse-dynamics", **options))
    assert result.share <= 1.0
    assert result.judged == min(200, result.intervals - result.eventful)
    assert (result.engine == "pinocchio") is (options.get("engine") == "newton-euler")
    assert (result.uncertainty == 0.0) is not options.get("continuous", False)
    if not options.get("continuous"):
        assert result.residual <= 1e-10
        assert result.gap <= 2e-15


@pytest.mark.slow
@pytest.mark.parametrize("options", [{}, {"continuous": True, "rate": 4000.0}], ids=["held", "continuous"])
def test_only_intervals_with_events_are_left_out(options):
    run = stopped(**options)
    result = other_road(run)
    assert {"stop", "release"} <= {event.kind for event in run.events}
    assert result.share <= 1.0
    left = set(range(len(run.t) - 1)) - set(uneventful(run, bool(options)).tolist())
    assert result.eventful == len(left) > 0
    for event in run.events:
        assert any(run.t[k] - 1e-9 <= event.t <= run.t[k + 1] + 1e-9 for k in left)
    if not options:
        assert len(left) <= 2 * len(run.events)


def test_where_no_other_engine_can_judge_it_is_said():
    plant = plant_of(lwr(), lwr_dyn.dynamics_of(lwr(), "newton-euler", rotors="full"))
    assert other_engine(plant) is None
    run = simulated(duration=0.02, engine=plant.dynamics)
    assert (run.audit["inverse_dynamics"], run.audit["closed"]) == (None, True)
    assert audit_lines(run.audit)[1] == (
        "inverse dynamics: not judged (no other engine models the plant, or an event in every sample)"
    )
    assert other_road(replace(followed(), setup=None)) is None


def test_intervals_where_a_torque_begins_or_ceases_to_be_cut_are_left_out_of_a_continuous_run():
    run = simulated(duration=0.05, continuous=True)
    command = run.tau_applied.copy()
    command[20:30, 2] += 1.0
    cut = replace(run, tau_command=command)
    whole = np.arange(run.t.size - 1)
    gone = [k for edge in (19, 29) for k in range(edge - NODES, edge + 1 + NODES)]
    assert uneventful(cut, True).tolist() == sorted({*whole} - {*gone})
    assert uneventful(cut, False).tolist() == uneventful(run, True).tolist() == whole.tolist()


def test_the_record_has_value_tolerance_and_verdict():
    record = followed().audit["inverse_dynamics"]
    wanted = {"closed": True, "engine": "newton-euler", "judged": 200, "intervals": 500, "eventful": 0}
    assert {name: record[name] for name in wanted} == wanted
    assert record["residual"] < record["tolerance"] < 1e-6
    energy, road = audit_lines(followed().audit)
    assert energy.endswith("J: closed to 1e-09 J")
    assert road.startswith("inverse dynamics by newton-euler at 200 of 500 samples: residual ")
    assert audit_words(followed().audit) == "closed, tolerance 1e-09 J, 4e-08 N m"
    doubled = audit(replace(followed(), t=2 * followed().t))
    assert audit_words(doubled.to_json()).startswith("NOT closed, residual ")
    assert audit_words({"residual": 1e-12}) == audit_words({}) == ""
