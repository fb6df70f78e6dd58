"""KRL files in an editor: random edits, hidden names that are asked for, and renames."""

from __future__ import annotations

import random
import tempfile
from pathlib import Path

from lwr_dyn.krl.editor.edited_project import EditedProject
from tests.krl import planting
from tests.krl.recall_trial import recall_trial
from tests.krl.rename_trial import random_backup, rename_trial
from tests.krl.small_backup import write_backup

SEEDS, STEPS = 60, 40
NAMES, NEEDED, LONGEST = 3000, 0.99, 0.05
RENAMES, BACKUPS = 1000, 60
CELL = Path(planting.__file__).parent / "cell"


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


def completion() -> tuple[str, bool]:
    """Names of two KRL backups of our own drawn by a seed, hidden and asked for: those offered, and how soon."""
    with tempfile.TemporaryDirectory() as folder:
        projects = [EditedProject(CELL), EditedProject(write_backup(Path(folder)))]
        found = [recall_trial(x, random.Random(11), NAMES // 2) for x in projects]
    offered, asked = (sum(getattr(x, name).total() for x in found) for name in ("offered", "asked"))
    seconds = sorted(s for x in found for s in x.seconds)[int(0.99 * asked)]
    text = f"{offered} of {asked} offered, 99 of 100 within {1e3 * seconds:.1f} ms of the processor"
    return text, offered >= NEEDED * asked and seconds <= LONGEST


def rename() -> tuple[str, bool]:
    """Names of KRL backups of our own, most drawn by a seed, renamed: after which the checks say something else."""
    with tempfile.TemporaryDirectory() as folder:
        empty = Path(folder) / "none"
        projects = [random_backup(random.Random(seed), empty) for seed in range(BACKUPS)]
        projects += [EditedProject(CELL), EditedProject(write_backup(Path(folder) / "small"))]
        wanted, found = RENAMES, []
        for seed, project in enumerate(projects):
            found.append(rename_trial(project, random.Random(seed), min(wanted, RENAMES // 4)))
            wanted -= found[-1].renamed
    changed = [x for trial in found for x in trial.changed]
    kept = sum(trial.kept.total() for trial in found)
    text = f"{RENAMES - wanted} renamed, {kept} kept with a sentence, {len(changed)} changed {changed[:1]}"
    return text, wanted == 0 and not changed
