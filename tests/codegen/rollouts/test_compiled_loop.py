"""The loop "compiled" against the usual loop: every sample, the works, the audit, signals, the command."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts.compiled_loop import run_compiled
from lwr_dyn.codegen.rollouts.law_forms import NoKernelFormError
from lwr_dyn.codegen.rollouts.philox_code import CountedEncoder
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.friction import symmetric
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop, prepare
from lwr_dyn.simulation.simulate import run_setup, simulate

STATES = 1e-12
"""[rad] Between two loops of the same numbers: a tracking run forgets rounding, and RK4 adds 1e-15 a step."""
SECONDS = 0.4


@cache
def lwr(reading="physical"):
    return lwr_dyn.load("lwr4plus", reading)


@cache
def rough():
    """An arm whose friction is little enough for RK4 at 1 kHz."""
    return arm_with_friction(lwr(), 5e-5)


@cache
def later(arm, start=3.0):
    """The paper's path from a moment in which it is fast."""
    ist = lwr_dyn.reference("ist", arm)

    class Later:
        duration = SECONDS
        name = "later"

        def sample(self, t):
            return replace(ist.sample(t + start), t=t)

    return Later()


VISCOUS = [symmetric(0.0, 0.1 + 0.01 * i) for i in range(7)]
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
        simulate(arm, lwr_dyn.controller("inverse-dynamics", lwr("printed")), later(arm), loop="compiled")


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
