"""Public arms by their kinematics alone: the tables of `public_arms.toml`, read through a URDF as a user's file is."""

import tempfile
import tomllib
from functools import cache
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.kinematics.forward import jacobian

_TABLES = tomllib.loads(Path(__file__).with_suffix(".toml").read_text())
NAMES = tuple(_TABLES)
SINGULAR = 2e-5
"""Least singular value of a Jacobian [m or 1] that has lost rank: the tables' angles are rounded to 1e-6."""


def _joint(row, parent, child):
    name, kind, xyz, rpy, axis, limits = row
    parts = [f'<parent link="{parent}"/><child link="{child}"/>', f'<origin xyz="{_text(xyz)}" rpy="{_text(rpy)}"/>']
    parts += [f'<axis xyz="{_text(axis)}"/>'] if axis else []
    parts += [f'<limit lower="{limits[0]!r}" upper="{limits[1]!r}" effort="1" velocity="1"/>'] if limits else []
    return f'<joint name="{name}" type="{kind}">{"".join(parts)}</joint>'


def _text(numbers):
    return " ".join(map(repr, numbers))


BODY = (
    '<inertial><origin xyz="0.01 0.02 0.06"/><mass value="3"/>'
    '<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
)
"""Of each link, where an arm needs some body."""


def urdf_of(name, body=""):
    """The URDF of a public arm: its joints as they were written, links without bodies or each with the same `body`."""
    rows = _TABLES[name]["joints"]
    links = "".join(f'<link name="link_{i}">{body}</link>' for i in range(len(rows) + 1))
    joints = "".join(_joint(row, f"link_{i}", f"link_{i + 1}") for i, row in enumerate(rows))
    return f'<robot name="{name}">{links}{joints}</robot>'


@cache
def public_arm(name):
    """A public arm."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.urdf"
        path.write_text(urdf_of(name))
        return lwr_dyn.load(path)


def random_positions(arm, count, seed):
    """Positions (count, n) drawn uniformly inside the limits; a joint without them within half a turn."""
    low, up = _ranges(arm)
    return np.random.default_rng(seed).uniform(low, up, (count, arm.n))


def singular_positions(arm, count, seed):
    """Positions (count, n) inside the limits at which the Jacobian has lost rank: stretched, folded, axes aligned.

    Drawn at random with one to four joints at a multiple of 90 degrees, and kept where it has.
    """
    low, up = _ranges(arm)
    rng, found = np.random.default_rng(seed), np.empty((0, arm.n))
    while len(found) < count:
        q = rng.uniform(low, up, (4000, arm.n))
        aligned = np.argsort(rng.random(q.shape), axis=1) < rng.integers(1, 5, (4000, 1))
        q = np.where(aligned, np.round(q / (np.pi / 2)) * (np.pi / 2), q)
        q = q[((q >= low) & (q <= up)).all(axis=1)]
        rank = np.linalg.svd(jacobian(arm.chain, q), compute_uv=False)[:, -1]
        found = np.concatenate([found, q[rank < SINGULAR]])
    return found[:count]


def positions_at_limits(arm, count, seed):
    """Positions (count, n) with one joint at a limit, or within 1e-4 of it."""
    low, up = _ranges(arm)
    rng = np.random.default_rng(seed)
    q = rng.uniform(low, up, (count, arm.n))
    limited = np.flatnonzero(np.isfinite(arm.lower))
    for row in q:
        joint = rng.choice(limited)
        gap = rng.choice([0.0, 10.0 ** rng.uniform(-12, -4)])
        row[joint] = low[joint] + gap if rng.random() < 0.5 else up[joint] - gap
    return q


def _ranges(arm):
    return np.where(np.isfinite(arm.lower), arm.lower, -np.pi), np.where(np.isfinite(arm.upper), arm.upper, np.pi)
