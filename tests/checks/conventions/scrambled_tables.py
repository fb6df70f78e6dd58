"""Random arms of solid bodies, printed under known conventions: the search for conventions must recover them.

A body is one to three ellipsoids or boxes of uniform density, tilted at random, about the link's own segment, so its
tensor is one that a body has and its products are not zero. Repeated links are mirror images. What is published beside
the table is computed from the unrounded arm and printed to four or five digits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.checks.conventions import printed_table
from lwr_dyn.checks.conventions.evidence import (
    DerivedNumber,
    Evidence,
    FlangePlace,
    SecondTensors,
    evidence_number,
    second_tensors,
)
from lwr_dyn.checks.conventions.hypotheses import frame_vectors, other_ends
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.chain import Body, Chain, Convention, DHRow, JointKind, link_frames, with_bodies
from lwr_dyn.model.spatial import Pose, from_rpy

KINDS = ("second tensors", "numbers", "both")
"""What is published beside a table: the tensors about the other point, B_ii and g_i at stated poses, or both."""
_OFF = ~np.eye(3, dtype=bool)


@dataclass(frozen=True, slots=True, eq=False)
class ScrambledTable:
    """A scrambled table with what is published beside it, and the truth."""

    table: printed_table.PrintedTable
    evidence: Evidence
    truth: printed_table.TableReading
    bodies: tuple[Body, ...]
    """Unrounded."""
    chain: Chain
    kind: str
    alike: tuple[int, ...]
    """Links that are mirror images of one another."""


def scrambled_table(rng: np.random.Generator) -> ScrambledTable:
    """A random arm, printed and scrambled."""
    n = int(rng.integers(3, 8))
    convention = list(Convention)[rng.integers(2)]
    rows = _rows(rng, n)
    kinds = tuple(JointKind.PRISMATIC if rng.random() < 0.05 else JointKind.REVOLUTE for _ in range(n))
    flange = Pose(np.eye(3), np.array([0.0, 0.0, round(float(rng.uniform(0.05, 0.15)), 3)]))
    frames = printed_table.PrintedTable(
        name="scrambled", joints=tuple(f"joint_{i + 1}" for i in range(n)), rows=rows, kinds=kinds, mass=np.zeros(n),
        com=np.zeros((n, 3)), inertia=np.zeros((n, 3, 3)), mass_step=1e-4, com_step=1e-5, inertia_step=1e-6,
        flange=flange,
    )  # fmt: skip
    ends = other_ends(frames, convention)
    bodies, alike = _bodies(rng, ends)
    chain = with_bodies(frames.chain(convention), bodies)
    truth = _reading(rng, n, convention)
    kind = KINDS[rng.integers(len(KINDS))]
    table = _printed(rng, frames, bodies, truth, ends)
    return ScrambledTable(
        table, _evidence(rng, table, chain, bodies, truth, kind), truth, tuple(bodies), chain, kind, alike
    )


SHORTEST = 0.6
"""[m] Sum of the lengths of an arm: links are not all shorter than they are thick."""


def _rows(rng: np.random.Generator, n: int) -> tuple[DHRow, ...]:
    def length(share: float, low: float, high: float) -> float:
        return round(float(rng.uniform(low, high)), 3) if rng.random() < share else 0.0

    def row() -> DHRow:
        alpha = (0.0, math.pi / 2, -math.pi / 2)[int(rng.choice(3, p=(0.2, 0.4, 0.4)))]
        return DHRow(alpha, length(0.5, -0.4, 0.4), length(0.6, 0.1, 0.5))

    rows: list[DHRow] = []
    while sum(math.hypot(x.a, x.d) for x in rows) < SHORTEST:
        rows = [row() for _ in range(n)]
    return tuple(rows)


def _bodies(rng: np.random.Generator, ends: Array) -> tuple[list[Body], tuple[int, ...]]:
    """A body per link about the segment from its frame to its other end; in half of the arms some are repeated."""
    bodies = [_body(rng, 8.0 * 0.7**i, end) for i, end in enumerate(ends)]
    alike: tuple[int, ...] = ()
    if rng.random() < 0.5:
        first, *others = rng.permutation(len(ends))[: int(rng.integers(2, min(len(ends), 4) + 1))]
        for i in others:
            signs, order = rng.choice([1.0, -1.0], 3), rng.permutation(3)
            turn = np.eye(3)[order] * signs[:, None]
            bodies[i] = bodies[first].seen_from(Pose(turn, np.zeros(3)))
        alike = (int(first), *(int(i) for i in others))
    return bodies, alike


def _body(rng: np.random.Generator, mass: float, end: Array) -> Body:
    """One to three tilted ellipsoids or boxes along the segment from the origin to `end`."""
    length = max(float(np.linalg.norm(end)), 0.12)
    whole = Body.massless()
    for _ in range(int(rng.integers(1, 4))):
        m, half = mass * float(rng.uniform(0.3, 1.0)), length * rng.uniform(0.12, 0.6, 3)
        fifth = 1 / 5 if rng.random() < 0.5 else 1 / 3
        second = m * fifth * half**2
        tensor = np.diag(second.sum() - second)
        place = end * rng.uniform(0.0, 1.0) + length * rng.uniform(-0.25, 0.25, 3)
        turn = from_rpy(rng.uniform(-math.pi, math.pi, 3))
        whole = whole + Body(m, np.zeros(3), tensor).seen_from(Pose(turn, place))
    return whole


def _reading(rng: np.random.Generator, n: int, convention: Convention) -> printed_table.TableReading:
    """How the table is printed: a rule for the signs, now and then a link against it, now and then axes exchanged."""
    about = ("com", "origin")[rng.integers(2)]
    com_from = "other end" if rng.random() < 0.2 else "own frame"
    rule = ("tensor", "integral")[rng.integers(2)]
    against = set(rng.permutation(n)[: int(rng.choice(3, p=(0.7, 0.2, 0.1)))].tolist())
    moved = set(rng.permutation(n)[: int(rng.choice(3, p=(0.7, 0.2, 0.1)))].tolist())
    links = []
    for i in range(n):
        other = "integral" if rule == "tensor" else "tensor"
        products = other if i in against else rule
        axes = printed_table.AXES[rng.integers(1, 6)] if i in moved else "xyz"
        moves = "row" if i in moved and rng.random() < 0.3 else "tensor"
        links.append(printed_table.LinkChoice(products, axes, moves))  # type: ignore[arg-type]
    shift = 1 if rng.random() < 0.15 else 0
    return printed_table.TableReading(printed_table.TableChoice(convention, about, com_from), tuple(links), shift)  # type: ignore[arg-type]


def _printed(
    rng: np.random.Generator,
    frames: printed_table.PrintedTable,
    bodies: list[Body],
    truth: printed_table.TableReading,
    ends: Array,
) -> printed_table.PrintedTable:
    """The table as it is printed under a reading: the inverse of what `link_options` does."""
    coms, tensors = np.zeros((len(bodies), 3)), []
    for i, body in enumerate(bodies):
        choice = truth.links[i]
        tensor = body.inertia_com if truth.table.about == "com" else body.inertia_origin()
        place = body.com - (ends[i] if truth.table.com_from == "other end" else 0.0)
        back = np.argsort(printed_table.moved_axes(choice.axes))
        tensor = tensor[np.ix_(back, back)]
        tensors.append(np.where(_OFF, -tensor, tensor) if choice.products == "integral" else tensor)
        coms[i] = place[back] if choice.moves == "row" else place
    smallest = min(float(np.abs(t).max()) for t in tensors)
    digits = math.ceil(-math.log10(smallest)) + int(rng.integers(3, 6))
    origin = np.round(frame_vectors(frames, truth.table.convention), 5)
    com = np.round(coms, 5)
    if truth.shift:
        origin, com[-1] = np.vstack([origin[1:], com[-1]]), np.nan
    return replace(
        frames, mass=np.round([b.mass for b in bodies], 4), com=com, inertia=np.round(tensors, digits),
        inertia_step=10.0**-digits, origin=origin if truth.shift or rng.random() < 0.4 else None,
    )  # fmt: skip


def _evidence(
    rng: np.random.Generator,
    table: printed_table.PrintedTable,
    chain: Chain,
    bodies: list[Body],
    truth: printed_table.TableReading,
    kind: str,
) -> Evidence:
    tensors = _second(rng, bodies, truth) if kind in ("second tensors", "both") else None
    numbers = _numbers(rng, chain) if kind in ("numbers", "both") else ()
    places = () if table.origin is not None and rng.random() < 0.5 else tuple(_place(rng, chain) for _ in range(2))
    return Evidence(numbers=numbers, tensors=tensors, places=places)


def _second(rng: np.random.Generator, bodies: list[Body], truth: printed_table.TableReading) -> SecondTensors:
    digits = int(rng.integers(4, 6))
    other = "origin" if truth.table.about == "com" else "com"
    tensors = [b.inertia_origin() if other == "origin" else b.inertia_com for b in bodies]
    known = rng.random() < 0.7
    sign = 1.0 if known or rng.random() < 0.5 else -1.0
    texts = [[f"{(sign if r != c else 1.0) * t[r, c]:.{digits}g}" for r, c in printed_table.TENSOR] for t in tensors]
    return second_tensors(texts, other, ("tensor",) if known else ("tensor", "integral"))  # type: ignore[arg-type]


def _numbers(rng: np.random.Generator, chain: Chain) -> tuple[DerivedNumber, ...]:
    """B_ii of every joint, and now and then g_i, at one to three poses, by the recursion."""
    recursion, digits = Recursion.of(chain), int(rng.integers(4, 6))
    poses, gravity = int(rng.integers(1, 4)), rng.random() < 0.5
    out = []
    for q in rng.uniform(-2.5, 2.5, (poses, chain.n)):
        diagonal, torque = np.diag(recursion.mass_matrix(q)), recursion.gravity_vector(q)
        for j in range(chain.n):
            out.append(DerivedNumber("inertia", j, evidence_number(f"{diagonal[j]:.{digits}g}"), q))
            if gravity and abs(torque[j]) > 1e-6:
                out.append(DerivedNumber("gravity", j, evidence_number(f"{torque[j]:.{digits}g}"), q))
    return tuple(out)


def _place(rng: np.random.Generator, chain: Chain) -> FlangePlace:
    q = rng.uniform(-2.5, 2.5, chain.n)
    *_, flange = link_frames(chain, q)
    return FlangePlace(q, np.round(flange[:3, 3], 4), 0.5e-4)


def same_bodies(table: printed_table.PrintedTable, found: tuple[Body, ...], truth: tuple[Body, ...]) -> bool:
    """The same inertia parameters to the printed digits.

    Masses, coms and tensors about the com differ by no more than rounding of the printed cells can make.
    """
    return all(
        abs(a.mass - b.mass) <= table.mass_step
        and np.abs(a.com - b.com).max() <= table.com_step
        and np.abs(a.inertia_com - b.inertia_com).max() <= rounding_of_tensor(table, b)
        for a, b in zip(found, truth, strict=True)
    )


def rounding_of_tensor(table: printed_table.PrintedTable, body: Body) -> float:
    """What rounding of mass, com and tensor by a whole last digit can do to a tensor moved by m c^2 [kg m^2]."""
    reach = float(np.linalg.norm(body.com))
    return table.inertia_step + 2 * body.mass * reach * table.com_step + table.mass_step * reach**2


def same_arm(scrambled: ScrambledTable, found: tuple[Body, ...], convention: Convention) -> bool:
    """No motion distinguishes the two: B and g agree at random poses to what rounding of the cells can make."""
    other = with_bodies(scrambled.table.chain(convention), found)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (8, scrambled.table.n))
    ours, theirs = Recursion.of(other), Recursion.of(scrambled.chain)
    gaps = (ours.mass_matrix(q) - theirs.mass_matrix(q), ours.gravity_vector(q) - theirs.gravity_vector(q))
    sizes = (theirs.mass_matrix(q), theirs.gravity_vector(q))
    return all(np.abs(gap).max() <= SAME_ARM * np.abs(size).max() for gap, size in zip(gaps, sizes, strict=True))


SAME_ARM = 2e-4
"""Share of the largest entry of B or g: numbers are printed to four digits."""
