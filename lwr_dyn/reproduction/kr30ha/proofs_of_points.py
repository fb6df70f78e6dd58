"""Proofs of the errata in the KR 30 HA report's points, angles and references."""

import math
from functools import partial

import numpy as np

from lwr_dyn.arms.papers.assembly import dh_rows
from lwr_dyn.kinematics.forward import flange_pose, frames
from lwr_dyn.model.printed_number import agrees
from lwr_dyn.reproduction.case import PaperData
from lwr_dyn.reproduction.kr30ha.formulas import simplified_point
from lwr_dyn.reproduction.kr30ha.points import point_misses, right_points, wrist_centre_mm
from lwr_dyn.reproduction.ledger import Proof, Prove


def home_x(data: PaperData) -> Proof:
    """Both printed homes against the wrist centre and the flange at mastering."""
    case = data.reading()
    text, table = (float(case.printed["home_position"][name][0]) for name in ("text", "table_4"))
    wrist = float(wrist_centre_mm(case.arm, np.array(case.arm.mastering))[0])
    flange = float(1e3 * flange_pose(case.arm.chain, np.array(case.arm.mastering))[0, 3])
    return Proof(
        "Table 4's x is the wrist centre's; the text's is neither the wrist centre's nor the flange's",
        agrees(f"{table:.0f}", wrist) and text not in (round(wrist), round(flange)),
        {"wrist centre [mm]": wrist, "flange [mm]": flange, "text": text},
    )


def theta1_offset(data: PaperData) -> Proof:
    """Azimuth of Point 1 with and without the shoulder's offset taken off, and how far beside it the arm turns."""
    case = data.reading()
    x, y, _ = case.block("point_1").printed["xyz"]
    a1 = 1e3 * dh_rows(case.geometry)[0].a
    printed = case.numbers("point_1", "theta_1")[0]
    right, formula = (math.degrees(math.atan2(y, x - shift)) for shift in (0.0, a1))
    beside = abs(x * math.sin(math.radians(printed)) - y * math.cos(math.radians(printed)))
    true = -math.degrees(right_points(case.arm, case.printed)[0].q[0])
    return Proof(
        "the printed angle is that of x - a_1; the arm's plane goes through the point at atan2(y, x), as the true"
        " inverse kinematics has it",
        agrees(case.printed["point_1"]["theta_1"][0], formula) and abs(true - right) < 1e-6 and beside > 100.0,
        {"atan2(y, x) [deg]": right, "atan2(y, x - a1) [deg]": formula, "beside the point [mm]": beside},
    )


def _last_digit(data: PaperData, point: str, column: str, index: int, erratum: str) -> Proof:
    """A printed number against the report's own formula, as printed and as read."""
    texts = [data.case(*ids).printed[point][column][index] for ids in ((), (erratum,))]
    case = data.case()
    value = float(simplified_point(case, case.block(point))[column][index])
    return Proof(
        "the report's own formula gives the number as read and not as printed",
        agrees(texts[1], value) and not agrees(texts[0], value),
        {"formula [deg]": value, "printed": texts[0], "read": texts[1]},
    )


def theta1_p2(data: PaperData) -> Proof:
    """theta_1 of Point 2 by the report's formula against both values that it prints."""
    table = data.case().printed["table_5"]["point_2"][0]
    proof = _last_digit(data, "point_2", "theta_1", 0, "theta1-p2")
    return Proof(proof.statement, proof.holds and not agrees(table, float(proof.numbers["formula [deg]"])),
                 {**proof.numbers, "Table 5": table})  # fmt: skip


def elbow_offset(data: PaperData) -> Proof:
    """Distances between axis 2, axis 3 and the wrist centre in the true arm."""
    case = data.reading()
    T = frames(case.arm.chain, np.zeros(6))
    upper, lower = (1e3 * float(np.linalg.norm(T[b, :3, 3] - T[a, :3, 3])) for a, b in ((0, 1), (1, 4)))
    a2, a3 = (case.numbers("geometry", name)[0] for name in ("a2", "a3"))
    return Proof(
        "the two links are 850 and 832.7 mm long; 995 and 820 mm are another triangle",
        abs(upper - 850.0) < 1e-6
        and abs(lower - math.hypot(145.0, 820.0)) < 1e-6
        and a2 - upper > 1.0
        and lower - a3 > 1.0,
        {"axis 2 to axis 3 [mm]": upper, "axis 3 to wrist [mm]": lower, "printed": f"{a2:g}, {a3:g}"},
    )


def target_frame(data: PaperData) -> Proof:
    """Where the wrist centre stands with the flange at the points, and how far Table 5's angles miss."""
    case = data.reading()
    right = right_points(case.arm, case.printed)[0]
    behind = float(np.linalg.norm(right.wrist_mm - np.array([right.target.x_mm, right.target.y_mm, right.target.z_mm])))
    misses = point_misses(case.arm, case.printed)[0]
    return Proof(
        "flange and wrist centre are 170 mm apart, and Table 5's angles bring neither to the point",
        abs(behind - 170.0) < 1e-6 and min(misses.wrist_miss_mm, misses.flange_miss_mm) > 500.0,
        {"wrist behind the flange [mm]": behind, "wrist misses [mm]": misses.wrist_miss_mm,
         "flange misses [mm]": misses.flange_miss_mm},
    )  # fmt: skip


def references(data: PaperData) -> Proof:
    """Every reference of the text against the caption that it means."""
    block = data.case().printed["references"]
    right = [1 + block[kind].index(title) for kind, title in block["meant"]]
    off = [int(printed) - number for printed, number in zip(block["number"], right, strict=True)]
    return Proof(f"{sum(map(bool, off))} of {len(off)} references are one too high, no other is wrong",
                 set(off) == {0, 1} and sum(off) >= 10, {"off by": str(off)})  # fmt: skip


def link_two(data: PaperData) -> Proof:
    """820 mm in Table 3 and Table 4."""
    case = data.case()
    a2, a3 = (case.numbers("geometry", name)[0] for name in ("a2", "a3"))
    d4 = 1e3 * dh_rows(case.geometry)[3].d
    return Proof("820 mm is d_4 and Table 4's link 3; its link 2 has 995 mm", abs(a3 - d4) < 1e-9 and a2 != a3,
                 {"Table 4, link 2 [mm]": a2, "link 3 [mm]": a3, "d_4 [mm]": d4})  # fmt: skip


POINTS: dict[str, Prove] = {
    "home-x": home_x,
    "theta1-offset": theta1_offset,
    "theta1-p2": theta1_p2,
    "theta3-p1": partial(_last_digit, point="point_1", column="theta_3", index=0, erratum="theta3-p1"),
    "phi-home": partial(_last_digit, point="home", column="phi", index=0, erratum="phi-home"),
    "theta2-home": partial(_last_digit, point="home", column="theta_2", index=0, erratum="theta2-home"),
    "elbow-offset": elbow_offset,
    "target-frame": target_frame,
    "references-off-by-one": references,
    "link-two-820": link_two,
}
