"""The kept runs of docs/robustness.json, of every controller."""

from __future__ import annotations

import json

import numpy as np
import robustness as page
import robustness_runs as runs

from lwr_dyn.studies.sweep.read_study import read_study
from lwr_dyn.studies.sweep.running.workshop import SweepWorkshop

CLOSE = 1e-5
"""Relative: the file has six digits."""


def robustness() -> tuple[str, bool]:
    """Runs of the robustness study whose errors are those of docs/robustness.json."""
    kept = json.loads(page.NUMBERS.read_text("utf-8"))["controllers"]
    shop, good, total = SweepWorkshop(read_study(page.STUDY)), 0, 0
    for name, one in kept.items():
        found = runs.repeated(shop, name, [each["run"] for each in one["again"]])
        for key, column in found.items():
            same = np.isclose(column, [each[key] for each in one["again"]], rtol=CLOSE, atol=0.0)
            good, total = good + int(same.sum()), total + same.size
    return f"{good} of {total} errors of the tip, {len(kept)} controllers", good == total
