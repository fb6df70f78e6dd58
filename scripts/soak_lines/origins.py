"""Copies of published sets and arms that copy nothing, traced by their digits."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

COPIES, OWN, TRACED = 200, 20, 0.95


def origins() -> tuple[str, bool]:
    """200 planted copies (digits, frames, units, links changed): 95 % traced to their robot or a set with the same
    numbers; none of 20 arms of random bodies is called a copy."""
    from lwr_dyn.checks.origin.link_numbers import KnownSet, known_sets, numbers_of_file
    from lwr_dyn.checks.origin.tracing import Trace, trace_origin
    from tests.checks.origin.planted import foreign_arm, planted_copy

    sets = known_sets()
    right = called = 0
    with TemporaryDirectory() as folder:
        path = Path(folder) / "planted.urdf"

        def traced(text: str) -> Trace | None:
            path.write_text(text, encoding="utf-8")
            found = trace_origin(numbers_of_file(path), sets)
            return found if found is not None and found.is_copy else None

        def same(a: KnownSet, b: KnownSet) -> bool:
            return a.robot == b.robot or (
                np.array_equal(a.links.mass, b.links.mass) and np.array_equal(a.links.tensor, b.links.tensor)
            )

        for seed in range(COPIES):
            rng = np.random.default_rng(seed)
            known = sets[rng.integers(len(sets))]
            found = traced(planted_copy(known, rng)[0])
            right += found is not None and same(found.known, known)
        for seed in range(OWN):
            called += traced(foreign_arm(np.random.default_rng(10**6 + seed))) is not None
    words = f"{right} of {COPIES} copies traced; {called} of {OWN} arms that copy nothing called a copy"
    return words, right >= TRACED * COPIES and called == 0
