"""What the loop "compiled" lacks is refused by its name, and a run that comes to a stop says when."""

from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts.compiled_loop import check_setup
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.errors import LwrDynError, OptionError
from lwr_dyn.model.run import Motion
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop, prepare
from lwr_dyn.simulation.simulate import simulate


@cache
def lwr():
    return lwr_dyn.load("lwr4plus", "physical")


class Still:
    """One pose for a time."""

    duration, name = 1.0, "still"

    def __init__(self, q):
        self.q = q

    def sample(self, t):
        zeros = np.zeros((t.size, self.q.size))
        return Motion(t, zeros + self.q, zeros, zeros)


def still():
    return Still(np.radians([0.0, 30.0, 0.0, -60.0, 0.0, 30.0, 0.0]))


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


def test_a_stop_is_said_with_joint_and_time():
    arm = lwr()
    q = still().q.copy()
    q[5] = arm.upper[5] - 1e-3
    controller, goal = lwr_dyn.controller("pd-gravity", arm), Still(q + 0.05 * np.eye(7)[5])
    usual = simulate(arm, controller, goal, q0=q, duration=0.2)
    stop = next(event for event in usual.events if event.kind == "stop")
    with pytest.raises(OptionError, match="reaches its own") as fault:
        simulate(arm, controller, goal, q0=q, duration=0.2, loop="compiled")
    k = np.ceil(stop.t * 1e3) / 1e3
    assert f"{arm.joint_names[5]} reaches its own before {k:.6g} s" in str(fault.value)
    assert "position_limits=False" in str(fault.value)
    free = simulate(arm, controller, goal, q0=q, duration=0.2, loop="compiled", position_limits=False)
    assert (free.q[:, 5] > arm.upper[5]).any()


def test_a_joint_that_moves_too_far_in_a_step_is_refused():
    arm = lwr()
    controller, dq0 = lwr_dyn.controller("pd-gravity", arm), np.zeros(7)
    dq0[6] = 250.0
    with pytest.raises(OptionError, match=r"cannot follow joint_7 at 0 s: above 0.2 rad a step"):
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
