"""What a momentum observer finds, and how often it calls a collision that is none."""

from __future__ import annotations

import numpy as np

SHARES = {"flange": (0.9, 0.95, 0.95), "link_3": (0.5, 0.9, 0.9)}
"""Least share found of pushes of 5 to 15, 15 to 30 and 30 to 60 N: below what was found when this was written."""


def pushes() -> tuple[str, bool, str]:
    """200 pushes on flange and elbow, wrong load and noise: found while they last."""
    from tests.control.laws.collisions import FORCES, PLACES, table
    from tests.control.laws.collisions import pushes as tried

    found = list(tried(200))
    rows, early = table(found), sum(f.early for f in found)
    lines = ["| at | force | found | median delay [ms] | 95 % [ms] |", "|---|---|---|---|---|"]
    lines += [f"| {at} | {band} | {hits} of {n} | {half:.0f} | {most:.0f} |" for at, band, n, hits, half, most in rows]
    least = [SHARES[at][i] for at in PLACES for i in range(len(FORCES))]
    holds = all(row[3] >= share * row[2] for row, share in zip(rows, least, strict=True)) and not early
    shares = f"{sum(f.delay is not None for f in found)} of {len(found)} found"
    return f"{shares}, {early} alarms before a push", holds, "\n".join(lines)


def false_alarms() -> tuple[str, bool]:
    """3 simulated hours without a push, each 14 s with a load error of its own: no alarm."""
    from tests.control.laws.collisions import alone, quiet

    batch, single = quiet(1, 1.0, noise=0.0).worst, alone(1.0)
    agree = float(np.abs(batch - single).max())
    result = quiet(772)
    rate = 3.0 / result.hours
    words = f"{result.alarms} alarms in {result.hours:.2f} h, at most {result.worst.max():.2f} of a level"
    proven = (
        f"{words}; none in that time proves less than {rate:.2g} an hour at 95 %; batch and loop differ by {agree:.0e}"
    )
    return proven, result.alarms == 0 and agree < 1e-6
