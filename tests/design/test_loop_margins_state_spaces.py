"""State spaces for python-control: the same poles and responses, and where its margins are not those of the loop."""

import sys

import numpy as np
import pytest

from lwr_dyn.design.loop_margins import frequency_grid, loop_gain, sensitivity
from lwr_dyn.design.margins import margins
from lwr_dyn.design.sampled_loop import GROWS
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from tests.design.margin_cases import BENT, arm, dynamics, law

JOINTS = (0, 1, 3)


def report(name="pd-gravity", **options):
    return margins(arm(), law(name), engine=dynamics(), q=[BENT], **options)


@pytest.fixture(scope="module")
def control():
    import control

    return control


@pytest.mark.slow
@pytest.mark.parametrize(("name", "options"), [("pd-gravity", {"delay": 2}), ("pid", {"cutoff_hz": 100.0})])
def test_python_control_closes_the_loop_to_the_same_poles_and_responses(name, options, control):
    found = report(name, **options)
    spaces, T = found.state_spaces(), 1e-3
    closed = control.feedback(spaces.open_loop, np.eye(7))
    ours, theirs = (np.sort(np.abs(p)) for p in (found.worst.poles, closed.poles()))
    np.testing.assert_allclose(theirs, ours, atol=1e-6)
    hz = frequency_grid(1000.0, 9)[4:]  # below 1 Hz three integrators leave few digits
    gain = loop_gain(found.loop, found.case.sampling, hz)
    z = np.exp(2j * np.pi * hz * T)
    shown = np.array([spaces.open_loop(x) for x in z])
    np.testing.assert_allclose(shown, gain[0], atol=1e-8 * np.abs(gain).max())
    diagonal = np.array([np.diag(spaces.sensitivity(x)) for x in z])
    np.testing.assert_allclose(diagonal, sensitivity(gain)[0], atol=1e-7)
    assert spaces.plant.dt == spaces.open_loop.dt == T
    assert spaces.plant.output_labels[0] == "q_joint_1"


@pytest.mark.slow
def test_the_plant_is_what_python_control_makes_of_the_continuous_one(control):
    found = report()
    plant = found.loop.plant
    continuous = control.ss(plant.A[0], plant.B[0], np.eye(14), 0)
    sampled, ours = control.sample_system(continuous, 1e-3, "zoh"), found.state_spaces().plant
    np.testing.assert_allclose(sampled.A, ours.A, atol=1e-10)
    np.testing.assert_allclose(sampled.B, ours.B, atol=1e-10)


def test_gain_margins_of_python_control_are_not_those_of_these_loops(control):
    """`stability_margins` of the loop cut at a joint, all others closed, which has one input and one output: the gain
    margin that it gives is passed by far without harm, and its distance from -1 is sometimes missing."""
    found = report()
    space, closed_others = found.state_spaces().open_loop, []
    for joint in JOINTS:
        others = [j for j in range(7) if j != joint]
        A = space.A - space.B[:, others] @ space.C[others]
        cut = control.ss(A, space.B[:, [joint]], space.C[[joint]], 0, 1e-3)
        closed_others.append(control.stability_margins(cut)[:3])
        true = found.worst.gain_up[joint]
        for factor, stable in ((0.99 * true, True), (1.01 * true, False)):
            scale = 1 + (factor - 1) * np.eye(7)[joint]
            assert (found.loop.radius(found.case.sampling, scale=scale)[0] <= GROWS) is np.bool_(stable)
    gains, _, distances = np.array(closed_others).T  # the numbers differ with and without slycot: wrong in both
    assert (gains < 0.5 * found.worst.gain_up[list(JOINTS)]).all()
    assert np.isinf(distances).any()


def test_without_python_control_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(MissingPackageError, match=r"lwr_dyn\[design\]"):
        report().state_spaces()


def test_a_loop_of_several_poses_is_refused(control):
    from lwr_dyn.design.loop_margins import state_spaces

    found = report()
    with pytest.raises(OptionError, match="one pose"):
        state_spaces(found.loops(np.array([BENT, BENT])), found.case.sampling, arm().joint_names)
