"""The inertia seen at a joint, B_ii(q), for many states at once: a diagonal entry of the composite-body algorithm.

While joint i alone accelerates, the links behind it are one rigid body, and B_ii is that body's moment about the axis
of joint i, or its mass along a sliding one (Featherstone, *Rigid Body Dynamics Algorithms* (2008), section 6.2). Ten
numbers describe it: mass, first moment, and inertia about the origin of a frame. They go from frame to frame inward by
the joint's turn or way, and by one constant matrix (10, 10).
"""

from functools import lru_cache

import numpy as np

from lwr_dyn.dynamics.recursion import LinkConstants
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.model.spatial import Matrix3, Vector

_ENTRIES = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Places of the last six of the ten numbers in the inertia."""


def seen_inertia(links: tuple[LinkConstants, ...], q: Array) -> Array:
    """B_11 (k,) of the chain `links`, without rotors [kg m^2; kg for a sliding joint], at q (k, n) [rad or m]."""
    return _of_first(links, _inward(links, _constants(links)[1][-1][:, None], q, len(links) - 1, 0), len(q))


def seen_inertia_along(links: tuple[LinkConstants, ...], q: Array, j: int, values: Array) -> Array:
    """`seen_inertia` (k, m) with joint j > 0 of the rows q (k, n) at each of m values [rad or m].

    Links beyond joint j are the same for all values and are put together once a row.
    """
    m = len(values)
    whole = _inward(links, _constants(links)[1][-1][:, None], q, len(links) - 1, j)
    if whole.shape[1] > 1:
        whole = np.repeat(whole, m, axis=1)
    lines = np.repeat(q, m, axis=0)
    lines[:, j] = np.tile(values, len(q))
    return _of_first(links, _inward(links, whole, lines, j, 0), len(lines)).reshape(len(q), m)


def _inward(links: tuple[LinkConstants, ...], whole: Array, q: Array, start: int, end: int) -> Array:
    """The body (10, k) or (10, 1) from link `start` outward, in its frame -> that from link `end` outward."""
    transfers, bodies = _constants(links)
    for i in range(start, end, -1):
        moved = _turned(whole, q[:, i]) if links[i].revolute else _slid(whole, q[:, i])
        whole = transfers[i] @ moved + bodies[i - 1][:, None]
    return whole


def _of_first(links: tuple[LinkConstants, ...], whole: Array, rows: int) -> Array:
    """Moment about the axis of joint 1, or mass along it, of a body (10, rows) or (10, 1) in its moved frame."""
    return np.broadcast_to(whole[9] if links[0].revolute else whole[0], (rows,))


@lru_cache(maxsize=256)
def _constants(links: tuple[LinkConstants, ...]) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Of each link: the matrix (10, 10) that leads from its joint's frame, before the joint moves, to the moved joint
    frame of the link before it (the first link: to the base); and its own body (10,) in its moved joint frame.
    """
    transfers, bodies = list[Array](), list[Array]()
    inner = np.eye(10)
    for link in links:
        transfers.append(inner @ _carried(link.turn_before, link.shift_before))
        inner = _carried(link.turn, link.shift)
        bodies.append(inner @ _body(link))
    return tuple(transfers), tuple(bodies)


def _body(link: LinkConstants) -> Array:
    """The ten numbers of a link in its own frame."""
    com, inertia = _vector(link.com), _matrix(link.inertia)
    second = link.mass * np.outer(com, com)
    return _numbers(link.mass, link.mass * com, inertia + np.trace(second) * np.eye(3) - second)


def _carried(turn: Matrix3, shift: Vector) -> Array:
    """(10, 10): a body's numbers in a frame -> those in the frame in which that one has this pose."""
    return _carried_by(_matrix(turn).tobytes(), _vector(shift).tobytes())


@lru_cache(maxsize=256)
def _carried_by(turn: bytes, shift: bytes) -> Array:
    """`_carried` of the bytes of a matrix and a vector: arms of other bodies and the same geometry share it."""
    R, r = np.frombuffer(turn).reshape(3, 3), np.frombuffer(shift)
    columns = []
    for unit in np.eye(10):
        mass, first, inertia = unit[0], R @ unit[1:4], np.zeros((3, 3))
        for (i, j), x in zip(_ENTRIES, unit[4:], strict=True):
            inertia[i, j] = inertia[j, i] = x
        cross = np.outer(first, r) + np.outer(r, first) + mass * np.outer(r, r)
        moved = R @ inertia @ R.T + np.trace(cross) * np.eye(3) - cross
        columns.append(_numbers(mass, first + mass * r, moved))
    return read_only(np.array(columns).T)


def _numbers(mass: float, first: Array, inertia: Array) -> Array:
    return np.array([mass, *first, *(inertia[entry] for entry in _ENTRIES)])


def _vector(v: Vector) -> Array:
    return np.array([v.x, v.y, v.z], dtype=np.float64)


def _matrix(m: Matrix3) -> Array:
    return np.array([[row.x, row.y, row.z] for row in (m.x, m.y, m.z)], dtype=np.float64)


def _turned(body: Array, angle: Array) -> Array:
    """The numbers (10, k) of a body (10, k) or (10, 1) after a turn about z by angles (k,)."""
    c, s = np.cos(angle), np.sin(angle)
    m, hx, hy, hz, xx, xy, xz, yy, yz, zz = body
    mean, half = (xx + yy) / 2.0, (xx - yy) / 2.0
    c2, s2 = 1.0 - 2.0 * s * s, 2.0 * s * c
    lean = half * c2 - xy * s2
    out = np.empty((10, len(angle)))
    out[0], out[1], out[2], out[3] = m, c * hx - s * hy, s * hx + c * hy, hz
    out[4], out[5], out[7] = mean + lean, half * s2 + xy * c2, mean - lean
    out[6], out[8], out[9] = c * xz - s * yz, s * xz + c * yz, zz
    return out


def _slid(body: Array, way: Array) -> Array:
    """The numbers (10, k) of a body (10, k) or (10, 1) after a way along z (k,) [m]."""
    m, hx, hy, hz, xx, xy, xz, yy, yz, zz = body
    more = 2.0 * way * hz + m * way * way
    out = np.empty((10, len(way)))
    out[0], out[1], out[2], out[3] = m, hx, hy, hz + m * way
    out[4], out[5], out[6] = xx + more, xy, xz - way * hx
    out[7], out[8], out[9] = yy + more, yz - way * hy, zz
    return out
