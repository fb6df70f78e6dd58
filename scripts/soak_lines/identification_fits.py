"""Thousands of fits with a known truth: what sigma says, what a long log costs."""

from __future__ import annotations

import numpy as np

import lwr_dyn

FITS = 1000
PLANTS = 20


def fits_cover() -> tuple[str, bool]:
    """1000 fits each of LWR and WAM, encoders of 1e-5 rad at 1 kHz, filtered: 3-sigma intervals and bias."""
    from tests.identification.coverage_study import coverage_study

    said, good = [], True
    for robot in ("lwr4plus", "wam7"):
        found = coverage_study(lwr_dyn.load(robot), range(FITS))
        worst = float(np.abs(found.bias).max())
        said.append(f"{robot} {found.share:.2%} within 3 sigma, largest bias {worst:.2f} sigma")
        good &= 0.995 <= found.share <= 0.999 and worst <= 0.2
    return "; ".join(said), good


def fresh_torques() -> tuple[str, bool]:
    """Torque error on fresh motions, fitted to an optimised 10 s: under 0.12 of the noise; with Stribeck beside it."""
    from lwr_dyn.identification.excitation.design import design_excitation
    from tests.identification.fresh_study import fresh_errors

    said, good = [], True
    for robot in ("lwr4plus", "wam7"):
        arm = lwr_dyn.load(robot)
        found = fresh_errors(arm, design_excitation(arm, 10.0).sampled(1000.0), range(PLANTS))
        said.append(
            f"{robot} {found.plain:.3f} of the noise (median of {PLANTS}, worst {found.worst:.3f}); with Stribeck "
            f"friction {found.outside:.3f} beyond three v_s, {found.column:.3f} at all speeds with its column"
        )
        good &= found.plain < 0.12 and found.outside < 0.12
    return "; ".join(said), good


def million_rows() -> tuple[str, bool]:
    """Base parameters and sigma of 1 000 000 rows of 7 joints on one core, in a process of its own (4 s, 100 MB)."""
    from benchmarks.identification import long_log

    runs = [long_log("lwr4plus", form) for form in ("states", "positions")]
    said = ", ".join(f"{run['processor']:.2f} s and {run['beyond'] / 1e6:.0f} MB beyond the log" for run in runs)
    good = all(run["processor"] < 4.0 and run["beyond"] < 100e6 and run["z"] < 4.5 for run in runs)
    return f"{said} (from states, from positions)", good
