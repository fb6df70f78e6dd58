"""`lwr-dyn lint` on every URDF of the installed packages or of folders: codes and how many files they hit.

Every file is read, arms or not, whatever its tree; files of the same content count once. Each has 30 s of CPU time.
Exit 1 for a traceback or a file over the limit.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]

from foreign_arms import BAD_KINDS, LIMIT, Done, Worker, installed_urdfs, of_each  # noqa: E402


@dataclass(frozen=True, slots=True)
class LintOutcome:
    """What `lint` made of one file: judged, refused, crashed or over the limit; its findings as (severity, code)."""

    file: Path
    kind: str
    gist: str
    found: frozenset[tuple[str, str]]
    seconds: float


def linted(path: Path, worker: Worker, limit: float = LIMIT) -> LintOutcome:
    """The outcome of one file."""
    done = worker.run(("lint", str(path), "--json"), limit)
    kind, gist = _judged(done)
    findings = json.loads(done.out)["findings"] if kind == "judged" else []
    found = frozenset((finding["severity"], finding["code"]) for finding in findings)
    return LintOutcome(path, kind, gist, found, done.seconds)


def _judged(done: Done) -> tuple[str, str]:
    """Kind and gist of a finished run."""
    lines = done.err.strip().splitlines()
    if done.code < 0:
        return "over the limit", f"signal {-done.code} after {done.seconds:.0f} s"
    if done.code == 2 and len(lines) == 1 and lines[0].startswith("lwr-dyn: "):
        return "refused", lines[0]
    if done.code not in (0, 1) or any("Traceback" in line for line in lines):
        return "crashed", lines[-1] if lines else f"exit code {done.code}"
    return "judged", ""


def survey(paths: Sequence[Path], processes: int, limit: float = LIMIT) -> list[LintOutcome]:
    """The outcome of every file."""
    return of_each(lambda path, worker: linted(path, worker, limit), paths, processes)


def table(outcomes: Sequence[LintOutcome]) -> str:
    """Counts by outcome and severity, then the codes: files with an error, a warning, a note of it."""
    kinds = Counter(outcome.kind for outcome in outcomes)
    lines = [", ".join(f"{count} {kind}" for kind, count in kinds.most_common())]
    for severity in ("error", "warning"):
        lines.append(f"files with {severity}s: {sum(any(s == severity for s, _ in o.found) for o in outcomes)}")
    hits = Counter(pair for outcome in outcomes for pair in outcome.found)
    codes = sorted({code for _, code in hits}, key=lambda code: (-hits["error", code], -hits["warning", code], code))
    lines += ["", "| code | files with errors | with warnings | with notes |", "|---|---|---|---|"]
    rows = [[hits[severity, code] for severity in ("error", "warning", "note")] for code in codes]
    lines += [f"| {code} | {e} | {w} | {n} |" for code, (e, w, n) in zip(codes, rows, strict=True)]
    bad = [outcome for outcome in outcomes if outcome.kind != "judged"]
    return "\n".join(lines + [f"{o.kind} | {o.file} | {o.gist[:300]} | {o.seconds:.1f} s" for o in bad])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", default=sys.path[2:], help="where to look (default: installed packages)")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    paths = installed_urdfs(options.folders)
    outcomes = survey(paths, options.processes)
    worst = max(outcomes, key=lambda x: x.seconds)
    print(f"{len(paths)} distinct URDFs; longest {worst.file.name}, {worst.seconds:.1f} s")
    print(table(outcomes))
    return 1 if any(outcome.kind in BAD_KINDS for outcome in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
