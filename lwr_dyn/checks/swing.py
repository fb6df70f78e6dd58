"""Energy of a torque-free swing: nothing drives or brakes the arm, so kinetic plus potential energy stands still."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from lwr_dyn.arrays import Array
from lwr_dyn.checks.verdict import Verdict
from lwr_dyn.dynamics.protocol import Dynamics, mechanical_energy

SECONDS, RTOL = 2.0, 1e-12
DRIFT = 1e-8
"""[J]; an arm swings through tens of joules, and DOP853 at rtol 1e-12 leaves about 1e-10 of them."""


def energy_drift(dynamics: Dynamics, q: Array, dq: Array, seconds: float = SECONDS) -> float:
    """Largest |E(t) - E(0)| [J] of a free swing from (q, dq), adaptive DOP853 at rtol 1e-12."""
    n, none = dynamics.n, np.zeros(dynamics.n)

    def rates(_: float, x: Array) -> Array:
        return np.concatenate([x[n:], dynamics.forward_dynamics(x[:n], x[n:], none)])

    run = solve_ivp(rates, (0.0, seconds), np.concatenate([q, dq]), method="DOP853", rtol=RTOL, atol=RTOL)
    if not run.success:
        return float("nan")
    energies = mechanical_energy(dynamics, run.y[:n].T, run.y[n:].T)
    return float(np.abs(energies - energies[0]).max())


def swing_verdict(dynamics: Dynamics, q: Array, dq: Array) -> Verdict:
    """The drift against what is allowed."""
    return Verdict(f"energy drift of a free swing, {SECONDS:g} s", energy_drift(dynamics, q, dq), DRIFT, "J")
