"""The loop "compiled" beside the usual one over the whole of the paper's path, law by law."""

from __future__ import annotations

import numpy as np

import lwr_dyn
from lwr_dyn.codegen.rollouts.law_forms import LAW_FORMS
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.simulation.plant import Encoder

ROUGH = "inverse-dynamics+friction"
SHARE = 5e-5
"""Of the torque limits: as much Coulomb friction as RK4 at 1 kHz follows in its smooth form."""
CLOSE = 1e-12


def compiled_loop() -> tuple[str, bool, str]:
    """14 s of ist-clear in both loops under every law with a kernel form, plain and with noise and a delay."""
    arm = lwr_dyn.load("lwr4plus", reading="physical")
    worst, closed, runs, table = 0.0, True, 0, []
    for law in (*LAW_FORMS.names, ROUGH):
        model = arm_with_friction(arm, SHARE) if law == ROUGH else arm
        friction = {"friction": "smooth", "substeps": 2} if law == ROUGH else {}
        for words, options in (("plain", {}), ("noise, delay", {"encoder": Encoder(noise=1e-5), "delay": 1})):
            q, is_closed = _apart(model, law, friction | options)
            worst, closed, runs = max(worst, q), closed and is_closed, runs + 1
            table.append(f"{law:28} {words:14} {q:.1e} rad")
    verdict = "all audits closed" if closed else "audits NOT closed"
    return (
        f"{runs} pairs of runs differ by {worst:.1e} rad at most, {verdict}",
        worst <= CLOSE and closed,
        "\n".join(table),
    )


def _apart(arm, law: str, options: dict) -> tuple[float, bool]:
    """The largest difference of the positions, and whether the compiled run's audit closes."""
    controller, path = lwr_dyn.controller(law, arm), lwr_dyn.reference("ist-clear", arm)
    usual, compiled = (
        lwr_dyn.simulate(arm, controller, path, loop=loop, progress=lambda share: None, **options)
        for loop in (None, "compiled")
    )
    return float(np.abs(usual.q - compiled.q).max()), bool(compiled.meta["audit"]["closed"])
