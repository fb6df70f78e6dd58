"""Formulas of the KR 30 HA report's numbers, printed and derived, by the names that its `results.toml` gives them.

Proofs of the errata in the KR 30 HA report's points, angles and references.
"""

import math
from functools import cache, partial
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.assembly import dh_rows
from lwr_dyn.arms.papers.reader import paper_of_tables
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.arms.papers.solids import COM_DIGITS, INERTIA_DIGITS, MASS_DIGITS, solid_bodies
from lwr_dyn.checks.datasheet.envelope import working_envelope
from lwr_dyn.dynamics.symbolic.link_motion import dh_matrices
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.kinematics.forward import flange_pose, frames
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.kinematics.six_joints.spherical_wrist import require_wrist_arm
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, link_frames
from lwr_dyn.model.printed_number import agrees
from lwr_dyn.model.spatial import from_rpy
from lwr_dyn.reproduction import case as shared
from lwr_dyn.reproduction.case import CONTRADICTION, PaperCase, PaperData, Proof, Prove, formulas
from lwr_dyn.reproduction.compare import compared
from lwr_dyn.reproduction.kr30ha.planar_dynamics import own_comparisons
from lwr_dyn.reproduction.kr30ha.points import point_misses, right_points, simplified_solution, wrist_centre_mm
from lwr_dyn.reproduction.papers import ResultBlock

IN_MM = np.array([[1, 1, 1, 1e3]] * 3 + [[1, 1, 1, 1]])
"""Factors that bring a homogeneous matrix from m to mm."""


