"""How often the rules cry at nothing, and how often they find a slip: measured on tables made up at random."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from lwr_dyn.audit.lint.examine import lint
from lwr_dyn.audit.lint.made_up import correct_sheet
from lwr_dyn.audit.lint.plants import SLIPS, Plant


def planted(rng: Generator, slip: str) -> Plant | None:
    """A correct sheet with a slip of a kind of `SLIPS`; nothing when it would change no digit."""
    sheet = correct_sheet(rng)
    plant = SLIPS[slip](rng, sheet)
    return None if plant is None or plant.sheet == sheet else plant


def false_alarms(count: int, seed: int = 0) -> tuple[str, ...]:
    """The findings that count in so many correct sheets: there should be none."""
    rng = np.random.default_rng(seed)
    return tuple(f.line() for _ in range(count) for f in lint(correct_sheet(rng)) if f.counts)


def detection(slip: str, count: int, seed: int = 0) -> float:
    """Share of so many planted slips of a kind that is found."""
    rng = np.random.default_rng(seed)
    plants = [p for _ in range(count) if (p := planted(rng, slip)) is not None]
    return sum(p.found for p in plants) / len(plants)
