"""The loop "compiled" against the usual loop: every sample, the works, the audit, signals, the command."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts.compiled_loop import _extremes, check_setup, run_compiled
from lwr_dyn.codegen.rollouts.law_forms import NoKernelFormError
from lwr_dyn.codegen.rollouts.philox_code import CountedEncoder
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.errors import LwrDynError, OptionError
from lwr_dyn.model.arm import arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.friction import symmetric
from lwr_dyn.model.run import Motion
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop, prepare
from lwr_dyn.simulation.simulate import run_setup, simulate
from lwr_dyn.trajectory.references.joint_moves import point_to_point
from tests.codegen.rollouts.beside import WHOLE, first_joints

STATES = 1e-12
"""[rad] Between two loops of the same numbers: a tracking run forgets rounding, and RK4 adds 1e-15 a step."""
SECONDS = 0.4


@cache
def lwr():
    """Its first four joints, whose loops compile twice as fast; the command below runs all seven."""
    return replace(first_joints(4), friction=WHOLE.friction)


@cache
def rough():
    """An arm whose friction is little enough for RK4 at 1 kHz."""
    return arm_with_friction(lwr(), 5e-5)


@cache
def later(arm, start=0.3):
    """A move from a moment in which it is fast."""
    move = point_to_point(arm, [[0.3, -1.2, 0.2, 0.9], [0.9, -0.7, -0.3, 1.5]], [1.0])

    class Later:
        duration = SECONDS
        name = "later"

        def sample(self, t):
            return replace(move.sample(t + start), t=t)

    return Later()


VISCOUS = [symmetric(0.0, 0.1 + 0.01 * i) for i in range(4)]
CASES = {
    "pd-gravity": {},
    "pid": {"delay": 1, "payload": 3.0, "is_known": True},
    "inverse-dynamics": {"encoder": CountedEncoder(0.0, 1e-5, 80.0, run=5), "seed": 4, "scale": 1.2},
    "adaptive": {"payload": 2.0, "encoder": Encoder(2 * np.pi / 2**18, 0.0, 100.0)},
    "robust": {"payload": 2.0, "friction": VISCOUS},
    "inverse-dynamics+friction": {"arm": "rough", "friction": "smooth", "substeps": 2},
}


def both(law, arm="lwr", is_known=False, scale=1.0, **options):
    arm = {"lwr": lwr, "rough": rough}[arm]()
    model = arm_with_payload(arm, options["payload"]) if is_known else arm
    reference = later(arm)
    off = 1e-3 * np.resize([1.0, -1.0], arm.n)  # an error to begin with
    options |= {"q0": reference.sample(np.zeros(1)).q[0] + off, "plant": arm_with_scaled_inertia(arm, scale)}
    controller = lwr_dyn.controller(law, model)
    return [simulate(arm, controller, reference, loop=loop, **options) for loop in (None, "compiled")]


@pytest.fixture(scope="module")
def pairs():
    return {law: both(law, **options) for law, options in CASES.items()}


@pytest.mark.slow
@pytest.mark.parametrize("law", CASES)
def test_every_sample_is_that_of_the_usual_loop(pairs, law):
    usual, compiled = pairs[law]
    assert np.abs(usual.q - compiled.q).max() < STATES
    assert np.abs(usual.dq - compiled.dq).max() < 1e2 * STATES
    for name in ("tau_command", "tau_applied", "tau_friction"):
        one, other = getattr(usual, name), getattr(compiled, name)
        assert np.abs(one - other).max() < 1e-10 * max(1.0, np.abs(usual.tau_command).max())
    assert np.abs(usual.energy - compiled.energy).max() < 1e-10
    for channel, work in usual.work.items():
        assert np.abs(work - compiled.work[channel]).max() < 1e-10
    assert usual.signals.keys() == compiled.signals.keys()
    for name, signal in usual.signals.items():
        assert np.abs(signal - compiled.signals[name]).max() < 1e-10 * max(1.0, np.abs(signal).max())


@pytest.mark.slow
@pytest.mark.parametrize("law", CASES)
def test_the_audit_closes_and_the_record_is_the_same_but_for_the_loop(pairs, law):
    usual, compiled = pairs[law]
    assert compiled.meta["audit"]["closed"]
    assert compiled.events == usual.events == ()
    same = {name: value for name, value in compiled.meta.items() if name not in ("audit", "loop")}
    assert same == {name: usual.meta[name] for name in same}
    assert (usual.meta["loop"], compiled.meta["loop"]) == (None, "compiled")


@pytest.mark.slow
def test_the_cases_are_what_they_are_for(pairs):
    assert pairs["adaptive"][1].signals["adapted_payload"].std() > 0.0
    friction = pairs["inverse-dynamics+friction"][1]
    assert friction.work["friction"][-1] < -1e-4
    assert np.abs(friction.tau_friction).max() > 1e-3
    assert pairs["robust"][1].work["friction"][-1] < -1e-3
    late = pairs["pid"][1].tau_command
    assert (late[0] == late[1]).all()
    assert not (late[1] == late[2]).all()


@pytest.mark.slow
def test_torques_are_cut_at_the_limits_unless_saturation_is_off():
    arm = lwr()
    reference, controller = later(arm), lwr_dyn.controller("pd-gravity", arm)
    options = {"q0": reference.sample(np.zeros(1)).q[0] + 0.05, "duration": 0.05}
    usual, cut = (simulate(arm, controller, reference, loop=loop, **options) for loop in (None, "compiled"))
    assert (np.abs(cut.tau_command) > arm.effort).any()
    assert np.abs(usual.tau_applied - cut.tau_applied).max() < 1e-9
    assert (np.abs(cut.tau_applied) <= arm.effort).all()
    free = simulate(arm, controller, reference, loop="compiled", saturate=False, **options)
    assert (free.tau_applied == free.tau_command).all()


def test_progress_is_reported_and_changes_nothing():
    arm, shares = lwr(), []
    setup = prepare(arm, lwr_dyn.controller("pd-gravity", arm), later(arm), Loop(loop="compiled"))
    whole = run_setup(setup)
    part = run_compiled(setup, shares.append)
    assert len(shares) > 50
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    for name in ("q", "dq", "tau_command", "energy"):
        assert (getattr(whole, name) == getattr(part, name)).all()


def test_a_controller_of_ones_own_is_refused_with_those_that_can_be_had():
    arm = lwr()
    own = lwr_dyn.controller("pd-gravity", arm)

    class Mine(type(own)):
        pass

    mine = object.__new__(Mine)
    mine.__dict__.update(getattr(own, "__dict__", {}))
    for controller in (lambda t, q, dq, *_: 0 * q, mine):
        with pytest.raises(NoKernelFormError, match="kernel"):
            simulate(arm, controller, later(arm), loop="compiled")


def test_a_controller_of_another_arm_is_refused_not_replaced():
    arm = lwr()
    with pytest.raises(NoKernelFormError, match="made for this arm"):
        simulate(arm, lwr_dyn.controller("inverse-dynamics", arm_with_payload(arm, 1.0)), later(arm), loop="compiled")


@pytest.mark.slow
def test_the_command_takes_the_loop(lwr_dyn_command):
    move = ["--task", "point-to-point", "--from-deg", "0,30,0,-60,0,30,0", "--to-deg", "9,40,0,-60,0,30,0"]
    given = ["simulate", "lwr4plus", "--reading", "physical", *move, "--controller", "pd-gravity", "--json"]
    code, usual, _ = lwr_dyn_command(*given)
    assert code == 0
    code, compiled, _ = lwr_dyn_command(*given, "--loop", "compiled")
    assert code == 0
    one, other = (json.loads(text)["metrics"]["tip_rms_mm"] for text in (usual, compiled))
    assert one == pytest.approx(other, rel=1e-9)
    code, _, err = lwr_dyn_command(*given, "--loop", "compiled", "--continuous")
    assert code == 2
    assert "loop: compiled, which does not have a controller at every moment" in err
    assert err.count("\n") == 1
    code, _, err = lwr_dyn_command(*given, "--loop", "compield")
    assert code == 2
    assert "compiled" in err


def test_signals_without_a_form_for_them_are_refused(monkeypatch):
    arm = lwr()
    controller = lwr_dyn.controller("pd-gravity", arm)
    monkeypatch.setattr(type(controller), "signals", {"mine": np.zeros(1)}, raising=False)
    with pytest.raises(OptionError, match="signals"):
        simulate(arm, controller, later(arm), loop="compiled")


class Still:
    """One pose for a time."""

    duration, name = 1.0, "still"

    def __init__(self, q):
        self.q = q

    def sample(self, t):
        zeros = np.zeros((t.size, self.q.size))
        return Motion(t, zeros + self.q, zeros, zeros)


def still():
    return Still(np.radians([0.0, 30.0, 0.0, -60.0]))


class OwnSensor(Encoder):
    def sensor(self, q0, dq0, samples, rate, seed):
        return lambda q, dq: (q, dq)


LACKING = {
    "elastic joints": {"elasticity": 1e4},
    "external torques": {"external": lambda t, q, dq: 0 * q},
    "a controller at every moment": {"continuous": True},
    "method dop853": {"method": "dop853"},
    "true stick": {"plant": "rough"},
    "friction by a function": {"friction": lambda dq: 2.0 * dq},
    "a delay of 9 samples": {"delay": 9},
    "an encoder with a sensor of its own": {"encoder": OwnSensor()},
    "an engine other than": {"engine": "full rotors"},
}


@pytest.mark.parametrize("what", LACKING)
def test_what_is_lacking_is_refused_by_name(what):
    options = dict(LACKING[what])
    if "plant" in options:
        options["plant"] = arm_with_friction(lwr(), 0.01)
    if "engine" in options:
        options["engine"] = dynamics_of(lwr(), "newton-euler", rotors="full")
    controller = lwr_dyn.controller("pd-gravity", lwr())
    with pytest.raises(OptionError, match=what) as fault:
        simulate(lwr(), controller, still(), loop="compiled", **options)
    assert "usual loop" in str(fault.value)
    assert str(fault.value).startswith("loop: compiled")
    assert ("friction smooth" in str(fault.value)) == (what == "true stick")


def test_what_there_is_passes():
    controller = lwr_dyn.controller("pd-gravity", lwr())
    options = {"delay": 8, "encoder": Encoder(1e-4, 1e-5, 50.0), "substeps": 3, "engine": "newton-euler"}
    check_setup(prepare(lwr(), controller, still(), Loop(**options)))


@pytest.mark.parametrize("samples", [1, 63, 64, 65, 200])
def test_the_least_and_the_largest_of_many_rows(samples):
    states = np.random.default_rng(samples).normal(size=(samples, 2, 3))
    assert np.array_equal(_extremes(states), [states.min(axis=0), states.max(axis=0)])
    states[samples // 2, 1, 2] = np.nan
    assert np.isnan(_extremes(states)).sum() == 2


def test_a_stop_is_said_with_joint_and_time():
    arm = lwr()
    q = still().q.copy()
    q[3] = arm.upper[3] - 1e-3
    controller, goal = lwr_dyn.controller("pd-gravity", arm), Still(q + 0.05 * np.eye(4)[3])
    usual = simulate(arm, controller, goal, q0=q, duration=0.2)
    stop = next(event for event in usual.events if event.kind == "stop")
    with pytest.raises(OptionError, match="reaches its own") as fault:
        simulate(arm, controller, goal, q0=q, duration=0.2, loop="compiled")
    k = np.ceil(stop.t * 1e3) / 1e3
    assert f"{arm.joint_names[3]} reaches its own before {k:.6g} s" in str(fault.value)
    assert "position_limits=False" in str(fault.value)
    free = simulate(arm, controller, goal, q0=q, duration=0.2, loop="compiled", position_limits=False)
    assert (free.q[:, 3] > arm.upper[3]).any()


def test_a_joint_that_moves_too_far_in_a_step_is_refused():
    arm = lwr()
    controller, dq0 = lwr_dyn.controller("pd-gravity", arm), np.zeros(4)
    dq0[3] = 250.0
    with pytest.raises(OptionError, match=r"cannot follow joint_4 at 0 s: above 0.2 rad a step"):
        simulate(
            arm, controller, still(), dq0=dq0, duration=0.01, loop="compiled", position_limits=False, saturate=False
        )


@pytest.mark.slow
def test_a_run_that_diverges_is_refused_with_the_time():
    arm = lwr()
    options = {"rate": 100.0, "position_limits": False, "saturate": False, "q0": still().q + 1e-3}
    with pytest.raises(OptionError, match=r"cannot follow joint_\d at 0\.\d+ s") as fault:
        simulate(arm, lwr_dyn.controller("pd-gravity", arm), still(), loop="compiled", **options)
    assert "usual loop" in str(fault.value)


@pytest.mark.slow
def test_a_torque_that_is_not_a_number_is_refused(monkeypatch):
    arm, wrong = lwr(), still()
    motion = wrong.sample(np.arange(11) / 1e3)
    dq = motion.dq.copy()
    dq[5] = np.nan
    motion = Motion(motion.t, motion.q, dq, motion.ddq)
    monkeypatch.setattr(Still, "sample", lambda self, t: motion)
    controller = lwr_dyn.controller("pd-gravity", arm, velocity_error=True)
    with pytest.raises(OptionError, match=r"cannot follow joint_1 at 0.005 s"):
        simulate(arm, controller, wrong, loop="compiled", duration=0.01)


@pytest.mark.parametrize(("loop", "elasticity"), [("rigid", 1e4), ("elastic", None), ("no such loop", None)])
def test_a_loop_that_does_not_fit_the_joints_is_refused(loop, elasticity):
    controller = lwr_dyn.controller("pd-gravity", lwr())
    with pytest.raises(LwrDynError, match="loop"):
        simulate(lwr(), controller, still(), duration=0.01, loop=loop, elasticity=elasticity)
