"""Laws in the loop beside inverse dynamics, and elastic joints beside rigid ones: time of the same run."""

from __future__ import annotations

from inspect import signature

import lwr_dyn
from benchmarks.timing import Call, head, paired, row
from lwr_dyn.control.controllers import CONTROLLERS, make_controller
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.trajectory.references.ist import ist_clear_reference

SECONDS = 5.0
MOST = {"adaptive": 4.0, "cartesian-impedance": 4.0, "joint-impedance": 4.0}
"""Times the run of inverse dynamics that a law may take; others 1.5, and elastic joints 8 times the rigid run."""
OTHERS, ELASTIC = 1.5, 8.0
WRAPPED = ("inverse-dynamics+observer", "inverse-dynamics+friction")


def control_laws(pairs: int) -> None:
    """Each law on the path IST clear of its stops, 5 s at 1 kHz, plant of reading `physical` without friction."""
    arm = lwr_dyn.load("lwr4plus", reading="physical")
    dynamics, reference = lwr_dyn.dynamics_of(arm), ist_clear_reference(arm)
    options = {"duration": SECONDS, "friction": "none"}
    base = make_controller("inverse-dynamics", arm, dynamics)
    theirs: Call = lambda: simulate(arm, base, reference, **options)  # noqa: E731
    head(f"Laws in the loop, {SECONDS:g} s at 1 kHz (time for the whole run, audit included)")
    for name in (*CONTROLLERS.names, *WRAPPED):
        if name == "inverse-dynamics":
            continue
        own = {"friction": arm_friction(arm.n)} if name.endswith("friction") else {}
        try:
            law = make_controller(name, arm, dynamics, **own)
        except lwr_dyn.foundation.errors.LwrDynError as fault:
            print(f"({name}: {fault})")
            continue
        ours: Call = lambda law=law: simulate(arm, law, reference, **options)  # noqa: E731
        most = MOST.get(name, OTHERS)
        row(name, "inverse dynamics", paired(ours, theirs, pairs, 1), f"at most {most:g}")
    if "elasticity" in signature(simulate).parameters:
        soft: Call = lambda: simulate(arm, base, reference, elasticity=1e4, **options)  # noqa: E731
        row("elastic joints, 1e4 N m/rad", "rigid joints", paired(soft, theirs, pairs, 1), f"at most {ELASTIC:g}")


def arm_friction(n: int) -> list[lwr_dyn.model.friction.JointFriction]:
    """Some friction of n joints, which only the law knows of."""
    from lwr_dyn.model.friction import Direction, JointFriction

    side = Direction(coulomb=1.0, viscous=0.5)
    return [JointFriction(side, side)] * n
