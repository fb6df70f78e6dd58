"""The implicit loop: it moves as the usual one with short steps does, and refuses stops and stick by name."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.friction import symmetric
from lwr_dyn.simulation.stiff import between_samples
from lwr_dyn.trajectory.references.joint_moves import point_to_point


@pytest.fixture(scope="module")
def arm():
    """The LWR 4+ whose wrist is held: four joints."""
    return lwr_dyn.load("lwr4plus", "physical", lock=dict.fromkeys(("joint_5", "joint_6", "joint_7"), 0.5))


@pytest.fixture(scope="module")
def move(arm):
    start = np.array([0.1, 0.2, -0.1, 0.3])
    return point_to_point(arm, np.array([start, start + 0.2]), [0.1])


@pytest.fixture(scope="module")
def law(arm):
    return lwr_dyn.controller("pd-gravity", arm, inertia=np.full(4, 2.0))


@pytest.mark.slow
def test_a_stiff_loop_moves_as_short_steps_do(arm, move, law):
    """Loads that are light for these gains: explicit steps of 1 ms do not hold, the implicit method does."""
    one = lwr_dyn.simulate(arm, law, move, rate=1000.0, continuous=True, loop="stiff", friction="none")
    fine = lwr_dyn.simulate(arm, law, move, rate=1000.0, continuous=True, substeps=10, friction="none")
    assert np.abs(one.q - fine.q).max() < 2e-5 * np.abs(fine.q_ref - fine.q).max()
    assert np.abs(one.tau_command - fine.tau_command).max() < 1e-3 * np.abs(fine.tau_command).max()
    assert one.meta["evaluations"] < fine.meta["evaluations"] / 2


def test_friction_takes_its_work(arm, move, law):
    run = lwr_dyn.simulate(
        arm, law, move, rate=1000.0, continuous=True, loop="stiff", friction=[symmetric(0.0, 20.0)] * 4
    )
    assert run.tau_friction == pytest.approx(20.0 * run.dq)
    assert run.work["friction"][-1] == pytest.approx(-np.trapezoid((20.0 * run.dq**2).sum(axis=1), run.t), rel=1e-4)
    total = sum(channel[-1] for channel in run.work.values())
    assert run.energy[-1] - run.energy[0] == pytest.approx(total, abs=1e-4 * abs(run.work["friction"][-1]))


@pytest.mark.parametrize(
    ("options", "fault"),
    [({"continuous": False}, "a controller that is sampled"), ({"friction": [symmetric(1.0, 0.0)] * 4}, "true stick"),
     ({"elasticity": 1e4}, "elastic joints"), ({"upper": 0.2}, r"joint_1 reaches its own before 0\.0")],
)  # fmt: skip
def test_what_it_lacks_is_refused_by_name(arm, move, law, options, fault):
    narrow = replace(arm, limits=(replace(arm.limits[0], upper=options.pop("upper", 9.0)), *arm.limits[1:]))
    stiff = {"continuous": True, "loop": "stiff", "friction": "none", "plant": narrow}
    with pytest.raises(OptionError, match=fault):
        lwr_dyn.simulate(arm, law, move, **stiff | options)


def test_between_samples_the_reference_is_its_own(move):
    at, times = between_samples(move.sample(np.arange(101) / 1000.0)), np.linspace(0.0, 0.1, 37)
    expected = move.sample(times)
    for name, found in zip(("q", "dq", "ddq"), zip(*map(at, times), strict=True), strict=True):
        scale = np.abs(getattr(expected, name)).max()
        assert np.array(found) == pytest.approx(getattr(expected, name), abs=1e-9 * scale)
