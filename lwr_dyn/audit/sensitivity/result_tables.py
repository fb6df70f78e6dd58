"""The tables of a sensitivity analysis: gravity torques, inertias and gains, errors of every pair, conclusions."""

import math

import numpy as np

from lwr_dyn.audit.sensitivity.analysis import OMEGA_N, XI, Sensitivity
from lwr_dyn.tables import Heading, Table

TINY = 1e-12
"""Below this a torque or inertia is rounding."""


def result_tables(result: Sensitivity) -> list[Table]:
    """All tables, in the order in which they are read."""
    names = [choice.name for choice in result.study.task.controllers]
    return [gravity_table(result), gains_table(result), *(error_table(result, n) for n in names), survival(result)]


def gravity_table(result: Sensitivity) -> Table:
    """Largest |g_i| over the poses, and the largest difference to the first reading [N m (N)]."""
    first, *_ = result.statics.values()
    rows = []
    for name, s in result.statics.items():
        rows.append((name, "largest |g|", *np.abs(s.gravity).max(axis=0)))
        if s is not first:
            rows.append((name, f"largest difference to {result.names[0]}", *s.gravity_off(first)))
    return Table(f"gravity torques at {result.poses} poses [N m (N)]", _headings(result), rows)


def gains_table(result: Sensitivity) -> Table:
    """max B_ii of every joint, and the gains drawn from it."""
    first, *_ = result.statics.values()
    rows: list[tuple[object, ...]] = []
    for name, s in result.statics.items():
        rows += [(name, figure, *x) for figure, x in (("b", s.b), ("Kp", s.gains.Kp), ("Kd", s.gains.Kd))]
        if s is not first:
            rows.append((name, f"off {result.names[0]}", *(f"{x:+.2%}" for x in s.b / first.b - 1.0)))
    gains = f"gains {OMEGA_N**2:g} b, {2 * XI * OMEGA_N:g} b"
    title = f"largest inertia b = max B_ii over the joint box [kg m^2 (kg)], and {gains}"
    return Table(title, _headings(result), rows)


def error_table(result: Sensitivity, controller: str) -> Table:
    """Errors under one controller: a row per model, a column per plant; * where the loop is sampled faster."""
    tips, worst = result.tip_rms_mm(controller), result.worst_mrad(controller)
    raised = {(r.model, r.plant) for r in result.runs if r.controller == controller and r.rate > result.rate}
    least, largest = float(np.nanmin(tips)), float(np.nanmax(tips)) or 1.0

    def shade(cell: tuple[float, float, str]) -> float:
        return float(np.nan_to_num((cell[0] - least) / largest))

    rows = []
    for i, model in enumerate(result.names):
        marks = ["*" if (model, plant) in raised else "" for plant in result.names]
        rows.append((model, *zip(tips[i], worst[i], marks, strict=True)))
    plants = (Heading(f"on {name}", format=_errors, shade=shade) for name in result.names)
    return Table("", (controller, *plants), rows)


def _errors(cell: tuple[float, float, str]) -> str:
    tip, worst, mark = cell
    return "no run" if math.isnan(tip) else f"{tip:.3g} ({worst:.3g}){mark}"


def survival(result: Sensitivity) -> Table:
    """Which conclusions hold under which readings."""
    return Table("what survives", ("conclusion", "verdict"), [(c.text, c.verdict()) for c in result.conclusions])


def _headings(result: Sensitivity) -> tuple[Heading | str, ...]:
    return ("reading", "figure", *(Heading(joint, format=_number) for joint in result.joints))


def _number(value: float | str) -> str:
    if isinstance(value, str):
        return value
    return f"{value:.4g}" if abs(value) > TINY else "0"


def notes(result: Sensitivity) -> list[str]:
    """What stands below the tables of errors: loops that are sampled faster, simulations that failed."""
    raised = sorted({r.rate for r in result.runs if r.rate > result.rate})
    lines = []
    if raised:
        rates = " or ".join(f"{r:g}" for r in raised)
        lines.append(
            f"* at {result.rate:g} samples a second this loop chatters: the damping is too strong for the lighter"
            f" plant; simulated at {rates}, as good as continuous"
        )
    return lines + [f"no run of {r.controller}, {r.model} on {r.plant}: {r.fault}" for r in result.runs if r.fault]
