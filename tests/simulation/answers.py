"""A loop with a known answer: inverse dynamics with the exact model is w^2 / (s^2 + 2 xi w s + w^2)."""

import numpy as np

import lwr_dyn

ARM = lwr_dyn.load("lwr4plus")
START = np.array([0.0, 0.5, 0.0, -1.2, 0.0, 0.6, 0.0])
OMEGA = 50.0


def answered(task, xi, joint, continuous=True, rate=500.0, **options):
    """A run of one joint; continuous, so that nothing but the second-order loop acts."""
    loop = lwr_dyn.controller("inverse-dynamics", ARM, omega_n=OMEGA, xi=xi)
    reference = lwr_dyn.reference(task, ARM, start=START, joint=joint, **options)
    return lwr_dyn.simulate(ARM, loop, reference, continuous=continuous, rate=rate)
