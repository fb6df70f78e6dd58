"""The linter's share of planted faults found: the 73 kinds of faults at every moving link of every arm judged good.

Arms of packages are found where they are installed; those of repositories as `OWNER+NAME/` in the folder --arms (or
LWR_DYN_ARMS). Verdicts are kept in out/linter_detection/ by the digest of the rules and the faults, an arm a file, so a
stopped run goes on where it was.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import linter_detection_tables as tables  # noqa: E402

from lwr_dyn.foundation.errors import LwrDynError  # noqa: E402
from lwr_dyn.foundation.files import write_file  # noqa: E402
from tests.checks.urdf.detection import Alarm, PlantVerdict, alarms, verdicts  # noqa: E402
from tests.checks.urdf.fault_plants import fault_kinds  # noqa: E402
from tests.checks.urdf.judged_arms import ARMS_FOLDER, JudgedArm, judged_arms  # noqa: E402
from tests.checks.urdf.plant_site import sites  # noqa: E402

HALVES = ("tuning", "unused", "fresh", "latest", "newest", "last")
KEPT = ROOT / "out" / "linter_detection"
SOURCES = ("lwr_dyn/checks/urdf/*.py", "tests/checks/urdf/*.py", "tests/checks/urdf/*.toml")


@dataclass(frozen=True, slots=True)
class HalfResult:
    """What the linter made of one half."""

    half: str
    arms: int
    absent: tuple[str, ...]
    """Arms that are not on this machine as they were judged."""
    links: int
    """Moving links judged good, with shapes."""
    verdicts: tuple[PlantVerdict, ...]
    alarms: tuple[Alarm, ...]

    def text(self) -> str:
        """The tables in Markdown."""
        where = f"not here: {', '.join(self.absent)}" if self.absent else "all here"
        head = (
            f"### {self.half}: {self.arms} good arms ({where}), {self.links} moving links, {len(self.verdicts)} plants"
        )
        parts = [
            head, tables.totals(self.verdicts), tables.alarm_lines(self.alarms, self.links),
            tables.by_kind(self.verdicts), tables.by_size(self.verdicts),
            tables.by(lambda v: v.arm, "arm", self.verdicts),
        ]  # fmt: skip
        return "\n\n".join(parts)


def source_digest() -> str:
    """Of the rules, the faults and the arms."""
    files = sorted(path for pattern in SOURCES for path in ROOT.glob(pattern))
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:12]


def arm_verdicts(arm: JudgedArm, digest: str, share: float) -> tuple[list[PlantVerdict], list[Alarm], int]:
    """The verdicts of one arm, kept in a file; its alarms; its moving links with shapes that were judged good."""
    kept = KEPT / f"{arm.name}-{digest}-{share:g}.jsonl"
    if kept.is_file():
        done = [tables.from_record(line) for line in kept.read_text(encoding="utf-8").splitlines()]
    else:
        done = verdicts(arm, fault_kinds(), share)
        write_file(kept, "".join(tables.to_record(v) + "\n" for v in done))
    links = [x for x in sites(arm.text(), arm.path) if x.link not in arm.faults and x.diameter]
    return done, alarms(arm), len(links)


def measured(half: str, processes: int = 2, share: float = 1.0, names: Sequence[str] = ()) -> HalfResult:
    """The verdicts of a half, or of the arms named."""
    KEPT.mkdir(parents=True, exist_ok=True)
    good = [a for a in judged_arms() if a.half == half and a.judgement == "good" and (not names or a.name in names)]
    here = [arm for arm in good if arm.is_as_judged]
    digest = source_digest()
    with ProcessPoolExecutor(processes) as pool:
        jobs = {arm.name: pool.submit(arm_verdicts, arm, digest, share) for arm in here}
        results = {name: job.result() for name, job in jobs.items()}
    absent = tuple(arm.name for arm in good if arm not in here)
    found = [v for done, _, _ in results.values() for v in done]
    false = [a for _, raised, _ in results.values() for a in raised]
    return HalfResult(half, len(here), absent, sum(n for _, _, n in results.values()), tuple(found), tuple(false))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="ARM", help="all if not given")
    parser.add_argument("--half", choices=HALVES, default=HALVES[0])
    parser.add_argument("--share", type=float, default=1.0, help="of the plants, drawn by seed (default: all)")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--arms", help=f"folder of the repositories (default: {ARMS_FOLDER})")
    options = parser.parse_args()
    if options.arms:
        os.environ[ARMS_FOLDER] = options.arms
    try:
        print(measured(options.half, options.processes, options.share, options.names).text())
    except LwrDynError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
