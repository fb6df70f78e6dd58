"""Rollouts of every law with a kernel form and every variant of it, on all seven joints, beside `simulate`."""

from __future__ import annotations

from lwr_dyn.foundation.tables import aligned

VARIANTS = (
    ("pd-gravity", {"omega_n": 20.0}),
    ("pd-gravity", {"omega_n": 20.0, "velocity_error": True}),
    ("pid", {"omega_n": 20.0}),
    ("pid", {"omega_n": 20.0, "gravity": False, "velocity_error": True}),
    ("pid+friction", {"omega_n": 20.0}),
    ("inverse-dynamics", {}),
    ("inverse-dynamics", {"feedforward": False}),
    ("inverse-dynamics", {"gravity": False}),
    ("inverse-dynamics+friction-measured", {"friction_width": 0.1}),
    ("motor-pd", {}),
    ("motor-pd", {"feedforward": False}),
    ("adaptive", {"omega_n": 25.0}),  # at 50 1/s with 3 samples of delay the loop itself is unstable: it chatters
    ("adaptive", {"omega_n": 25.0, "adapt_friction": True}),
    ("adaptive", {"omega_n": 25.0, "adapt": "base"}),
    ("adaptive+friction", {"omega_n": 25.0}),
    ("robust", {"omega_n": 25.0, "largest_load": 1.0}),
    ("robust", {"omega_n": 25.0, "largest_load": 1.0, "layer": 5.0}),
)
RUNS = 9
"""In the rollout, each beside `simulate`."""


def rollout_laws() -> tuple[str, bool, str]:
    """Rollouts of every law and variant, LWR 4+, 9 runs of 1 s each: gains, loads, friction, delay, limits differ."""
    from tests.agreement.test_rollouts_of_every_law import SHARE, largest_difference
    from tests.codegen.rollouts.beside import first_joints

    arm, rows, holds = first_joints(7), [], True
    for name, options in VARIANTS:
        off, cut = largest_difference(arm, name, options, 1.0, range(RUNS), heaviest=1.0, weakest=0.7)
        holds &= bool(off < SHARE)
        words = ", ".join(f"{key} {value}" for key, value in options.items())
        rows.append((name, words, f"{off:.1e}", str(cut)))
    worst = max(rows, key=lambda row: float(row[2]))
    table = aligned(rows, ("law", "options", "off, rad", "samples at a limit"))
    return f"{len(rows)} kernels, at most {worst[2]} rad off ({worst[0]})", holds, table
