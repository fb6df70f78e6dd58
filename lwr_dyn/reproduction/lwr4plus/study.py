"""Everything the LWR 4+ paper prints, recomputed."""

from collections.abc import Mapping
from pathlib import Path

from lwr_dyn.model.arm import Arm
from lwr_dyn.reproduction.lwr4plus import TIMINGS
from lwr_dyn.reproduction.lwr4plus.cached_maxima import arms
from lwr_dyn.reproduction.lwr4plus.errors import (
    LARGEST_MARGIN,
    condition_tables,
    error_table,
    fitted_arm_angle,
    velocity_rows,
)
from lwr_dyn.reproduction.lwr4plus.figures import pictures
from lwr_dyn.reproduction.lwr4plus.formulas import error_columns
from lwr_dyn.reproduction.lwr4plus.runs import controller_runs, ranking_table
from lwr_dyn.reproduction.lwr4plus.tables import (
    errata_that_matter,
    gain_cells,
    gain_table,
    inertia_rows,
    inertia_table,
    shell_asymmetry,
)
from lwr_dyn.reproduction.paper_study import Progress, Reproduction
from lwr_dyn.trajectory.references.ist import ist_reference


def run(_: Path, arm: Arm, progress: Progress, timing: str = "smooth", fit_arm_angle: bool = False) -> Reproduction:
    """Recompute the paper: tables, runs, figures and the replay.

    Tables VII and VIII are computed under all timings; `timing` is that of the runs that are replayed. With
    `fit_arm_angle` they are also computed with the arm angle fitted to Table VIII, and named as fitted.
    """
    progress("Tables IV and VI")
    inertias, gains = inertia_rows(), gain_cells()
    shells = {name: shell_asymmetry(a) for name, a in arms().items()}
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
    nearer = min(velocity, key=lambda name: velocity[name])
    return Reproduction(
        holds=all(r.reproduced("computed") for r in inertias) and all(g.reproduced or g.fits for g in gains),
        tables=(
            inertia_table(inertias),
            "Principal moments of the mirror-image links 1 to 4, largest spread over mean: " + _listed(shells, ".1%"),
            gain_table(gains),
            *(table for tables in errors.values() for table in condition_tables(tables)),
            "Table VIII, velocity maxima and minima, RMS miss over row range: "
            f"{_listed(velocity, '.2f')}; nearer: {nearer}",
            ranking_table(runs),
        ),
        record={
            "table_iv": [row.record() for row in inertias],
            "errata_that_matter": list(errata_that_matter()),
            "table_vi": [cell.record() for cell in gains],
            **{name: [table.record() for table in tables] for name, tables in errors.items()},
            "controllers": [run.record() for run in runs],
            "shell_spread": shells,
            "velocity_rows": velocity,
        },
        known={name: error_columns(one, arm) for name, one in nearest.items()},
        pictures=pictures(arm, runs, nearest["table_viii"].run),
    )


def _listed(values: Mapping[str, float], form: str) -> str:
    return ", ".join(f"{name} {x:{form}}" for name, x in values.items())
