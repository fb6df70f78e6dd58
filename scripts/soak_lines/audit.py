"""Faults that `lint` finds in tables, and conventions that are found again."""

from __future__ import annotations


def lint() -> tuple[str, bool]:
    """Lint: false alarms on 1000 random correct tables, and the share it finds of 1000 faults of each kind."""
    from tests.checks.tables.faulty_sheets import FAULTS, detection, false_alarms

    alarms = false_alarms(1000, seed=1)
    detected = {fault: detection(fault, 1000, seed=2) for fault in FAULTS}
    shares = ", ".join(f"{fault} {share:.0%}" for fault, share in detected.items())
    return f"{len(alarms)} false alarms; found: {shares}", not alarms and min(detected.values()) >= 0.6


def recovery() -> tuple[str, bool]:
    """Conventions of 1000 scrambled tables that their evidence decides, recovered."""
    from tests.checks.conventions.recovery import recovery as recovered

    result = recovered(1000)
    return result.statement(), result.rate >= 0.99 and result.kept_or_recovered == 1.0
