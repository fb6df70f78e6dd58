"""Rollouts against `simulate`: the same metrics and states, run by run."""

import json

import numpy as np

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.codegen.rollouts.result import figures_of
from lwr_dyn.codegen.rollouts.rollouts import rollouts

ARM = lwr_dyn.load("lwr4plus")
OWN = inertial_parameters(ARM.chain).ravel()
IST = lwr_dyn.reference("ist-clear", ARM)
SHORT = 2.0


def perturbed(runs, seed=0):
    """Inertial parameters (runs, 70): each link's mass and tensor by up to 10 %, one factor a link."""
    factors = np.random.default_rng(seed).uniform(0.9, 1.1, (runs, 7, 1))
    return (OWN.reshape(7, 10) * factors).reshape(runs, 70)


def test_a_rollout_is_the_run_of_simulate():
    law = lwr_dyn.controller("inverse-dynamics", ARM, omega_n=50.0)
    gains = law.Kp * np.array([[1.0], [0.8], [1.2]])
    options = {"tolerance": 1e-4, "quantiles": (0.5, 0.95)}
    done = rollouts(
        ARM, law, IST, parameters={"inertia": perturbed(3), "Kp": gains}, duration=SHORT, record=1, **options
    )
    assert done.flags == ("", "", "")
    assert json.loads(json.dumps(done.setup))["references"] == ["TaskReference"]
    assert "friction_width" not in done.setup
    assert repr(done) == f"Rollouts(3 runs, flags: none, {len(done.metrics)} metrics, record of {done.t.size} samples)"
    for i in (0, 2):
        run = done.run(i)
        expected = figures_of(run, ARM, **options)
        assert done.metrics.keys() == expected.keys()
        assert np.abs(run.q - done.q[i]).max() < 1e-12
        assert np.abs(run.dq - done.dq[i]).max() < 1e-12
        assert np.abs(run.tau_applied - done.tau[i]).max() < 1e-10  # of 100 N m
        for metric in ("tip_rms", "tip_max", "tip_final", "position_rms", "position_max", "limit_margin", "tip_q95"):
            assert np.abs(done.metrics[metric][i] - expected[metric]).max() < 1e-12
        assert done.metrics["first_violation"][i] == expected["first_violation"]
        assert (done.metrics["saturated_s"][i] == expected["saturated_s"]).all()
