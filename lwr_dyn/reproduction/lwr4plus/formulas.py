"""Formulas of the numbers that the LWR 4+ paper prints, by the names that its `results.toml` gives them.

Table VII is the PD controller in the paper's form. Table VIII is the inverse-dynamics controller with ddq_d = 0 and,
by hypothesis, without gravity in n(q, dq): its errors are then the droop B^-1 g / omega_n^2, which is what is printed.
The printed unit is mm; the numbers are read as mrad (mrad/s).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper, dh_rows
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.kinematics.arm_geometry import require_srs
from lwr_dyn.kinematics.solution import BRANCHES, joint_ranges
from lwr_dyn.kinematics.srs import closed_form
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, with_bodies
from lwr_dyn.model.printed_number import agrees
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.case import COMPUTED, REPEATED, SHARED, PaperCase, formulas
from lwr_dyn.reproduction.compare import NEAR
from lwr_dyn.reproduction.lwr4plus import TIMINGS
from lwr_dyn.reproduction.lwr4plus.worst_cases import at_printed, largest, shell_asymmetry
from lwr_dyn.reproduction.papers import ResultBlock, printed_tables
from lwr_dyn.simulation.metrics import metrics, stop_contacts
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.trajectory.references.ist import POINTS, ist_path, ist_reference, timed_ist
from lwr_dyn.trajectory.references.pose_path_reference import FixedArmAngle, PosePathReference

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

    def counts(self) -> dict[str, int]:
        """Cells reproduced, near and not near."""
        words = [cell.verdict.split(",")[0] for cell in self.cells]
        return {word: words.count(word) for word in ("reproduced", "near", "not near")}

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        own = {"timing": self.timing, "arm_angle": self.arm_angle, "distance": self.distance, "stops": self.stops}
        return own | {"margin": self.reference.margin, "cells": [cell.record() for cell in self.cells]}


def error_table(arm: Arm, name: str, timing: str, arm_angle: FixedArmAngle | None = None) -> ErrorTable:
    """Table VII ("table_vii") or VIII ("table_viii") under a timing and an arm angle.

    With `arm_angle` given, position limits are not enforced: the authors' simulation is not known to have kept them.
    """
    kept = arm_angle is None
    reference = shared_ist(arm, timing) if kept else ist_reference(arm, timing, arm_angle=arm_angle, limits=False)
    angle = LARGEST_MARGIN
    if arm_angle is not None:
        angle = f"{math.degrees(arm_angle.psi):.0f} deg, branch {arm_angle.branch.label} (fitted to Table VIII)"
    tables = printed_tables("lwr4plus")
    if name == "table_vii":
        controller = make_controller("pd-gravity", arm, inertia=tuple(map(float, tables["table_iv"]["b"])))
    else:
        controller = make_controller("inverse-dynamics", arm, feedforward=False, gravity=False)
    run = simulate(arm, controller, reference, position_limits=kept, meta={"task": "ist", "table": name})
    figures, printed = metrics(run, arm).position_mrad, tables[name]
    ranges = [float(most) - float(least) for most, least in zip(printed["maximum"], printed["minimum"], strict=True)]
    cells = tuple(
        ErrorCell(i, column, printed[column][i], float(getattr(figures, figure)[i]), ranges[i])
        for i in range(arm.n)
        for column, figure in COLUMNS.items()
    )
    return ErrorTable(name, timing, angle, cells, run, reference)


@lru_cache(maxsize=8)
def shared_ist(arm: Arm, timing: str) -> PosePathReference:
    """IST with the arm angle of the largest margin, one for all tables and runs: its motion too is sampled once."""
    return ist_reference(arm, timing)


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


def velocity_rows(table: ErrorTable, arm: Arm) -> dict[str, float]:
    """Two readings of Table VIII's velocity block, and how far each is from the run: RMS of misses over row ranges.

    From row 2 on, the first two of the three cells can be a maximum and a minimum. Either they are those of the
    row's own joint, or of the joint before: the block one row too low. The paper's own text decides the same
    question: joints 2, 4 and 3 "showed the highest errors".
    """
    printed = printed_tables("lwr4plus")["table_viii"]
    figures = metrics(table.run, arm).velocity_mrad_s
    computed = np.array([figures.max, figures.min]).T
    average, most, least = (printed[f"velocity_{column}"] for column in COLUMNS)
    cells = np.array([*zip(average[1:6], most[1:6], strict=True), (most[6], least[6])], dtype=np.float64)
    ranges = (cells[:, 0] - cells[:, 1])[:, None]
    readings = {"rows as numbered": computed[1:7], "one row too low": computed[0:6]}
    return {name: float(np.sqrt((((rows - cells) / ranges) ** 2).mean())) for name, rows in readings.items()}


def nearest_table(arm: Arm, name: str) -> ErrorTable:
    """The table under the timing that comes nearest to the printed one, with the arm angle of the largest margin."""
    return min((error_table(arm, name, timing) for timing in TIMINGS), key=lambda t: t.distance)


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
        [(t.timing, "; ".join(filter(None, (t.arm_angle, t.stops))), t.distance, *t.counts().values()) for t in ranked],
        f"nearest: {nearest.timing} timing, arm angle: {nearest.arm_angle}",
    )
    numbers = (Heading("recomputed", format=".3g"), Heading("of row range", format="+.0%"))
    rows = [(f"J{c.joint + 1} {c.column}", c.printed, c.value, c.miss, c.verdict) for c in nearest.cells]
    return conditions, Table("", ("cell", "printed", *numbers, "verdict"), rows)


def rotor_inertia(_: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """I_m = 1/2 m r^2 [kg m^2]"""
    return {"I_m": [0.5 * block.printed["m"] * block.printed["r"] ** 2]}


def vectors_between_origins(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """r_{i-1,i} in frame i = (a_i, d_i sin alpha_i, d_i cos alpha_i) [m]"""
    return {"r": _origins(case).tolist()}


def _origins(case: PaperCase) -> Array:
    return np.array([[r.a, r.d * np.sin(r.alpha), r.d * np.cos(r.alpha)] for r in dh_rows(case.geometry)])


def origin_miss(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """|r_{i-1,i} of Table II - (a_i, d_i sin alpha_i, d_i cos alpha_i)| [m]"""
    return {"miss": np.linalg.norm(case.geometry.columns["frames.origin"].si() - _origins(case), axis=1)}


def last_index(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """n + 1: the index at which the backward recursion begins"""
    return {"index": [case.n + 1]}


def sizes(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Sizes of B(q), C(q, dq) in C dq, and g(q) as computed"""
    chain = arm_from_paper(case.geometry).chain
    body, state = Body(1.0, np.zeros(3), np.eye(3)), np.full(case.n, 0.1)
    recursion = Recursion.of(with_bodies(chain, [body] * case.n))
    B, C = recursion.mass_matrix(state), recursion.coriolis_matrix(state, state)
    g = recursion.gravity_vector(state)[:, None]
    return {"B": B.shape, "C": C.shape, "g": g.shape}


