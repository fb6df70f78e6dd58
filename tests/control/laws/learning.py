"""What the adaptive law learns of a load that it does not know, and its Lyapunov function along motions."""

import numpy as np

import lwr_dyn
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.model.friction import symmetric
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.trajectory.references.ist import part_of
from tests.control.laws.lyapunov import ARM, LOAD, missing_load

MODEL, PLANT, THETA = lwr_dyn.dynamics_of(ARM), lwr_dyn.dynamics_of(LOAD).ungated, missing_load()
COULOMB = np.linspace(2.0, 0.5, 7)
FRICTION = {"friction": [symmetric(level, 0.5) for level in COULOMB], "encoder": Encoder(0.0, 1e-5), "delay": 1}
"""Dry friction with true stick, noise of the encoders, and a sample of delay."""
ELASTIC = {"elasticity": "file", "encoders": "link"}


def second_pass(name, move, arm=ARM, plant=None, **options):
    """RMS error of the tip [mm] in the second pass with 3 kg that the law does not know, and the run."""
    law = make_controller(name, arm, **options)
    run = lwr_dyn.simulate(arm, law, move, payload=3.0, **(plant or {}))
    return metrics(part_of(run, move.second), arm).tip_rms_mm, run


def only_pass(move, plant=None, **options):
    """RMS error of the tip [mm] of inverse dynamics with that load: a law that learns nothing needs no second pass."""
    run = lwr_dyn.simulate(ARM, make_controller("inverse-dynamics", ARM, **options), move, payload=3.0, **(plant or {}))
    return metrics(run, ARM).tip_rms_mm


def lyapunov(law, q, dq, theta, motion, k):
    """V = s^T B s / 2 + theta_err^T Gamma^-1 theta_err / 2 at sample k of a motion, B and theta of the loaded arm."""
    s = dq - motion.dq[k] - law.omega_n * (motion.q[k] - q)
    return s @ PLANT.mass_matrix(q) @ s / 2 + ((theta - THETA) ** 2 / (2 * law.adapted.gains)).sum()


def along_a_continuous_loop(law, move, steps, h=1e-3):
    """V (steps + 1,), with law and plant in every stage of RK4, from a start 10 mrad beside the reference."""
    motion = move.sample(np.arange(2 * steps + 1) * h / 2)
    x = np.concatenate([motion.q[0] + 0.01, motion.dq[0], np.zeros(10)])

    def rates(x, k):
        q, dq, theta = x[:7], x[7:14], x[14:]
        tau, rate = law.torque_and_rate(theta, q, dq, motion.q[k], motion.dq[k], motion.ddq[k])
        return np.concatenate([dq, PLANT.forward_dynamics(q, dq, tau), rate])

    V = [lyapunov(law, x[:7], x[7:14], x[14:], motion, 0)]
    for k in range(0, 2 * steps, 2):
        k1 = rates(x, k)
        k2 = rates(x + h / 2 * k1, k + 1)
        k3 = rates(x + h / 2 * k2, k + 1)
        k4 = rates(x + h * k3, k + 2)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        V.append(lyapunov(law, x[:7], x[7:14], x[14:], motion, k + 2))
    return np.array(V)


def largest_rise(law, move, rate, duration):
    """The largest rise of V in a sample over V at the start, the law held from sample to sample."""
    run = lwr_dyn.simulate(LOAD, law, move, rate=rate, duration=duration)
    motion = move.sample(run.t)
    rows = zip(run.q, run.dq, run.signals["adapted_payload"], strict=True)
    V = np.array([lyapunov(law, *row, motion, k) for k, row in enumerate(rows)])
    return np.diff(V).max() / V[0]
