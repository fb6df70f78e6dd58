"""The arm as meshcat commands: `set_object` and `set_transform` dictionaries in the format of a meshcat viewer.

The replay page and the live server use the same commands. Names come from the place in the scene tree, not at random,
so the same runs give the same bytes. Link k is at `link_path(run, k)` below link k - 1; its transform is the joint's
origin times the joint's motion, which the player sets.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from lwr_dyn.arms.urdf.geometry import Primitive, primitives
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import joint_motion
from lwr_dyn.model.installation import ends_of
from lwr_dyn.model.spatial import Pose, rot_x
from lwr_dyn.pages.replay.look import tokens
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun

Command = Mapping[str, Any]

ROOT = "arms"
_UPRIGHT = Pose(rot_x(np.pi / 2), np.zeros(3))
"""Turns the y axis of a three.js cylinder to our z axis."""
_SIDES = 40
_BODY = {"grey": "housing", "orange": "limb", "dark": "joint"}
_BAND = 0.7
"""A dark cylinder shorter than this, in radii, is a band, and has the colour of its run; a foot has not."""


def run_path(run: int) -> str:
    """Path of the base of run `run` in the scene tree."""
    return f"/{ROOT}/run_{run}"


def link_path(run: int, link: int) -> str:
    """Path of link `link`: 0 is the first frame of the chain, n + 1 the last one of an arm with n joints."""
    return "/".join([run_path(run), *(f"link_{i}" for i in range(link + 1))])


def arm_commands(shown: ReplayedRun, run: int) -> Iterator[Command]:
    """The shapes of an arm, then its links at the first sample of the run."""
    links = ["base", *(link.link for link in shown.arm.chain.links), "flange"]
    ends = dict(zip(("base", "flange"), ends_of(shown.arm.installation), strict=True))
    for k, shape in enumerate(primitives(shown.arm)):
        shape = replace(shape, pose=ends[shape.link] @ shape.pose) if shape.link in ends else shape
        yield cylinder(f"{link_path(run, links.index(shape.link))}/shape_{k}", shape, f"run{min(shown.place, 4) + 1}")
    yield from pose_commands(shown.arm, shown.run.q[0], run)


def pose_commands(arm: Arm, q: Array, run: int) -> Iterator[Command]:
    """The transforms that put the arm at q (n,) [rad or m]."""
    for i, (joint, value) in enumerate(zip(arm.joints(), q, strict=True), start=1):
        yield transform(link_path(run, i), joint.origin @ joint_motion(joint.kind, float(value)))
    yield transform(link_path(run, arm.n + 1), arm.flange())


def cylinder(path: str, shape: Primitive, accent: str) -> Command:
    """A drawn cylinder: bodies are grey, bands have the token `accent`; the page takes its colour from `userData`."""
    is_band = shape.colour == "dark" and shape.link != "base" and shape.length <= _BAND * shape.radius
    token = accent if is_band else _BODY[shape.colour]
    geometry = {
        "uuid": f"{path}#geometry",
        "type": "CylinderGeometry",
        "radiusTop": shape.radius,
        "radiusBottom": shape.radius,
        "height": shape.length,
        "radialSegments": _SIDES,
    }
    material = {
        "uuid": f"{path}#material",
        "type": "MeshPhongMaterial",
        "color": int(tokens()[token][1:], 16),
        "specular": 0x2A2A2A,
        "shininess": 35,
    }
    mesh = {
        "uuid": path,
        "type": "Mesh",
        "geometry": geometry["uuid"],
        "material": material["uuid"],
        "matrix": column_major(shape.pose @ _UPRIGHT),
        "userData": {"token": token},
    }
    return _object(path, mesh, geometry, material)


def transform(path: str, pose: Pose) -> Command:
    """Sets the pose of the node at `path` in its parent."""
    return {"type": "set_transform", "path": path, "matrix": column_major(pose)}


def column_major(pose: Pose) -> list[float]:
    """The 16 numbers of a pose in column-major order, as in three.js."""
    return [float(x) for x in pose.matrix().T.ravel()]


def _object(path: str, item: Command, geometry: Command, material: Command) -> Command:
    metadata = {"version": 4.5, "type": "Object"}
    scene = {"metadata": metadata, "geometries": [geometry], "materials": [material], "object": item}
    return {"type": "set_object", "path": path, "object": scene}
