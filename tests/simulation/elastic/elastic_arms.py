"""The LWR 4+ with elastic joints, and short runs of it."""

from functools import cache

import numpy as np

import lwr_dyn
from lwr_dyn.model.friction import symmetric
from lwr_dyn.simulation.simulate import simulate
from tests.simulation.sample_runs import joint_waves

FRICTION = [symmetric(coulomb, 0.5) for coulomb in (2.0, 2.0, 1.5, 1.5, 1.0, 0.5, 0.5)]


@cache
def physical():
    return lwr_dyn.load("lwr4plus", reading="physical")


@cache
def law(name="inverse-dynamics"):
    return lwr_dyn.controller(name, physical())


def short_run(controller=None, **options):
    """A run of 0.1 s on elastic joints of 1e4 N m/rad, unless options say otherwise."""
    settings = {"elasticity": "file", "duration": 0.1} | options
    return simulate(physical(), controller or law(), settings.pop("reference", joint_waves()), **settings)


def states(seed=0, size=5):
    """Random states (size, 2, 14) near the middle of the box, springs turned by 1e-3 rad."""
    random = np.random.default_rng(seed)
    q, dq, relative = random.normal(size=(3, size, 7))
    x = np.hstack([0.5 * q, 0.5 * q + 1e-3 * relative])
    return np.stack([x, np.hstack([dq, dq + 0.1 * relative])], axis=1)
