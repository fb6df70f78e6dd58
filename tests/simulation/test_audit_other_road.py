"""The residual of inverse dynamics: rounding for every sound run, large for faults to which energy is blind."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.simulation.audit import (
    ENERGY_TOLERANCE,
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


def waves(duration=0.5):
    """Fast enough for every joint's inertia and speed torques to show."""
    return Sinusoids(MIDDLE, joint_waves().amplitude, 4 * joint_waves().w, duration)


def simulated(name="pd-gravity", duration=0.5, **options):
    return simulate(lwr(), controllers()[name], waves(duration), **options)


def stopped(**options):
    """A run on which joints meet their stops, and leave them."""
    fast = Sinusoids(MIDDLE, 2 * joint_waves().amplitude, 20 * joint_waves().w, 0.3)
    plant = with_limits(lwr(), lower=-1.6, upper=1.35)
    return simulate(
        lwr(), controllers()["inverse-dynamics"], fast, plant=plant, friction=lambda dq: DRAG * dq, **options
    )


@cache
def sound():
    return simulated()


def engine_with(**functions):
    """The plant's engine with some functions replaced; energies are its own."""
    true = lwr_dynamics().ungated
    names = ("mass_matrix", "bias_torque", "mechanical_energy", "gravity_vector", "forward_dynamics")
    return SimpleNamespace(n=7, ungated=SimpleNamespace(**{x: getattr(true, x) for x in names} | functions))


def gyroscopic():
    """30 N m s between joints 1 and 2: always across the motion, so it does no work."""
    turn = np.zeros((7, 7))
    turn[0, 1], turn[1, 0] = 30.0, -30.0
    forward = lwr_dynamics().ungated.forward_dynamics
    return simulated(engine=engine_with(forward_dynamics=lambda q, dq, tau: forward(q, dq, tau - turn @ dq)))


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


def late(run):
    """The torques one sample late, and the work of the motors counted from them."""
    tau = np.vstack([run.tau_applied[:1], run.tau_applied[:-1]])
    return replace(run, tau_applied=tau)


FAULTS = {
    "a gyroscopic torque": (gyroscopic, 0.5),
    "the time column doubled": (lambda: replace(sound(), t=2 * sound().t), 0.05),
    "the time column stretched by a thousandth": (lambda: replace(sound(), t=1.001 * sound().t), 1e-5),
    "rotors of twice the inertia": (wrong_rotors, 1e-4),
    "two joints swapped in every column": (lambda: swapped(sound()), 1e-4),
    "gravity that leans": (lambda: on_another(gravity=np.array([0.1, 0.0, -9.8])), 0.1),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_to_which_energy_is_blind(fault):
    make, torque = FAULTS[fault]
    run = make()
    result = audit(run)
    assert result.worst_energy <= ENERGY_TOLERANCE
    assert result.other_road.residual > torque
    assert not result.is_closed()
    assert "NOT closed" in audit_lines(result.to_json())[1]


@pytest.mark.parametrize("column", ["q", "dq", "tau_applied", "tau_friction"])
def test_a_falsified_column(column):
    bent = np.array(getattr(sound(), column))
    bent[250:, 0] += 1e-4  # about the first axis neither weight nor inertia changes
    result = other_road(replace(sound(), **{column: bent}), most=500)
    assert result.share > 100.0
    assert result.judged == 500


def test_late_torques():
    assert other_road(late(sound())).residual > 1e-2


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


def test_sticking_joints_of_the_wam_are_held():
    arm = lwr_dyn.load("wam7")
    controller = make_controller("pd-gravity", arm, lwr_dyn.dynamics_of(arm), own_gains=True)
    wave = Sinusoids(np.array([0, 0.5, 0, 1.5, 0, 0, 0]), np.full(7, 0.05), np.array([2, 4, 6, 2, 4, 6, 2.0]), 0.4)
    run = simulate(arm, controller, wave)
    result = other_road(run)
    assert (run.dq == 0.0).any(axis=1).mean() > 0.2
    assert result.share <= 1.0
    assert result.eventful > 3
    assert other_road(replace(run, tau_friction=run.tau_friction + 1e-6)).share > 10.0


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
    run = simulate(lwr(), controllers()["pd-gravity"], waves(0.02), engine=plant.dynamics)
    assert run.audit["inverse_dynamics"] is None
    assert audit_lines(run.audit)[1] == (
        "inverse dynamics: not judged (no other engine models the plant, or an event in every sample)"
    )
    assert other_road(replace(sound(), setup=None)) is None
    assert run.audit["closed"]


def test_the_record_has_value_tolerance_and_verdict():
    record = sound().audit["inverse_dynamics"]
    assert record["closed"] is True
    assert (record["engine"], record["judged"], record["intervals"], record["eventful"]) == (
        "newton-euler",
        200,
        500,
        0,
    )
    assert record["residual"] < record["tolerance"] < 1e-6
    energy, road = audit_lines(sound().audit)
    assert energy.endswith("J: closed to 1e-09 J")
    assert road.startswith("inverse dynamics by newton-euler at 200 of 500 samples: residual ")


def test_an_audit_in_short():
    assert audit_words(sound().audit) == "closed, tolerance 1e-09 J, 4e-08 N m"
    assert audit_words(audit(replace(sound(), t=2 * sound().t)).to_json()).startswith("NOT closed, residual ")
    assert audit_words({"residual": 1e-12}) == audit_words({}) == ""
