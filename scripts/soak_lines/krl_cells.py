"""KRL programs with what goes on beside them."""

from __future__ import annotations

import lwr_dyn

PROGRAMS, FIRST = 1000, 1000


def krl_cells() -> tuple[str, bool]:
    """1000 random programs with interrupts, BRAKE, triggers, answers: no axis jumps, events in order, runs alike."""
    from tests.krl.random_cells import faults_of

    arm, wrong = lwr_dyn.load("kr30ha"), []
    for seed in range(FIRST, FIRST + PROGRAMS):
        try:
            wrong += faults_of(arm, seed)
        except Exception as fault:
            wrong.append(f"seed {seed}: {type(fault).__name__} {str(fault)[:200]}")
    return "; ".join(wrong[:5]) or f"{PROGRAMS} programs", not wrong
