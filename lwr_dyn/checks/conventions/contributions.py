"""Contribution of each link to B_ii and g_i, linear in its ten parameters (m, m c, tensor about its frame's origin).

With v, w the velocity of the link's origin and its angular velocity per unit of joint speed i, in the link's frame,
B_ii = sum over the links beyond i of m v.v + 2 (v x w).(m c) + w^T I w, and
g_i = -sum of g_0 . (m v + w x m c), the work of gravity (Siciliano et al., Robotics, eqs. 7.32 and 7.39).
"""

import itertools
from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.conventions.evidence import DerivedNumber
from lwr_dyn.checks.conventions.printed_table import PrintedTable
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.kinematics.forward import joint_axes
from lwr_dyn.model.chain import Chain, link_frames
from lwr_dyn.model.dh import JointKind

MOST_CORNERS = 4096
"""Corners of the quarter-turn lattice on which a largest B_ii is searched."""


@dataclass(frozen=True, slots=True, eq=False)
class NumberRows:
    """The derived numbers as linear rows: number k is the largest of its rows times the parameters, plus its rotor."""

    coefficients: Array
    """(R, n, 10)"""
    start: tuple[int, ...]
    """First row of each number, and R at the end."""
    joint: tuple[int, ...]
    value: Array
    """(K,) printed, less the rotor's share."""
    half: Array
    """(K,)"""


def contribution_rows(chain: Chain, quantity: str, joint: int, q: Array) -> Array:
    """Coefficients (P, n, 10) of B_ii or g_i of one joint at poses q (P, n); zero for links before the joint."""
    axes = joint_axes(chain, q)
    z, p, revolute = axes.z[:, joint], axes.p[:, joint], axes.revolute[joint]
    out = np.zeros((len(q), chain.n, 10))
    for j, pose in enumerate(itertools.islice(link_frames(chain, q), chain.n)):
        if j < joint:
            continue
        turn, place = pose[:, :3, :3], pose[:, :3, 3]
        linear = np.cross(z, place - p) if revolute else z
        v = np.einsum("pji,pj->pi", turn, linear)
        w = np.einsum("pji,pj->pi", turn, z) if revolute else np.zeros_like(v)
        if quantity == "gravity":
            g = np.einsum("pji,j->pi", turn, chain.gravity)
            out[:, j, 0] = -np.einsum("pi,pi->p", g, v)
            out[:, j, 1:4] = -np.cross(g, w)
            continue
        out[:, j, 0] = np.einsum("pi,pi->p", v, v)
        out[:, j, 1:4] = 2.0 * np.cross(v, w)
        out[:, j, 4:7] = w**2
        out[:, j, 7:10] = 2.0 * np.stack([w[:, 0] * w[:, 1], w[:, 0] * w[:, 2], w[:, 1] * w[:, 2]], axis=-1)
    return out


def number_rows(chain: Chain, table: PrintedTable, numbers: tuple[DerivedNumber, ...]) -> NumberRows:
    """All derived numbers as rows, distal joints first."""
    ordered = sorted(numbers, key=lambda x: -x.joint)
    blocks, start, value = [np.zeros((0, chain.n, 10))], [0], []
    for number in ordered:
        q = corners(table, number.joint) if number.q is None else np.asarray(number.q)[None, :]
        block = contribution_rows(chain, number.quantity, number.joint, q)
        blocks.append(np.unique(np.round(block, 12), axis=0) if number.q is None else block)
        start.append(start[-1] + len(blocks[-1]))
        rotor = 0.0 if table.armature is None or number.quantity == "gravity" else float(table.armature[number.joint])
        value.append(number.printed.value - rotor)
    half = np.array([x.printed.half for x in ordered])
    return NumberRows(np.concatenate(blocks), tuple(start), tuple(x.joint for x in ordered), np.array(value), half)


def corners(table: PrintedTable, joint: int) -> Array:
    """The quarter-turn lattice inside the joint box, over the joints beyond `joint`, (P, n) [rad].

    The largest B_ii of a link whose axes are perpendicular lies there but for small products. Raises
    `MissingDataError` for a sliding joint without limits.
    """
    lower = np.full(table.n, -np.pi) if table.lower is None else table.lower
    upper = np.full(table.n, np.pi) if table.upper is None else table.upper
    axes = []
    for j in range(table.n):
        if table.kinds[j] is JointKind.PRISMATIC:
            if table.lower is None or table.upper is None:
                raise MissingDataError(table.name, f"limits of {table.joints[j]}", "a largest B_ii")
            axes.append([float(lower[j]), float(upper[j])] if j > joint else [0.0])
            continue
        inside = [x for x in np.pi / 2 * np.arange(-4, 5) if lower[j] <= x <= upper[j]]
        turns = sorted({round(float(x) % (2 * np.pi), 9): float(x) for x in inside}.values())
        axes.append(turns or [float(lower[j] + upper[j]) / 2] if j > joint else [0.0])
    while np.prod([len(a) for a in axes]) > MOST_CORNERS:
        widest = max(range(len(axes)), key=lambda k: len(axes[k]))
        axes[widest] = axes[widest][::2]
    return np.array(list(itertools.product(*axes)))
