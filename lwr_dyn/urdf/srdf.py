"""Rotors as Pinocchio reads them: the SRDF's `rotor_params`, which `pinocchio.loadRotorParameters` turns into armature.

Pinocchio calls the rotor's moment of inertia `mass`.
"""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

from lwr_dyn.model.arm import Arm
from lwr_dyn.urdf.xml_text import comment, number


def srdf_text(arm: Arm) -> str:
    """The arm's rotors as SRDF text; joints without a known rotor are left out."""
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        "<!--",
        f"  {comment(f'rotors of robot {arm.name}, reading {arm.reading}; written by lwr_dyn, do not edit')}",
        "  for pinocchio.loadRotorParameters: mass is the rotor's moment of inertia about its axis [kg m^2];",
        "  armature = gear_ratio^2 mass",
        "-->",
        f"<robot name={quoteattr(arm.name)}>",
        "  <rotor_params>",
    ]
    for link in arm.chain.links:
        if link.rotor is not None:
            mass, ratio = number(link.rotor.inertia), number(link.rotor.gear_ratio)
            lines.append(f'    <joint name={quoteattr(link.joint)} mass="{mass}" gear_ratio="{ratio}"/>')
    return "\n".join([*lines, "  </rotor_params>", "</robot>"]) + "\n"
