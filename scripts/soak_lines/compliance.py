"""Stiffness of the settled tip in all poses, and the passivity of law and wall over a minute."""

from __future__ import annotations

import numpy as np

from lwr_dyn.foundation.tables import aligned

ASKED = 1e-4
"""Relative: what the stiffness may be off."""
SECONDS = 60.0


def impedance() -> tuple[str, bool, str]:
    """Stiffness of the tip under Cartesian impedance, settled: 20 poses; and k/K of a stretched elbow."""
    from tests.control.laws import settled

    cases = [("regular", q) for q in settled.regular_poses()] + [("singular", q) for q in settled.SINGULAR]
    errors = [settled.stiffness_error(q, seed, settled.SETTLED_S[kind]) for seed, (kind, q) in enumerate(cases)]
    rows = []
    for q4, q in settled.STRETCHED.items():
        found = settled.elbow_stiffness(q)
        rows.append((f"{q4:g}", *(f"{found[name]:.4f}" for name in ("outward", "inward", "across"))))
    table = aligned(rows, ("q4, rad", "k/K outward", "inward", "across"))
    singular = len(settled.SINGULAR)
    words = f"largest error {max(errors[:-singular]):.1e} regular, {max(errors[-singular:]):.1e} near singular"
    return f"{len(errors)} poses: {words}", max(errors) < ASKED, table


def passivity() -> tuple[str, bool]:
    """Law and wall, continuous, pushed for 60 s by a restless hand: energy that either gives out in a sample."""
    from tests.control.laws.passivity import cartesian, jointly

    words, holds = [], True
    for law in (cartesian, jointly):
        run = law(seconds=SECONDS)
        law_given, wall_given = -np.diff(run.law_loss).min(), -np.diff(run.wall_loss).min()
        holds &= bool(law_given < 0.0 and wall_given < 1e-8 and np.diff(run.excess).max() < 0.0)
        touching = f"in contact {np.mean(run.depth > 0.0):.0%} of the time"
        words.append(
            f"{law.__name__}: law takes at least {-law_given:.1e} J, wall gives {wall_given:.1e} J; {touching}"
        )
    return "; ".join(words), holds
