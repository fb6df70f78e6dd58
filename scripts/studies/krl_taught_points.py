"""Whether the points that people taught on real robots fit our model of those robots, Status and Turn included.

    python scripts/studies/krl_taught_points.py FOLDER... [--list]

Each FOLDER is a backup with its `$machine.dat`. A point is `DECL E6POS XP1={X ..., S 2, T 34, ...}` whose tool and base
`DECL FDAT FP1={TOOL_NO 1, BASE_NO 0, ...}` names; TOOL_DATA and BASE_DATA stand in the `$config.dat`. The controller
wrote S and T when the point was taught, so they test the geometry of the arm, its limits, and our Status and Turn.

A tool that was measured again afterwards spoils a point, and so does a copy from another cell: equal points count once,
and what does not fit is listed, not explained away. The programs are not ours: only counts are printed.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

import lwr_dyn  # noqa: E402
from lwr_dyn.foundation.arrays import Array  # noqa: E402
from lwr_dyn.kinematics.inverse import inverse_kinematics  # noqa: E402
from lwr_dyn.krl.project.program import load_project  # noqa: E402
from lwr_dyn.krl.project.project import ModuleFile, Project  # noqa: E402
from lwr_dyn.krl.robot.kuka_pose import KukaPose, status, turn  # noqa: E402
from lwr_dyn.krl.robot.machine_data import given_values  # noqa: E402
from lwr_dyn.model.arm import Arm  # noqa: E402

FITS, OTHER_TURN, OTHER_STATUS = "S and T fit", "S fits, T does not", "S does not fit"
AWAY, LIMITS, LEFT_OUT = "out of reach", "outside the limits", "left out: no S and T, tool, base or axes of KUKA"
VERDICTS = (FITS, OTHER_TURN, OTHER_STATUS, LIMITS, AWAY)
Names = Mapping[str, Any]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--list", action="store_true", help="each point that does not fit")
    options = parser.parse_args()
    for folder in options.folders:
        verdicts = taught_points(load_project(folder))
        counts = Counter(verdicts.values())
        judged = sum(counts[x] for x in VERDICTS)
        line = ", ".join(f"{x} {counts[x]}" for x in (*VERDICTS, LEFT_OUT) if counts[x])
        print(f"{Path(folder).name}: {counts[FITS]} of {judged} points fit; {line}")
        for (name, *_), verdict in verdicts.items():
            if options.list and verdict not in (FITS, LEFT_OUT):
                print(f"    {name}: {verdict}")


def taught_points(project: Project) -> dict[tuple[str, ...], str]:
    """(file and name, numbers) of each distinct point of a project -> its verdict."""
    verdicts: dict[tuple[str, ...], str] = {}
    arms: dict[Path, Arm] = {}
    seen: set[str] = set()
    for module in project.modules:
        machine, config = (project.nearest(module, name) for name in ("$machine.dat", "$config.dat"))
        if module.data is None or machine is None or config is None or module.name.startswith("$"):
            continue
        arm = arms[machine] if machine in arms else arms.setdefault(machine, lwr_dyn.load(machine))
        frames = {key: value for key, value in _values(project.file(config.relative_to(project.folder).as_posix()))}
        for name, point, frame in _points(module.data):
            numbers = str(sorted(point.items(), key=str)) + str(frame)
            if numbers not in seen:
                seen.add(numbers)
                verdicts[(f"{module.path} {name}", numbers)] = verdict(arm, point, frame, frames)
    return verdicts


def _values(file: ModuleFile) -> Iterator[tuple[tuple[str, int | None], Any]]:
    for _, statement in file.outline.data:
        yield from (((name, index), value) for name, index, value in given_values(statement))


def _points(file: ModuleFile) -> Iterator[tuple[str, Names, Names]]:
    """Name, components, and tool and base of each point of a `.dat`."""
    values = {name: value for (name, index), value in _values(file) if index is None and isinstance(value, dict)}
    for name, point in values.items():
        frame = values.get(f"F{name[1:]}", {})
        if name.startswith("X") and "TOOL_NO" in frame and {"X", "Y", "Z", "A", "B", "C"} <= set(point):
            yield name, point, frame


def verdict(arm: Arm, point: Names, frame: Names, frames: Mapping[tuple[str, int | None], Any]) -> str:
    """What the model says of a point."""
    s, t = point.get("S"), point.get("T")
    tool, base = (_frame(frames, f"{x}_DATA", frame.get(f"{x}_NO", 0)) for x in ("TOOL", "BASE"))
    if s is None or t is None or tool is None or base is None or frame.get("IPO_FRAME", "BASE") != "BASE":
        return LEFT_OUT
    place = base @ _pose(point) @ np.linalg.inv(tool)
    result = inverse_kinematics(arm, np.asarray(place))
    if result.status != "solved":
        return AWAY if result.status == "out of reach" else LIMITS
    # more than the three bits of the branch, and the bits of external axes, are not of the arm
    found = {(status(arm, x.q), turn(x.q)) for x in result.solutions}
    if (s & 7, t & 63) in found:
        return FITS
    return OTHER_TURN if s & 7 in {a for a, _ in found} else OTHER_STATUS


def _frame(frames: Mapping[tuple[str, int | None], Any], table: str, number: Any) -> Array | None:
    if number == 0:
        return np.eye(4)
    value = frames.get((table, number))
    return _pose(value) if isinstance(value, dict) else None


def _pose(value: Names) -> Array:
    return KukaPose(*(float(value[x]) for x in ("X", "Y", "Z", "A", "B", "C"))).matrix()


if __name__ == "__main__":
    main()
