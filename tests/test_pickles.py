"""What a user sends to a process pool can be pickled, and what arrives gives the same numbers to the last bit.

Every name of `import lwr_dyn` has a row, and every controller, wrapper and kind of reference; only a function of the
user's own is bound to what pickle asks of functions: a place in a module.
"""

import pickle
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import CONTROLLERS, WRAPPERS
from lwr_dyn.control.protocol import JointReadings
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.model.friction import symmetric
from lwr_dyn.model.run import Motion
from lwr_dyn.trajectory.references.references import REFERENCES

ARM = replace(lwr_dyn.load("lwr4plus"), friction=(symmetric(1.0, 0.5),) * 7)
POSE = [0.1, 0.4, -0.2, -1.0, 0.3, 0.5, 0.2]
ENDS = {"start": POSE, "end": [0.3] * 7}
TIP = lwr_dyn.forward_kinematics(ARM, POSE)[:3, 3] + [0.0, 0.05, 0.0]
RECORDED = "time [s],q1,q2,q3,q4,q5,q6,q7\n" + "\n".join(
    f"{0.1 * k},{','.join([str(0.01 * k)] * 7)}" for k in range(30)
)
WAYPOINTS = "q1,q2,q3,q4,q5,q6,q7\n0,0.3,0,-1,0,0.5,0\n0.2,0.5,0,-1.2,0,0.5,0\n"

LONG = ("batch_dynamics", "ik_solver", "ik_solver, kernel", "rollouts", "rank", "least-time")
"""The first use of a kernel on a machine compiles for seconds."""


def there(made):
    return pickle.loads(pickle.dumps(made))


def same(one, other):
    """The same kind of thing, and the same bits of all numbers in it; functions and engines are not looked at."""
    if isinstance(one, Mapping):  # what is found when first read is there a plain dictionary
        return same([*one.items()], [*other.items()])
    assert type(one) is type(other)
    if isinstance(one, np.ndarray):
        assert np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    elif is_dataclass(one):
        for field in fields(one):
            same(getattr(one, field.name), getattr(other, field.name))
    elif isinstance(one, list | tuple):
        assert len(one) == len(other)
        for pair in zip(one, other, strict=True):
            same(*pair)
    elif isinstance(one, str | int | float | bool | None):
        assert one == other or one != one


def samples(count):
    """Arguments of a controller at a few samples of a motion."""
    for k in range(count):
        t = 0.001 * k
        q = np.array(POSE) + 0.01 * np.sin(t * np.arange(1, 8))
        yield t, q, np.full(7, 0.02), np.array(POSE) + 0.02, np.full(7, 0.01), np.full(7, 0.1)


def driven(law, calls):
    """Torques at samples, with the readings of joint sensors where the law takes them."""
    for call in calls:
        if hasattr(law, "sense"):
            law.sense(JointReadings(call[1] + 1e-3, call[2], call[1], call[2], np.full(7, 2.0)))
        yield law(*call)


@pytest.mark.parametrize("name", [*CONTROLLERS.names, *(f"pid+{name}" for name in WRAPPERS.names), "adaptive+observer"])
def test_a_controller_goes_on_where_it_was(name):
    searched = name.startswith(("pd-gravity", "pid", "motor-pd", "joint-impedance"))
    law, calls = lwr_dyn.controller(name, ARM, **({"inertia": [2.0] * 7} if searched else {})), [*samples(6)]
    [*driven(law, calls[:3])]
    other = there(law)
    assert other.parameters == law.parameters
    assert np.array_equal([*driven(law, calls[3:])], [*driven(other, calls[3:])])
    if hasattr(law, "linear_feedback"):
        same(law.linear_feedback(np.array([POSE])).position, other.linear_feedback(np.array([POSE])).position)


def test_a_law_without_feedforward_and_stribeck_friction_too():
    held = lwr_dyn.controller("joint-impedance", ARM, stiffness=500.0, feedforward=False)
    stribeck = [replace(symmetric(1.0, 0.5), positive=replace(symmetric(1.0, 0.5).positive, static=2.0,
                                                              stribeck_velocity=0.01))] * 7  # fmt: skip
    compensated = lwr_dyn.controller("inverse-dynamics+friction", ARM, friction=stribeck)
    for law in (held, compensated):
        other = there(law)
        assert np.array_equal([*driven(law, samples(2))], [*driven(other, samples(2))])


OPTIONS = {
    "ist": {}, "ist-clear": {}, "ist-clear-twice": {}, "point-to-point": {**ENDS, "duration": 1.0}, "move": {},
    "lspb": {**ENDS, "duration": 2.0}, "line": {"start": POSE, "to_xyz": TIP},
    "waypoints": {"waypoints": WAYPOINTS}, "least-time": {"along": "point-to-point", **ENDS}, "csv": {"file": RECORDED},
    "step": {"start": POSE}, "chirp": {"start": POSE}, "hold": {"q": POSE},
}  # fmt: skip


