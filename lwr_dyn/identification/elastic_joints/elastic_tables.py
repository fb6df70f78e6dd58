"""Gears, drives and links of elastic joints as text for people and as a record for programs."""

from typing import Any

import numpy as np

from lwr_dyn.foundation.tables import aligned
from lwr_dyn.identification.elastic_joints.identify_elastic import DRIVE, GEAR, ElasticIdentification
from lwr_dyn.identification.friction.friction_tables import with_error
from lwr_dyn.model.arm import Arm

SHOWN = ("stiffness", "damping", "armature", "coulomb", "viscous", "offset")
UNITS = {
    "stiffness": "N m/rad", "damping": "N m s/rad", "armature": "kg m^2", "coulomb": "N m", "viscous": "N m s/rad",
    "offset": "N m", "zero": "N m",
}  # fmt: skip


def elastic_text(found: ElasticIdentification, arm: Arm) -> str:
    """A row a joint with springs, dampers, rotors and friction; the noise of both sides; what bends too little."""
    cells = {name: (found.of(name), found.of(name, sigma=True)) for name in SHOWN}
    rows = [
        (str(j + 1), *(with_error(float(v[j]), float(s[j])) for v, s in cells.values()), _own(arm, j))
        for j in range(found.n)
    ]
    heads = (*(f"{name} [{UNITS[name]}]" for name in SHOWN), "stiffness of the model")
    noise = [(str(j + 1), f"{found.noise[j]:.4g}", f"{found.noise[found.n + j]:.4g}") for j in range(found.n)]
    lines = [
        f"{len(found.values)} parameters from {found.equations} equations, {found.base.count} of them the links'",
        aligned(rows, ("joint", *heads)),
        "rotors and friction are the motors', seen at the joints",
    ]
    for j in np.flatnonzero(~found.bends):
        lines.append(f"stiffness of joint {j + 1} not identified: it carries too little to bend beyond its encoders")
    return "\n".join((*lines, "", aligned(noise, ("joint", "noise of the torque [N m]", "of the gear [N m]"))))


def elastic_record(found: ElasticIdentification, robot: str) -> dict[str, Any]:
    """Every parameter of every joint with its error, the links' base parameters, and the noise of both sides."""
    cells = {name: (found.of(name), found.of(name, sigma=True)) for name in (*GEAR, *DRIVE.names)}
    links = zip(found.base.statements(), found.links, found.sigma, strict=False)
    return {
        "robot": robot, "equations": found.equations,
        "joints": [
            {
                "joint": j + 1, "bends": bool(found.bends[j]), "torque_noise": found.noise[j],
                "gear_noise": found.noise[found.n + j],
                "parameters": {
                    name: {"value": v[j], "standard_error": s[j], "unit": UNITS[name]} for name, (v, s) in cells.items()
                },
            }
            for j in range(found.n)
        ],
        "links": [{"parameter": name, "value": v, "standard_error": s} for name, v, s in links],
    }  # fmt: skip


def _own(arm: Arm, joint: int) -> str:
    return "-" if arm.elasticity is None else f"{arm.elasticity.stiffness[joint]:.5g}"
