"""Everything the WAM paper simulates: tables, runs, Figures 4 to 8 redrawn, a replay."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lwr_dyn.files import make_folder
from lwr_dyn.model.arm import Arm
from lwr_dyn.reproduction.paper_study import PageExtras, Progress, Reproduction
from lwr_dyn.reproduction.wam7.figures import drawn_runs, figures, page_extras, runs_of_joints
from lwr_dyn.reproduction.wam7.runs import GRAVITIES, CruiseError, Experiment, cruises, experiments
from lwr_dyn.reproduction.wam7.text import (
    cruises_text,
    figure_7_holds,
    figure_7_text,
    passivity_text,
    runs_text,
    verdict,
)
from lwr_dyn.viewer.plots import save_figure
from lwr_dyn.viewer.replay_page import write_replay


def run(place: Path, arm: Arm, progress: Progress) -> Reproduction:
    """Recompute the paper's simulations.

    It holds when every cruise of a loop with damping settles on (F_c + sigma v)/kp, and no readable axis of Figure 7
    is left. The loop without damping is a finding, stated as such.
    """
    made = experiments(arm, progress)
    found = cruises(arm, made)
    progress("plots and replay")
    extras = _pictures(place, arm, made)
    text = "\n\n".join(
        [cruises_text(found), findings_text(found), figure_7_text(found), passivity_text(arm), runs_text(made)]
    )
    holds = all(c.holds for c in found) and figure_7_holds(found)
    record = {"cruises": [_cruise(c) for c in found], "runs": [_run(e) for e in made]}
    settled = [1e3 * c.mean for c in found if c.side > 0 and c.gravity == GRAVITIES[0] and c.stable]
    return Reproduction(holds, text, record, {"settled": {"error": settled}}, extras)


def findings_text(found: Sequence[CruiseError]) -> str:
    """Loops that cannot cruise steadily, as findings."""
    lines = [
        f"J{c.joint + 1} {'positive' if c.side > 0 else 'negative'}, {c.gravity}: {verdict(c)}"
        for c in found
        if not c.stable
    ]
    return "\n".join(["Findings: the friction takes more damping than kd gives, a limit cycle", *lines])


def _pictures(place: Path, arm: Arm, made: Sequence[Experiment]) -> PageExtras:
    """Write runs, figures and the replay; what the report page shows of them."""
    plots, folder = make_folder(place / "plots"), make_folder(place / "runs")
    for e in made:
        stem = e.name.replace(" +", "_up").replace(" -", "_down").replace(", ", "_").replace(" ", "_")
        e.run.save(folder / f"{stem}.npz")
    alone, together = (runs_of_joints(arm, made, alone) for alone in (True, False))
    runs, drawn = drawn_runs(arm, alone, together), figures(arm, alone, together)
    for name, figure in drawn.items():
        save_figure(figure, plots / name, runs)
    title = "Barrett WAM, all joints, 0.5 rad in 7 s"
    write_replay(place / "replay.html", [one.run for one in runs[:2]], arm, labels=list(together), title=title)
    return page_extras(arm, made, runs, list(drawn.values()))


def _cruise(c: CruiseError) -> dict[str, Any]:
    words = {"joint": c.joint + 1, "side": c.side, "gravity": c.gravity, "predicted": c.predicted, "mean": c.mean}
    words |= {"least": c.least, "most": c.most, "slowest": c.slowest, "fastest": c.fastest, "sticks": c.sticks}
    return words | {"net_damping": c.net_damping, "stable": c.stable, "holds": c.holds}


def _run(e: Experiment) -> dict[str, Any]:
    meta = e.run.meta
    return {"name": e.name, "evaluations": meta["evaluations"], "audit": meta["audit"], "events": len(e.run.events)}
