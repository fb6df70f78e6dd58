"""Which bodies of the links give the published numbers: a search from the flange inward, one link at a time.

B_ii and g_i depend on the links beyond joint i only, so the last joint's numbers judge the last link alone, the next
one's two links, and so on. The contribution of a link is one vector over all numbers still to come; options with equal
contributions are one class (no number distinguishes them); what misses a number is dropped at once. The full product of
all links' options is never formed.

A contribution is linear in the link's ten parameters (m, m c, tensor about its frame's origin). With v, w the velocity
of the link's origin and its angular velocity per unit of joint speed i, in the link's frame,
B_ii = sum over the links beyond i of m v.v + 2 (v x w).(m c) + w^T I w, and
g_i = -sum of g_0 . (m v + w x m c), the work of gravity (Siciliano et al., Robotics, eqs. 7.32 and 7.39).
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.checks.conventions.evidence import DerivedNumber
from lwr_dyn.checks.conventions.printed_table import LinkOptions, PrintedTable
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.kinematics.forward import joint_axes
from lwr_dyn.model.chain import Chain, JointKind, link_frames

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


DEVIATIONS = 4.0
"""Standard deviations of the rounding of the table's cells by which a number may miss beyond half a digit."""
SAME = 0.02
"""Two options add the same to a number when they differ by less than this share of its allowed miss."""
PLAIN = 2
"""The first two options of a link have its axes as printed, the products with either sign."""
MOST_STATES = 3000
"""States kept at most, the plainest first."""
OptionSets = tuple[tuple[int, ...], ...]
"""Per link the options that remain; every combination of them is a reading of the table."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchResult:
    """Sets of options that give every number, or the numbers at which the search ended."""

    sets: tuple[OptionSets, ...]
    matched: int
    """Numbers matched before the search ended (all of them where some sets remain)."""
    failed: tuple[int, ...]
    """Indices into the rows of the numbers that no state matched."""
    partial: tuple[OptionSets, ...]
    """Sets for the links beyond the joint at which it ended."""
    nearest: float
    """Smallest miss of the failed numbers, in units of the allowed miss."""


Equals = tuple[tuple[OptionSets, ...], ...]
"""Per state, which is the sum over the links so far for every row, the sets of options that have it."""


def fit_numbers(rows: NumberRows, options: Sequence[LinkOptions], allowed: Sequence[Sequence[int]]) -> SearchResult:
    """Every combination of the links' allowed options that gives all the numbers; `allowed` lists them link by link."""
    allowance = allowances(rows, options)
    per_row = np.repeat(allowance, np.diff(rows.start))
    sums, matched = np.zeros((1, len(per_row))), 0
    equals: Equals = (((),),)
    for link in reversed(range(len(options))):
        classes, adds = _classes(rows, options[link], allowed[link], link, per_row)
        longer = tuple(tuple((members, *s) for s in equal) for equal in equals for members in classes)
        grown = (sums[:, None, :] + adds).reshape(len(longer), len(per_row))
        numbers = [k for k, joint in enumerate(rows.joint) if joint == link]
        miss = misses(rows, grown, allowance, numbers)
        good = np.flatnonzero(miss <= 1.0)
        if len(good) == 0:
            partial = tuple(s for equal in equals for s in equal)
            return SearchResult((), matched, tuple(numbers), partial, float(miss.min(initial=np.inf)))
        matched += len(numbers)
        sums, equals = _merged(rows, grown, longer, good, link, per_row)
    sets = sorted((s for equal in equals for s in equal), key=permuted_axes)
    return SearchResult(tuple(sets), matched, (), (), 0.0)


def misses(rows: NumberRows, sums: Array, allowance: Array, numbers: Sequence[int]) -> Array:
    """The worst miss of some numbers, (S,), for sums (S, R), in units of the allowed miss."""
    worst = np.zeros(len(sums))
    for k in numbers:
        value = sums[:, rows.start[k] : rows.start[k + 1]].max(axis=-1)
        worst = np.maximum(worst, np.abs(value - rows.value[k]) / allowance[k])
    return worst


def allowances(rows: NumberRows, options: Sequence[LinkOptions]) -> Array:
    """Allowed miss of each number, (K,): half its last digit and the rounding of the table's cells."""
    allowed: Array = rows.half * (1.0 + 1e-6) + DEVIATIONS * _deviation(rows, options)
    return allowed


def _deviation(rows: NumberRows, options: Sequence[LinkOptions]) -> Array:
    """One standard deviation of each number by rounding of the table's cells, (K,)."""
    deviation = np.array([o.deviation for o in options])
    per_row = np.sqrt(((rows.coefficients * deviation) ** 2).sum(axis=(1, 2)))
    return np.array([per_row[a:b].max(initial=0.0) for a, b in zip(rows.start[:-1], rows.start[1:], strict=True)])


def values(rows: NumberRows, options: Sequence[LinkOptions], picked: Sequence[int]) -> Array:
    """The numbers under one option per link, (K,), less the rotors' share."""
    sums = sum((rows.coefficients[:, i] @ options[i].parameters[o] for i, o in enumerate(picked)), np.zeros(1))
    return np.array([sums[a:b].max() for a, b in zip(rows.start[:-1], rows.start[1:], strict=True)])


def misfit(rows: NumberRows, options: Sequence[LinkOptions], picked: Sequence[int]) -> float:
    """Half the chi-square of the numbers under one option per link: minus the log of how likely the misses are."""
    variance = rows.half**2 / 3.0 + _deviation(rows, options) ** 2
    return float(((values(rows, options, picked) - rows.value) ** 2 / variance).sum() / 2.0)


def _classes(
    rows: NumberRows, options: LinkOptions, allowed: Sequence[int], link: int, per_row: Array
) -> tuple[list[tuple[int, ...]], Array]:
    """Classes of one link's options that add the same to every number, and what each class adds, (C, R)."""
    adds = rows.coefficients[:, link] @ options.parameters.T
    classes: dict[int, list[int]] = {}
    for o in allowed:
        same = (k for k in classes if (np.abs(adds[:, k] - adds[:, o]) <= SAME * per_row).all())
        classes.setdefault(next(same, o), []).append(o)
    return [tuple(members) for members in classes.values()], adds[:, list(classes)].T


def _merged(
    rows: NumberRows, sums: Array, equals: Equals, good: NDArray[np.intp], link: int, per_row: Array
) -> tuple[Array, Equals]:
    """The good states; those whose sums agree on every number still to come become one."""
    blocks = [np.arange(rows.start[k], rows.start[k + 1]) for k, joint in enumerate(rows.joint) if joint < link]
    ahead = np.concatenate([*blocks, np.zeros(0, dtype=int)])
    keys = np.round(sums[np.ix_(good, ahead)] / (SAME * per_row[ahead])).astype(np.int64)
    merged: dict[bytes, list[int]] = {}
    for key, s in zip(keys, good, strict=True):
        merged.setdefault(key.tobytes(), []).append(int(s))
    sets = [sorted((s for k in g for s in equals[k]), key=permuted_axes)[:MOST_STATES] for g in merged.values()]
    groups = sorted(zip(merged.values(), sets, strict=True), key=lambda g: permuted_axes(g[1][0]))[:MOST_STATES]
    return sums[[g[0] for g, _ in groups]], tuple(tuple(s) for _, s in groups)


def permuted_axes(sets: OptionSets) -> int:
    """Number of links whose axes must be permuted: options are in order, the plainest first."""
    return sum(min(options) >= PLAIN for options in sets)
