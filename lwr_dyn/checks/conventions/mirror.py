"""Repeated links: bodies of equal mass whose centres of mass are mirror images should have mirror-image tensors.

A signed permutation P of the axes that maps one centre of mass to the other, P c_i = c_j, must map the tensors too,
P I_i P^T = I_j. That ties together the signs of the products of both links, their axes, and the point the tensors are
about: moved by the wrong m c^2, bodies whose coms differ a little no longer agree.
"""

import itertools
from collections.abc import Sequence

import numpy as np

from lwr_dyn.checks.conventions.choices import LinkOptions
from lwr_dyn.checks.conventions.printed_table import PrintedTable
from lwr_dyn.foundation.arrays import Array

FORGIVEN = 4.0
"""Standard deviations of the rounding of cells that explain a miss."""
MIRROR = 0.03
"""Share of its length by which the com of a repeated link may miss the mirror image of the other's."""
_PERMUTATIONS = np.array(
    [np.eye(3)[list(p)] * np.array(s)[:, None] for p in itertools.permutations(range(3))
     for s in itertools.product((1.0, -1.0), repeat=3)]
)  # fmt: skip
"""All 48 signed permutations."""


def alike_links(table: PrintedTable, com: Array) -> tuple[tuple[int, ...], ...]:
    """Groups of links of equal mass whose coms (n, 3) are one another's mirror images, two or more each."""
    groups: list[list[int]] = []
    for i in range(table.n):
        for group in groups:
            j = group[0]
            length = float(np.linalg.norm(com[j]))
            gap = np.abs(np.sort(np.abs(com[i])) - np.sort(np.abs(com[j]))).max()
            equal = abs(table.mass[i] - table.mass[j]) <= table.mass_step / 2
            if equal and length > 0.0 and gap <= MIRROR * length:
                group.append(i)
                break
        else:
            groups.append([i])
    return tuple(tuple(g) for g in groups if len(g) > 1)


def mirror_misses(a: LinkOptions, b: LinkOptions, of_a: Sequence[int], of_b: Sequence[int]) -> Array:
    """Smallest miss of P I_a P^T = I_b over all P that take com to com, (A, B), in units of the printed tensor.

    The whole tensor counts, about the centre of mass; infinite where no P fits the coms.
    """
    com_a, com_b = a.com[list(of_a)], b.com[list(of_b)]
    turned = np.einsum("pij,aj->pai", _PERMUTATIONS, com_a)
    gap = np.abs(turned[:, :, None, :] - com_b).max(axis=-1)
    allowed = gap <= MIRROR * np.linalg.norm(com_b, axis=-1) + 1e-12
    tensors = np.einsum("pij,ajk,plk->pail", _PERMUTATIONS, a.inertia_com[list(of_a)], _PERMUTATIONS)
    miss = np.abs(tensors[:, :, None] - b.inertia_com[list(of_b)]).max(axis=(-1, -2))
    least: Array = np.where(allowed, miss, np.inf).min(axis=0) / max(a.scale, b.scale)
    return least


def rounding_miss(table: PrintedTable, links: Sequence[LinkOptions], group: Sequence[int]) -> float:
    """The largest miss that rounding of the printed cells explains, in units of the printed tensor."""
    largest = max(links[i].scale for i in group)
    spread = max(links[i].deviation_com for i in group)
    return (table.inertia_step + FORGIVEN * spread) / largest
