"""`simulate`, `compare`, `gains`, and `new study` with its `sweep` and `tune`, without an option on the 40 public arms
of default_arms.toml: what ran inside its limits, and why an arm did not.

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
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pinocchio as pin

sys.path.insert(0, str(Path(__file__).resolve().parent))
from foreign_arms import Done, Worker, of_each

LIST = Path(__file__).with_suffix(".toml")
LIMIT = 300.0
"""[s] Longest CPU time for one arm."""
CLONE = "LWR_DYN_URDF_FILES"
RAN = "ran"
OUTSIDE = "outside its limits"
BAD_KINDS = {"diverged", OUTSIDE, "crashed", "over the limit"}


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
    """What became of one arm: kind, what was chosen or the cause of a refusal, the largest error of the tip [mm]."""

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


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a finished command says: kind, the choices or the cause, the largest error of the tip [mm] where one is."""

    kind: str
    gist: str
    tip_mm: float | None = None


def outcome(arm: ListedArm, worker: Worker, command: str = "simulate", limit: float = LIMIT) -> ArmOutcome:
    """The outcome of one of `COMMANDS` without an option but the tip."""
    found = COMMANDS[command](arm, worker, limit)
    return ArmOutcome(arm, found.kind, found.gist, found.tip_mm)


def judged(done: Done, of_record: Callable[[Any], Verdict], may_fail: bool = False) -> Verdict:
    """The verdict on a finished command: of its record, or why it has none; `may_fail` lets exit code 1 have one."""
    last = (done.err.strip().splitlines() or [f"exit code {done.code}"])[-1]
    if done.code == 2 and last.startswith("lwr-dyn: "):
        return Verdict("refused", last.removeprefix("lwr-dyn: "))
    if "diverges" in last:
        return Verdict("diverged", last)
    if done.code < 0:
        return Verdict("over the limit", f"{done.seconds:.0f} s")
    if done.code not in ((0, 1) if may_fail else (0,)) or not done.out:
        return Verdict("crashed", last)
    return of_record(json.loads(done.out))


def of_simulate(record: Any) -> Verdict:
    """Of one run."""
    meta, found = record["meta"], record["metrics"]
    gist = f"{meta['controller']['name']}, {meta['options']['substeps']} steps a sample, {meta['note']['task']}"
    return Verdict(OUTSIDE if found["within_limits"] is False else RAN, gist, found["tip_max_mm"])


def of_compare(record: Any) -> Verdict:
    """Of the runs of all laws; one that is left out is named by the command, one that diverges counts."""
    runs, failures = record["runs"], record["failures"]
    if diverged := [text for text in failures if "diverge" in text]:
        return Verdict("diverged", "; ".join(diverged))
    if not runs:
        return Verdict("refused", "; ".join(failures))
    outside = [one["typed"] for one in runs if one["unstable"] or one["metrics"]["within_limits"] is False]
    gist = f"{len(runs)} laws, {len(failures)} left out" + (f"; outside: {', '.join(outside)}" if outside else "")
    return Verdict(OUTSIDE if outside else RAN, gist)


def of_gains(record: Any) -> Verdict:
    """Of the gains of every joint: whether they are finite, and which laws hold at 1 kHz."""
    values = [one[key] for one in record["joints"] for key in ("Kp", "Kd")]
    held = [name for name, one in record["sampled"].items() if one and one["holds"]]
    kind = RAN if all(value is not None and value > 0.0 for value in values) else "crashed"
    return Verdict(kind, f"{len(record['joints'])} joints; hold at 1000 Hz: {', '.join(held) or 'none'}")


def of_sweep(record: Any) -> Verdict:
    """Of the runs of a new study, each on another plant: none diverges, no torque is cut."""
    found = record["summary"]["controllers"]
    events = {(name, event): x["count"] for name, one in found.items() for event, x in one["events"].items()}
    said = [f"{name}: {event} in {count}" for (name, event), count in events.items() if count and event != "simulated"]
    gist = f"{', '.join(found)}; {record['runs']} runs each" + (f"; {', '.join(said)}" if said else "")
    if not record["complete"] or any("diverged" in text for text in said):
        return Verdict("diverged", gist)
    return Verdict(OUTSIDE if said else RAN, gist)


def of_tune(record: Any) -> Verdict:
    """Of the gains found: whether runs that the search has not seen keep the torque limits too."""
    kept = record["check"] is not None and record["check"]["keeps_bound"]
    found = ", ".join(f"{name.partition('.')[2]} {x:.3g}" for name, x in record["found"].items())
    return Verdict(RAN if kept else OUTSIDE, f"{record['controller']}: {found}")


def _study(arm: ListedArm, worker: Worker, limit: float) -> Verdict:
    """`new study` of the arm, then `sweep` and `tune` of it in a few runs: the first verdict that is not `RAN`."""
    with TemporaryDirectory() as folder:
        study = str(Path(folder) / "study.toml")
        made = worker.run(("new", "study", study, *arm.words), limit)
        if made.code != 0:
            return judged(made, of_sweep)
        steps = (
            (("sweep", study, "--out", f"{folder}/out", *SWEEP), of_sweep),
            (("tune", study, *TUNE), of_tune),
        )
        gists = []
        for words, of_record in steps:
            found = judged(worker.run((*words, "--json"), limit), of_record, may_fail=True)
            gists.append(f"{words[0]}: {found.gist}")
            if found.kind != RAN:
                return Verdict(found.kind, "; ".join(gists))
        return Verdict(RAN, "; ".join(gists))


def _one(command: str, of_record: Callable[[Any], Verdict]) -> Callable[[ListedArm, Worker, float], Verdict]:
    return lambda arm, worker, limit: judged(worker.run((command, *arm.words, "--json"), limit), of_record)


COMMANDS: dict[str, Callable[[ListedArm, Worker, float], Verdict]] = {
    "simulate": _one("simulate", of_simulate),
    "compare": _one("compare", of_compare),
    "gains": _one("gains", of_gains),
    "study": _study,
}
"""What is tried on every arm; `study` is `new study`, `sweep` and `tune`."""
SWEEP = ("--runs", "8", "--jobs", "1")
TUNE = ("--runs", "32", "--check-runs", "64", "--population", "8", "--generations", "4", "--front", "0", "--jobs", "1")


def survey(arms: Sequence[ListedArm], processes: int, command: str = "simulate") -> list[ArmOutcome]:
    """The outcome of a command on every arm; each is printed on stderr when it is there."""

    def one(arm: Path, worker: Worker) -> ArmOutcome:
        found = outcome(by_path[arm], worker, command)
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
    return "\n".join(["| arm | outcome | choices, or cause | tip error, largest, mm |", "|---|---|---|---|",
                      *map(row, outcomes)])  # fmt: skip


def words(arms: Sequence[ListedArm], outcomes: Sequence[ArmOutcome]) -> str:
    """The counts, and how many arms of the list were here."""
    kinds = Counter(one.kind for one in outcomes)
    counted = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    return f"{len(outcomes)} of {len(arms)} arms here: {counted}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("command", choices=COMMANDS, nargs="?", default="simulate")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    arms = listed_arms()
    outcomes = survey([arm for arm in arms if arm.path.is_file()], options.processes, options.command)
    print(words(arms, outcomes), table(outcomes), sep="\n\n")
    return 1 if any(one.kind in BAD_KINDS for one in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
