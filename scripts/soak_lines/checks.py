"""Every identity and agreement of every robot, and every run's audit, over many states."""

from __future__ import annotations

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper, studied
from lwr_dyn.checks.arm.run_checks import check_arm
from lwr_dyn.trajectory.references.ist import ist_reference
from lwr_dyn.trajectory.timings import MOTION_PROFILES

EXACT = 1e-12
STATED_ELSEWHERE = ("the maker's", "as printed", "data sheet")
"""Ends of the names of checks against a second statement of the arm, which the reading `printed` may not meet."""


def checks() -> tuple[str, bool]:
    """Every robot and reading over 100 000 states; data-sheet checks count for default readings only."""
    failed, elsewhere, worst = [], 0, 0.0
    for robot in studied():
        for reading in lwr_dyn.readings(robot):
            report = check_arm(lwr_dyn.load(robot, reading), open_paper(robot, reading), states=100_000, seed=1)
            fails = [v.name for v in report.verdicts if not v.holds]
            counted = [x for x in fails if reading == lwr_dyn.readings(robot)[0] or not x.endswith(STATED_ELSEWHERE)]
            failed += [f"{robot} {reading}: {name}" for name in counted]
            elsewhere += len(fails) - len(counted)
            worst = max([worst, *(v.value for v in report.verdicts if "against our own recursion" in v.name)])
    words = f"roads differ by {worst:.1e} relative at most; failed: {', '.join(failed) or 'none'}"
    return f"{words}; poses and envelope that other readings do not meet: {elsewhere}", not failed


def runs() -> tuple[str, bool]:
    """The audit of energy and inverse dynamics of every controller, timing and reading on IST."""
    from lwr_dyn.control.controllers import CONTROLLERS, make_controller

    energy, torque, closed, count = 0.0, 0.0, 0, 0
    for reading in lwr_dyn.readings("lwr4plus"):
        arm = lwr_dyn.load("lwr4plus", reading)
        for timing in MOTION_PROFILES.rows:
            reference = ist_reference(arm, timing)
            for name in CONTROLLERS.rows:
                run = lwr_dyn.simulate(arm, make_controller(name, arm), reference)
                energy = max(energy, run.audit["residual"])
                torque = max(torque, run.audit["inverse_dynamics"]["residual"])
                closed, count = closed + run.audit["closed"], count + 1
    return f"{closed} of {count} runs of 14 s closed, to {energy:.1e} J and {torque:.1e} N m", closed == count


def kernels() -> tuple[str, bool]:
    """Every generated function of every robot against Pinocchio over 100 000 states."""
    from benchmarks.kernel_peers import agreement

    arms = [lwr_dyn.load(robot) for robot in studied()]
    worst = {arm.name: agreement(arm, 100_000) for arm in arms if arm.chain.bodies is not None}
    words = "; ".join(
        f"{name} {max(differences.values()):.1e} ({max(differences, key=differences.get)})"
        for name, differences in worst.items()
    )
    return words, max(max(differences.values()) for differences in worst.values()) <= EXACT


def parity() -> tuple[str, bool]:
    """Every committed model in Pinocchio, MuJoCo, Drake and PyBullet against ours (pip install '.[parity]')."""
    from tests.checks.engines.committed import summary

    return summary(states=1000)
