"""The adaptive law on the letters, written twice, and its Lyapunov function over whole runs."""

from __future__ import annotations

import numpy as np

import lwr_dyn
from lwr_dyn.foundation.tables import aligned


def adaptation() -> tuple[str, bool, str]:
    """Second pass of IST with an unknown 3 kg, adaptive beside inverse dynamics; Lyapunov over 14 s."""
    from tests.control.laws.learning import ELASTIC, FRICTION, along_a_continuous_loop, largest_rise, second_pass
    from tests.control.laws.lyapunov import ARM

    rows, holds = [], True
    for reading in ("computed", "physical"):
        arm = lwr_dyn.load("lwr4plus", reading=reading)
        move = lwr_dyn.reference("ist-clear-twice", arm)
        cases = [("load alone", {}, {}, {}, 100.0), ("friction too", FRICTION, {}, {"adapt_friction": True}, 10.0)]
        if reading == "physical":
            cases.append(("elastic, links, 25 rad/s", ELASTIC, {"omega_n": 25.0}, {}, 10.0))
        for name, plant, both, own, asked in cases:
            fixed, _ = second_pass("inverse-dynamics", move, arm, plant, **both)
            learnt, _ = second_pass("adaptive", move, arm, plant, **both, **own)
            holds &= fixed > asked * learnt
            rows.append((reading, name, f"{fixed:.4g}", f"{learnt:.2g}", f"{fixed / learnt:.0f}", f"{asked:g}"))
    once = lwr_dyn.reference("ist-clear", ARM)
    law = lwr_dyn.controller("adaptive", ARM, adapt_gain=100.0)
    V = along_a_continuous_loop(law, once, 28000, h=5e-4)  # at 1 ms RK4 itself leaves 1.5e-14 at a jump of the jerk
    rise = np.diff(V).max() / V[0]
    rises = [largest_rise(law, once, rate, 14.0) for rate in (1000, 2000, 4000)]
    order = np.log2(np.divide(rises[:-1], rises[1:]))
    holds &= bool(rise <= 1e-14 and (np.abs(order - 2.0) < 0.3).all())
    table = aligned(rows, ("reading", "plant", "inverse dynamics, mm", "adaptive, mm", "times", "asked"))
    held = ", ".join(f"{x:.1e}" for x in rises)
    words = f"V rises by {rise:.1e} V0 continuously (RK4, 0.5 ms); held by {held} at 1, 2, 4 kHz"
    return f"{words}: order {order[0]:.2f}, {order[1]:.2f}", bool(holds), table
