"""Slips planted in the LWR's table and traced by one log."""

from __future__ import annotations

import numpy as np

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper

OFF = (0.0, 0.01, 0.05, 0.2)
"""Shares by which the arm is off its table."""
TRACED, ONE = 0.99, 0.8


def slips() -> tuple[str, bool, str]:
    """228 wrong cells and 246 exchanges, a 20 s optimised log with 0.1 N m, an arm exactly as its table: what is seen
    is traced in 99 % and to one repair in 80 %; with the arm 1, 5, 20 % off its table beside it."""
    from lwr_dyn.identification.excitation.design import design_excitation
    from tests.identification.plants import Motion
    from tests.identification.slip_study import SlipStudy, exchanged_faults, shares, single_faults

    arm = lwr_dyn.load("lwr4plus", "physical")
    moved = design_excitation(arm, duration=20.0).motion.sample(np.arange(2001) / 100.0)
    motion = Motion(moved.t, moved.q, moved.dq, moved.ddq)
    study = SlipStudy.of(arm, open_paper("lwr4plus", "physical"), motion)
    lines, holds = [], True
    for off in OFF:
        rng = np.random.default_rng(5)
        for name, faults in (("single", single_faults(study.table)), ("exchanged", exchanged_faults(study.table))):
            outcomes = [study.outcome(fault, off, rng) for fault in faults]
            lines.append(f"arm {off:.0%} off, {name}: {shares(outcomes)}")
            seen = [o for o in outcomes if o.seen]
            if off == 0.0:
                holds &= sum(o.listed for o in seen) >= TRACED * len(seen)
                holds &= sum(o.one for o in seen) >= ONE * len(seen)
    return lines[0], holds, "\n".join(lines)
