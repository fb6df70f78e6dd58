"""The wall: its force by hand, its energy, what it takes out, where it touches, and its channel in the audit."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.kinematics.forward import frames, jacobian, jacobian_at, joint_axes
from lwr_dyn.model.spatial import Pose
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.simulation.walls_and_pushes import Course, Push, Wall
from tests.simulation.sample_runs import joint_waves, lwr

ARM = lwr_dyn.load("lwr4plus", reading="physical")
POSE = np.array([0.0, 0.7, 0.0, -1.5, 0.0, 0.9, 0.0])
TIP = lwr_dyn.forward_kinematics(ARM, POSE)[:3, 3]
SPEED = np.array([0.1, -0.2, 0.3, 0.2, -0.1, 0.3, 0.2])
NORMAL = np.array([1.0, 2.0, 2.0]) / 3.0
K, LOSS, M, MU, SLIP = 2e4, 0.8, 1.5, 0.3, 0.02


def force_by_hand(depth, velocity):
    """f (3,) of the formulas in the module's docstring."""
    if depth <= 0.0:
        return np.zeros(3)
    inward = -NORMAL @ velocity
    normal = max(K * depth**M * (1.0 + LOSS * inward), 0.0)
    along = velocity + inward * NORMAL
    return normal * NORMAL - MU * normal * along / np.sqrt(along @ along + SLIP**2)


def test_a_wall_pushes_by_the_formulas():
    point = np.array([0.04, -0.02, 0.1])
    T, J = lwr_dyn.forward_kinematics(ARM, POSE), jacobian(ARM.chain, POSE)
    lever = T[:3, :3] @ point
    at_point = J[:3] + np.cross(J[3:].T, lever).T
    touching = T[:3, 3] + lever
    for depth in (-1e-3, 2e-3):
        for side in (1.0, -1.0, 400.0, -400.0):  # away so fast that the force would pull, in one of the last two
            wall = Wall(ARM, touching + depth * NORMAL, 3.0 * NORMAL, K, LOSS, M, MU, SLIP, point)
            expected = force_by_hand(depth, at_point @ (side * SPEED))
            np.testing.assert_allclose(wall.forces(POSE, side * SPEED), expected, rtol=1e-9)
            np.testing.assert_allclose(wall(0.0, POSE, side * SPEED), at_point.T @ expected, rtol=1e-9, atol=1e-12)
            np.testing.assert_allclose(wall.depth(POSE), depth, rtol=1e-9)
    spring = Wall(ARM, touching + 2e-3 * NORMAL, NORMAL, K, 0.0, M, 0.0, SLIP, point)
    slope = [spring.energy(POSE + 1e-6 * e) - spring.energy(POSE - 1e-6 * e) for e in np.eye(7)]
    np.testing.assert_allclose(-np.array(slope) / 2e-6, spring(0.0, POSE, 0.0 * SPEED), rtol=1e-5, atol=1e-6)


def test_a_slow_impact_returns_the_share_of_hunt_and_crossley():
    """1 kg at 0.1 m/s with c = 1 s/m: 1 - 2 c v / 3 of the speed, to the square of that loss."""
    wall = Wall(ARM, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 1e5, 1.0)
    x, v, h = 0.0, -0.1, 1e-5
    while x <= 0.0 or v < 0.0:
        force = wall._force(-x, np.array([0.0, 0.0, v]))[2] if x < 0.0 else 0.0
        v += h * force
        x += h * v
    assert abs(v / 0.1 - (1.0 - 2.0 * 0.1 / 3.0)) < (2.0 * 0.1 / 3.0) ** 2


def test_batches_of_states_are_states_one_by_one():
    wall = Wall(ARM, TIP + 1e-3 * NORMAL, NORMAL, friction=0.2)
    q = POSE + np.linspace(0.0, 0.02, 6).reshape(2, 3, 1)
    dq = np.broadcast_to(SPEED, q.shape)
    together = wall.forces(q, dq)
    assert (together.shape, wall.depth(q).shape) == ((2, 3, 3), (2, 3))
    np.testing.assert_array_equal(together[1, 2], wall.forces(q[1, 2], SPEED))


def test_a_press_closes_the_audit_with_its_channel():
    """The second engine sees the wall too: its residual is that of a run without it."""
    wall = Wall(ARM, TIP - [0.0, 0.0, 0.01], [0.0, 0.0, 1.0], friction=0.3)
    law = lwr_dyn.controller("cartesian-impedance", ARM)
    press = lwr_dyn.reference("line", ARM, start=POSE, to_xyz=TIP - [0.0, 0.0, 0.02], duration=0.6)
    run = lwr_dyn.simulate(ARM, law, press, external=wall, duration=0.8, friction="none")
    record = run.meta["audit"]
    assert record["closed"]
    assert record["channels"]["external"] < -1e-3
    assert run.meta["external"]["parameters"] == wall.parameters
    np.testing.assert_allclose(
        run.signals["tau_external"], [wall(0.0, *state) for state in zip(run.q, run.dq, strict=True)]
    )
    assert -run.work["external"][-1] > wall.energy(run.q[-1])  # the rest is lost to friction and damping


FORCE = np.array([3.0, -2.0, 5.0])
POINT = np.array([0.02, -0.03, 0.05])


@cache
def arm_with_tool():
    """The LWR 4+, whose flange frame is that of its last link, with its flange moved and turned."""
    flange = Pose(np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.array([0.1, 0.05, 0.2]))
    return lwr().with_chain(replace(lwr().chain, flange=flange))


