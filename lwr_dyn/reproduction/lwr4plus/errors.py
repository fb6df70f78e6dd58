"""Tables VII and VIII of the LWR 4+ paper: both controllers on IST, under each timing and arm angle considered.

Table VII is the PD controller in the paper's form. Table VIII is the inverse-dynamics controller with ddq_d = 0 and,
by hypothesis, without gravity in n(q, dq): its errors are then the droop B^-1 g / omega_n^2, which is what is printed.
The printed unit is mm; the numbers are read as mrad (mrad/s).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from lwr_dyn.control.controllers import make_controller
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.kinematics.arm_geometry import require_srs
from lwr_dyn.kinematics.branches import BRANCHES, joint_ranges
from lwr_dyn.kinematics.srs import closed_form
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.printed_number import agrees
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.compare import NEAR
from lwr_dyn.reproduction.lwr4plus import TIMINGS
from lwr_dyn.reproduction.results import printed_tables
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.simulation.stop_contacts import stop_contacts
from lwr_dyn.trajectory.references.arm_angles import FixedArmAngle
from lwr_dyn.trajectory.references.ist import ist_reference, timed_ist
from lwr_dyn.trajectory.references.pose_path_reference import PosePathReference

FIT_STEPS_DEG = (5, 1)
"""Coarse and fine grid of constant arm angles that `fitted_arm_angle` looks at."""
LARGEST_MARGIN = "largest joint-limit margin"
"""How the arm angle is chosen that is not fitted."""
OMEGA_N = 50.0
"""[rad/s] Of both controllers, printed."""
COLUMNS = {"average": "mean_abs", "maximum": "max", "minimum": "min"}


@dataclass(frozen=True, slots=True)
class ErrorCell:
    """One printed error beside the computed one, [mrad]."""

    joint: int
    column: str
    printed: str
    value: float
    row_range: float
    """Printed maximum minus minimum of the row."""

    @property
    def miss(self) -> float:
        """Computed minus printed, over the range of the row."""
        return (self.value - float(self.printed)) / self.row_range

    @property
    def verdict(self) -> str:
        """Reproduced, near or not, and by how much; conditions are assumed, so that nothing here "differs"."""
        if agrees(self.printed, self.value):
            return "reproduced"
        near = "near" if abs(self.miss) <= NEAR else "not near"
        return f"{near}, by {self.value - float(self.printed):+.2g}"

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        shown = {"joint": self.joint + 1, "column": self.column, "printed": self.printed, "value": self.value}
        return shown | {"miss_of_row_range": self.miss, "verdict": self.verdict}


@dataclass(frozen=True, slots=True, eq=False)
class ErrorTable:
    """A table under one set of conditions."""

    name: str
    timing: str
    arm_angle: str
    cells: tuple[ErrorCell, ...]
    run: Run
    reference: PosePathReference

    @property
    def distance(self) -> float:
        """RMS of the misses over all cells: how near these conditions come."""
        return float(np.sqrt(np.mean([cell.miss**2 for cell in self.cells])))

    @property
    def stops(self) -> str:
        """Joints that met their stops in the run, in words; empty if none did."""
        return stop_contacts(self.run, self.reference.arm).sentence()

    @property
    def where(self) -> str:
        """The arm angle, and the stops that joints met."""
        return "; ".join(text for text in (self.arm_angle, self.stops) if text)

    def counts(self) -> dict[str, int]:
        """Cells reproduced, near and not near."""
        words = [cell.verdict.split(",")[0] for cell in self.cells]
        return {word: words.count(word) for word in ("reproduced", "near", "not near")}

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        conditions = {"timing": self.timing, "arm_angle": self.arm_angle, "distance": self.distance}
        conditions["stops"] = self.stops
        return conditions | {"margin": self.reference.margin, "cells": [cell.record() for cell in self.cells]}


def error_table(arm: Arm, name: str, timing: str, arm_angle: FixedArmAngle | None = None) -> ErrorTable:
    """Table VII ("table_vii") or VIII ("table_viii") under a timing and an arm angle.

    With `arm_angle` given, position limits are not enforced: the authors' simulation is not known to have kept them.
    """
    kept = arm_angle is None
    reference = ist_reference(arm, timing, arm_angle=arm_angle, limits=kept)
    angle = LARGEST_MARGIN if arm_angle is None else _fitted(arm_angle)
    if name == "table_vii":
        controller = make_controller("pd-gravity", arm, inertia=_printed_b())
    else:
        controller = make_controller("inverse-dynamics", arm, feedforward=False, gravity=False)
    run = simulate(arm, controller, reference, position_limits=kept, meta={"task": "ist", "table": name})
    figures, printed = metrics(run, arm).position_mrad, printed_tables("lwr4plus")[name]
    cells = []
    for i in range(arm.n):
        row_range = float(printed["maximum"][i]) - float(printed["minimum"][i])
        for column, figure in COLUMNS.items():
            value = float(getattr(figures, figure)[i])
            cells.append(ErrorCell(i, column, printed[column][i], value, row_range))
    return ErrorTable(name, timing, angle, tuple(cells), run, reference)


def fitted_arm_angle(arm: Arm) -> FixedArmAngle:
    """The constant arm angle and branch whose droop B^-1 g / omega_n^2 along IST comes nearest to Table VIII.

    This is a fit to a printed result, never the default; it may leave the position limits.
    """
    printed = printed_tables("lwr4plus")["table_viii"]
    wanted = np.array([[float(x) for x in printed[column]] for column in COLUMNS]).T
    ranges = (wanted[:, 1] - wanted[:, 2])[:, None]
    recursion, geometry, joints = Recursion.of(arm.chain), require_srs(arm), joint_ranges(arm)
    T = timed_ist("smooth").at(np.linspace(0.0, 14.0, 141)).T

    def distance(candidate: FixedArmAngle) -> float:
        q = closed_form(geometry, joints, T, np.full(len(T), candidate.psi), candidate.branch)
        B, g = recursion.mass_matrix(q), recursion.gravity_vector(q)
        droop = 1e3 * np.linalg.solve(B, g[..., None])[..., 0] / OMEGA_N**2
        # the run starts without droop, so zero is among its values
        errors = np.array([np.abs(droop).mean(0), droop.max(0).clip(min=0), droop.min(0).clip(max=0)]).T
        return float((((errors - wanted) / ranges) ** 2).mean())

    coarse = [FixedArmAngle(math.radians(d), branch) for branch in BRANCHES for d in range(-180, 180, FIT_STEPS_DEG[0])]
    best = min(coarse, key=distance)
    middle, (wide, narrow) = math.degrees(best.psi), FIT_STEPS_DEG
    fine = [FixedArmAngle(math.radians(middle + d), best.branch) for d in range(-wide, wide + 1, narrow)]
    return min(fine, key=distance)


def _fitted(angle: FixedArmAngle) -> str:
    return f"{math.degrees(angle.psi):.0f} deg, branch {angle.branch.label} (fitted to Table VIII)"


def velocity_rows(table: ErrorTable, arm: Arm) -> dict[str, float]:
    """Two readings of Table VIII's velocity block, and how far each is from the run: RMS of misses over row ranges.

    From row 2 on, the first two of the three cells can be a maximum and a minimum. Either they are those of the
    row's own joint, or of the joint before: the block one row too low. The paper's own text decides the same
    question: joints 2, 4 and 3 "showed the highest errors".
    """
    printed = printed_tables("lwr4plus")["table_viii"]
    figures = metrics(table.run, arm).velocity_mrad_s
    computed = np.array([figures.max, figures.min]).T
    pairs = zip(printed["velocity_average"][1:6], printed["velocity_maximum"][1:6], strict=True)
    last = printed["velocity_maximum"][6], printed["velocity_minimum"][6]
    cells = np.array([[float(a), float(b)] for a, b in (*pairs, last)])
    ranges = (cells[:, 0] - cells[:, 1])[:, None]
    readings = {"rows as numbered": computed[1:7], "one row too low": computed[0:6]}
    return {name: float(np.sqrt((((rows - cells) / ranges) ** 2).mean())) for name, rows in readings.items()}


def velocity_columns_of(table: ErrorTable, arm: Arm) -> dict[str, Array]:
    """Velocity errors of a run by the columns of Table VIII, (n,) each [mrad/s]."""
    figures = metrics(table.run, arm).velocity_mrad_s
    return {f"velocity_{column}": getattr(figures, figure) for column, figure in COLUMNS.items()}


def nearest_table(arm: Arm, name: str) -> ErrorTable:
    """The table under the timing that comes nearest to the printed one, with the arm angle of the largest margin."""
    return min((error_table(arm, name, timing) for timing in TIMINGS), key=lambda t: t.distance)


@cache
def _printed_b() -> tuple[float, ...]:
    return tuple(float(x) for x in printed_tables("lwr4plus")["table_iv"]["b"])


TITLES = {
    "table_vii": "Table VII, PD with gravity compensation",
    "table_viii": "Table VIII, inverse dynamics (hypothesis: no feed-forward, no gravity in n)",
}


def condition_tables(tables: Sequence[ErrorTable]) -> tuple[Table, Table]:
    """The conditions tried for one table, nearest first, and the nearest one cell by cell."""
    ranked = sorted(tables, key=lambda t: t.distance)
    nearest = ranked[0]
    miss = Heading("RMS miss / row range", format=".3f")
    conditions = Table(
        f"{TITLES[nearest.name]}: position errors, printed in mm, read as mrad",
        ("timing (assumed)", "arm angle", miss, "reproduced", f"near ({NEAR:.0%})", "not near"),
        [(t.timing, t.where, t.distance, *t.counts().values()) for t in ranked],
        f"nearest: {nearest.timing} timing, arm angle: {nearest.arm_angle}",
    )
    numbers = (Heading("recomputed", format=".3g"), Heading("of row range", format="+.0%"))
    rows = [(f"J{c.joint + 1} {c.column}", c.printed, c.value, c.miss, c.verdict) for c in nearest.cells]
    return conditions, Table("", ("cell", "printed", *numbers, "verdict"), rows)
