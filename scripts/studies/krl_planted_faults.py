"""The share of planted faults that `krl check` tells: 26 kinds, 9 of each, in programs without errors of a folder.

    python scripts/studies/krl_planted_faults.py FOLDER [--seed 7 --seed 11 ...] [--refused] [--misses] [--alarms]

FOLDER holds a folder a project (a repository, a backup). Its programs are only tried. What counts as told and as
rightly named stands in `tests/krl/planting`, and was fixed before the first count. `--misses` lists the faults that
are not told or wrongly named, `--alarms` what the five checks of constants say of the unchanged programs.

`--refused` plants the 18 kinds that the pendant refuses, 10 of each, also in programs that name what a missing file
declares. Folders `owner+name@part` are parts of one repository.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT))

from lwr_dyn.foundation.errors import FileAccessError  # noqa: E402
from lwr_dyn.krl.diagnostics import Diagnostic  # noqa: E402
from lwr_dyn.krl.project.program import load_project  # noqa: E402
from tests.krl.planting.kinds import KINDS, REFUSED, FaultKind  # noqa: E402
from tests.krl.planting.site import SeededProject, seeded  # noqa: E402
from tests.krl.planting.trial import MISSING, PlantVerdict, clean_modules, diagnostics_of, verdicts  # noqa: E402

COUNT, COUNT_REFUSED = 9, 10
NEEDED, LEAST = 0.95, 6
"""Share of all faults, and number of each kind, that must be told and rightly named."""
CONSTANTS = frozenset({"index-range", "speed-unit", "percent-range", "no-constant", "recursive-type"})


def projects_in(folder: Path) -> list[SeededProject]:
    """Each folder inside as a project; those without KRL are left out."""
    out = []
    for path in sorted(p for p in folder.iterdir() if p.is_dir()):
        try:
            out.append(seeded(path.name.split("@")[0], load_project(path)))
        except FileAccessError:
            continue
    return out


def alarms(projects: Sequence[SeededProject]) -> Iterator[tuple[str, Diagnostic]]:
    """What the checks of constants say of the programs as they are."""
    for of in projects:
        for module in of.project.modules:
            yield from ((of.name, d) for d in diagnostics_of(of.project, module) if d.code in CONSTANTS)


def table(found: Sequence[PlantVerdict], kinds: Sequence[FaultKind]) -> str:
    """A row a kind: planted, told, rightly named."""
    rows = []
    for kind in kinds:
        own = [x for x in found if x.kind == kind.name]
        rows.append(f"  {kind.name:24} {len(own):3} {sum(x.told for x in own):3} {sum(x.named for x in own):3}")
    return "\n".join(["  kind                 planted told named", *rows])


def holds(found: Sequence[PlantVerdict], kinds: Sequence[FaultKind]) -> bool:
    """Whether the share and each kind are reached."""
    named = sum(x.named for x in found)
    by_kind = [sum(x.named for x in found if x.kind == kind.name) for kind in kinds]
    return bool(found) and named / len(found) >= NEEDED and min(by_kind) >= LEAST


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="The share of planted faults that `krl check` tells.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, action="append")
    parser.add_argument("--refused", action="store_true")
    parser.add_argument("--misses", action="store_true")
    parser.add_argument("--alarms", action="store_true")
    options = parser.parse_args(arguments)
    projects = projects_in(options.folder)
    kinds, count = (REFUSED, COUNT_REFUSED) if options.refused else (KINDS, COUNT)
    modules = clean_modules(projects, MISSING if options.refused else frozenset())
    names = {m.of.name for m in modules}
    print(f"{len(modules)} modules to plant in, of {len(names)} repositories; {len(projects)} projects")
    good = True
    for seed in options.seed or [7]:
        found = verdicts(modules, seed, count, kinds)
        told, named = sum(x.told for x in found), sum(x.named for x in found)
        print(f"seed {seed}: {len(found)} planted in {len({x.project for x in found})} projects, {told} told, "
              f"{named} rightly named ({100 * named / max(len(found), 1):.1f} %)")  # fmt: skip
        print(table(found, kinds))
        for x in found if options.misses else ():
            if not x.named:
                print(f"  MISS {x.kind}: {x.project}/{x.file}:{x.line}: {x.text} -> {', '.join(x.said) or 'nothing'}")
        good = good and holds(found, kinds)
    for name, d in alarms(projects) if options.alarms else ():
        print(f"  ALARM {name}/{d}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
