"""The plant with elastic joints: a whole run against Radau IIA 5, the rigid limit, energy."""

from __future__ import annotations

import numpy as np

import lwr_dyn
from lwr_dyn.simulation.simulate import simulate

NEAR = 1e-8
"""[rad] from Radau IIA 5 in two steps a sample."""
LIMIT_S = 2.0
STIFFNESS = (1e4, 1e5, 1e6, 1e7, 1e8)


def elastic_plant() -> tuple[str, bool]:
    """IST at 1 kHz, inverse dynamics on the motors' side: 14 s against Radau, 2 s against rigid joints."""
    arm = lwr_dyn.load("lwr4plus", reading="physical")
    law, ist = lwr_dyn.controller("inverse-dynamics", arm), lwr_dyn.reference("ist", arm)
    run = simulate(arm, law, ist, elasticity="file")
    fine = simulate(arm, law, ist, elasticity="file", method="radau", substeps=2)
    gap = max(np.abs(run.q - fine.q).max(), np.abs(run.signals["theta"] - fine.signals["theta"]).max())
    rigid = simulate(arm, law, ist, duration=LIMIT_S)
    soft = [simulate(arm, law, ist, duration=LIMIT_S, elasticity=K) for K in STIFFNESS]
    away = np.array([np.abs(x.q - rigid.q).max() for x in soft])
    orders = np.log10(away[:-1] / away[1:])
    closed = all(x.audit["closed"] for x in (run, fine, *soft))
    words = (
        f"14 s of IST: {gap:.1e} rad from Radau, energy to {run.audit['residual']:.1e} J; order in 1/K up to 1e8: "
        f"{orders.min():.4f} to {orders.max():.4f}"
    )
    return words, bool(gap <= NEAR and np.abs(orders - 1.0).max() <= 0.02 and closed)
