"""Fuzzed inputs of every reader, made from good ones by `tests/hostile/`: exceptions, CPU time and memory.

LWR_DYN_FUZZ is how many a reader (55 600, together a million), LWR_DYN_FUZZ_SEED another draw of them,
LWR_DYN_FUZZ_READERS which readers, separated by commas.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.hostile.readers import READERS

COUNT, BATCH = int(os.environ.get("LWR_DYN_FUZZ", "55600")), 5000
SEED = int(os.environ.get("LWR_DYN_FUZZ_SEED", "24"))
SHARE = 0.25
"""Of each reader's inputs that it must read: else only its first checks are tried."""
LARGEST = 1_000_000_000
"""[bytes] Most memory of an input."""


@dataclass(slots=True)
class Tally:
    """What came of a reader's inputs."""

    inputs: int = 0
    read: int = 0
    slowest: float = 0.0
    slow: int = 0
    peak: int = 0
    foreign: Counter[str] = field(default_factory=Counter)

    def add(self, result: dict[str, Any]) -> None:
        """Add a batch."""
        self.inputs += result["inputs"]
        self.read += result["read"]
        self.slowest, self.peak = max(self.slowest, result["slowest"]), max(self.peak, result["peak"])
        self.slow += len(result["slow"])
        self.foreign.update(f"input {number}: {what}" for number, what in result["foreign"])

    @property
    def holds(self) -> bool:
        """No exception but ours, nothing slow or large, enough of it read."""
        return not self.foreign and not self.slow and self.peak < LARGEST and self.read >= SHARE * self.inputs

    def row(self, name: str) -> str:
        """A row of the table."""
        share = self.read / max(self.inputs, 1)
        cells = (
            name,
            self.inputs,
            f"{share:.0%}",
            self.foreign.total(),
            f"{self.slowest:.2f}",
            f"{self.peak / 1e6:.0f}",
        )
        return f"| {' | '.join(map(str, cells))} |"


def tallied(name: str, count: int, seed: int = SEED) -> Tally:
    """All inputs of a reader in batches; a batch that is killed goes on behind the input that killed it."""
    tally, begin = Tally(), 0
    while begin < count:
        end = min(begin + BATCH, count)
        with tempfile.TemporaryDirectory() as folder:
            script = Path(__file__).with_name("fuzz_worker.py")
            command = [sys.executable, str(script), name, str(seed), str(begin), str(end), folder]
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
            result = Path(folder, "result")
            if result.exists():
                tally.add(json.loads(result.read_text()))
            else:
                at = Path(folder, "at")
                end = int(at.read_text()) + 1 if at.exists() else end
                tally.inputs += end - begin
                tally.foreign[f"input {end - 1}: ended with {done.returncode}: {done.stderr[-200:]!r}"] += 1
        begin = end
    return tally


def fuzz() -> tuple[str, bool, str]:
    """Fuzzed inputs of every reader: no exception but ours, nothing over 1 s of CPU time or 1 GB, a quarter read."""
    chosen = os.environ.get("LWR_DYN_FUZZ_READERS", ",".join(READERS)).split(",")
    tallies = {}
    for name in chosen:
        tallies[name] = tallied(name, COUNT)
        print(tallies[name].row(name), *tallies[name].foreign, sep="\n  ", file=sys.stderr, flush=True)
    head = ("reader", "inputs", "read", "foreign exceptions", "slowest, s of CPU", "peak, MB")
    rows = [f"| {' | '.join(head)} |", "|---" * len(head) + "|", *(tally.row(name) for name, tally in tallies.items())]
    foreign = sum(tally.foreign.total() for tally in tallies.values())
    words = f"{sum(t.inputs for t in tallies.values())} inputs of {len(tallies)} readers, {foreign} foreign exceptions"
    return words, all(tally.holds for tally in tallies.values()), "\n".join(rows)
