"""Is the truth identifiable: do the numbers published beside a scrambled table leave only one reading?

Computed independently of `rank_readings`: the recursion runs on every arm that differs from the truth in one choice
(of one link, of the repeated links together, of all signs, of the whole table). A choice is open when that arm has
other bodies that can exist and gives the same published numbers.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from lwr_dyn.checks.conventions.hypotheses import frame_vectors, other_ends, shifted, with_rows_moved
from lwr_dyn.checks.conventions.printed_table import (
    CHOICES,
    TENSOR,
    LinkChoice,
    PrintedTable,
    TableChoice,
    link_options,
)
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.recursion import LinkConstants, link_constants
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Body, Chain, Convention, is_physical, link_frames, with_bodies
from lwr_dyn.model.spatial import Matrix3, Vector
from tests.checks.conventions.scrambled_tables import ScrambledTable, rounding_of_tensor, same_bodies

ROOM = 2.0
"""Half digits within which a number counts as the printed one: the table's rounding adds to the number's own."""


def open_choices(scrambled: ScrambledTable) -> tuple[str, ...]:
    """Names of the choices that the evidence leaves open; none when only the truth is left."""
    table = with_rows_moved(scrambled.table, scrambled.truth.shift)
    truth = scrambled.truth
    found = [f"link_{i + 1}" for i in range(table.n) if _open_link(scrambled, table, i)]
    for name, flipped in (("signs", range(table.n)), ("signs of repeated links", scrambled.alike)):
        links = tuple(_flipped(c) if i in flipped else c for i, c in enumerate(truth.links))
        if flipped and _open(scrambled, table, truth.table, links, only=flipped):
            found.append(name)
    for name, choice in _other_tables(truth.table):
        if _open(scrambled, table, choice, truth.links, only=None):
            found.append(name)
    return tuple(found)


def _flipped(choice: LinkChoice) -> LinkChoice:
    return replace(choice, products="integral" if choice.products == "tensor" else "tensor")


def _other_tables(choice: TableChoice) -> Iterator[tuple[str, TableChoice]]:
    other = next(c for c in Convention if c is not choice.convention)
    yield "convention", replace(choice, convention=other)
    yield "about", replace(choice, about="origin" if choice.about == "com" else "com")
    yield "com_from", replace(choice, com_from="own frame" if choice.com_from == "other end" else "other end")


def _read(table: PrintedTable, choice: TableChoice, links: Sequence[LinkChoice]) -> tuple[Body, ...]:
    ends = other_ends(table, choice.convention)
    return tuple(link_options(table, i, choice, ends[i], (c,)).body(0) for i, c in enumerate(links))


def _open(
    scrambled: ScrambledTable,
    table: PrintedTable,
    choice: TableChoice,
    links: Sequence[LinkChoice],
    only: Sequence[int] | None,
) -> bool:
    """The arm so read has other bodies (or frames), which exist, and gives what is published."""
    bodies = _read(table, choice, links)
    moved = choice.convention is not scrambled.truth.table.convention
    if moved and not _same_frames(scrambled, table, choice.convention):
        return False
    if not moved and same_bodies(table, bodies, scrambled.bodies):
        return False
    if not all(is_physical(b) for b in bodies) or not _second(scrambled, bodies):
        return False
    if only is not None and 0 < len(set(only) & set(scrambled.alike)) < len(scrambled.alike):
        return False
    recursion = Recursion.of(with_bodies(table.chain(choice.convention), bodies))
    true = with_bodies(scrambled.chain, _read(table, scrambled.truth.table, scrambled.truth.links))
    return bool(_numbers_agree(scrambled, recursion, Recursion.of(true))[0])


def _same_frames(scrambled: ScrambledTable, table: PrintedTable, convention: Convention) -> bool:
    if table.origin is not None:
        gap = np.abs(shifted(table.origin, 0) - frame_vectors(table, convention))
        if np.nanmax(gap) > table.com_step:
            return False
    chain = table.chain(convention)
    for place in scrambled.evidence.places:
        *_, flange = link_frames(chain, place.q)
        if np.abs(flange[:3, 3] - place.xyz).max() > ROOM * place.half:
            return False
    return True


def _second(scrambled: ScrambledTable, bodies: Sequence[Body]) -> bool:
    """The second tensors come out, to their digits and those of the table."""
    tensors = scrambled.evidence.tensors
    if tensors is None:
        return True
    about = [b.inertia_origin() if tensors.about == "origin" else b.inertia_com for b in bodies]
    ours = np.array([[t[r, c] for r, c in TENSOR] for t in about])
    room = ROOM * tensors.half + np.array([[rounding_of_tensor(scrambled.table, b)] for b in bodies])
    signs = [np.array([1.0] * 3 + [-1.0 if p == "integral" else 1.0] * 3) for p in tensors.products]
    return any(bool((np.abs(s * tensors.values - ours) <= room).all()) for s in signs)


def _open_link(scrambled: ScrambledTable, table: PrintedTable, link: int) -> bool:
    """Some other choice for one link alone is as good as the truth."""
    choice, truth = scrambled.truth.table, scrambled.truth.links
    if link in scrambled.alike:
        return False  # its mirror image excludes the others, or all of them are open together
    others = [c for c in CHOICES if c != truth[link]]
    found = link_options(table, link, choice, other_ends(table, choice.convention)[link], others)
    options, true = [], _read(table, choice, truth)
    for o in range(len(found.choices)):
        bodies = list(true)
        bodies[link] = found.body(o)
        if same_bodies(table, tuple(bodies), scrambled.bodies) or not is_physical(bodies[link]):
            continue
        if _second(scrambled, bodies):
            options.append(bodies[link])
    chain = with_bodies(scrambled.chain, true)
    return bool(options) and bool(_numbers_agree(scrambled, _batch(chain, link, options), Recursion.of(chain)).any())


def _batch(chain: Chain, link: int, bodies: Sequence[Body]) -> Recursion:
    """The recursion of an arm with one link's body as a batch."""
    constants: list[LinkConstants] = list(link_constants(chain))
    com = np.array([b.com for b in bodies])[:, None]
    tensor = np.array([b.inertia_com for b in bodies])[:, None]
    rows = [Vector(*(tensor[..., r, c] for c in range(3))) for r in range(3)]
    constants[link] = replace(
        constants[link], com=Vector(com[..., 0], com[..., 1], com[..., 2]), inertia=Matrix3(*rows)
    )
    return replace(Recursion.of(chain), links=tuple(constants))


def _numbers_agree(scrambled: ScrambledTable, recursion: Recursion, true: Recursion) -> Array:
    """Per arm of a batch, (A,), whether every published number is that of the truth as the table prints it."""
    good = np.array([True])
    for q in {id(x.q): x.q for x in scrambled.evidence.numbers if x.q is not None}.values():
        theirs, ours = _numbers_at(true, q), _numbers_at(recursion, q)
        for x in (x for x in scrambled.evidence.numbers if x.q is q):
            k = int(x.quantity == "gravity")
            good = good & (np.abs(ours[k][:, x.joint] - theirs[k][0, x.joint]) <= ROOM * x.printed.half)
    return np.asarray(good, dtype=bool)


def _numbers_at(recursion: Recursion, q: Array) -> tuple[Array, Array]:
    """B_ii and g_i of a batch of arms at one pose, (A, n) each."""
    diagonal = np.diagonal(recursion.mass_matrix(q[None, None, :]), axis1=-2, axis2=-1)
    torque = recursion.gravity_vector(q[None, None, None, :])
    return diagonal.reshape(-1, len(q)), torque.reshape(-1, len(q))
