"""Rollouts of every law with a kernel form against `simulate`: gains, loads, friction, delay and limits differ by run.

The arm is the first four joints of the LWR 4+, whose kernels compile in half a second; `scripts/soak.py rollout_laws`
does the same on all seven, at more variants.
"""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import friction_parameters, inertial_parameters
from lwr_dyn.codegen.rollouts.law_forms import LAW_FORMS, law_form
from lwr_dyn.trajectory.references.joint_moves import point_to_point
from tests.codegen.rollouts.beside import ARM, made

RUNS = 9
"""One more than a block has lanes."""
SHARE = 1e-12
"""[rad] What may be left between kernel and `simulate`; these loops are stable, so that roundings do not grow."""


def parameters_of(arm, form, heaviest, weakest, seed=0):
    """Every parameter that a run may have, a row a run: gains changed by 10 %, loads that the law knows in part."""
    rng = np.random.default_rng(seed)

    def spread(value, share=0.1):
        value = np.asarray(value, dtype=np.float64)
        return value * (1.0 + share * rng.uniform(-1.0, 1.0, (RUNS, *value.shape)))

    gains = {name: spread(value, 0.02 if "load" in name else 0.1) for name, value in form.values().items()}
    q0 = START[: arm.n] + 0.03 * rng.uniform(-1.0, 1.0, (RUNS, arm.n))
    return gains | {
        "inertia": spread(inertial_parameters(arm.chain).ravel()),
        "payload": np.linspace(0.0, heaviest, RUNS), "payload_com": 0.05 * rng.normal(size=(RUNS, 3)),
        "model_payload": np.linspace(heaviest / 2, 0.0, RUNS), "friction": spread(friction_parameters(arm)), "q0": q0,
        "delay": np.arange(RUNS) % 4, "effort": arm.effort * np.linspace(1.2, weakest, RUNS)[:, None],
    }  # fmt: skip


START = np.array([0.3, -1.2, 0.2, 0.9, -1.5, 1.1, -0.6])


def largest_difference(arm, name, options, duration, compared=range(RUNS), heaviest=5.0, weakest=0.2):
    """Of the runs `compared`: positions [rad], speeds / 100 and shares of torques / 10; and samples at a torque limit.

    Unknown loads from 0 to `heaviest` [kg], torque limits down to the share `weakest` of the arm's own.

    Speeds and torques carry the roundings of gains of tens of 1/s.
    """
    law = made(name, arm, **options)
    end = START[: arm.n] + 0.15
    reference = point_to_point(arm, [START[: arm.n], end], [duration])
    parameters = parameters_of(arm, law_form(law, arm), heaviest, weakest)
    done = lwr_dyn.rollouts(
        arm, law, reference, parameters=parameters, friction="smooth", friction_width=0.05,
        record=1, substeps=1, hand_over=False,
    )  # fmt: skip
    assert set(done.flags) == {""}
    worst, cut = 0.0, 0
    for i in compared:
        run = done.run(i)
        worst = max(worst, np.abs(run.q - done.q[i]).max(), np.abs(run.dq - done.dq[i]).max() / 100.0)
        worst = max(worst, np.abs(run.tau_applied - done.tau[i]).max() / np.abs(run.tau_applied).max() / 10.0)
        cut += int((np.abs(run.tau_command) > np.abs(run.tau_applied)).any(axis=1).sum())
    return worst, cut


CASES = {
    "pd-gravity": {"omega_n": 20.0, "velocity_error": True},
    "pid+friction": {"omega_n": 20.0},
    "inverse-dynamics+friction-measured": {"friction_width": 0.1},
    "motor-pd": {},
    "adaptive": {"adapt_friction": True},
    "robust": {},
}


def test_every_law_with_a_form_is_here():
    assert {name.partition("+")[0] for name in CASES} == set(LAW_FORMS.rows)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_a_rollout_of_every_law_is_the_run_of_simulate(name):
    """Some samples at a torque limit, in a loop with unknown load, friction and delay."""
    worst, cut = largest_difference(ARM, name, CASES[name], duration=0.25, compared=(0, 4, 8))
    assert worst < SHARE
    assert cut > 0
