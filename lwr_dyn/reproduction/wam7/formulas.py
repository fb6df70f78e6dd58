"""Formulas of the numbers that the WAM paper prints, by the names that its `results.toml` gives them."""

from typing import Any

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.arm import JointGains
from lwr_dyn.model.friction import FRICTIONLESS
from lwr_dyn.reproduction.case import (
    COMPUTED,
    CONTRADICTION,
    REPEATED,
    SHARED,
    PaperCase,
    PaperData,
    Proof,
    Prove,
    formulas,
)
from lwr_dyn.reproduction.papers import ResultBlock
from lwr_dyn.reproduction.wam7.runs import cruise_error, experiment, sides_of
from lwr_dyn.trajectory.motion_profile import lspb

DIRECTIONS = {"positive": 1, "negative": -1}


def joints(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Number of joints"""
    return {"count": [case.n]}


def simulations(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """One per joint, and one with all"""
    return {"count": [case.n + 1]}


def motion(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """|q_f - q_i| of Figure 4, and its speed (q_f - q_i)/(t_f - t_c)"""
    caption = case.block("caption_4").printed
    travel = abs(float(caption["q_f"]) - float(caption["q_i"]))
    cruise = float(block.printed["duration"]) - float(block.printed["blend"])
    return {"travel": [travel], "velocity": [travel / cruise]}


def printed_velocity(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """4 (q_f - q_i)/(t_f^2 - (2 (t_c - 0.5 t_f))^2), and the same as acceleration (eq. 4)"""
    t_f, t_c = (float(case.block("motion").printed[name]) for name in ("duration", "blend"))
    value = 4 * case.numbers("motion", "travel")[0] / (t_f**2 - (2 * (t_c - 0.5 * t_f)) ** 2)
    return {"dq_c": [value], "ddq_c": [value]}


def caption_acceleration(_: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """(q_f - q_i)/(t_c (t_f - t_c))"""
    q_i, q_f, t_f, t_c = (float(block.printed[name]) for name in ("q_i", "q_f", "t_f", "t_c"))
    return {"ddq_c": [(q_f - q_i) / (t_c * (t_f - t_c))]}


def caption_motion(case: PaperCase) -> tuple[Array, dict[str, Array]]:
    """Times [s], and q, dq and ddq [rad, rad/s, rad/s^2] of the LSPB that Figure 4's caption describes."""
    q_i, q_f, t_f, t_c = (float(case.block("caption_4").printed[name]) for name in ("q_i", "q_f", "t_f", "t_c"))
    t, sign = np.linspace(0.0, t_f, 701), np.sign(q_f - q_i)
    way = lspb(abs(q_f - q_i), t_f, t_c).at(t)
    return t, {"position": q_i + sign * way.s, "velocity": sign * way.ds, "acceleration": sign * way.dds}


def figure_4(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Least and most of q, dq and ddq of the caption's LSPB"""
    return {name: [curve.min(), curve.max()] for name, curve in caption_motion(case)[1].items()}


def covered(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """-/+ the speed up to which Table 1 was identified"""
    speeds = np.array([model.covered for model in _friction(case)])
    return {"least": -speeds, "most": speeds}


def most_affected(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """The joint with the largest F_c, both directions taken together"""
    return {"joint": [1 + int(np.argmax(_coulomb(case)))]}


def least_influenced(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """The three joints with the smallest F_c, both directions taken together"""
    return {"joints": sorted(1 + int(i) for i in np.argsort(_coulomb(case))[:3])}


def _coulomb(case: PaperCase) -> Any:
    return np.array([m.positive.coulomb + m.negative.coulomb for m in _friction(case)])


def _friction(case: PaperCase) -> list[Any]:
    return [model or FRICTIONLESS for model in case.arm.friction_models()]


def _gains(case: PaperCase) -> JointGains:
    if case.arm.gains is None:
        raise MissingDataError(case.arm.name, "gains", "cruise errors")
    return case.arm.gains


def cruise_errors(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """tau_friction(v)/kp at v = 0.5/6 rad/s [mrad]"""
    speed, Kp = 0.5 / 6.0, _gains(case).Kp
    errors = np.array([[1e3 * float(m.torque(s * speed)) for m in _friction(case)] for s in DIRECTIONS.values()]) / Kp
    return dict(zip(DIRECTIONS, errors, strict=True))


def cruise_in_figure(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """tau_friction(v)/kp at v = 0.5/6 rad/s, manufacturer's kp [rad]"""
    errors = cruise_errors(case, block)["positive"] / 1e3
    return {name: [errors[int(name[-1]) - 1]] * 2 for name in dict.fromkeys(c.column for c in block.cells)}


def net_damping(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """kd + sigma per direction [N m s/rad]"""
    sides, Kd = sides_of(case.arm), _gains(case).Kd
    return {
        name: [sides[i, sign].net_damping(float(Kd[i])) for i in range(case.n)] for name, sign in DIRECTIONS.items()
    }


def feeds_energy(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Speed from which friction feeds energy in, joint by joint, positive direction first [rad/s]"""
    order = sorted(sides_of(case.arm).items(), key=lambda item: (item[0][0], -item[0][1]))
    return {"speed": [side.from_speed for _, side in order if side.from_speed is not None]}


def friction_at_end(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """F_c sign(v) + sigma v at the end of the maps [N m]"""
    return {name: [float(m.torque(sign * 0.4)) for m in _friction(case)] for name, sign in DIRECTIONS.items()}


def controller(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """kp/ki [s], effort/kp [rad]"""
    gains = _gains(case)
    if gains.Ki is None or gains.effort is None:
        raise MissingDataError(case.arm.name, "ki or effort", "the controller's figures")
    return {"integral_time": gains.Kp / gains.Ki, "error_at_cut": gains.effort / gains.Kp}


def motor_speeds(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """T dq [rad/s]"""
    if case.arm.transmission is None:
        raise MissingDataError(case.arm.name, "a transmission", "motor speeds")
    return {"speed": case.arm.transmission.motor_velocity(np.array(block.printed["dq"], dtype=float))}


def sheet_tensors(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """I_i + m_i S(c_i)^T S(c_i) about the origin of frame i [kg m^2]"""
    tensors = tensors_about_origin(case, block)
    products = {"xy_of_link_1": ("xy", 0), "xy_of_link_3": ("xy", 2), "yz_of_link_6": ("yz", 5)}
    moments = {name: tensors[name] for name in ("xx", "yy", "zz")}
    return moments | {name: [tensors[entry][i]] for name, (entry, i) in products.items()}


def tensors_about_origin(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """I_i + m_i S(c_i)^T S(c_i) about the origin of frame i [kg m^2]"""
    tensors = np.array([body.inertia_origin() for body in case.bodies])
    pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    return {name: tensors[:, r, c] for name, (r, c) in pairs.items()}


def home_excess(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """How far home stands outside the limits, at most [rad]"""
    home = np.array(block.printed["q"], dtype=float)
    return {"excess": [np.maximum(home - case.arm.upper, case.arm.lower - home).max()]}


def settled_errors(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Mean of q_ref - q over the second half of the simulated cruise [mrad]"""
    moved = (i for i in range(case.n) if i != 3)
    return {"error": [1e3 * cruise_error(case.arm, experiment(case.arm, i)).mean for i in moved]}


FORMULAS = (
    SHARED
    | formulas(
        joints, simulations, motion, printed_velocity, caption_acceleration, figure_4, covered, cruise_errors,
        cruise_in_figure, net_damping, feeds_energy, friction_at_end, controller,
        motor_speeds, sheet_tensors, tensors_about_origin, home_excess,
    )
    | formulas(most_affected, least_influenced, basis=REPEATED)  # places in Table 1
    | formulas(settled_errors, slow=True, basis=COMPUTED)  # simulated
)  # fmt: skip

SHEET = 1e-6
"""[kg m^2] The sheet's two tables differ in the last digits that the coarser one prints."""


def products_sign(data: PaperData) -> Proof:
    """The sheet's own tensors about the frame origins against the parallel-axis theorem, with both signs."""
    misses = []
    for case in (data.case(), data.case("products-sign")):
        tensors = sheet_tensors(case, case.block("sheet_tensors")).items()
        misses.append(max(np.abs(np.subtract(x, case.numbers("sheet_tensors", name))).max() for name, x in tensors))
    as_tensor, as_integral = misses
    return Proof(
        "the sheet's tensors about the origins follow from the products negated, and not from the products as printed",
        as_integral < SHEET and as_tensor > 50 * SHEET,
        {"largest miss, negated [kg m^2]": as_integral, "as printed [kg m^2]": as_tensor},
    )


def home_outside(data: PaperData) -> Proof:
    """libbarrett's home against the manual's limits."""
    case = data.reading()
    home = np.array(case.block("home").printed["q"], dtype=float)
    over = np.maximum(home - case.arm.upper, case.arm.lower - home)
    outside = [i + 1 for i in range(case.n) if over[i] > 0.0]
    return Proof("of home's joints this one stands outside its limits", outside == [4],
                 {"joint": str(outside), "by [rad]": float(over.max())}, CONTRADICTION)  # fmt: skip


def lspb_velocity(data: PaperData) -> Proof:
    """Equation (2) with velocity and acceleration of (3) and (4), for t_c = 1 s and 2 s: its jump at t_c."""
    case = data.case()
    travel = case.numbers("motion", "travel")[0]
    t_f = float(case.block("motion").printed["duration"])

    def jump(t_c: float, as_printed: bool) -> float:
        """|q(t_c+) - q(t_c-)| of equation (2) [rad]."""
        value = 4 * travel / (t_f**2 - (2 * (t_c - 0.5 * t_f)) ** 2)
        speed = value if as_printed else value * t_c
        return abs(0.5 * (travel - speed * t_f) + speed * t_c - 0.5 * value * t_c**2)

    printed, right = ([jump(t_c, as_printed) for t_c in (1.0, 2.0)] for as_printed in (True, False))
    return Proof(
        "equation (2) is continuous with (3) as the acceleration for any t_c; as the velocity for t_c = 1 s alone",
        printed[0] < 1e-12 and max(right) < 1e-12 and printed[1] > 0.05,
        {"jump at t_c = 2 s as printed [rad]": printed[1], "as read [rad]": right[1]},
    )


def figure4_signs(data: PaperData) -> Proof:
    """The caption's motion against the axes of its own figure, with the printed signs and with minus before both."""
    inside = []
    for case in (data.case(), data.case("figure4-acceleration")):
        block = case.block("figure_4")
        spans = {cell.column: cell.span for cell in block.cells if cell.span is not None}
        curves = figure_4(case, block)
        inside.append(sum(float(low) <= x <= float(up) for name, (low, up) in spans.items() for x in curves[name]))
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
