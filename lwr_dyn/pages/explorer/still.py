"""A picture of an arm: its cylinders in facets, the far ones first, drawn by Matplotlib (extra `plots`)."""

import io
from collections.abc import Iterator
from importlib.util import find_spec
from itertools import pairwise

import numpy as np

from lwr_dyn.arms.urdf.geometry import Primitive, primitives
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import joint_motion
from lwr_dyn.model.installation import ends_of
from lwr_dyn.model.run import Run
from lwr_dyn.model.spatial import Pose
from lwr_dyn.pages.replay.look import tokens
from lwr_dyn.pages.replay.replayed_runs import replayed_runs

_SIDES, _RINGS = 32, 40
_AZIMUTH, _ELEVATION = -1.15, 0.27
"""Direction from which the arm is seen [rad]."""
_LIGHT = np.array([0.45, -0.55, 0.7])
_BODY = {"grey": "housing", "orange": "limb", "dark": "joint"}
"""Colour of a drawn cylinder -> token of the look, as on the page."""
_SIZE = (6.0, 4.5)
"""[inch], at 120 points each."""


def arm_still(arm: Arm, q: Array, run: Run | None = None) -> bytes | None:
    """The arm at q (n,) [rad or m] as PNG, with the path of a run and its reference; None without Matplotlib."""
    if find_spec("matplotlib") is None:
        return None
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    look = tokens()
    facets = sorted(_facets(arm, q), key=lambda facet: float(facet[0].mean(axis=0) @ _view()[2]))
    corners = [corners @ _view()[:2].T for corners, _ in facets]
    colours = [colour for _, colour in facets]
    figure = Figure(figsize=_SIZE, facecolor=look["card"])
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96), aspect="equal", frame_on=False, xticks=[], yticks=[])
    axes.add_collection(PolyCollection(corners, facecolors=colours, edgecolors=colours, linewidths=0.4))
    if run is not None:
        (shown,) = replayed_runs([run], arm)
        for path, colour, width in (
            (shown.reference_path, look["ref"], 4.0),
            (shown.pose[:, :3, 3], shown.colour, 1.8),
        ):
            axes.plot(*(path @ _view()[:2].T).T, color=colour, linewidth=width, solid_capstyle="round")
    axes.autoscale_view()
    axes.margins(0.08)
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=120, metadata={"Software": None})
    return out.getvalue()


def _rgb(token: str) -> tuple[float, ...]:
    return tuple(int(tokens()[token][i : i + 2], 16) / 255.0 for i in (1, 3, 5))


def _view() -> Array:
    """Rows right, up and towards the eye, (3, 3)."""
    ca, sa, ce, se = np.cos(_AZIMUTH), np.sin(_AZIMUTH), np.cos(_ELEVATION), np.sin(_ELEVATION)
    return np.array([[-sa, ca, 0.0], [-ca * se, -sa * se, ce], [ca * ce, sa * ce, se]])


def _facets(arm: Arm, q: Array) -> Iterator[tuple[Array, tuple[float, ...]]]:
    """Corners (k, 3) [m] in the first frame and colour of each facet that faces the eye."""
    poses = _link_poses(arm, q)
    for shape in primitives(arm):
        pose = poses[shape.link] @ shape.pose
        for corners, normal in _cylinder(shape):
            out = pose.rotation @ normal
            if out @ _view()[2] > 0.0:
                shade = 0.62 + 0.38 * max(0.0, float(out @ _LIGHT) / float(np.linalg.norm(_LIGHT)))
                yield corners @ pose.rotation.T + pose.position, tuple(shade * x for x in _rgb(_BODY[shape.colour]))


def _cylinder(shape: Primitive) -> Iterator[tuple[Array, Array]]:
    """Facets of a cylinder with their normals, in its own frame; short ones, which can be sorted by distance."""
    turn = np.linspace(0.0, 2.0 * np.pi, _SIDES + 1)
    rim = np.column_stack([shape.radius * np.cos(turn), shape.radius * np.sin(turn), np.zeros(_SIDES + 1)])
    rings = int(np.clip(np.ceil(2.0 * shape.length / max(shape.radius, 1e-6)), 1, _RINGS))
    heights = np.zeros((rings + 1, 3))
    heights[:, 2] = np.linspace(-shape.length / 2, shape.length / 2, rings + 1)
    for low, high in pairwise(heights):
        for a, b in pairwise(rim):
            yield np.array([a + low, b + low, b + high, a + high]), (a + b) / (2.0 * max(shape.radius, 1e-9))
    for end in heights[[0, -1]]:
        yield rim[:-1] + end, np.sign(end)


def _link_poses(arm: Arm, q: Array) -> dict[str, Pose]:
    """The frame of each link, of the base and of the flange, in the first frame of the chain."""
    base, flange = ends_of(arm.installation)
    pose, out = Pose.identity(), {"base": base}
    for link, joint, x in zip(arm.chain.links, arm.joints(), q, strict=True):
        pose = pose @ joint.origin @ joint_motion(joint.kind, float(x))
        out[link.link] = pose
    return out | {"flange": pose @ arm.flange() @ flange}
