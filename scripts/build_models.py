"""Write models/ROBOT/ROBOT[_READING].* for every robot and reading, or check that they are fresh.

Of a robot with published sets the default reading alone: the others differ from it in numbers only, and
`lwr-dyn urdf ROBOT --reading NAME` writes them.

python scripts/build_models.py            write
python scripts/build_models.py --check    list stale, missing and surplus files; exit 1 when there are any
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import lwr_dyn
from lwr_dyn.arms.papers.catalog import published
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.foundation.files import write_folder

MODELS = Path(__file__).resolve().parent.parent / "models"


def all_files() -> dict[str, dict[str, str]]:
    """Robot -> file name -> text."""
    out: dict[str, dict[str, str]] = {}
    for robot in lwr_dyn.robots():
        for reading in lwr_dyn.readings(robot)[: 1 if robot in published() else None]:
            out.setdefault(robot, {}).update(model_files(lwr_dyn.load(robot, reading=reading)))
    return out


def differences(folder: Path, wanted: dict[str, dict[str, str]]) -> list[str]:
    """What is not as it should be, one line a file."""
    texts = {f"{robot}/{name}": text for robot, files in wanted.items() for name, text in files.items()}
    there = {p.relative_to(folder).as_posix(): p for p in sorted(folder.rglob("*")) if p.is_file()}
    stale = [f"stale: {n}" for n, text in texts.items() if n in there and there[n].read_bytes() != text.encode()]
    missing = [f"missing: {n}" for n in texts if n not in there]
    return stale + missing + [f"surplus: {n}" for n in there if n not in texts]


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 when a file is not fresh")
    parser.add_argument("--folder", type=Path, default=MODELS, help="where the models are (default: models/)")
    options = parser.parse_args(arguments)
    wanted = all_files()
    if options.check:
        stale = differences(options.folder, wanted)
        print("\n".join(stale) or f"fresh: {sum(map(len, wanted.values()))} files")
        return 1 if stale else 0
    for robot, files in wanted.items():
        write_folder(options.folder / robot, files)
    for line in differences(options.folder, wanted):
        print(line)
    return 0


if __name__ == "__main__":
    sys.exit(main())
