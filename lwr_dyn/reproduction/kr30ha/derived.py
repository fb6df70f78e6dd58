"""Numbers that follow from the KR 30 HA's data file and that the report does not print: recomputing functions."""

from __future__ import annotations

from typing import Any

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.errors import MissingDataError
from lwr_dyn.kinematics.envelope import working_envelope
from lwr_dyn.kinematics.forward import forward_kinematics, frames
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body
from lwr_dyn.model.spatial import from_rpy
from lwr_dyn.papers.schema import Paper
from lwr_dyn.papers.solids import COM_DIGITS, INERTIA_DIGITS, MASS_DIGITS, solid_bodies
from lwr_dyn.reproduction.case import PaperCase, PaperFormula
from lwr_dyn.reproduction.kr30ha.points import point_misses, right_points, wrist_centre_mm
from lwr_dyn.reproduction.quantities import AXIS
from lwr_dyn.reproduction.results import ResultBlock


def misses(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """|wrist centre - point| and |flange - point| with A = -theta of Table 5 [mm]"""
    found = point_misses(case.arm, case.printed)[:2]
    return {"wrist": [m.wrist_miss_mm for m in found], "flange": [m.flange_miss_mm for m in found]}


def right_angles(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """A1 to A6 [deg] of the true inverse kinematics"""
    return {point.name: np.degrees(point.q) for point in right_points(case.arm, case.printed)[:2]}


def branches(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """How many solutions of the inverse kinematics there are"""
    found = right_points(case.arm, case.printed)[:2]
    return {"inside": [p.inside_limits for p in found], "all": [p.solutions for p in found]}


def mastering(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Forward kinematics at the mastering position [mm]"""
    q = np.array(case.arm.mastering)
    return {"flange": 1e3 * forward_kinematics(case.arm.chain, q)[:3, 3], "wrist": wrist_centre_mm(case.arm, q)}


def elbow(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """hypot(a_3, d_4) [mm], atan2(a_3, d_4) [deg]"""
    a3, d4 = case.values("dh", "a")[2], case.values("dh", "d")[3]
    return {"length": [np.hypot(a3, d4)], "phi": [np.degrees(np.arctan2(a3, d4))]}


def envelope_figures(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """Reach [mm] and volume [m^3] of the envelope, and what the data sheet has less"""
    found, rated = working_envelope(case.arm), case.arm.ratings
    reach, volume = 1e3 * found.reach, found.volume
    if rated.reach is None or rated.envelope_volume is None:
        raise MissingDataError(case.arm.name, "rated reach or volume", "the comparison")
    return {
        "reach": [reach], "volume": [volume],
        "reach_less": [reach - 1e3 * rated.reach], "volume_less": [volume - rated.envelope_volume],
    }  # fmt: skip


def pose_misses(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """[poses] of the data file less forward kinematics: lengths [mm], directions [1]"""
    arm, columns, zero = case.arm, case.paper.columns, np.zeros(case.n)
    at_zero = forward_kinematics(arm.chain, zero)
    wrist = wrist_centre_mm(arm, np.array(arm.mastering)) - 1e3 * columns["poses.mastering_wrist"].si()[0]
    flange = 1e3 * (at_zero[:3, 3] - columns["poses.zero_flange"].si()[0])
    turn = at_zero[:3, :3] - from_rpy(columns["poses.flange_rpy"].si()[0])
    axis = columns["poses.axis"].si() - _axes(arm, zero)
    lengths = {"wrist": [np.abs(wrist).max()], "flange": [np.abs(flange).max()]}
    return lengths | {"axis": np.abs(axis).max(axis=1), "turn": [np.abs(turn).max()]}


def _axes(arm: Arm, q: Array) -> Array:
    """Positive directions of the joints in the base, (n, 3): what turns frame i when q_i grows."""
    here, out = frames(arm.chain, q), []
    for i in range(arm.n):
        moved = q.copy()
        moved[i] += 1e-3
        turn = frames(arm.chain, moved)[i, :3, :3] @ here[i, :3, :3].T
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
    return columns | {"moment": [AXIS @ b.inertia_com @ AXIS for b in bodies]}


def estimate_misses(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """|estimate - body of the solids| of the data file in units of its last digit, the half that rounding leaves off"""
    found = list(_bodies(case.paper).values())[1:]
    out: dict[str, Any] = {}
    parts = (("mass", MASS_DIGITS, "mass"), ("com", COM_DIGITS, "com"), ("inertia", INERTIA_DIGITS, "inertia_com"))
    for name, digits, attribute in parts:
        mine = case.paper.columns[f"inertial.{name}"].si()
        theirs = [getattr(body, attribute) for body in found]
        out[name] = [np.abs(np.asarray(a - b)).max() * 10.0**digits for a, b in zip(mine, theirs, strict=True)]
    base = next(iter(_bodies(case.paper).values())).mass - float(case.tables["base"]["mass"]["values"])
    return out | {"mass": [abs(base) * 10.0**MASS_DIGITS / 10.0, *out["mass"]]}


def _bodies(paper: Paper) -> dict[str, Body]:
    if paper.solids is None:
        raise MissingDataError(paper.name, "drawn solids", "the estimate")
    return solid_bodies(paper.solids, paper.columns["ratings.mass"].si()[0])


_ALL = (
    misses, right_angles, branches, mastering, elbow, envelope_figures, pose_misses, masses, solids, estimate_misses,
)  # fmt: skip
DERIVED = {function.__name__: PaperFormula(function) for function in _ALL}
