"""Special logs: motors behind couplings, both encoders of elastic joints, a load, and no filter at all."""

from __future__ import annotations

import numpy as np

MOTIONS = range(20)
"""Seeds; ten draws of noise each."""
INSIDE = 0.99
"""Share of misses within 3 sigma that is wanted; right errors have 99.73 %."""


def special_logs() -> tuple[str, bool, str]:
    """Recovery of 200 fits each: IV without a filter, motors through couplings, a load, elastic joints."""
    from tests.identification import special_study as study

    elastic, off = study.elastic_misses(MOTIONS)
    found = {
        "instrumental variables, unfiltered, LWR": study.instrumental_misses(MOTIONS),
        "least squares, unfiltered, beside it": study.instrumental_misses(range(2), plain=True),
        "logs of coupled motors, WAM": study.motor_misses(MOTIONS),
        "a load of 2.5 kg, LWR": study.load_misses(MOTIONS),
        "elastic joints with both encoders, LWR": elastic,
    }
    lines = [f"  {name}: {misses} ({len(misses.z)} fits)" for name, misses in found.items()]
    stiffness = ", ".join(f"{x:.2%}" for x in np.median(np.abs(off), axis=0))
    lines.append(f"  stiffness missed by (medians, joint by joint): {stiffness}")
    good = all(misses.inside >= INSIDE and misses.bias < 0.2 for name, misses in found.items() if "least" not in name)
    shares = ", ".join(f"{misses.inside:.2%}" for misses in found.values())
    return f"within 3 sigma: {shares}", good, "\n".join(lines)
