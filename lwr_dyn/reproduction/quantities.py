"""Formulas of numbers that any arm has; all studies share them. States (q, dq, ddq) stand in the block's `given`."""

from typing import Any

import numpy as np

from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.chain import with_payload
from lwr_dyn.reproduction.case import PaperCase, formulas
from lwr_dyn.reproduction.results import ResultBlock

AXIS = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
"""For n . I n every entry of the tensor I counts, each with another weight."""


def _state(case: PaperCase, block: ResultBlock, name: str) -> Array:
    return np.array(block.printed.get(name, np.zeros(case.n)), dtype=np.float64)


def total_mass(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """sum m_i over the moving links [kg]"""
    return {"mass": [sum(case.values("inertial", "mass"))]}


def torques(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """g(q), B(q) ddq, C(q, dq) dq by the hand-written recursion [N m]"""
    recursion = Recursion.of(case.arm.require_dynamics())
    q, dq, ddq = (_state(case, block, name) for name in ("q", "dq", "ddq"))
    g = recursion.gravity_vector(q)
    inertial = recursion.mass_matrix(q) @ ddq
    return {"g": g, "B_ddq": inertial, "C_dq": recursion.inverse_dynamics(q, dq, ddq) - inertial - g}


def payload_torque(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """g(q) with the rated payload at the flange [N m]"""
    chain = with_payload(case.arm.require_dynamics(), case.arm.ratings.payload or 0.0)
    return {"g": Recursion.of(chain).gravity_vector(_state(case, block, "q"))}


def link_moments(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """n . I_i n about each link's centre of mass, n = (1, 2, 3)/sqrt(14) in the DH frame [kg m^2]"""
    return {"moment": [AXIS @ body.inertia_com @ AXIS for body in case.arm.chain.bodies or ()]}


def flange(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """T_0n(q): position [m] and the flange's axes in the base"""
    T = flange_pose(case.arm.chain, _state(case, block, "q"))
    return {"position": T[:3, 3], "rotation": T[:3, :3].tolist()}


def limits(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Limits in SI, positions in the DH coordinate: [rad], [rad/s], [N m]"""
    arm = case.arm
    columns = {"lower": arm.lower, "upper": arm.upper, "velocity": arm.velocity, "effort": arm.effort}
    return {name: columns[name] for name in dict.fromkeys(c.column for c in block.cells)}


def height(case: PaperCase, block: ResultBlock) -> dict[str, Any]:
    """Height of the flange above the floor at q: pedestal plus p_z [m]"""
    T = flange_pose(case.arm.chain, _state(case, block, "q"))
    return {"height": [case.arm.drawing.pedestal + T[2, 3]]}


def armature(case: PaperCase, _: ResultBlock) -> dict[str, Any]:
    """k_r^2 I_m: rotor inertia seen at the joint [kg m^2]"""
    return {"armature": case.arm.armature}


SHARED = formulas(total_mass, torques, payload_torque, link_moments, flange, limits, height, armature)