def axes(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Joints of the arm, all of them driven"""
    return {"count": [case.n, case.n]}


def link_lengths(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """d_1, a_1, a_2 + a_3 and d_4 of Table 3 [mm], as the report takes them"""
    rows = dh_rows(case.geometry)
    lengths = {"d1": rows[0].d, "d2": rows[0].a, "a2": rows[1].a + rows[2].a, "a3": rows[3].d}
    return {name: [1e3 * value] for name, value in lengths.items()}


def coordinates(_: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Table 1 [mm]"""
    columns = dict.fromkeys(cell.column for cell in block.cells)
    return {name: block.printed[f"point_{name[-1]}"] for name in columns}


def wrist_at_mastering(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Wrist centre at the mastering position of Appendix A [mm]"""
    wrist = wrist_centre_mm(case.arm, np.array(case.arm.mastering))
    return {"text": wrist, "table_4": wrist}


def simplified_point(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """The report's D, theta_1, theta_3, alpha, phi and theta_2 = alpha +- phi from Table 4"""
    values = simplified_solution(block.printed, case.block("geometry").printed)
    out: dict[str, Any] = {name: [values[name]] for name in ("theta_1", "D", "theta_3", "alpha", "phi")}
    return out | {"theta_2": [values["theta_2 (first)"], values["theta_2 (second)"]]}


def table_5(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """theta_1, theta_2, theta_3 by the report's own formulas; theta_2 the elbow-up one"""
    found = {name: simplified_point(case, case.block(name)) for name in ("point_1", "point_2", "home")}
    return {name: [x["theta_1"][0], x["theta_2"][name != "home"], x["theta_3"][0]] for name, x in found.items()}


def symbolic_matrices(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Equation (1) with Table 2, theta_i = theta_i* + offset_i"""
    dh = {name: column for name, column in case.tables["dh"].items() if name != "sign"}
    matrices = dh_matrices(paper_of_tables({**case.bare, "dh": dh}, case.file, errata_read=()))
    return {f"A{i + 1}": compared(block.printed[f"A{i + 1}"], m.tolist()) for i, m in enumerate(matrices)}


def numeric_matrices(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Equation (1) with Table 2 at the mastering position of Appendix A, lengths in mm"""
    chain, q = case.arm.chain, case.arm.mastering
    links = zip(chain.links, q, strict=True)
    return {f"T{i + 1}": (IN_MM * link.pose(x).matrix()).tolist() for i, (link, x) in enumerate(links)}


def composite_matrices(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """T_1^0 ... T_k^{k-1} at the mastering position of Appendix A, lengths in mm"""
    poses = list(link_frames(case.arm.chain, np.array(case.arm.mastering)))
    return {f"T0{k}": (IN_MM * poses[k - 1]).tolist() for k in range(2, 7)}


def flange_at_mastering(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Flange [mm] with KUKA's axes at mastering; at A = 0 where the printed pose is read as that one"""
    q = np.zeros(case.n) if "mastering-transform" in case.applied else np.array(case.arm.mastering)
    if not {"kuka-signs", "table2-offset"} <= case.applied:
        return {"position": [None, None, None]}  # the joint coordinates are not KUKA's axes
    return {"position": 1e3 * list(link_frames(case.arm.chain, q))[-1][:3, 3]}


def envelope(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Largest distance of the wrist centre from axis 1, and pi times the moment of its section, ahead of the axis"""
    computed = working_envelope(case.arm)
    return {"reach": [1e3 * computed.reach], "volume": [computed.volume]}


def expressions(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """The right expression of the report's own planar model, with what the errata applied take away"""
    return {"printed": [_expression(name, case.applied) for name in dict.fromkeys(c.row for c in block.cells)]}


@cache
def _expression(name: str, applied: frozenset[str]) -> shared.ComparedExpression:
    found = next(c for c in own_comparisons() if c.name == name)
    return shared.ComparedExpression("; ".join(map(str, found.right)), found.follows_with(applied))


def caption_numbers(_: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Number of the caption that is meant"""
    return {"number": [1 + block.printed[kind].index(title) for kind, title in block.printed["meant"]]}


def misses(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """|wrist centre - point| and |flange - point| with A = -theta of Table 5 [mm]"""
    points = point_misses(case.arm, case.printed)[:2]
    return {"wrist": [m.wrist_miss_mm for m in points], "flange": [m.flange_miss_mm for m in points]}


def right_angles(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """A1 to A6 [deg] of the true inverse kinematics"""
    return {point.name: np.degrees(point.q) for point in right_points(case.arm, case.printed)[:2]}


def branches(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """How many solutions of the inverse kinematics there are"""
    points = right_points(case.arm, case.printed)[:2]
    return {"inside": [p.inside_limits for p in points], "all": [p.solutions for p in points]}


def mastering(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Forward kinematics at the mastering position [mm]"""
    q = np.array(case.arm.mastering)
    return {"flange": 1e3 * flange_pose(case.arm.chain, q)[:3, 3], "wrist": wrist_centre_mm(case.arm, q)}


def elbow(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """hypot(a_3, d_4) [mm], atan2(a_3, d_4) [deg]"""
    a3, d4 = case.values("dh", "a")[2], case.values("dh", "d")[3]
    return {"length": [np.hypot(a3, d4)], "phi": [np.degrees(np.arctan2(a3, d4))]}


def envelope_figures(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Reach [mm] and volume [m^3] of the envelope, and what the data sheet has less"""
    computed, rated = working_envelope(case.arm), case.arm.ratings
    reach, volume = 1e3 * computed.reach, computed.volume
    if rated.reach is None or rated.envelope_volume is None:
        raise MissingDataError(case.arm.name, "rated reach or volume", "the comparison")
    return {
        "reach": [reach], "volume": [volume],
        "reach_less": [reach - 1e3 * rated.reach], "volume_less": [volume - rated.envelope_volume],
    }  # fmt: skip


def pose_misses(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """[poses] of the data file less forward kinematics: lengths [mm], directions [1]"""
    arm, columns, zero = case.arm, case.paper.columns, np.zeros(case.n)
    at_zero = flange_pose(arm.chain, zero)
    wrist = wrist_centre_mm(arm, np.array(arm.mastering)) - 1e3 * columns["poses.mastering_wrist"].si()[0]
    flange = 1e3 * (at_zero[:3, 3] - columns["poses.zero_flange"].si()[0])
    turn = at_zero[:3, :3] - from_rpy(columns["poses.flange_rpy"].si()[0])
    axis = columns["poses.axis"].si() - _axes(arm)
    lengths = {"wrist": [np.abs(wrist).max()], "flange": [np.abs(flange).max()]}
    return lengths | {"axis": np.abs(axis).max(axis=1), "turn": [np.abs(turn).max()]}


def _axes(arm: Arm) -> Array:
    """Positive directions of the joints at zero in the base, (n, 3): what turns frame i when q_i grows."""
    still, out = frames(arm.chain, np.zeros(arm.n)), []
    for i, moved in enumerate(1e-3 * np.eye(arm.n)):
        turn = frames(arm.chain, moved)[i, :3, :3] @ still[i, :3, :3].T
        out.append(np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]))
    return np.asarray(out) / (2.0 * float(np.sin(1e-3)))


def masses(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """sum m_i [kg], alone and with the base"""
    moving = sum(case.values("inertial", "mass"))
    return {"moving": [moving], "with_base": [moving + float(case.tables["base"]["mass"]["values"])]}


def solids(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Mass, centre of mass and n . I n, n = (1, 2, 3)/sqrt(14), of each link's cylinders at one density"""
    bodies = list(_bodies(case.paper).values())
    columns = {"mass": [b.mass for b in bodies], "com": [b.com.tolist() for b in bodies]}
    return columns | {"moment": [shared.AXIS @ b.inertia_com @ shared.AXIS for b in bodies]}


def estimate_misses(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """|estimate - body of the solids| of the data file in units of its last digit, the half that rounding leaves off"""
    bodies = list(_bodies(case.paper).values())[1:]
    out: dict[str, Any] = {}
    parts = (("mass", MASS_DIGITS, "mass"), ("com", COM_DIGITS, "com"), ("inertia", INERTIA_DIGITS, "inertia_com"))
    for name, digits, attribute in parts:
        mine = case.paper.columns[f"inertial.{name}"].si()
        theirs = [getattr(body, attribute) for body in bodies]
        out[name] = [np.abs(np.asarray(a - b)).max() * 10.0**digits for a, b in zip(mine, theirs, strict=True)]
    base = next(iter(_bodies(case.paper).values())).mass - float(case.tables["base"]["mass"]["values"])
    return out | {"mass": [abs(base) * 10.0**MASS_DIGITS / 10.0, *out["mass"]]}


def _bodies(paper: Paper) -> dict[str, Body]:
    if paper.solids is None:
        raise MissingDataError(paper.name, "drawn solids", "the estimate")
    return solid_bodies(paper.solids, paper.columns["ratings.mass"].si()[0])


FORMULAS = (
    shared.SHARED
    | formulas(
        axes, link_lengths, coordinates, wrist_at_mastering, simplified_point, table_5, symbolic_matrices,
        numeric_matrices, composite_matrices, flange_at_mastering, envelope, misses, right_angles,
        branches, mastering, elbow, envelope_figures, pose_misses, masses, solids, estimate_misses,
    )
    | formulas(caption_numbers, basis=shared.REPEATED)  # places in the list of captions
    | formulas(expressions, slow=True, basis=shared.COMPUTED)  # derived by algebra, no number of the paper enters
)  # fmt: skip


def home_x(data: PaperData) -> Proof:
    """Both printed homes against the wrist centre and the flange at mastering."""
    case = data.reading()
    text, table = (float(case.printed["home_position"][name][0]) for name in ("text", "table_4"))
    flange, wrist = (float(place[0]) for place in mastering(case, case.block("mastering")).values())
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
    is_so = abs(upper - 850.0) < 1e-6 and abs(lower - math.hypot(145.0, 820.0)) < 1e-6
    return Proof(
        "the two links are 850 and 832.7 mm long; 995 and 820 mm are another triangle",
        is_so and a2 - upper > 1.0 and lower - a3 > 1.0,
        {"axis 2 to axis 3 [mm]": upper, "axis 3 to wrist [mm]": lower, "printed": f"{a2:g}, {a3:g}"},
    )


def target_frame(data: PaperData) -> Proof:
    """Point 1 with all other errors put right: angles for the wrist centre there, and angles for the flange there.

    Table 5's own angles show nothing of this error: others move them by more.
    """
    case = data.reading()
    target = right_points(case.arm, case.printed)[0].target
    point = np.array([target.x_mm, target.y_mm, target.z_mm])
    meant, ahead = target.matrix(), target.matrix()
    ahead[:3, 3] -= target.matrix()[:3, :3] @ require_wrist_arm(case.arm).wrist_in_flange
    misses = []
    for pose in (ahead, meant):
        flange = flange_pose(case.arm.chain, inverse_kinematics(case.arm, pose).solutions[0].q)
        misses.append(float(np.linalg.norm(1e3 * flange[:3, 3] - point)))
    return Proof(
        "angles for the wrist centre at Point 1 take the flange 170 mm past it; those for the flange bring it there",
        abs(misses[0] - 170.0) < 1e-6 and misses[1] < 1e-6,
        {"flange misses by angles for the wrist [mm]": misses[0], "by angles for the flange [mm]": misses[1]},
    )


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
                 {"Table 4, link 2 [mm]": a2, "link 3 [mm]": a3, "d_4 [mm]": d4}, CONTRADICTION)  # fmt: skip


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
