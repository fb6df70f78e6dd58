"""The implicit loop: it moves as the usual one with short steps does, and refuses stops and stick by name."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import DivergenceError, OptionError
from lwr_dyn.model.friction import symmetric
from lwr_dyn.simulation.stiff import between_samples
from lwr_dyn.trajectory.references.joint_moves import point_to_point
from tests.simulation.sample_runs import Sinusoids, Still, one_joint


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


def test_a_motion_that_grows_without_bound_or_a_torque_that_is_none_ends_the_run_and_does_not_last_for_ever():
    """2 ddq = 8 q^3 from q = dq = 1: dq^2 = 2 q^4 - 1, which is infinite after 0.75 s."""
    arm, still = one_joint(mass=2.0), Still(np.zeros(1), 2.0)
    options = {"continuous": True, "loop": "stiff", "q0": [1.0], "dq0": [1.0], "rate": 100.0}
    ends = [
        (lambda t, q, *_: 8.0 * q**3, r"t = 0\.71 s: joint_1: 381 m/s at the last sample that can be followed"),
        (lambda t, q, *_: [8.0 * q[0] ** 3 if q[0] < 2.0 else np.nan], r"joint_1: torque command nan"),
        (lambda *_: [np.nan], "t = 0 s: joint_1: torque command nan"),
        (lambda *_: [1e300], "t = 0 s: joint_1: 1 m/s at the last sample that can be followed"),
    ]
    for law, words in ends:
        with pytest.raises(DivergenceError, match=words) as fault:
            lwr_dyn.simulate(arm, law, still, **options)
        run, broken = fault.value.run, "nan" in words
        np.testing.assert_allclose(run.dq**2, 2.0 * run.q**4 - 1.0, rtol=2e-4)
        assert (run.q < 2.0).all() or not broken
        assert np.abs(run.dq).max() <= 2 * np.pi * 100.0
    shares = []
    run = lwr_dyn.simulate(arm, ends[0][0], replace(still, duration=0.5), progress=shares.append, **options)
    np.testing.assert_allclose(run.dq**2, 2.0 * run.q**4 - 1.0, rtol=1e-4)
    np.testing.assert_allclose(run.tau_command, 8.0 * run.q**3, rtol=1e-12)
    np.testing.assert_allclose(run.work["actuator"], 2.0 * (run.q[:, 0] ** 4 - 1.0), rtol=1e-4, atol=1e-9)
    assert shares == [1.0]


def test_a_law_forgets_the_sensors_of_the_run_before():
    arm = lwr_dyn.load("lwr4plus", reading="physical")
    law, hold = lwr_dyn.controller("motor-pd", arm, inertia=np.ones(7)), Still(np.full(7, 0.3), 0.01)
    stiff = {"continuous": True, "loop": "stiff"}
    first, _, again = (
        lwr_dyn.simulate(arm, law, hold, q0=[0.31] * 7, **options) for options in (stiff, {"elasticity": "file"}, stiff)
    )
    np.testing.assert_array_equal(again.tau_command, first.tau_command)


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


def test_between_samples_the_reference_is_its_own():
    wave = Sinusoids(np.array([0.2, -0.1]), np.array([0.4, 1.0]), np.array([9.0, -5.0]))
    at, times = between_samples(wave.sample(np.arange(101) / 1000.0)), np.linspace(0.0, 0.1, 370)
    expected = wave.sample(times)
    for name, found in zip(("q", "dq", "ddq"), zip(*map(at, times), strict=True), strict=True):
        scale = np.abs(getattr(expected, name)).max()
        assert np.array(found) == pytest.approx(getattr(expected, name), abs=1e-9 * scale)
