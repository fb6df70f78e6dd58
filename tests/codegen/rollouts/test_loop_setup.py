"""Rollouts in other conditions than tracking: a free swing, saturation, stops, several references, delay, noise."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.codegen.rollouts.result import figures_of
from lwr_dyn.codegen.rollouts.run_parameters import arm_of_run
from lwr_dyn.simulation.plant import Encoder
from tests.codegen.rollouts.test_rollouts import ARM, IST, OWN, perturbed
from tests.random_arms import random_arm

LAW = lwr_dyn.controller("inverse-dynamics", ARM, omega_n=50.0)


def differences(done, i, plant=ARM, **options):
    """Metric -> largest difference between the kernel's and those of `simulate`."""
    found = figures_of(done.run(i), plant, **options)
    assert found.keys() == done.metrics.keys()
    return {name: float(np.abs(np.subtract(done.metrics[name][i], x)).max()) for name, x in found.items() if _known(x)}


def _known(value):
    return np.isfinite(value).all()


@pytest.mark.slow
def test_a_free_swing_is_followed_for_a_second():
    """An arm that swings freely is chaotic: nothing can be asked after 6 s."""
    rest = lwr_dyn.reference("hold", ARM, q=IST.sample(np.zeros(1)).q[0], duration=1.0)
    given = {"effort": np.zeros(2), "inertia": perturbed(2)}
    done = lwr_dyn.rollouts(ARM, LAW, rest, parameters=given, record=1, position_limits=False)
    assert done.flags == ("", "")
    assert (done.metrics["limit_margin"] < 0.0).any()  # beyond limits that are off
    run = done.run(1)
    assert np.abs(run.q[-1] - run.q[0]).max() > 1.0
    assert np.abs(done.q[1] - run.q).max() < 1e-9  # rounding that has grown: 5e-11 on one processor, 1e-12 on another


@pytest.mark.slow
def test_cut_torques_and_their_time_are_those_of_simulate():
    own = {"inertia": [OWN]}
    effort = 0.98 * lwr_dyn.rollouts(ARM, LAW, IST, parameters=own, duration=1.0).metrics["peak_torque"]
    given = own | {"effort": effort}
    done = lwr_dyn.rollouts(ARM, LAW, IST, parameters=given, duration=1.0, tolerance=1e-5)
    assert done.flags == ("",)
    assert done.metrics["saturated_s"].max() > 0.002
    found = differences(done, 0, arm_of_run(ARM, {"effort": effort[0]}), tolerance=1e-5)
    assert found.pop("saturated_s") < 1e-15
    assert max(found.values()) < 1e-9  # the moment of a cut hangs on rounding: 1.3e-10 on one processor
    free = lwr_dyn.rollouts(ARM, LAW, IST, parameters=given, duration=1.0, saturate=False)
    assert (free.metrics["peak_torque"] > effort).any()
    assert differences(free, 0, arm_of_run(ARM, {"effort": effort[0]}))["saturated_s"] < 1e-15
    assert free.metrics["saturated_s"].max() > 0.002


def test_a_run_that_meets_a_stop_is_that_of_simulate_and_the_others_stay_in_the_kernel():
    rest = lwr_dyn.reference("hold", ARM, q=[0.0, 1.9, 0.0, 0.5, 0.0, 0.5, 0.0], duration=0.3)
    given = {"effort": ARM.effort * [[1.0], [0.05]], "inertia": [OWN, OWN]}
    options = {"record": 10, "tolerance": 1e-3, "quantiles": (0.9,)}
    done = lwr_dyn.rollouts(ARM, LAW, rest, parameters=given, **options)
    assert done.flags == ("", "stop")
    assert repr(done).startswith("Rollouts(2 runs, flags: 1 stop, 1 of them by simulate, ")
    assert done.simulated.tolist() == [False, True]
    run = done.run(1)
    assert any(event.kind == "stop" for event in run.events)
    found = figures_of(run, arm_of_run(ARM, {"effort": given["effort"][1]}), 1e-3, (0.9,))
    assert all(np.array_equal(done.metrics[name][1], value) for name, value in found.items())
    assert np.array_equal(done.q[1], run.q[::10])
    left = lwr_dyn.rollouts(ARM, LAW, rest, parameters=given, hand_over=False, **options)
    assert left.flags == done.flags
    assert not left.simulated.any()
    assert all(np.isnan(values[1]).all() for values in left.metrics.values())
    assert all(np.array_equal(values[0], done.metrics[name][0]) for name, values in left.metrics.items())


