"""A push is J^T f with a smooth course: against the Jacobian, and with its work in a run that closes."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.kinematics.forward import frames, jacobian_at, joint_axes
from lwr_dyn.model.spatial import Pose
from lwr_dyn.simulation.environment.walls_and_pushes import Course, Push
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.sample_runs import joint_waves, lwr
from tests.slips import uncaught

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


def check(module):
    """The torque at several points against the Jacobian, and the course at some times."""
    for at in ("flange", "link_3", "link_7"):
        push = module.Push(arm_with_tool(), FORCE, start=1.0, duration=1.0, rise=0.2, at=at, point=POINT)
        for q in np.random.default_rng(1).uniform(-1.5, 1.5, (5, 7)):
            for t, share in ((0.5, 0.0), (1.1, 0.5), (1.5, 1.0), (1.95, 0.103515625), (2.5, 0.0)):
                expected = share * jacobian_of(at, POINT, q).T @ FORCE
                np.testing.assert_allclose(push(t, q, np.zeros(7)), expected, rtol=0, atol=1e-12)


SLIPS = (
    ("gravity=-self.force", "gravity=self.force"),
    ("share * self._pull(q)", "self._pull(q)"),
    ("unit if j == place", "unit if j == len(names) - 1"),
    ("unit.seen_from(chain.flange)", "unit"),
    ("6.0 * x - 15.0", "6.0 * x + 15.0"),
    ("self.start + self.duration - t", "self.duration - t"),
)


def test_planted_slips_are_caught():
    assert not uncaught("lwr_dyn.simulation.environment.walls_and_pushes", SLIPS, check)


def test_its_work_closes_the_audit_and_it_is_written_down():
    push = Push(lwr(), (10.0, 0.0, 5.0), start=0.1, duration=0.3, at="link_3")
    law = lwr_dyn.controller("inverse-dynamics", lwr(), omega_n=15.0)
    run = simulate(lwr(), law, joint_waves(), duration=0.5, external=push)
    assert run.audit["closed"], run.audit
    assert abs(run.work["external"][-1]) > 1e-4
    assert run.meta["external"] == {"name": "push", "label": "push", "parameters": push.parameters}
    assert not run.signals["tau_external"][:100].any()


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"force": (1.0, 2.0)}, ShapeError, "push force"),
        ({"force": (1.0, np.nan, 0.0)}, ShapeError, "push force"),
        ({"at": "elbow"}, OptionError, "push at: elbow; allowed: flange, link_1, "),
        ({"duration": 0.0}, OptionError, "push duration"),
        ({"rise": 0.0}, OptionError, "push rise"),
        ({"rise": 0.2}, OptionError, "push rise: 0.2; allowed: at most half of the duration, 0.15 s"),
        ({"start": np.inf}, OptionError, "push start"),
    ],
)
def test_bad_pushes_are_refused(options, error, words):
    with pytest.raises(error, match=words):
        Push(lwr(), **{"force": FORCE, "start": 1.0, "duration": 0.3} | options)


def test_the_course_is_smooth():
    course, t = Course(0.0, 1.0, 0.25), np.linspace(-0.1, 1.1, 12001)
    s = np.array([course.share(x) for x in t])
    bend = np.diff(s, 2) / (t[1] - t[0]) ** 2
    assert np.abs(np.diff(bend)).max() < 0.4  # no jump in the second derivative, whose largest value is 92
    assert s.min() == 0.0
    assert s.max() == pytest.approx(1.0, abs=1e-14)
