"""Frames with z on the joints' own axes, slid along them until few lengths remain between one frame and the next.

Kernels are generated in these frames: joints whose axes meet share an origin (the LWR's shoulder and wrist), so that a
chain with seven joints keeps two shifts. The motion and the torques are those of the source's frames.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.parameters import in_parent_frame
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Chain
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.spatial import Pose
from lwr_dyn.model.vectors import Matrix3, Vector

EXACT = 1e-12
"""[m, 1] Entries of constants nearer to 0 or +-1 than this are taken as such."""


@dataclass(frozen=True, slots=True, eq=False)
class AxisFrame:
    """The pose of a joint's frame, at q = 0, in the moved frame of the joint before; the link's frame in its own."""

    is_turning: bool
    turn: Matrix3
    shift: Vector
    link: Pose

    def to_own(self, parameters: list[Any]) -> list[Any]:
        """Inertial parameters of a body (10,), given in the link's frame, in this frame; linear in them."""
        return in_parent_frame(parameters, self.link.rotation, self.link.position)


def axis_frames(chain: Chain) -> tuple[AxisFrame, ...]:
    """The frames of a chain."""
    before = [link.before for link in chain.links]
    poses = [before[0], *(a.after @ b for a, b in zip(chain.links, before[1:], strict=False))]
    slides = _slides(poses)
    frames, last = [], 0.0
    for link, pose, slide in zip(chain.links, poses, slides, strict=True):
        shift = pose.position - last * np.array([0.0, 0.0, 1.0]) + slide * pose.rotation[:, 2]
        own = Pose(link.after.rotation, link.after.position - slide * np.array([0.0, 0.0, 1.0]))
        turn = Matrix3.of(_tidy(pose.rotation))
        frames.append(AxisFrame(link.kind is JointKind.REVOLUTE, turn, Vector.of(_tidy(shift)), own))
        last = slide
    return tuple(frames)


def parameter_map(frames: Sequence[AxisFrame]) -> Array:
    """The matrix (10 n, 10 n) from inertial parameters in the links' frames to those in `frames`."""
    n = len(frames)
    out = np.zeros((10 * n, 10 * n))
    for i, frame in enumerate(frames):
        part = slice(10 * i, 10 * i + 10)
        out[part, part] = np.array([frame.to_own(list(unit)) for unit in np.eye(10)], dtype=np.float64).T
    return out


def _slides(poses: Sequence[Pose]) -> list[float]:
    """How far each frame is slid along its axis [m]; the first by what makes the way to the second shortest."""
    out = [_to_the_next(poses[1]) if len(poses) > 1 else 0.0]
    for pose in poses[1:]:
        here = pose.position - np.array([0.0, 0.0, out[-1]])
        axis = pose.rotation[:, 2]
        candidates = [0.0, *(-here[k] / axis[k] for k in range(3) if abs(axis[k]) > EXACT)]
        out.append(min(candidates, key=lambda s: (np.count_nonzero(_tidy(here + s * axis)), abs(s))))
    return out


def _to_the_next(pose: Pose) -> float:
    """Along the first axis, the foot of the shortest way to the second; 0 where they are parallel."""
    axis = pose.rotation[:, 2]
    across = 1.0 - axis[2] ** 2
    return 0.0 if across < EXACT else float((pose.position[2] - axis[2] * (axis @ pose.position)) / across)


def _tidy(entries: Array) -> Array:
    """The entries, those that miss 0 or +-1 by rounding put right."""
    near = np.round(entries)
    return np.where((np.abs(entries - near) < EXACT) & (np.abs(near) <= 1.0), near, entries)
