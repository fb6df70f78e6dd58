"""Loops for the tests of margins: sliders known by hand, the LWR 4+ with its laws."""

from functools import cache
from types import SimpleNamespace

import numpy as np

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.gains import LinearFeedback
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.design.sampled_loop import RestingLoop, RestingPlant
from lwr_dyn.model.transmission import JointElasticity

BENT = np.array([0.3, 1.0, -0.5, -1.4, 0.8, 0.9, 0.0])


@cache
def arm(reading="physical"):
    return lwr_dyn.load("lwr4plus", reading)


@cache
def dynamics(reading="physical"):
    return lwr_dyn.dynamics_of(arm(reading))


@cache
def largest(reading):
    return tuple(w.value for w in worst_case_inertias(arm(reading)))


@cache
def law(name, reading="physical", omega_n=50.0):
    inertia = {"inertia": largest(reading)} if name != "inverse-dynamics" else {}
    return make_controller(name, arm(reading), dynamics(reading), omega_n=omega_n, **inertia)


def sliders(*masses, Kp=0.0, Kd=0.0, integral=None):
    """Free masses, each with its own PD: known by hand."""
    n = len(masses)
    A, B = np.zeros((1, 2 * n, 2 * n)), np.zeros((1, 2 * n, n))
    A[0, :n, n:], B[0, n:] = np.eye(n), np.diag(1.0 / np.array(masses))
    plant = RestingPlant(A, B, np.eye(n, 2 * n), np.eye(n, 2 * n, n))
    position, velocity = (np.diag(np.atleast_1d(x) * np.ones(n))[None] for x in (Kp, Kd))
    feedback = LinearFeedback(position, velocity, None if integral is None else integral * np.ones(n))
    return RestingLoop.of_plant(plant, feedback, np.zeros((1, n)))


def linear(position, velocity):
    """A law of which the matrices alone are known."""
    return SimpleNamespace(linear_feedback=lambda q: LinearFeedback(position, velocity))


def springs(K, damping_time=1e-3):
    """K, 0.6 of it on the wrist, D = damping_time K: all three pinned here, as signs hang on them."""
    stiffness = K * np.array([1, 1, 1, 1, 0.6, 0.6, 0.6])
    return JointElasticity(stiffness, damping_time * stiffness)
