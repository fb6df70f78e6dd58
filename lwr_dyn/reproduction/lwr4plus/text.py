"""The tables of the LWR 4+ report as text: printed beside recomputed, with a verdict each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lwr_dyn.control.worst_case_inertia import InertiaMaximum
from lwr_dyn.reproduction.lwr4plus.errors import NEAR, ErrorTable
from lwr_dyn.reproduction.lwr4plus.runs import PLANTS, ControllerRun, ranking
from lwr_dyn.reproduction.lwr4plus.tables import GainCell, InertiaRow, errata_that_matter, in_paper_angles
from lwr_dyn.tables import aligned

READINGS = ("printed", "computed", "physical")


def table_iv_text(rows: Sequence[InertiaRow]) -> str:
    """Table IV under every reading, the printed configurations, the maximisers, and how they were searched."""
    cells = []
    for r in rows:
        values = [f"{r.values[n]:.6g}{' =' if r.reproduced(n) else ''}" for n in READINGS]
        cells.append(
            (str(r.joint + 1), r.printed, *values, " ".join(r.printed_q), f"{r.at_printed[1]:.5g}", _at(r.worst))
        )
    head = ("joint", "Table IV", *READINGS, "printed q [deg]", "B_ii there, at most", "maximisers [deg]")
    lines = ["Table IV, worst-case inertia [kg m^2]; = reproduced to the printed digits; * any; q2 from the horizontal"]
    lines.append(aligned(cells, head))
    lines += [f"b{r.joint + 1}{r.joint + 1}: {r.worst.statement()}" for r in rows]
    lines.append(f"what makes the difference between printed and computed: {' and '.join(errata_that_matter())}")
    return "\n".join(lines)


def _at(worst: InertiaMaximum) -> str:
    shown = in_paper_angles(worst)
    more = worst.distinct - len(shown)
    return " | ".join(" ".join(q) for q in shown) + (f" | and {more} more" if more > 0 else "")


def shells_text(spreads: Mapping[str, float]) -> str:
    """Whether links 1 to 4, four shells of two mirror-image forms, come out alike under each reading."""
    words = ", ".join(f"{name} {x:.1%}" for name, x in spreads.items())
    return f"Principal moments of the mirror-image links 1 to 4, largest spread over mean: {words}"


def table_vi_text(cells: Sequence[GainCell]) -> str:
    """Table VI; an exchanged cell names the cell whose value is printed there."""
    rows = []
    for c in cells:
        verdict = "reproduced" if c.reproduced else f"printed here: the value of {c.fits}" if c.fits else "open"
        rows.append((f"{c.name}_{c.joint + 1}", c.printed, f"{c.value:.6g}", verdict))
    head = "Table VI, gains from omega_n = 50 rad/s, xi = 1 and the printed b"
    return f"{head}\n{aligned(rows, ('cell', 'printed', 'recomputed', 'verdict'))}"


def error_tables_text(found: Sequence[ErrorTable]) -> str:
    """The conditions tried for one table, nearest first, and the nearest one cell by cell."""
    ranked = sorted(found, key=lambda t: t.distance)
    rows = [(t.timing, t.arm_angle, f"{t.distance:.3f}", *(str(n) for n in t.counts().values())) for t in ranked]
    title = {"table_vii": "Table VII, PD with gravity compensation", "table_viii": "Table VIII, inverse dynamics"}
    hypothesis = "" if ranked[0].name == "table_vii" else " (hypothesis: no feed-forward, no gravity in n)"
    head = ("timing (assumed)", "arm angle", "RMS miss / row range", "reproduced", f"near ({NEAR:.0%})", "differs")
    nearest = ranked[0]
    lines = [f"{title[nearest.name]}{hypothesis}: position errors, printed in mm, read as mrad", aligned(rows, head)]
    lines.append(f"nearest: {nearest.timing} timing, arm angle: {nearest.arm_angle}")
    cells = [
        (f"J{c.joint + 1} {c.column}", c.printed, f"{c.value:.3g}", f"{c.miss:+.0%}", c.verdict) for c in nearest.cells
    ]
    lines.append(aligned(cells, ("cell", "printed", "recomputed", "of row range", "verdict")))
    return "\n".join(lines)


def velocity_rows_text(distances: Mapping[str, float]) -> str:
    """How the velocity block of Table VIII is to be read."""
    words = ", ".join(f"{name} {x:.2f}" for name, x in distances.items())
    nearest = min(distances, key=lambda name: distances[name])
    return f"Table VIII, velocity maxima and minima, RMS miss over row range: {words}; nearer: {nearest}"


def ranking_text(found: Sequence[ControllerRun]) -> str:
    """The controllers on each plant, best first."""
    rows = []
    for plant in PLANTS:
        for place, t in enumerate(ranking(found, plant), start=1):
            m, audit = t.metrics, t.run.meta["audit"]
            figures = (
                f"{m.tip_rms_mm:.4g}",
                f"{m.tip_max_mm:.4g}",
                f"{max(m.torque_use):.0%}",
                f"{max(m.speed_use):.0%}",
            )
            kept = "kept" if m.within_limits else "NOT kept"
            rows.append((plant, str(place), t.controller, *figures, kept, f"{audit['residual']:.1e}"))
    head = ("plant", "place", "controller", "tip RMS mm", "tip max mm", "torque", "speed", "limits", "audit J")
    return f"Controllers on IST, ranked by RMS tip error; they believe in the arm as modelled\n{aligned(rows, head)}"
