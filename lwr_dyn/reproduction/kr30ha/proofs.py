"""Proofs of the errata in the KR 30 HA report's frames, axes and matrices."""

import math

import numpy as np

from lwr_dyn.arms.papers.assembly import dh_rows
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.printed_number import agrees
from lwr_dyn.model.spatial import rot_x, rot_z
from lwr_dyn.reproduction.case import PaperCase, PaperData
from lwr_dyn.reproduction.kr30ha.formulas import envelope, pose_misses, symbolic_matrices
from lwr_dyn.reproduction.kr30ha.points import wrist_centre_mm
from lwr_dyn.reproduction.kr30ha.proofs_of_motion import MOTION
from lwr_dyn.reproduction.kr30ha.proofs_of_points import POINTS
from lwr_dyn.reproduction.kr30ha.proofs_of_program import PROGRAM
from lwr_dyn.reproduction.ledger import Proof, Prove

OFFSET, HALF_TURN, SIGNS = "table2-offset", "table2-half-turn", "kuka-signs"


def table2_offset(data: PaperData) -> Proof:
    """The wrist centre at mastering with the offset on theta_2 and on theta_3, against the report's own home."""
    home = np.array(data.case().numbers("home_position", "table_4"))
    as_printed, as_read = (
        _mastering_wrist(data.case(*ids)) for ids in ((HALF_TURN, SIGNS), (OFFSET, HALF_TURN, SIGNS))
    )
    misses = [float(np.linalg.norm(place - home)) for place in (as_printed, as_read)]
    return Proof(
        "with KUKA's axes at mastering the wrist stands where Table 4 has home only if the 90 deg belong to theta_3",
        misses[1] < 1e-6 and misses[0] > 500.0,
        {"missed as printed [mm]": misses[0], "as read [mm]": misses[1]},
    )


def _mastering_wrist(case: PaperCase) -> Array:
    return wrist_centre_mm(case.arm, np.array(case.arm.mastering))


def half_turn(data: PaperData) -> Proof:
    """T_TCP^5: the symbolic matrix against theta_6 + 180 deg; KUKA's A, B, C of the flange at zero."""
    differing = [_differing(data.case(*ids), ("A6",)) for ids in ((), (HALF_TURN,))]
    numeric = np.array(data.case().printed["numeric"]["T6"], dtype=float)[:3, :3]
    turns = [
        float(pose_misses(c, c.block("pose_misses"))["turn"][0]) for c in (data.case(OFFSET, SIGNS), data.reading())
    ]
    return Proof(
        "the symbolic T_TCP^5 is that of theta_6 + 180 deg and the numeric one that of theta_6; the flange at zero is"
        " turned as KUKA's only with it",
        differing == [4, 0] and np.array_equal(numeric, np.eye(3)) and turns[0] > 1.0 and turns[1] < 1e-9,
        {"symbolic entries that differ without": differing[0], "with": differing[1],
         "turn missed without": turns[0], "turn missed with": turns[1]},
    )  # fmt: skip


def _differing(case: PaperCase, names: tuple[str, ...]) -> int:
    """How many entries of printed symbolic matrices are not those of Table 2."""
    matrices = symbolic_matrices(case, case.block("symbolic"))
    return sum(not entry.same for name in names for row in matrices[name] for entry in row)


def kuka_signs(data: PaperData) -> Proof:
    """Axes at zero and the volume of the envelope with theta_i = A_i and theta_i = -A_i."""
    plus, minus = data.case(OFFSET, HALF_TURN), data.reading()
    axes = [float(np.max(pose_misses(c, c.block("pose_misses"))["axis"])) for c in (plus, minus)]
    volumes = [envelope(c, c.block("appendix_a"))["volume"][0] for c in (plus, minus)]
    sheet = data.case().printed["appendix_a"]["volume"][0]
    return Proof(
        "with theta_i = -A_i axes turn as KUKA's do and the ranges of Appendix A sweep its volume; with a plus neither",
        axes[0] > 1.0 and axes[1] < 1e-6 and agrees(sheet, volumes[1]) and not agrees(sheet, volumes[0]),
        {"volume with plus [m^3]": volumes[0], "with minus [m^3]": volumes[1], "Appendix A": sheet},
    )


