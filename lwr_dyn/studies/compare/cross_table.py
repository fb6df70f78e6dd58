"""A comparison as one table in Markdown, plants down and controllers across: the RMS error of the tip in mm."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

MARKS = {"unstable": "{} !", "best": "**{}**", "": "{}"}
NONE = "none"
"""Where a pair has no run; `failures` say why."""


def cross_table(runs: Iterable[Mapping[str, Any]]) -> str:
    """The table of the records of `RunComparison.record()["runs"]`, controllers as typed; the best of each plant bold.

    >>> run = {"typed": "pid", "plant": "delay", "tip_rms_mm": 0.123456, "unstable": False, "best": []}
    >>> print(cross_table([run, {**run, "typed": "mine.py", "tip_rms_mm": 9.0, "unstable": True}]))
    | plant | `pid` | `mine.py` |
    | --- | --- | --- |
    | delay | 0.123 | 9 ! |
    """
    listed = list(runs)
    controllers = list(dict.fromkeys(str(run["typed"]) for run in listed))
    plants = list(dict.fromkeys(str(run["plant"]) for run in listed))
    cells = {(run["plant"], run["typed"]): _cell(run) for run in listed}
    rows = [[plant, *(cells.get((plant, one), NONE) for one in controllers)] for plant in plants]
    head = ["plant", *(f"`{one}`" for one in controllers)]
    return "\n".join(map(_line, [head, ["---"] * len(head), *rows]))


def _cell(run: Mapping[str, Any]) -> str:
    mark = "unstable" if run["unstable"] else "best" if "tip_rms_mm" in run["best"] else ""
    return MARKS[mark].format(f"{run['tip_rms_mm']:.3g}")


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
