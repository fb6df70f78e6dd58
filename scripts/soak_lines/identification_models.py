"""Models that an identification writes, what it promises of unseen torques, and of motions that are missing."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import lwr_dyn

PLANTS = range(60)
NOISE, SECONDS, RATE = 0.1, 8.0, 250.0
AGREES = 1e-11
"""Largest torque between a fit and the file it was written to, as a share of the largest torque."""


def fitted_models() -> tuple[str, bool, str]:
    """Fits of 60 plants each of LWR and WAM, written as data files and loaded: torques, bodies, validation."""
    from lwr_dyn.arms.loading import load_with_paper
    from tests.identification.model_study import study

    lines, good = [], True
    for robot, reading in (("lwr4plus", "physical"), ("wam7", None)):
        arm, paper = load_with_paper(robot, reading)
        with tempfile.TemporaryDirectory() as folder:
            cases = [study(arm, paper, seed, SECONDS, RATE, NOISE, Path(folder)) for seed in PLANTS]
        off = max(case.off for case in cases)
        physical = all(case.physical for case in cases)
        seen, unseen, fresh = (
            np.array([getattr(case, name) for case in cases]) for name in ("seen", "unseen", "fresh")
        )
        promise = np.concatenate([case.promises for case in cases])
        good &= off < AGREES and physical and bool(np.median(np.abs(promise - 1.0)) < 0.1)
        lines.append(
            f"  {lwr_dyn.load(robot).name}: file against fit {off:.1e}, {'every' if physical else 'NOT every'} link a "
            f"body; RMS over the noise, medians: seen {np.median(seen):.3f}, unseen {np.median(unseen):.3f}, other "
            f"motions {np.median(fresh):.3f}; sigma of {promise.size} parameters after the motion that was named, over "
            f"the promised one: median {np.median(promise):.2f}, 5 to 95 % {np.percentile(promise, 5):.2f} to "
            f"{np.percentile(promise, 95):.2f}"
        )
    return f"{2 * len(PLANTS)} fits", good, "\n".join(lines)
