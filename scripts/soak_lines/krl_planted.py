"""Faults planted in a small KRL project of our own: each of 44 kinds at up to 200 seeded sites."""

from __future__ import annotations

from pathlib import Path

from lwr_dyn.krl.project.program import load_project
from tests.krl import planting
from tests.krl.planting.kinds import KINDS, REFUSED
from tests.krl.planting.site import seeded
from tests.krl.planting.trial import clean_modules, verdicts

SEEDS, NEEDED = 100, 0.99


def krl_planted() -> tuple[str, bool]:
    """Faults planted in KRL programs of our own that are told at their line and rightly named."""
    modules = clean_modules([seeded("cell", load_project(Path(planting.__file__).parent / "cell"))])
    kinds = KINDS + REFUSED
    found = [x for seed in range(SEEDS) for x in verdicts(modules, seed, 2, kinds)]
    named = sum(x.named for x in found) / len(found)
    planted = {x.kind for x in found}
    text = f"{len(found)} faults of {len(planted)} kinds, {100 * named:.1f} % told and rightly named"
    return text, named >= NEEDED and len(planted) == len(kinds)
