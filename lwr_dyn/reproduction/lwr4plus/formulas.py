"""Formulas of the numbers that the LWR 4+ paper prints, by the names that its `results.toml` gives them."""

from typing import Any

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper, dh_rows
from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Body, with_bodies
from lwr_dyn.reproduction.case import COMPUTED, REPEATED, PaperCase, formulas
from lwr_dyn.reproduction.lwr4plus.cached_maxima import at_printed, largest
from lwr_dyn.reproduction.lwr4plus.errors import COLUMNS, nearest_table, velocity_columns_of
from lwr_dyn.reproduction.lwr4plus.tables import shell_asymmetry
from lwr_dyn.reproduction.quantities import SHARED
from lwr_dyn.reproduction.results import ResultBlock
from lwr_dyn.trajectory.references.ist import POINTS, ist_path, ist_reference


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
    names = ("velocity_average", "velocity_maximum", "velocity_minimum")
    sizes = np.abs([case.numbers("table_viii", name) for name in names]).max(axis=0)
    if "table8-velocity-rows" in case.applied:
        sizes = sizes[1:]  # the block stands one row too low
    return {"joint": _largest(sizes, 3)}


def _largest(values: Any, count: int) -> list[int]:
    return sorted(int(i) + 1 for i in np.argsort(-np.asarray(values))[:count])


def table_vii(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Errors of PD with gravity compensation on IST, of the assumed timings the nearest [mrad]"""
    return _errors(case, "table_vii")


def table_viii(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Errors of inverse dynamics without feed-forward and without g in n, the nearest timing [mrad, mrad/s]"""
    return _errors(case, "table_viii")


def _errors(case: PaperCase, name: str) -> dict[str, Any]:
    return error_columns(nearest_table(case.arm, name), case.arm)


def error_columns(table: Any, arm: Any) -> dict[str, Any]:
    """The columns of Table VII or VIII from one computed under some conditions."""
    columns: dict[str, Any] = {c: [cell.value for cell in table.cells if cell.column == c] for c in COLUMNS}
    return columns if table.name == "table_vii" else columns | velocity_columns_of(table, arm)


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
