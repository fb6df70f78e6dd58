"""What rollouts refuse, in one clear line."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.codegen.rollouts.kernel import room_for_record
from lwr_dyn.codegen.rollouts.law_forms import NoKernelFormError
from lwr_dyn.codegen.rollouts.run_parameters import arm_of_run, mass_matrices
from lwr_dyn.foundation import errors
from lwr_dyn.model.friction import symmetric
from tests.codegen.rollouts.test_rollouts import ARM, IST, OWN
from tests.random_arms import random_arm

LAW = lwr_dyn.controller("inverse-dynamics", ARM)
NAN = np.full(3, np.nan)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"inertias": [OWN]}, errors.UnknownNameError, "did you mean inertia"),
        ({"Kpp": [1.0]}, errors.UnknownNameError, "known: inertia.*Kp, Kd"),
        ({"inertia": [OWN[:69]]}, errors.ShapeError, r"\(1, 70\)"),
        ({"inertia": [OWN, -OWN]}, errors.OptionError, "a mass of -.* kg in run 1, link 1; allowed: masses from 0 on"),
        ({"inertia": [3.0]}, errors.ShapeError, r"\(1, 70\)"),
        ({"inertia": [OWN.reshape(7, 10).T]}, errors.ShapeError, r"\(1, 10, 7\)"),
        ({"friction": np.zeros((1, 7, 5))}, errors.ShapeError, r"\(1, 5, 7\)"),
        ({"payload": 2.0}, errors.ShapeError, "a single number"),
        ({"payload": [1.0, 2.0], "Kp": [100.0]}, errors.ShapeError, "1 rows; allowed: 2 rows"),
        ({"payload": []}, errors.OptionError, "from 1 to"),
        ({"payload": NAN}, errors.ShapeError, "finite"),
        ({"payload": [0.0, -1.0]}, errors.OptionError, "-1 in run 1"),
        ({"payload_com": [[0.0, 0.0, 0.1]]}, errors.OptionError, "without payload"),
        ({"delay": [0, 9]}, errors.OptionError, "9 in run 1"),
        ({"delay": [0.5]}, errors.OptionError, "whole numbers"),
        ({"reference": [1]}, errors.OptionError, "from 0 to 0"),
        ({"friction": np.zeros((1, 5, 7))}, errors.OptionError, "'smooth'"),
        ({"effort": [-1.0]}, errors.OptionError, "from 0 on"),
        ({"Kp": ["a"]}, errors.ShapeError, "numbers"),
    ],
)
def test_parameters_that_cannot_be_are_refused(given, error, words):
    with pytest.raises(error, match=words):
        lwr_dyn.rollouts(ARM, LAW, IST, parameters=given, duration=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"runs": 0}, "from 1 to"),
        ({"runs": 2.0}, "from 1 to"),
        ({"runs": True}, "from 1 to"),
        ({"runs": None}, "not given"),
        ({"rate": 0.0}, "above 0"),
        ({"duration": 0.0}, "above 0"),
        ({"substeps": 0}, "from 1"),
        ({"delay": 9}, "from 0 to 8"),
        ({"friction": "stick"}, "none, smooth"),
        ({"friction": "smooth", "friction_width": 0.0}, "above 0"),
        ({"quantiles": (1.0,)}, "between 0 and 1"),
        ({"quantiles": 0.95}, "a sequence"),
        ({"tolerance": -1.0}, "above 0"),
        ({"record": -1}, "from 0"),
        ({"threads": 0}, "from 1"),
        ({"first_run": -1}, "from 0"),
        ({"seed": -1}, "from 0"),
        ({"seed": 2**64}, "below 2"),
    ],
)
def test_options_that_cannot_be_are_refused(options, words):
    with pytest.raises(errors.OptionError, match=words):
        lwr_dyn.rollouts(ARM, LAW, IST, **{"runs": 1, "duration": 0.1} | options)


def test_a_record_that_memory_does_not_hold_is_refused():
    with pytest.raises(errors.OptionError, match="record: 1000000 runs of 1000000 samples, "):
        room_for_record(1_000_000, 1_000_000, 21)


def test_true_stick_is_refused_and_its_smooth_form_named():
    arm = lwr_dyn.load("lwr4plus")
    object.__setattr__(arm, "friction", (symmetric(1.0, 0.5),) * 7)
    law = lwr_dyn.controller("inverse-dynamics", arm)
    with pytest.raises(errors.OptionError, match="no true stick; allowed: friction 'smooth'"):
        lwr_dyn.rollouts(arm, law, IST, runs=1, friction="set-valued", duration=0.1)
    with pytest.raises(errors.OptionError, match="substeps from"):
        lwr_dyn.rollouts(arm, law, IST, runs=1, friction="smooth", duration=0.1)


def test_other_things_that_cannot_be_are_refused():
    with pytest.raises(NoKernelFormError):
        lwr_dyn.rollouts(ARM, lambda t, q, dq, q_ref, dq_ref, ddq_ref: -dq, IST, runs=1)
    with pytest.raises(errors.UnknownNameError):
        lwr_dyn.rollouts(ARM, "inverse-dynamic", IST, runs=1)
    with pytest.raises(errors.OptionError, match="a Reference"):
        lwr_dyn.rollouts(ARM, LAW, None, runs=1)
    with pytest.raises(errors.OptionError, match="empty sequence"):
        lwr_dyn.rollouts(ARM, LAW, [], runs=1)
    with pytest.raises(errors.OptionError, match="an arm"):
        lwr_dyn.rollouts("lwr4plus", LAW, IST, runs=1)
    with pytest.raises((errors.MissingDataError, errors.NotPhysicalError)):
        lwr_dyn.rollouts(ARM, LAW, IST, runs=1, plant=lwr_dyn.load("lwr4"), duration=0.1)
    with pytest.raises(errors.LwrDynError):
        lwr_dyn.rollouts(ARM, LAW, IST, runs=1, plant=lwr_dyn.load("kr30ha"), duration=0.1)


def test_a_start_outside_the_limits_is_refused():
    with pytest.raises(errors.OptionError, match="q0 of run 1"):
        lwr_dyn.rollouts(ARM, LAW, IST, parameters={"q0": [IST.sample(np.zeros(1)).q[0], [9.0] * 7]}, duration=0.1)


def test_a_run_that_was_not_made_is_refused():
    done = lwr_dyn.rollouts(ARM, LAW, IST, parameters={"inertia": [OWN]}, duration=0.1)
    for number in (1, -2, 0.5, "a", True, None):
        with pytest.raises(errors.OptionError, match="0 to 0"):
            done.run(number)


def test_friction_too_stiff_for_one_light_arm_is_refused():
    """The arm itself is slow enough: RK4 of 1 ms is stable below 2700 1/s."""
    table = np.zeros((5, 7))
    table[[0, 2]] = 0.02 * ARM.effort
    B = lwr_dyn.dynamics_of(ARM).mass_matrix(IST.sample(np.zeros(1)).q[0])
    own = np.linalg.eigvals(np.linalg.solve(B, np.diag(table[0]))).real.max()
    given = {"friction": [table, table], "armature": [ARM.armature, 0.5 * ARM.armature]}
    options = {"friction": "smooth", "friction_width": own / 2690.0, "duration": 0.01}
    with pytest.raises(errors.OptionError, match=r"run 1.*substeps"):
        lwr_dyn.rollouts(ARM, LAW, IST, parameters=given, **options)


@pytest.mark.parametrize("arm", [lwr_dyn.load("lwr4plus"), random_arm(5, "RPRP")])
def test_mass_matrices_are_those_of_each_runs_arm(arm):
    rng = np.random.default_rng(0)
    q = rng.normal(size=arm.n)
    given = {
        "inertia": (inertial_parameters(arm.chain) * rng.uniform(0.8, 1.2, (3, arm.n, 1))).reshape(3, -1),
        "payload": np.array([0.0, 1.0, 2.0]), "payload_com": rng.normal(size=(3, 3)),
        "armature": rng.uniform(0.0, 1.0, (3, arm.n)),
    }  # fmt: skip
    for i, found in enumerate(mass_matrices(arm.chain, q, given)):
        plant = arm_of_run(arm, {name: rows[i] for name, rows in given.items()})
        expected = lwr_dyn.dynamics_of(plant).mass_matrix(q)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-13 * np.abs(expected).max())
    np.testing.assert_allclose(mass_matrices(arm.chain, q, {})[0], lwr_dyn.dynamics_of(arm).mass_matrix(q), atol=1e-12)
