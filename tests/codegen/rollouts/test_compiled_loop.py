"""The loop "compiled" against the usual loop: every sample, works, audit, signals, the command; what it does not take;
which runs say that it is faster."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts import compiled_loop
from lwr_dyn.codegen.rollouts.compiled_loop import _extremes, check_setup, run_compiled
from lwr_dyn.codegen.rollouts.law_forms import NoKernelFormError
from lwr_dyn.codegen.rollouts.philox_code import CountedEncoder
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.errors import LwrDynError, MissingPackageError, OptionError
from lwr_dyn.model.arm import arm_with_payload, arm_with_scaled_inertia
from lwr_dyn.model.friction import symmetric
from lwr_dyn.model.run import Run
from lwr_dyn.simulation import simulate as module
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop, prepare
from lwr_dyn.simulation.simulate import LONG, run_setup, simulate
from lwr_dyn.trajectory.references.joint_moves import point_to_point
from tests.codegen.rollouts.beside import WHOLE, first_joints

STATES = 1e-12
"""[rad] Between two loops of the same numbers: a tracking run forgets rounding, and RK4 adds 1e-15 a step."""
SECONDS = 0.4


@cache
def lwr(joints=4):
    """Its first four joints, whose loops compile twice as fast; the command below runs all seven."""
    return replace(first_joints(joints), friction=WHOLE.friction)


@cache
def rough(joints=4):
    """An arm whose friction is little enough for RK4 at 1 kHz."""
    return arm_with_friction(lwr(joints), 5e-5)


class Later:
    """A move from a moment in which it is fast."""

    duration, name = SECONDS, "later"

    def __init__(self, arm):
        self._move = point_to_point(
            arm, [ends[: arm.n] for ends in ([0.3, -1.2, 0.2, 0.9], [0.9, -0.7, -0.3, 1.5])], [1.0]
        )

    def sample(self, t):
        return replace(self._move.sample(t + 0.3), t=t)


def pd(**options):
    return lwr_dyn.controller("pd-gravity", lwr(), **options)


STILL = np.radians([0.0, 30.0, 0.0, -60.0])


def still(q=STILL, seconds=1.0):
    return lwr_dyn.reference("hold", lwr(), q=q, duration=seconds)


def compiled_run(controller, reference, **options):
    return simulate(lwr(), controller, reference, loop="compiled", **options)


CASES = {
    "pd-gravity": {},
    "pid": {"delay": 1, "payload": 3.0, "is_known": True},
    "inverse-dynamics": {"encoder": CountedEncoder(0.0, 1e-5, 80.0, run=5), "seed": 4, "scale": 1.2},
    "adaptive": {"payload": 2.0, "encoder": Encoder(2 * np.pi / 2**18, 0.0, 100.0)},
    "robust": {"payload": 2.0, "friction": [symmetric(0.0, 0.1 + 0.01 * i) for i in range(4)]},
    "inverse-dynamics+friction": {"arm": rough, "friction": "smooth", "substeps": 2},
}


def both(law, arm=lwr, is_known=False, scale=1.0, **options):
    arm = arm()
    model = arm_with_payload(arm, options["payload"]) if is_known else arm
    reference = Later(arm)
    off = 1e-3 * np.resize([1.0, -1.0], arm.n)  # an error to begin with
    options |= {"q0": reference.sample(np.zeros(1)).q[0] + off, "plant": arm_with_scaled_inertia(arm, scale)}
    controller = lwr_dyn.controller(law, model)
    return [simulate(arm, controller, reference, loop=loop, **options) for loop in (None, "compiled")]


SMALL = {
    "pd-gravity, one joint": {
        "arm": lambda: lwr(1), "delay": 1, "encoder": CountedEncoder(0.0, 1e-5, 80.0, run=5), "seed": 4,
    },
    "inverse-dynamics+friction, two": {"arm": lambda: rough(2), "friction": "smooth", "substeps": 2, "payload": 1.0},
}  # fmt: skip
"""Arms whose loops compile at once."""


@cache
def pair(law):
    return both(law.partition(",")[0], **(CASES | SMALL)[law])


@pytest.mark.parametrize("law", [*(pytest.param(law, marks=pytest.mark.slow) for law in CASES), *SMALL])
def test_every_sample_and_the_record_are_those_of_the_usual_loop(law):
    usual, compiled = pair(law)
    torque = 1e-10 * max(1.0, np.abs(usual.tau_command).max())
    bounds = {"q": STATES, "dq": 1e2 * STATES, "energy": 1e-10}
    for name, bound in (bounds | dict.fromkeys(("tau_command", "tau_applied", "tau_friction"), torque)).items():
        assert np.abs(getattr(usual, name) - getattr(compiled, name)).max() < bound, name
    assert (usual.work.keys(), usual.signals.keys()) == (compiled.work.keys(), compiled.signals.keys())
    for channel, work in usual.work.items():
        assert np.abs(work - compiled.work[channel]).max() < 1e-10
    for name, signal in usual.signals.items():
        assert np.abs(signal - compiled.signals[name]).max() < 1e-10 * max(1.0, np.abs(signal).max())
    assert compiled.meta["audit"]["closed"]
    assert compiled.events == usual.events == ()
    assert compiled.meta == usual.meta | {"audit": compiled.meta["audit"], "loop": "compiled"}


@pytest.mark.slow
def test_the_cases_are_what_they_are_for():
    assert pair("adaptive")[1].signals["adapted_payload"].std() > 0.0
    friction = pair("inverse-dynamics+friction")[1]
    assert friction.work["friction"][-1] < -1e-4
    assert np.abs(friction.tau_friction).max() > 1e-3
    assert pair("robust")[1].work["friction"][-1] < -1e-3
    late = pair("pid")[1].tau_command
    assert [(late[k] == late[k + 1]).all() for k in (0, 1)] == [True, False]


@pytest.mark.slow
def test_torques_are_cut_at_the_limits_unless_saturation_is_off():
    arm, reference, controller = lwr(), Later(lwr()), pd()
    options = {"q0": reference.sample(np.zeros(1)).q[0] + 0.05, "duration": 0.05}
    usual, cut = (simulate(arm, controller, reference, loop=loop, **options) for loop in (None, "compiled"))
    assert (np.abs(cut.tau_command) > arm.effort).any()
    assert np.abs(usual.tau_applied - cut.tau_applied).max() < 1e-9
    assert (np.abs(cut.tau_applied) <= arm.effort).all()
    free = compiled_run(controller, reference, saturate=False, **options)
    assert (free.tau_applied == free.tau_command).all()


def test_progress_is_reported_and_changes_nothing():
    shares, setup = [], prepare(lwr(), pd(), Later(lwr()), Loop(loop="compiled"))
    whole, part = run_setup(setup), run_compiled(setup, shares.append)
    assert len(shares) > 50
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    for name in ("q", "dq", "tau_command", "energy"):
        assert (getattr(whole, name) == getattr(part, name)).all()


def subclass():
    """A controller of a class of one's own, under a known name."""
    own = pd()
    mine = object.__new__(type("Mine", (type(own),), {}))
    mine.__dict__.update(getattr(own, "__dict__", {}))
    return mine


