"""Names across the modules of KRL projects."""

from __future__ import annotations

import random

PROJECTS, SEED = 5000, 29


def krl_projects() -> tuple[str, bool]:
    """5000 random projects: each name that a module sees is that of the file which the written rule says."""
    from tests.krl.random_projects import disagreement

    rng = random.Random(SEED)
    for i in range(PROJECTS):
        found = disagreement(rng)
        if found is not None:
            return f"project {i}: {found[:300]}", False
    return f"{PROJECTS} projects", True
