"""A load in the hand of the LWR 4+, and logs with it."""

import numpy as np

import lwr_dyn
from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.model.chain import Body
from lwr_dyn.model.spatial import from_rpy
from tests.identification.plants import Plant, of_load, random_motion, simulated_log

ARM = lwr_dyn.load("lwr4plus", "physical")
MASS, COM = 2.5, np.array([0.02, -0.01, 0.08])
TENSOR = from_rpy([0.3, 0.2, -0.5]) @ np.diag([0.012, 0.010, 0.006]) @ from_rpy([0.3, 0.2, -0.5]).T
TRUTH = body_parameters(Body(MASS, COM, TENSOR))


def loaded(plant, load=None):
    """The plant with the load, or another one (mass, centre)."""
    parameters = plant.parameters.copy()
    last = slice(plant.columns.bodies - 10, plant.columns.bodies)
    parameters[last] += of_load(ARM.chain, *(load or (MASS, COM, TENSOR)))
    return Plant(plant.columns, parameters)


def logs_of(plant, seed, count=1, noise=0.1, duration=10.0, encoder=1e-5):
    rng = np.random.default_rng(seed)
    return [
        simulated_log(plant, random_motion(ARM, duration, rng, rate=1000.0), noise, rng, encoder) for _ in range(count)
    ]
