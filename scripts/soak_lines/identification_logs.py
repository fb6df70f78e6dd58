"""Faults planted in logs, and how many are recognised."""

from __future__ import annotations

PLANTS, EACH = 20, 12
"""Arms that are 20 % off their table, faults planted in the log of each."""
WANTED, MISNAMED = 0.9, 0.02
"""Shares of the faults."""


def log_faults() -> tuple[str, bool]:
    """Wrong signs, orders and units of columns in 10 s logs of LWRs and WAMs, recognised; whole logs, no alarm."""
    from tests.identification.log_fault_study import recognised

    found = [recognised(*arm, PLANTS, EACH, seed=1) for arm in (("lwr4plus", "physical"), ("wam7", None))]
    held = [
        x.right >= WANTED * x.planted and x.wrong <= MISNAMED * x.planted and x.alarms == 0 for x in found
    ]  # fmt: skip
    return "; ".join(f"{name}: {x.text}" for name, x in zip(("LWR", "WAM"), found, strict=True)), all(held)