class OwnSensor(Encoder):
    def sensor(self, q0, dq0, samples, rate, seed):
        return lambda q, dq: (q, dq)


FAST = {"dq0": 250.0 * np.eye(4)[3], "duration": 0.01, "position_limits": False, "saturate": False}
NO_FORM = {
    "a function": (lambda: lambda t, q, dq, *_: 0 * q, "kernel"),
    "a class of one's own": (subclass, "kernel"),
    "of another arm": (
        lambda: lwr_dyn.controller("inverse-dynamics", arm_with_payload(lwr(), 1.0)), "made for this arm"
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", NO_FORM)
def test_a_controller_without_a_form_is_refused_not_replaced(what):
    make, words = NO_FORM[what]
    with pytest.raises(NoKernelFormError, match=words):
        compiled_run(make(), Later(lwr()))


LACKING = {
    "elastic joints": lambda: {"elasticity": 1e4},
    "external torques": lambda: {"external": lambda t, q, dq: 0 * q},
    "a controller at every moment": lambda: {"continuous": True},
    "method dop853": lambda: {"method": "dop853"},
    "true stick": lambda: {"plant": arm_with_friction(lwr(), 0.01)},
    "friction by a function": lambda: {"friction": lambda dq: 2.0 * dq},
    "a delay of 9 samples": lambda: {"delay": 9},
    "an encoder with a sensor of its own": lambda: {"encoder": OwnSensor()},
    "an engine other than": lambda: {"engine": dynamics_of(lwr(), "newton-euler", rotors="full")},
}


@pytest.mark.parametrize("what", LACKING)
def test_what_is_lacking_is_refused_by_name(what):
    with pytest.raises(OptionError, match=f"^loop: compiled.*{what}.*usual loop") as fault:
        compiled_run(pd(), still(), **LACKING[what]())
    assert ("friction smooth" in str(fault.value)) == (what == "true stick")


def test_what_there_is_passes():
    options = {"delay": 8, "encoder": Encoder(1e-4, 1e-5, 50.0), "substeps": 3, "engine": "newton-euler"}
    check_setup(prepare(lwr(), pd(), still(), Loop(**options)))


@pytest.mark.slow
def test_the_command_takes_the_loop(lwr_dyn_command):
    move = ["--task", "point-to-point", "--from-deg", "0,30,0,-60,0,30,0", "--to-deg", "9,40,0,-60,0,30,0"]
    given = ["simulate", "lwr4plus", "--reading", "physical", *move, "--controller", "pd-gravity", "--json"]
    (code, usual, _), (again, compiled, _) = (lwr_dyn_command(*given, *x) for x in ((), ("--loop", "compiled")))
    assert (code, again) == (0, 0)
    one, other = (json.loads(text)["metrics"]["tip_rms_mm"] for text in (usual, compiled))
    assert one == pytest.approx(other, rel=1e-9)
    for wrong, words in (
        (("compiled", "--continuous"), "loop: compiled, which does not have a controller at every moment"),
        (("compield",), "compiled"),
    ):
        code, _, err = lwr_dyn_command(*given, "--loop", *wrong)
        assert (code, err.count("\n")) == (2, 1)
        assert words in err


@pytest.mark.parametrize("samples", [1, 63, 64, 65, 200])
def test_the_least_and_the_largest_of_many_rows(samples):
    states = np.random.default_rng(samples).normal(size=(samples, 2, 3))
    assert np.array_equal(_extremes(states), [states.min(axis=0), states.max(axis=0)])
    states[samples // 2, 1, 2] = np.nan
    assert np.isnan(_extremes(states)).sum() == 2


def test_a_stop_is_said_with_joint_and_time():
    arm, q = lwr(), STILL.copy()
    q[3] = arm.upper[3] - 1e-3
    given = {"q0": q, "duration": 0.2}
    goal = Later(arm)
    goal.sample = lambda t: replace(still().sample(t), q=np.tile(q + 0.05 * np.eye(4)[3], (t.size, 1)))
    stop = next(event for event in simulate(arm, pd(), goal, **given).events if event.kind == "stop")
    k = np.ceil(stop.t * 1e3) / 1e3
    with pytest.raises(OptionError, match=f"{arm.joint_names[3]} reaches its own before {k:.6g} s") as fault:
        compiled_run(pd(), goal, **given)
    assert "position_limits=False" in str(fault.value)
    free = compiled_run(pd(), goal, **given, position_limits=False)
    assert (free.q[:, 3] > arm.upper[3]).any()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (FAST, r"cannot follow joint_4 at 0 s: above 0.2 rad a step"),
        pytest.param(
            {"rate": 100.0, "position_limits": False, "saturate": False, "q0": STILL + 1e-3},
            r"cannot follow joint_\d at 0\.\d+ s.*usual loop",
            marks=pytest.mark.slow,
        ),
    ],
    ids=["a joint too fast for a step", "a run that diverges"],
)
def test_what_the_loop_cannot_follow_is_refused_with_the_time(options, words):
    with pytest.raises(OptionError, match=words):
        compiled_run(pd(), still(), **options)


@pytest.mark.slow
def test_a_torque_that_is_not_a_number_is_refused():
    wrong = Later(lwr())
    wrong.sample = lambda t: replace(still().sample(t), dq=np.where(t[:, None] == 0.005, np.nan, np.zeros((1, 4))))
    with pytest.raises(OptionError, match=r"cannot follow joint_1 at 0.005 s"):
        compiled_run(pd(velocity_error=True), wrong, duration=0.01)


@pytest.mark.parametrize(("loop", "elasticity"), [("rigid", 1e4), ("elastic", None), ("no such loop", None)])
def test_a_loop_that_does_not_fit_the_joints_is_refused(loop, elasticity):
    with pytest.raises(LwrDynError, match="loop"):
        simulate(lwr(), pd(), still(), duration=0.01, loop=loop, elasticity=elasticity)


STEPS = 60
WORDS = "loop: compiled is some 10 times as fast for such a run"


@pytest.fixture
def shorter(monkeypatch):
    """Runs of 60 steps count as long."""
    monkeypatch.setattr(module, "LONG", STEPS)


def short_run(law=None, steps=STEPS, **options):
    return simulate(lwr(), law or pd(), still(np.full(4, 0.3)), duration=steps / 1000.0, **options)


@pytest.mark.usefixtures("shorter")
def test_a_long_run_of_a_law_that_compiles_says_which_loop_is_faster(tmp_path, monkeypatch):
    def compiles(plan):
        raise AssertionError("a hint needs no kernel")

    monkeypatch.setattr(compiled_loop, "whole_kernel", compiles)
    run = short_run()
    assert run.hint.startswith(WORDS)
    assert run.hint in repr(run)
    run.save(tmp_path / "run.npz")
    assert Run.load(tmp_path / "run.npz").hint == run.hint
    assert short_run(steps=STEPS // 2, substeps=2).hint.startswith(WORDS)  # substeps count


NO_HINT = {
    "short": lambda: {"steps": STEPS - 1},
    "law of one's own": lambda: {"law": lambda t, q, dq, *_: 0.0 * q},
    "compiled": lambda: {"loop": "compiled"},
    "kernels": lambda: {"engine": "kernels"},
    "continuous": lambda: {"continuous": True},
    "method": lambda: {"method": "dop853"},
    "stick": lambda: {"friction": [symmetric(0.05, 0.1)] * 4},
    "stop": lambda: {"dq0": np.full(4, 60.0), "q0": lwr().upper - 1e-3},
}


@pytest.mark.usefixtures("shorter")
@pytest.mark.parametrize("case", NO_HINT)
def test_nothing_is_said_where_no_other_loop_is_faster(case):
    assert short_run(**NO_HINT[case]()).hint == ""


@pytest.mark.usefixtures("shorter")
def test_nothing_is_said_without_the_extra(monkeypatch):
    def missing():
        raise MissingPackageError("llvmlite", "batch")

    monkeypatch.setattr(compiled_loop, "require_packages", missing)
    assert short_run().hint == ""


@pytest.mark.usefixtures("shorter")
def test_signals_without_a_form_for_them_are_refused_and_a_reason_to_say_nothing(monkeypatch):
    controller = pd()
    monkeypatch.setattr(type(controller), "signals", {"mine": np.zeros(1)}, raising=False)
    assert short_run(controller).hint == ""
    with pytest.raises(OptionError, match="signals"):
        compiled_run(controller, Later(lwr()))


@pytest.mark.usefixtures("shorter")
def test_the_run_is_the_same_and_the_law_keeps_what_it_has_learnt():
    laws = [lwr_dyn.controller("adaptive", lwr()) for _ in range(2)]
    long, short = (short_run(law, steps) for law, steps in zip(laws, (STEPS, STEPS - 1), strict=True))
    assert (bool(long.hint), short.hint) == (True, "")
    assert np.array_equal(long.q[:-1], short.q)
    name, estimate = next(iter(long.signals.items()))
    assert np.array_equal(laws[0].signals[name], estimate[-1])


@pytest.mark.slow
@pytest.mark.usefixtures("shorter")
def test_the_command_says_it_in_one_line(lwr_dyn_command):
    move = ["--task", "point-to-point", "--from-deg", "0,30,0,-60,0,30,0", "--to-deg", "1,31,0,-60,0,30,0"]
    given = ["simulate", "lwr4plus", *move, "--controller", "pd-gravity"]
    code, _, err = lwr_dyn_command(*given)
    assert code == 0
    assert [line for line in err.splitlines() if WORDS in line] == [f"note: {WORDS}, apart from sampling its reference"]
    code, out, err = lwr_dyn_command(*given, "--json")
    assert (code, err) == (0, "")
    assert json.loads(out)["meta"]["hint"].startswith(WORDS)


@pytest.mark.slow
def test_fifty_seconds_at_a_kilohertz_are_long():
    assert LONG == 50_000
    assert simulate(lwr(), pd(), still(seconds=50.0)).hint.startswith(WORDS)
    assert simulate(lwr(), pd(), still(seconds=50.0), duration=49.0).hint == ""
