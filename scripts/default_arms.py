"""`lwr-dyn simulate` without an option on the 40 public arms of default_arms.toml: what ran inside its limits, and why
an arm did not.

An arm counts as run where the command ends with exit code 0 and passes no known limit. A tree gets the tip of the list.
Arms whose source is not on this machine are left out and counted; `LWR_DYN_URDF_FILES` names the folder of the second.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tomllib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pinocchio as pin

sys.path.insert(0, str(Path(__file__).resolve().parent))
from foreign_arms import Done, Worker, of_each

LIST = Path(__file__).with_suffix(".toml")
LIMIT = 300.0
"""[s] Longest CPU time for one arm."""
CLONE = "LWR_DYN_URDF_FILES"
RAN = "ran"
BAD_KINDS = {"diverged", "outside its limits", "crashed", "over the limit"}


@dataclass(frozen=True, slots=True)
class ListedArm:
    """A file of the list, where it should lie, and its tip where it needs one."""

    path: Path
    tip: str | None

    @property
    def words(self) -> tuple[str, ...]:
        """How a command names it."""
        return (str(self.path), *(() if self.tip is None else ("--tip", self.tip)))


@dataclass(frozen=True, slots=True)
class ArmOutcome:
    """What became of one arm: kind, its law and steps or the cause of a refusal, the largest error of the tip [mm]."""

    arm: ListedArm
    kind: str
    gist: str
    tip_mm: float | None = None


def listed_arms() -> list[ListedArm]:
    """All arms of the list; those of a source that is not on this machine have paths that do not exist."""
    roots = [Path(pin.__file__).parents[4] / "share/example-robot-data/robots", Path(os.environ.get(CLONE, "absent"))]
    sources = tomllib.loads(LIST.read_text(encoding="utf-8"))["source"]
    return [
        ListedArm(root / row["file"], row.get("tip"))
        for source, root in zip(sources, roots, strict=True)
        for row in source["arms"]
    ]


def outcome(arm: ListedArm, worker: Worker, limit: float = LIMIT) -> ArmOutcome:
    """The outcome of `simulate` without an option."""
    done = worker.run(("simulate", *arm.words, "--json"), limit)
    return ArmOutcome(arm, *judged(done))


def judged(done: Done) -> tuple[str, str, float | None]:
    """Kind, gist and error of the tip [mm] of a finished command."""
    last = (done.err.strip().splitlines() or [f"exit code {done.code}"])[-1]
    if done.code == 2 and last.startswith("lwr-dyn: "):
        return "refused", last.removeprefix("lwr-dyn: "), None
    if "diverges" in last:
        return "diverged", last, None
    if done.code < 0:
        return "over the limit", f"{done.seconds:.0f} s", None
    if done.code != 0 or not done.out:
        return "crashed", last, None
    record = json.loads(done.out)
    meta, found = record["meta"], record["metrics"]
    gist = f"{meta['controller']['name']}, {meta['options']['substeps']} steps a sample, {meta['note']['task']}"
    kind = "outside its limits" if found["within_limits"] is False else RAN
    return kind, gist, found["tip_max_mm"]


def survey(arms: Sequence[ListedArm], processes: int) -> list[ArmOutcome]:
    """The outcome of every arm; each is printed on stderr when it is there."""

    def one(arm: Path, worker: Worker) -> ArmOutcome:
        found = outcome(by_path[arm], worker)
        print(row(found), file=sys.stderr, flush=True)
        return found

    by_path = {arm.path: arm for arm in arms}
    return of_each(one, list(by_path), processes)


def row(found: ArmOutcome) -> str:
    """A line of the table."""
    tip = "" if found.tip_mm is None else f"{found.tip_mm:.3g}"
    return f"| {found.arm.path.stem} | {found.kind} | {found.gist} | {tip} |"


def table(outcomes: Sequence[ArmOutcome]) -> str:
    """One row an arm."""
    return "\n".join(["| arm | outcome | law, steps, task, or cause | tip error, largest, mm |", "|---|---|---|---|",
                      *map(row, outcomes)])  # fmt: skip


def words(arms: Sequence[ListedArm], outcomes: Sequence[ArmOutcome]) -> str:
    """The counts, and how many arms of the list were here."""
    kinds = Counter(one.kind for one in outcomes)
    counted = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    return f"{len(outcomes)} of {len(arms)} arms here: {counted}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    arms = listed_arms()
    outcomes = survey([arm for arm in arms if arm.path.is_file()], options.processes)
    print(words(arms, outcomes), table(outcomes), sep="\n\n")
    return 1 if any(one.kind in BAD_KINDS for one in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
