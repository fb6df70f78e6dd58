"""Proofs of the errata in the WAM paper and in the data sheets that it builds on."""

import numpy as np

from lwr_dyn.reproduction.case import PaperCase, PaperData
from lwr_dyn.reproduction.ledger import Proof, Prove
from lwr_dyn.reproduction.wam7.formulas import figure_4, sheet_tensors

SHEET = 1e-6
"""[kg m^2] The sheet's two tables differ in the last digits that the coarser one prints."""


def products_sign(data: PaperData) -> Proof:
    """The sheet's own tensors about the frame origins against the parallel-axis theorem, with both signs."""
    as_tensor, as_integral = (_misses(data.case(*ids)) for ids in ((), ("products-sign",)))
    return Proof(
        "the sheet's tensors about the origins follow from the products negated, and not from the products as printed",
        as_integral < SHEET and as_tensor > 50 * SHEET,
        {"largest miss, negated [kg m^2]": as_integral, "as printed [kg m^2]": as_tensor},
    )


def _misses(case: PaperCase) -> float:
    block = case.block("sheet_tensors")
    tensors = sheet_tensors(case, block)
    return float(max(np.abs(np.subtract(tensors[name], case.numbers(block.name, name))).max() for name in tensors))


def home_outside(data: PaperData) -> Proof:
    """libbarrett's home against the manual's limits."""
    case = data.reading()
    home = np.array(case.block("home").printed["q"], dtype=float)
    over = np.maximum(home - case.arm.upper, case.arm.lower - home)
    outside = [i + 1 for i in range(case.n) if over[i] > 0.0]
    return Proof("of home's joints this one stands outside its limits", outside == [4],
                 {"joint": str(outside), "by [rad]": float(over.max())})  # fmt: skip


def lspb_velocity(data: PaperData) -> Proof:
    """Equation (2) with velocity and acceleration of (3) and (4), for t_c = 1 s and 2 s: its jump at t_c."""
    case = data.case()
    travel = case.numbers("motion", "travel")[0]
    t_f = float(case.block("motion").printed["duration"])
    printed = [_jump(travel, t_f, t_c, as_printed=True) for t_c in (1.0, 2.0)]
    right = [_jump(travel, t_f, t_c, as_printed=False) for t_c in (1.0, 2.0)]
    return Proof(
        "equation (2) is continuous with (3) as the acceleration for any t_c; as the velocity for t_c = 1 s alone",
        printed[0] < 1e-12 and max(right) < 1e-12 and printed[1] > 0.05,
        {"jump at t_c = 2 s as printed [rad]": printed[1], "as read [rad]": right[1]},
    )


def _jump(travel: float, t_f: float, t_c: float, as_printed: bool) -> float:
    """|q(t_c+) - q(t_c-)| of equation (2) [rad]."""
    value = 4 * travel / (t_f**2 - (2 * (t_c - 0.5 * t_f)) ** 2)
    speed, acceleration = (value, value) if as_printed else (value * t_c, value)
    before = 0.5 * acceleration * t_c**2
    after = 0.5 * (travel - speed * t_f) + speed * t_c
    return abs(after - before)


def figure4_signs(data: PaperData) -> Proof:
    """The caption's motion against the axes of its own figure, with the printed signs and with minus before both."""
    inside = []
    for case in (data.case(), data.case("figure4-acceleration")):
        curves = figure_4(case, case.block("figure_4"))
        cells = case.block("figure_4").cells
        spans = {cell.column: cell.span for cell in cells if cell.span is not None}
        within = [float(low) <= x <= float(up) for name, (low, up) in spans.items() for x in curves[name]]
        inside.append(sum(within))
    return Proof(
        "with minus signs before q_i and q_f position, velocity and acceleration stay within the figure's axes; as"
        " printed position and velocity leave them",
        inside[1] == 6 and inside[0] < 4,
        {"ends within the axes as printed, of six": inside[0], "as read": inside[1]},
    )


PROOFS: dict[str, Prove] = {
    "products-sign": products_sign,
    "home-outside": home_outside,
    "lspb-velocity": lspb_velocity,
    "figure4-acceleration": figure4_signs,
}