def test_each_run_has_the_reference_that_it_names():
    moves = [
        lwr_dyn.reference("point-to-point", ARM, start=[0.1] * 7, end=[end] * 7, duration=0.5) for end in (0.3, -0.2)
    ]
    own = np.tile(OWN, (3, 1))
    both = lwr_dyn.rollouts(ARM, LAW, moves, parameters={"reference": [1, 0, 1], "inertia": own}, record=1)
    assert not both.simulated.any()
    for i, which in enumerate((1, 0, 1)):
        alone = lwr_dyn.rollouts(ARM, LAW, moves[which], parameters={"inertia": own[:1]}, record=1)
        assert np.array_equal(both.q[i], alone.q[0])
        assert max(differences(both, i).values()) < 1e-10


@pytest.mark.slow
def test_delay_encoder_and_noise_are_those_of_simulate_with_the_runs_own_number():
    pd = lwr_dyn.controller("pd-gravity", ARM, velocity_error=True)
    given = {"delay": [0, 3, 8], "noise": [0.0, 2e-5, 1e-5], "inertia": perturbed(3)}
    encoder = Encoder.of_bits(16, noise=1e-5)
    done = lwr_dyn.rollouts(
        ARM, pd, IST, parameters=given, encoder=encoder, duration=0.5, seed=7, first_run=40, record=1
    )
    assert not done.simulated.any()
    for i in range(3):
        run = done.run(i)
        assert np.abs(run.q - done.q[i]).max() < 1e-12
        assert np.abs(run.tau_applied - done.tau[i]).max() < 1e-7
    later = {name: values[2:] for name, values in given.items()}
    again = lwr_dyn.rollouts(
        ARM, pd, IST, parameters=later, encoder=encoder, duration=0.5, seed=7, first_run=42, record=1
    )
    assert np.array_equal(again.q[0], done.q[2])
    other = lwr_dyn.rollouts(ARM, pd, IST, parameters=later, encoder=encoder, duration=0.5, seed=7, record=1)
    assert not np.array_equal(other.q[0], done.q[2])


@pytest.mark.slow
def test_loads_armature_start_friction_and_substeps_are_those_of_simulate():
    start = IST.sample(np.zeros(1)).q[0]
    friction = np.tile([[3.0], [1.0], [2.0], [0.5], [0.1]], (2, 1, 7)) * [[[1.0]], [[0.0]]]
    given = {
        "payload": [0.0, 3.0], "payload_com": [[0.0, 0.0, 0.0], [0.02, -0.01, 0.1]], "armature": [0.2, 0.05],
        "q0": np.add(start, [[0.0], [0.01]]), "dq0": [0.0, 0.1], "model_payload": [0.0, 2.0], "friction": friction,
    }  # fmt: skip
    done = lwr_dyn.rollouts(
        ARM, LAW, IST, parameters=given, friction="smooth", friction_width=0.05, substeps=3, duration=0.5,
        plant=lwr_dyn.load("lwr4plus", reading="physical"),
    )  # fmt: skip
    assert not done.simulated.any()
    for i in range(2):
        assert differences(done, i)["tip_max"] < 1e-12
        assert max(differences(done, i).values()) < 1e-9


@pytest.mark.slow
def test_an_arm_with_sliding_joints_moves_as_in_simulate():
    arm = random_arm(5, "RPRP")
    law = lwr_dyn.controller("inverse-dynamics", arm, omega_n=20.0)
    move = lwr_dyn.reference("point-to-point", arm, start=[0.1] * 4, end=[0.3, 0.2, -0.2, 0.0], duration=0.5)
    own = inertial_parameters(arm.chain).ravel()
    done = lwr_dyn.rollouts(arm, law, move, parameters={"inertia": own * [[1.0], [1.1]]}, record=1)
    assert done.flags == ("", "")
    assert np.abs(done.run(1).q - done.q[1]).max() < 1e-12
    assert max(differences(done, 1, arm).values()) < 1e-10
