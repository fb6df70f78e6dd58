"""Planted faults that are said to change nothing: each is one that can be planted in the code as it is."""

import importlib
import tomllib
from collections import Counter
from pathlib import Path

REASONS = Path("scripts/soak_lines/mutants.toml")


def test_a_reason_belongs_to_a_fault_that_can_still_be_planted(monkeypatch):
    monkeypatch.syspath_prepend("scripts")
    of = {".py": importlib.import_module("soak_lines.mutations").mutants_of,
          ".c": importlib.import_module("soak_lines.mutations_of_c").mutants_of_c}  # fmt: skip
    reasons = tomllib.loads(REASONS.read_text(encoding="utf-8"))["changes_nothing"]
    found: Counter[str] = Counter()
    for module in {name.partition(" ")[0] for name in reasons}:
        path = Path("lwr_dyn", module)
        if path.exists():
            found.update(mutant.key for mutant in of[path.suffix](path, module))
    assert [name for name in reasons if not found[name]] == []
    assert all(len(reason) > 10 for reason in reasons.values())