def wave(t):
    return 0.1 * np.sin(t * np.arange(1, 8))


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in (*REFERENCES.names, wave)]
)
def test_a_reference_is_the_same_motion(name, tmp_path):
    options = {"duration": 1.0} if callable(name) else dict(OPTIONS[name])
    for key in ("waypoints", "file"):
        if key in options:
            path = tmp_path / f"{key}.csv"
            path.write_text(options[key])
            options[key] = str(path)
    reference = lwr_dyn.reference(name, ARM, **options)
    t = np.linspace(0.0, reference.duration, 7)
    same(reference.sample(t), there(reference).sample(t))


def a_run(law="inverse-dynamics"):
    hold = lwr_dyn.reference("hold", ARM, q=POSE, duration=0.003)
    return lwr_dyn.simulate(ARM, lwr_dyn.controller(law, ARM), hold)


def a_ranking():
    arm = lwr_dyn.load("ur10")
    t = 0.02 * np.arange(400)
    q = np.stack([np.sin((1.0 + 0.2 * j) * t + j) for j in range(6)], axis=1)
    dq, ddq = (np.gradient(q, 0.02, axis=0), np.gradient(np.gradient(q, 0.02, axis=0), 0.02, axis=0))
    tau = lwr_dyn.dynamics_of(arm).inverse_dynamics(q, dq, ddq) + 5.0 * np.tanh(100 * dq)
    noise = np.random.default_rng(0).normal(0.0, 2.0, tau.shape)
    return lwr_dyn.rank("ur10", JointLog("log", tuple(range(1, 7)), t, q, tau + noise), [arm, lwr_dyn.load("ur10e")])


def solved(solve):
    T = lwr_dyn.forward_kinematics(ARM, POSE)
    return solve(T), solve(T, [0.0] * 7), solve.batch(T[None])


def of_batch(batch):
    return batch.mass_matrix(np.array([POSE])), batch.gravity_vector(np.array([POSE]))


def everything(made):
    return made


RESULTS = {
    "load": (lambda: ARM, lambda arm: (arm, lwr_dyn.urdf_text(arm))),
    "dynamics_of": (lambda: lwr_dyn.dynamics_of(ARM), of_batch),
    "batch_dynamics": (lambda: lwr_dyn.batch_dynamics(ARM), of_batch),
    "ik_solver": (lambda: lwr_dyn.ik_solver(ARM), solved),
    "ik_solver, pinocchio": (lambda: lwr_dyn.ik_solver(ARM, search="pinocchio", limits=False, seed=3), solved),
    "ik_solver, kernel": (lambda: lwr_dyn.ik_solver(ARM, search="kernel", starts=7, seed=3), solved),
    "inverse_kinematics": (
        lambda: lwr_dyn.inverse_kinematics(ARM, lwr_dyn.forward_kinematics(ARM, POSE)),
        everything,
    ),
    "forward_kinematics": (lambda: lwr_dyn.forward_kinematics(ARM, POSE), everything),
    "Motion": (lambda: Motion([0.0], [POSE], [POSE], [POSE]), everything),
    "Run": (a_run, everything),
    "simulate": (lambda: a_run("adaptive+observer"), everything),
    "compare": (lambda: lwr_dyn.compare(a_run(), a_run("cartesian-impedance")), lambda found: found.document.text()),
    "margins": (
        lambda: lwr_dyn.margins(ARM, "robust", q=POSE),
        lambda found: (found, found.document.text(), found.loops(np.array([POSE])).step_matrices(found.case.sampling)),
    ),
    "rank": (a_ranking, lambda found: (found, found.document.text())),
    "rollouts": (
        lambda: lwr_dyn.rollouts(ARM, "pid", lwr_dyn.reference("hold", ARM, q=POSE, duration=0.003), runs=2),
        lambda rolls: (rolls.metrics, rolls.run(1).q),
    ),
}  # fmt: skip
"""Name -> what makes such an object, and what is asked of it."""
ABOVE = {"controller": "test_a_controller_goes_on_where_it_was", "reference": "test_a_reference_is_the_same_motion"}
TEXT_OR_NOTHING = {"urdf_text", "robots", "readings", "engines", "replay", "show", "plot"}
"""They give texts, write a file, or draw: a figure belongs to matplotlib."""


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in RESULTS])
def test_a_result_is_the_same(name):
    make, ask = RESULTS[name]
    made = make()
    same(ask(made), ask(there(made)))


def test_every_name_of_the_front_door_has_a_row():
    rows = {name.partition(",")[0] for name in RESULTS}
    assert rows | ABOVE.keys() | TEXT_OR_NOTHING == set(lwr_dyn.__all__)
    assert OPTIONS.keys() == set(REFERENCES.names)
