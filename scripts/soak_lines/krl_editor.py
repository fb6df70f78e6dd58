"""Edits of KRL files in an editor."""

from __future__ import annotations

import tempfile
from pathlib import Path

SEEDS, STEPS = 60, 40


def krl_edits() -> tuple[str, bool]:
    """Random edits of a small backup: diagnoses are those of a fresh project, each name is among its own uses."""
    from tests.krl.edited_texts import edits_agree

    compared = 0
    for seed in range(SEEDS):
        with tempfile.TemporaryDirectory() as folder:
            try:
                compared += edits_agree(Path(folder), 1000 + seed, STEPS)
            except Exception as fault:
                return f"seed {1000 + seed}: {type(fault).__name__} {str(fault)[:200]}", False
    return f"{SEEDS * STEPS} edits, {compared} diagnoses compared", True
