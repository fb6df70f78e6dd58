"""Public MJCF files read as arms, beside MuJoCo's own computation."""

from __future__ import annotations

import os
from pathlib import Path

LARGEST = 1e-12
FOLDER = "LWR_DYN_MJCF"
"""The folder with the models, such as unpacked wheels of robosuite, gymnasium-robotics and dm_control."""


def public_mjcf() -> tuple[str, bool, str]:
    """Mass matrix, bias torque (relative) and tip [m] of every arm in the files of a folder that MuJoCo compiles."""
    import lwr_dyn
    from lwr_dyn.foundation.errors import LwrDynError
    from tests.arms.export.beside_mujoco import differences

    files = sorted(Path(os.environ.get(FOLDER, "nowhere")).rglob("*.xml"))
    rows, worst, refused = list[str](), 0.0, dict[str, int]()
    for file in files:
        try:
            for tip in _tips(file):
                arm = lwr_dyn.load(file, tip=tip)
                found = differences(file, arm)
                worst = max(worst, *found)
                rows.append(f"{file} {tip or ''} n={arm.n} " + " ".join(f"{x:.1e}" for x in found))
        except LwrDynError as fault:
            why = str(fault).partition(": ")[2][:70]
            refused[why] = refused.get(why, 0) + 1
    said = f"{len(files)} files of ${FOLDER}, {len(rows)} arms, largest difference {worst:.1e}"
    return said, worst <= LARGEST, "\n".join([*rows, *(f"refused {n} x: {why}" for why, n in refused.items())])


def _tips(file: Path) -> list[str | None]:
    """None where a file has one arm, else the tips that the refusal lists."""
    import lwr_dyn
    from lwr_dyn.foundation.errors import UrdfError

    try:
        lwr_dyn.load(file)
    except UrdfError as fault:
        _, mark, listed = fault.allowed.partition("--tip: ")
        return [x.rpartition(" (")[0] for x in listed.removesuffix(" ...").split(", ")] if mark else [None]
    return [None]