def symbolic_signs(data: PaperData) -> Proof:
    """Symbolic A_1, A_3, A_4, A_5 against equation (1) with Table 2, entry by entry."""
    names = ("A1", "A3", "A4", "A5")
    counts = [_differing(data.case(*ids), names) for ids in ((), ("symbolic-signs",))]
    return Proof("twelve entries have the sign of the other twist; so read all are equation (1)", counts == [12, 0],
                 {"entries that differ as printed": counts[0], "as read": counts[1]})  # fmt: skip


def symbolic_a2(data: PaperData) -> Proof:
    """Symbolic T_2^1 against equation (1) at theta_2 + 90 deg, at 90 deg - theta_2, and as read."""
    counts = [_differing(data.case(*ids), ("A2",)) for ids in ((), ("symbolic-a2",))]
    printed = data.case().printed["symbolic"]["A2"]
    theta = 0.4
    values = {"S2": math.sin(theta), "C2": math.cos(theta)}
    turned = rot_z(math.pi / 2 - theta)[:2, :2]
    rotation = np.array([[_number(printed[r][c], values) for c in range(2)] for r in range(2)])
    return Proof(
        "three entries differ from theta_2 + 90 deg; the printed rotation is that of 90 deg - theta_2",
        counts == [3, 0] and float(np.abs(rotation - turned).max()) < 1e-12,
        {"entries that differ as printed": counts[0], "as read": counts[1]},
    )


def _number(text: str, values: dict[str, float]) -> float:
    return -values[text[1:]] if text.startswith("-") else values[text]


def composition_order(data: PaperData) -> Proof:
    """T_1^0 as Trans x Trans z Rot x Rot z and as Rot z Trans z Trans x Rot x, against equation (1)."""
    row, theta = dh_rows(data.case().geometry)[0], 0.4
    c, s, ca, sa = math.cos(theta), math.sin(theta), math.cos(row.alpha), math.sin(row.alpha)
    equation = np.array(
        [[c, -s * ca, s * sa, row.a * c], [s, c * ca, -c * sa, row.a * s], [0, sa, ca, row.d], [0, 0, 0, 1]]
    )
    parts = [_moved(row.a, 0.0), _moved(0.0, row.d), _turned(rot_x(row.alpha)), _turned(rot_z(theta))]
    printed = np.linalg.multi_dot(parts)
    read = np.linalg.multi_dot([parts[3], parts[1], parts[0], parts[2]])
    misses = [float(np.abs(product - equation).max()) for product in (printed, read)]
    return Proof("only Rot z, Trans z, Trans x, Rot x is equation (1)", misses[0] > 0.1 and misses[1] < 1e-12,
                 {"largest difference as printed": misses[0], "as read": misses[1]})  # fmt: skip


def _moved(x: float, z: float) -> Array:
    out = np.eye(4)
    out[0, 3], out[2, 3] = x, z
    return out


def _turned(rotation: Array) -> Array:
    out = np.eye(4)
    out[:3, :3] = rotation
    return out


def mastering_transform(data: PaperData) -> Proof:
    """The flange at A = 0 and at mastering, against the printed T_TCP^0."""
    case = data.reading()
    printed = np.array(case.numbers("mastering_flange", "position"))
    at = [1e3 * flange_pose(case.arm.chain, q)[:3, 3] for q in (np.zeros(6), np.array(case.arm.mastering))]
    misses = [float(np.linalg.norm(place - printed)) for place in at]
    return Proof("the printed transform is that of A = 0", misses[0] < 1e-6 and misses[1] > 1000.0,
                 {"missed at A = 0 [mm]": misses[0], "missed at mastering [mm]": misses[1]})  # fmt: skip


PROOFS: dict[str, Prove] = {
    "table2-offset": table2_offset,
    "table2-half-turn": half_turn,
    "kuka-signs": kuka_signs,
    "symbolic-signs": symbolic_signs,
    "symbolic-a2": symbolic_a2,
    "composition-order": composition_order,
    "mastering-transform": mastering_transform,
    **POINTS,
    **MOTION,
    **PROGRAM,
}
