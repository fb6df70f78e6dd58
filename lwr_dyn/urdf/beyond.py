"""What an arm has that a URDF cannot hold: friction per direction, the motor map, gains. It goes to the sidecar."""

from __future__ import annotations

from typing import Any

from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction.models import Direction

ONE_SIDED = (
    "friction differs by direction, which a URDF and an MJCF cannot hold: none is written here; "
    'it is under "friction" in the sidecar'
)
"""The header line of an arm whose friction is left out."""


def sidecar_blocks(arm: Arm) -> dict[str, Any]:
    """Block of the sidecar -> its content in SI; only what the arm has."""
    out: dict[str, Any] = {}
    if arm.friction:
        pairs = zip(arm.joint_names, arm.friction, strict=True)
        out["friction"] = {
            joint: {
                "positive": _direction(f.positive),
                "negative": _direction(f.negative),
                "offset": f.offset,
                "covered": f.covered,
            }
            for joint, f in pairs
            if f is not None
        }
    if arm.transmission is not None:
        out["transmission"] = {"motors_by_joints": arm.transmission.matrix.tolist()}
    if arm.gains is not None:
        named = {name: getattr(arm.gains, name) for name in ("Kp", "Ki", "Kd", "effort")}
        out["gains"] = {name: None if value is None else value.tolist() for name, value in named.items()}
    return out


def sidecar_quantities(arm: Arm) -> tuple[str, ...]:
    """The quantities that `sidecar_blocks` is made of."""
    endings = [("friction.", bool(arm.friction)), ("gains.", arm.gains is not None)]
    parts = [f"{joint}.{part}" for joint in arm.joint_names for part, there in endings if there]
    motors = [f"{joint}.motors" for joint in arm.joint_names] if arm.transmission is not None else []
    return tuple(name for name in arm.sources if name.startswith(tuple(parts)) or name in motors)


def _direction(d: Direction) -> dict[str, float | None]:
    return {
        "coulomb": d.coulomb,
        "viscous": d.viscous,
        "static": d.static,
        "stribeck_velocity": d.stribeck_velocity,
    }
