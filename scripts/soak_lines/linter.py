"""Faults planted in public arms that the URDF linter finds; broken files that it bears."""

from __future__ import annotations

import os

BROKEN_FILES = 20_000
LEAST_LARGE, LEAST_ALL, LEAST_LINKS_A_WARNING = 0.96, 0.85, 12
"""Share found above the floors without the hopeless kinds; of all 73 kinds; good links for each one with a warning."""


def linter() -> tuple[str, bool, str]:
    """The 73 kinds of faults planted at every link of the arms judged by hand; parts without an arm here are named."""
    from linter_detection import HALVES, measured
    from linter_detection_tables import shares

    words, good, tables = [], True, []
    for half in HALVES:
        result = measured(half, min(2, os.cpu_count() or 1))
        if not result.arms:
            words.append(f"{half}: none of its arms is here")
            continue
        large = shares([v for v in result.verdicts if v.large])[1]
        everything = shares(result.verdicts)[1]
        errors = sum(alarm.level == "error" for alarm in result.alarms)
        warned = len({(alarm.arm, alarm.link) for alarm in result.alarms if alarm.level == "warning"})
        words.append(
            f"{half}: {result.arms} arms, {len(result.verdicts)} faults, {large:.1%} of large ones, {everything:.1%} "
            f"of all, {errors} false errors, warnings on {warned} of {result.links} good links"
        )
        good = good and large >= LEAST_LARGE and everything >= LEAST_ALL and not errors
        good = good and warned * LEAST_LINKS_A_WARNING <= result.links
        tables.append(result.text())
    return "; ".join(words), good, "\n\n".join(tables)


def linter_broken() -> tuple[str, bool]:
    """Exceptions of the URDF linter on broken files, seeded: one to four changes each."""
    from tests.checks.urdf.broken_files import judged

    found, stopped = 0, []
    for seed in range(BROKEN_FILES):
        try:
            found += judged(seed) > 0
        except Exception as fault:  # every kind counts
            stopped.append(f"seed {seed}: {type(fault).__name__}")
    said = f": {', '.join(stopped[:5])}" if stopped else ""
    return f"{BROKEN_FILES} files, {found} with findings, {len(stopped)} exceptions{said}", not stopped
