"""Loops on elastic joints, over the whole joint box."""

from __future__ import annotations

import lwr_dyn
from lwr_dyn.design.elastic_loop import POSES, elastic_table
from lwr_dyn.simulation.metrics import metrics

STABLE = "0 (below 0.2 %)"
ALL = "all (above 99.8 %)"


def elastic() -> tuple[str, bool, str]:
    """Laws on elastic joints, 2000 poses of the joint box: unstable, continuous and at 1 kHz."""
    arm = lwr_dyn.load("lwr4plus", reading="physical")
    by_model, motor = lwr_dyn.controller("inverse-dynamics", arm), lwr_dyn.controller("motor-pd", arm)
    laws = [(lwr_dyn.controller("pd-gravity", arm), "link"), (by_model, "link"), (motor, "motor"), (by_model, "motor")]
    table = elastic_table(arm, laws, [5e3, 1e4, 3e4], lwr_dyn.reference("ist", arm), 5.0)
    shares = {(row[0], row[1], row[2]): row[4:] for row in table.cells}
    soft = all(shares[K, law, "link"] == (ALL, ALL) for K in ("5000", "10000") for law in (by_model.name, "pd-gravity"))
    collocated = all(row[4] == STABLE for row in table.cells if row[2] == "motor")
    pd = all(shares[K, motor.name, "motor"] == (STABLE, STABLE) for K in ("5000", "10000", "30000"))
    words = f"{POSES} poses: link side unstable at 5e3 and 1e4 everywhere, motor side stable in continuous time"
    return words, soft and collocated and pd, table.text()


def elastic_ist() -> tuple[str, bool]:
    """Tip error on all of IST with joints of 1e4 N m/rad, by what a law knows of the springs."""
    arm = lwr_dyn.load("lwr4plus", reading="physical")
    ist = lwr_dyn.reference("ist", arm)
    laws = {
        "taken for rigid": ("inverse-dynamics", {}, 2.1),
        "gravity taken off": ("inverse-dynamics+motor-side", {}, 0.05),
        "PD, gravity": ("motor-pd", {"feedforward": False}, 0.12),
        "PD, all fed forward": ("motor-pd", {}, 0.0005),
    }
    words, holds = [], True
    for label, (name, options, most) in laws.items():
        law = lwr_dyn.controller(name, arm, **options)
        run = lwr_dyn.simulate(arm, law, ist, elasticity="file", position_limits=False)
        found = metrics(run, arm).tip_rms_mm
        words, holds = [*words, f"{label} {found:.3g} mm"], holds and found <= most
    return ", ".join(words), holds