def jacobian_of(at, point, q):
    """(3, n) of a point of a link or of the flange, from the axes of the joints."""
    poses, place = frames(arm_with_tool().chain, q), 7 if at == "flange" else int(at[-1]) - 1
    J = jacobian_at(joint_axes(arm_with_tool().chain, q), poses[place, :3, :3] @ point + poses[place, :3, 3])[:3]
    J[:, place + (at != "flange") :] = 0.0
    return J


def test_a_push_acts_for_its_time():
    """The torque at several points against the Jacobian, and the course at some times."""
    for at in ("flange", "link_3", "link_7"):
        push = Push(arm_with_tool(), FORCE, start=1.0, duration=1.0, rise=0.2, at=at, point=POINT)
        for q in np.random.default_rng(1).uniform(-1.5, 1.5, (5, 7)):
            for t, share in ((0.5, 0.0), (1.1, 0.5), (1.5, 1.0), (1.95, 0.103515625), (2.5, 0.0)):
                expected = share * jacobian_of(at, POINT, q).T @ FORCE
                np.testing.assert_allclose(push(t, q, np.zeros(7)), expected, rtol=0, atol=1e-12)


def test_its_work_closes_the_audit_and_it_is_written_down():
    push = Push(lwr(), (10.0, 0.0, 5.0), start=0.1, duration=0.3, at="link_3")
    law = lwr_dyn.controller("inverse-dynamics", lwr(), omega_n=15.0)
    run = simulate(lwr(), law, joint_waves(), duration=0.5, external=push)
    assert run.audit["closed"], run.audit
    assert abs(run.work["external"][-1]) > 1e-4
    assert run.meta["external"] == {"name": "push", "label": "push", "parameters": push.parameters}
    assert not run.signals["tau_external"][:100].any()


def test_the_course_is_smooth():
    course, t = Course(0.0, 1.0, 0.25), np.linspace(-0.1, 1.1, 12001)
    s = np.array([course.share(x) for x in t])
    bend = np.diff(s, 2) / (t[1] - t[0]) ** 2
    assert np.abs(np.diff(bend)).max() < 0.4  # no jump in the second derivative, whose largest value is 92
    assert s.min() == 0.0
    assert s.max() == pytest.approx(1.0, abs=1e-14)


def test_numbers_where_nothing_is_given_and_the_course_to_its_ends():
    push, wall = Push(ARM, [1.0, 0.0, 0.0], 0.3), Wall(ARM, [0.0, 0.0, 0.5], [0.0, 0.0, 2.0])
    course = {"start": 0.3, "duration": 0.2, "rise": 0.02}
    assert push.parameters == {"force": [1.0, 0.0, 0.0], "at": "flange", "point": [0.0] * 3, **course}
    numbers = {"stiffness": 1e5, "loss": 1.0, "exponent": 1.5, "friction": 0.0, "slip_speed": 0.01}
    assert wall.parameters == {"place": [0.0, 0.0, 0.5], "normal": [0.0, 0.0, 1.0], "point": [0.0] * 3, **numbers}
    whole = Course(1.0, 0.4, 0.2)  # it may rise for half of its time
    times = np.array([0.9, 1.0, 1.05, 1.1, 1.2, 1.3, 1.4, 1.5])
    u = np.array([0.0, 0.0, 0.25, 0.5, 1.0, 0.5, 0.0, 0.0])
    np.testing.assert_allclose([whole.share(t) for t in times], 10 * u**3 - 15 * u**4 + 6 * u**5, atol=1e-12)


def wall(**options):
    return Wall(ARM, **({"place": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]} | options))


def push(**options):
    return Push(lwr(), **{"force": FORCE, "start": 1.0, "duration": 0.3} | options)


BAD = [
    *((wall, {name: bad}, OptionError, f"{name} of a wall: {bad}; allowed: a number ")
      for name, bad in (("stiffness", 0.0), ("stiffness", -1.0), ("stiffness", np.inf), ("loss", -0.1),
                        ("exponent", 0.5), ("friction", -0.1), ("slip_speed", 0.0))),
    (wall, {"normal": [0.0, 0.0, 0.0]}, OptionError, "normal"),
    (wall, {"place": [0.0, 0.0]}, ShapeError, "place: 2 numbers; allowed: 3 numbers"),
    (wall, {"point": np.eye(3)}, ShapeError, "point"),
    (wall, {"normal": [0.0, np.nan, 1.0]}, ShapeError, "normal: nan"),
    (push, {"force": (1.0, 2.0)}, ShapeError, "push force: 2 numbers; allowed: 3 numbers"),
    (push, {"force": (1.0, np.nan, 0.0)}, ShapeError, "push force: nan"),
    (push, {"at": "elbow"}, OptionError, "push at: elbow; allowed: flange, link_1, "),
    (push, {"duration": 0.0}, OptionError, "push duration: 0.0; allowed: a number above 0, in s"),
    (push, {"rise": 0.0}, OptionError, "push rise: 0.0"),
    (push, {"rise": 0.151}, OptionError, "push rise: 0.151; allowed: at most half of the duration, 0.15 s"),
    (push, {"start": np.inf}, OptionError, "push start: inf; allowed: a number, in s"),
]  # fmt: skip


@pytest.mark.parametrize(("made", "options", "error", "words"), BAD)
def test_walls_pushes_and_states_that_cannot_be(made, options, error, words):
    with pytest.raises(error, match=words):
        made(**options)
    with pytest.raises(ShapeError, match="dq"):
        wall().forces(np.zeros((2, 7)), np.zeros((3, 7)))
    with pytest.raises(ShapeError, match="q"):
        wall().depth(np.zeros(6))
