"""The LWR-IV exercise as a folder: what was found, as text and JSON, and the kinematic model."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.checks.verdict import CheckReport
from lwr_dyn.files import make_folder, write_folder
from lwr_dyn.model.arm import Arm
from lwr_dyn.papers.assembly import arm_from_paper
from lwr_dyn.papers.catalog import open_paper
from lwr_dyn.reproduction.checked_models import check_record, models_and_checks
from lwr_dyn.reproduction.lwr4.exercise import Exercise, exercise
from lwr_dyn.reproduction.outcome import PageExtras, Reproduction
from lwr_dyn.reproduction.pages import checks_of
from lwr_dyn.reproduction.report.content import Replay, Still


def reproduce(folder: str | Path) -> Reproduction:
    """Solve the exercise and write `folder`; raises `FileAccessError` when it cannot be written."""
    place, e = make_folder(folder), exercise()
    arm = arm_from_paper(open_paper("lwr4"))
    reports = models_and_checks(place, "lwr4")
    routes = {
        name: {"value": [str(x) for x in route.value], "products": route.multiplications, "sums": route.additions}
        for name, route in (("full_product", e.wrist_full), ("vector_route", e.wrist_short))
    }
    matrices = {f"A{i + 1}": str(m.tolist()) for i, m in enumerate(e.matrices)}
    record: dict[str, Any] = {"matrices": matrices, "identical_to_printed": list(e.identical), "wrist": routes}
    record |= {"routes_agree": e.routes_agree, "tool": e.tool}
    text = _text(e)
    write_folder(place, {"exercise.txt": text + "\n"})
    record |= {"checks": check_record(reports)}
    holds = e.holds and all(r.holds for r in reports)
    return Reproduction(holds, text, record, shown=_page_extras(arm, e, reports))


def _page_extras(arm: Arm, e: Exercise, reports: Sequence[CheckReport]) -> PageExtras:
    """The arm with its frames as the exercise shows it, and with the tool point at its given position."""
    place = ", ".join(f"{x + 0.0:.2f}" for x in e.tool)
    stills = (
        Still("Assignment of D-H frames, q = 0", arm, np.zeros(arm.n)),
        Still("tool position", arm, np.radians(e.q_deg), f"the tool point stands at ({place}) m in frame 0"),
    )
    return PageExtras(replay=Replay(stills=stills), checks=checks_of(reports))


def _text(e: Exercise) -> str:
    same = ("DIFFERS from", "identical to")
    lines = [f"A{i}: {same[found]} the printed matrix" for i, found in enumerate(e.identical, start=1)]
    full, short = e.wrist_full, e.wrist_short
    lines.append(f"wrist by A1...A7 (0,0,0,1): {full.multiplications} products, {full.additions} sums")
    lines.append(f"wrist by A1..A4 (0,0,M,1):  {short.multiplications} products, {short.additions} sums")
    lines.append(f"both routes give one expression: {e.routes_agree}")
    lines += [f"  p_W,{axis} = {x}" for axis, x in zip("xyz", short.value, strict=False)]
    tool = " ".join(f"{round(x, 12) + 0.0:g}" for x in e.tool)
    lines.append(f"tool point {e.tool_in_flange} at q = {e.q_deg} deg: {tool} m")
    return "\n".join(lines)
