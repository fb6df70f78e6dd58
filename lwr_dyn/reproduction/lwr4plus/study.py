"""Everything the LWR 4+ paper prints, recomputed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lwr_dyn.files import make_folder
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.lwr4plus import TIMINGS
from lwr_dyn.reproduction.lwr4plus.errors import (
    LARGEST_MARGIN,
    ErrorTable,
    error_table,
    fitted_arm_angle,
    velocity_rows,
)
from lwr_dyn.reproduction.lwr4plus.figures import INVERSE, PD, drawn_runs, figures, page_extras
from lwr_dyn.reproduction.lwr4plus.formulas import error_columns
from lwr_dyn.reproduction.lwr4plus.runs import ControllerRun, controller_runs
from lwr_dyn.reproduction.lwr4plus.tables import (
    GainCell,
    InertiaRow,
    arms,
    errata_that_matter,
    shell_spread,
    table_iv,
    table_vi,
)
from lwr_dyn.reproduction.lwr4plus.text import (
    error_tables_text,
    ranking_text,
    shells_text,
    table_iv_text,
    table_vi_text,
    velocity_rows_text,
)
from lwr_dyn.reproduction.paper_study import PageExtras, Progress, Reproduction
from lwr_dyn.trajectory.references.ist import ist_reference
from lwr_dyn.viewer.plots import save_figure
from lwr_dyn.viewer.replay_page import write_replay
from lwr_dyn.viewer.run_figures import error_figure

DEFAULT_TIMING = "smooth"
REPLAYED = ("pd-gravity", "inverse-dynamics")


def run(
    place: Path, arm: Arm, progress: Progress, timing: str = DEFAULT_TIMING, fit_arm_angle: bool = False
) -> Reproduction:
    """Recompute the paper: tables, runs, plots and the replay.

    Tables VII and VIII are computed under all timings; `timing` is that of the runs that are replayed. With
    `fit_arm_angle` they are also computed with the arm angle fitted to Table VIII, and named as fitted.
    """
    progress("Tables IV and VI")
    inertias, gains = table_iv(), table_vi()
    spreads = {name: shell_spread(a) for name, a in arms().items()}
    progress("Tables VII and VIII")
    angles = [None, *([fitted_arm_angle(arm)] if fit_arm_angle else [])]
    errors = {
        name: [error_table(arm, name, t, angle) for angle in angles for t in TIMINGS]
        for name in ("table_vii", "table_viii")
    }
    velocity = velocity_rows(min(errors["table_viii"], key=lambda t: t.distance), arm)
    progress("controllers on three plants")
    runs = controller_runs(arm, ist_reference(arm, timing))
    progress("plots and replay")
    own = {name: [t for t in tables if t.arm_angle == LARGEST_MARGIN] for name, tables in errors.items()}
    nearest = {name: min(tables, key=lambda t: t.distance) for name, tables in own.items()}
    extras = _pictures(place, arm, runs, nearest["table_viii"].run)
    text = "\n\n".join(
        [
            table_iv_text(inertias),
            shells_text(spreads),
            table_vi_text(gains),
            *(error_tables_text(tables) for tables in errors.values()),
            velocity_rows_text(velocity),
            ranking_text(runs),
        ]
    )
    holds = all(r.reproduced("computed") for r in inertias) and all(g.reproduced or g.fits for g in gains)
    record = _record(inertias, gains, errors, runs) | {"shell_spread": spreads, "velocity_rows": velocity}
    known = {name: error_columns(one, arm) for name, one in nearest.items()}
    return Reproduction(holds, text, record, known, extras)


def _pictures(place: Path, arm: Arm, found: tuple[ControllerRun, ...], table_viii: Run) -> PageExtras:
    """Write runs, figures and the replay; what the report page shows of them."""
    plots, folder = make_folder(place / "plots"), make_folder(place / "runs")
    for trial in found:
        stem = f"{trial.controller}_{trial.plant.replace(' ', '_').replace('%', 'percent')}"
        trial.run.save(folder / f"{stem}.npz")
    replayed = [t for t in found if t.plant == "as modelled" and t.controller in REPLAYED]
    runs = drawn_runs(arm, replayed, table_viii)
    drawn = figures(runs)
    both = {q.replace(" ", "_"): error_figure(runs, (PD, INVERSE), q) for q in ("position error", "velocity error")}
    for name, figure in (drawn | both).items():
        save_figure(figure, plots / name, runs)
    labels = [t.controller for t in replayed]
    write_replay(place / "replay.html", [t.run for t in replayed], arm, labels=labels, title="KUKA LWR 4+ draws IST")
    return page_extras(arm, found, runs, list(drawn.values()))


def _record(
    inertias: tuple[InertiaRow, ...],
    gains: tuple[GainCell, ...],
    errors: dict[str, list[ErrorTable]],
    found: tuple[ControllerRun, ...],
) -> dict[str, Any]:
    return {
        "table_iv": [
            {"joint": r.joint + 1, "printed": r.printed, "values": dict(r.values), "search": r.worst.statement()}
            | {"reproduced": {name: r.reproduced(name) for name in r.values}, "at_printed_q": list(r.at_printed)}
            for r in inertias
        ],
        "errata_that_matter": list(errata_that_matter()),
        "table_vi": [
            {"cell": f"{g.name}_{g.joint + 1}", "printed": g.printed, "value": g.value, "reproduced": g.reproduced}
            | {"fits": g.fits or None}
            for g in gains
        ],
        **{
            name: [
                {"timing": t.timing, "arm_angle": t.arm_angle, "distance": t.distance, "margin": t.reference.margin}
                | {"cells": [_cell(c) for c in t.cells]}
                for t in tables
            ]
            for name, tables in errors.items()
        },
        "controllers": [
            {"controller": t.controller, "plant": t.plant, "audit": t.run.meta["audit"]} | t.metrics.to_json()
            for t in found
        ],
    }


def _cell(cell: Any) -> dict[str, Any]:
    words = {"joint": cell.joint + 1, "column": cell.column, "printed": cell.printed, "value": cell.value}
    return words | {"miss_of_row_range": cell.miss, "verdict": cell.verdict}