def worst_case_inertia(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """max over the joint box of B_ii(q) + k_r^2 I_m [kg m^2]"""
    case.arm.require_dynamics()
    return {"b": [largest(case.arm, i, case.from_known_maxima) for i in range(case.arm.n)]}


def inertia_at_printed_q(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """B_ii(q) + k_r^2 I_m at the printed q, signs tried, any joint printed as "-" moved [kg m^2]"""
    case.arm.require_dynamics()
    spans = [at_printed(case.arm, i, q) for i, q in enumerate(block.printed["q"])]
    return {"at_least": [least for least, _ in spans], "at_most": [most for _, most in spans]}


def semicircle_centres(_: PaperCase, __: ResultBlock) -> dict[str, Any]:
    """p_3 + (p_6 - p_3)/4 and p_3 + 3 (p_6 - p_3)/4 [m]"""
    p = POINTS.si()
    return {"point_4": p[2] + (p[5] - p[2]) / 4, "point_5": p[2] + 3 * (p[5] - p[2]) / 4}


def gains(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """K_P = omega_n^2 b, K_D = 2 xi omega_n b with the printed b of Table IV"""
    computed = second_order_gains(case.numbers("table_iv", "b"), block.printed["omega_n"], block.printed["xi"])
    return {"Kp": computed.Kp, "Kd": computed.Kd}


def outer_gains(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """omega_n^2 and 2 xi omega_n"""
    omega, xi = (case.block("table_vi").printed[name] for name in ("omega_n", "xi"))
    return {"Kp": np.full(case.n, omega**2), "Kd": np.full(case.n, 2 * xi * omega)}


def largest_errors(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Maxima of joints 2 and 4 in Table VII, in m as the paper reads them"""
    maxima = case.numbers("table_vii", "maximum")
    return {"maximum": [maxima[1] / 1e3, maxima[3] / 1e3]}


def joints_of_largest_maximum(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """The two joints with the largest maximum of Table VII, in their order"""
    return {"joint": _largest(case.numbers("table_vii", "maximum"), 2)}


def joints_of_largest_average(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """The two joints with the largest average position error of Table VIII, in their order"""
    return {"joint": _largest(case.numbers("table_viii", "average"), 2)}


def joints_of_largest_velocity(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """The three joints with the largest velocity error in Table VIII, by the size of any of the row's three cells"""
    sizes = np.abs([case.numbers("table_viii", f"velocity_{column}") for column in COLUMNS]).max(axis=0)
    if "table8-velocity-rows" in case.applied:
        sizes = sizes[1:]  # the block stands one row too low
    return {"joint": _largest(sizes, 3)}


def _largest(values: Any, count: int) -> list[int]:
    return sorted(int(i) + 1 for i in np.argsort(-np.asarray(values))[:count])


def table_vii(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Errors of PD with gravity compensation on IST, of the assumed timings the nearest [mrad]"""
    return error_columns(nearest_table(case.arm, "table_vii"))


def table_viii(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Errors of inverse dynamics without feed-forward and without g in n, the nearest timing [mrad, mrad/s]"""
    return error_columns(nearest_table(case.arm, "table_viii"))


def error_columns(table: ErrorTable) -> dict[str, Any]:
    """The columns of Table VII or VIII from one computed under some conditions [mrad, mrad/s]."""
    columns: dict[str, Any] = {c: [cell.value for cell in table.cells if cell.column == c] for c in COLUMNS}
    if table.name == "table_vii":
        return columns
    figures = metrics(table.run, table.reference.arm).velocity_mrad_s
    return columns | {f"velocity_{column}": getattr(figures, figure) for column, figure in COLUMNS.items()}


def shell_spread(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Largest spread of the principal moments of links 1 to 4 over their mean"""
    case.arm.require_dynamics()
    return {"spread": [shell_asymmetry(case.arm)]}


def ist_length(_: PaperCase, __: ResultBlock) -> dict[str, Any]:
    """Length of 1-2-3, two semicircles, 6-7-8-9 [m]"""
    return {"length": [ist_path().length]}


def ist_speed(_: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Length over duration [m/s]"""
    return {"speed": [ist_path().length / block.printed["duration"]]}


def ist_margin(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """min over the path of the distance to a joint limit, at the best arm angle [deg]"""
    return {"margin": [np.degrees(ist_reference(case.arm, "smooth").margin)]}


FORMULAS = (
    SHARED
    | formulas(
        rotor_inertia, vectors_between_origins, origin_miss, last_index, sizes, worst_case_inertia, gains, outer_gains,
        largest_errors, shell_spread,
    )
    | formulas(  # places in Tables VII and VIII
        joints_of_largest_maximum, joints_of_largest_average, joints_of_largest_velocity, basis=REPEATED,
    )
    | formulas(semicircle_centres, ist_length, ist_speed, basis=COMPUTED)  # Table V stands in trajectory.references.ist
    | formulas(inertia_at_printed_q, slow=True, basis=REPEATED)  # the numbers of Table IV once more
    | formulas(ist_margin, slow=True, basis=COMPUTED)  # searched
    | formulas(table_vii, table_viii, slow=True)  # under assumed conditions
)  # fmt: skip
