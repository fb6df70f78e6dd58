"""Mass matrices of many plants at once against those of each plant's own arm."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel_spec import inertial_parameters
from lwr_dyn.codegen.rollouts.run_parameters import arm_of_run, mass_matrices
from tests.random_arms import random_arm


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
