"""How often the true reading of scrambled tables is recovered, apart for tables whose evidence decides it or not.

Do the numbers published beside a table leave only one reading? Computed independently of `rank_readings`: the recursion
runs on every arm that differs from the truth in one choice (of one link, of the repeated links together, of all signs,
of the whole table). A choice is open when that arm has other bodies that can exist and gives the same numbers.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lwr_dyn.checks.conventions import printed_table
from lwr_dyn.checks.conventions.evidence import DerivedNumber
from lwr_dyn.checks.conventions.hypotheses import frame_vectors, other_ends, shifted, with_rows_moved
from lwr_dyn.checks.conventions.ranking import RankedReadings, rank_readings
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.model.chain import Body, Convention, is_physical, link_frames, with_bodies
from tests.checks.conventions import scrambled_tables

OUTCOMES = ("recovered", "same arm", "named", "lost")
"""The same inertial parameters to the printed digits (and DH convention); others, but no motion of the arm differs;
others, with the truth among the readings that are left; the truth not among those."""


@dataclass(frozen=True, slots=True)
class Recovery:
    """Counts of outcomes where the evidence decides, and where it leaves another reading as good as the truth."""

    decided: Mapping[str, int]
    undecidable: Mapping[str, int]
    missed: tuple[int, ...]
    """Numbers of the tables that are decided and not recovered, or that left the truth out; see `numbered_table`."""

    @property
    def rate(self) -> float:
        """Share recovered of the tables that the evidence decides."""
        total = sum(self.decided.values())
        return self.decided["recovered"] / total if total else float("nan")

    @property
    def kept_or_recovered(self) -> float:
        """Share of the undecidable tables that are recovered, or whose truth is among the readings that are left."""
        total = sum(self.undecidable.values())
        return 1.0 - self.undecidable["lost"] / total if total else float("nan")

    def statement(self) -> str:
        """Both shares in one sentence."""
        sums = [sum(x.values()) for x in (self.decided, self.undecidable)]
        return (
            f"{self.decided['recovered']} of {sums[0]} decidable tables recovered ({self.rate:.1%}); of {sums[1]} more "
            f"that no evidence decides {self.undecidable['recovered']} recovered as the plainest reading, "
            f"{self.undecidable['same arm'] + self.undecidable['named']} with the truth named among those left, "
            f"{self.undecidable['lost']} lost"
        )


def numbered_table(number: int, seed: int) -> scrambled_tables.ScrambledTable:
    """Table `number` of a series."""
    return scrambled_tables.scrambled_table(np.random.default_rng([seed, number]))


def recovery(count: int, seed: int = 7) -> Recovery:
    """Counts over so many tables that `count` of them are decidable."""
    decided: Counter[str] = Counter({x: 0 for x in OUTCOMES})
    undecidable: Counter[str] = Counter({x: 0 for x in OUTCOMES})
    missed, number = [], 0
    while sum(decided.values()) < count:
        one = numbered_table(number, seed)
        found = outcome(one, rank_readings(one.table, one.evidence))
        clear = not open_choices(one)
        (decided if clear else undecidable)[found] += 1
        if found == "lost" or (clear and found != "recovered"):
            missed.append(number)
        number += 1
    return Recovery(dict(decided), dict(undecidable), tuple(missed))


def outcome(one: scrambled_tables.ScrambledTable, found: RankedReadings) -> str:
    """One of `OUTCOMES`."""
    best, truth = found.best, one.truth
    if best is None:
        return "lost"
    convention = best.reading.table.convention
    if convention is truth.table.convention and scrambled_tables.same_bodies(one.table, best.bodies, one.bodies):
        return "recovered"
    left = any(
        c.reading.table == truth.table
        and all(any(x in equal for equal in c.remaining[i]) for i, x in enumerate(truth.links))
        for c in found.both or found.physical
    )
    if not left:
        return "lost"
    return "same arm" if scrambled_tables.same_arm(one, best.bodies, convention) else "named"


ROOM = 2.0
"""Half digits within which a number counts as the printed one: the table's rounding adds to the number's own."""


def open_choices(scrambled: scrambled_tables.ScrambledTable) -> tuple[str, ...]:
    """Names of the choices that the evidence leaves open; none when only the truth is left."""
    table = with_rows_moved(scrambled.table, scrambled.truth.shift)
    truth = scrambled.truth
    found = [f"link_{i + 1}" for i in range(table.n) if _open_link(scrambled, table, i)]
    for name, flipped in (("signs", range(table.n)), ("signs of repeated links", scrambled.alike)):
        links = tuple(
            replace(c, products="integral" if c.products == "tensor" else "tensor") if i in flipped else c
            for i, c in enumerate(truth.links)
        )
        if flipped and _open(scrambled, table, truth.table, links, only=flipped):
            found.append(name)
    for name, choice in _other_tables(truth.table):
        if _open(scrambled, table, choice, truth.links, only=None):
            found.append(name)
    return tuple(found)


def _other_tables(choice: printed_table.TableChoice) -> Iterator[tuple[str, printed_table.TableChoice]]:
    other = next(c for c in Convention if c is not choice.convention)
    yield "convention", replace(choice, convention=other)
    yield "about", replace(choice, about="origin" if choice.about == "com" else "com")
    yield "com_from", replace(choice, com_from="own frame" if choice.com_from == "other end" else "other end")


def _read(
    table: printed_table.PrintedTable, choice: printed_table.TableChoice, links: Sequence[printed_table.LinkChoice]
) -> tuple[Body, ...]:
    ends = other_ends(table, choice.convention)
    return tuple(printed_table.link_options(table, i, choice, ends[i], (c,)).body(0) for i, c in enumerate(links))


def _open(
    scrambled: scrambled_tables.ScrambledTable,
    table: printed_table.PrintedTable,
    choice: printed_table.TableChoice,
    links: Sequence,
    only,
) -> bool:
    """The arm so read has other bodies (or frames), which exist, and gives what is published; of the links `only`."""
    bodies = _read(table, choice, links)
    moved = choice.convention is not scrambled.truth.table.convention
    if moved and not _same_frames(scrambled, table, choice.convention):
        return False
    if not moved and scrambled_tables.same_bodies(table, bodies, scrambled.bodies):
        return False
    if not all(is_physical(b) for b in bodies) or not _second(scrambled, bodies):
        return False
    if only is not None and 0 < len(set(only) & set(scrambled.alike)) < len(scrambled.alike):
        return False
    recursion = Recursion.of(with_bodies(table.chain(choice.convention), bodies))
    true = with_bodies(scrambled.chain, _read(table, scrambled.truth.table, scrambled.truth.links))
    return _numbers_agree(scrambled, recursion, Recursion.of(true))


def _same_frames(
    scrambled: scrambled_tables.ScrambledTable, table: printed_table.PrintedTable, convention: Convention
) -> bool:
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


def _second(scrambled: scrambled_tables.ScrambledTable, bodies: Sequence[Body]) -> bool:
    """The second tensors come out, to their digits and those of the table."""
    tensors = scrambled.evidence.tensors
    if tensors is None:
        return True
    about = [b.inertia_origin() if tensors.about == "origin" else b.inertia_com for b in bodies]
    ours = np.array([[t[r, c] for r, c in printed_table.TENSOR] for t in about])
    room = ROOM * tensors.half + np.array([[scrambled_tables.rounding_of_tensor(scrambled.table, b)] for b in bodies])
    signs = [np.array([1.0] * 3 + [-1.0 if p == "integral" else 1.0] * 3) for p in tensors.products]
    return any(bool((np.abs(s * tensors.values - ours) <= room).all()) for s in signs)


def _open_link(scrambled: scrambled_tables.ScrambledTable, table: printed_table.PrintedTable, link: int) -> bool:
    """Some other choice for one link alone is as good as the truth."""
    choice, truth = scrambled.truth.table, scrambled.truth.links
    if link in scrambled.alike:
        return False  # its mirror image excludes the others, or all of them are open together
    others = [c for c in printed_table.CHOICES if c != truth[link]]
    found = printed_table.link_options(table, link, choice, other_ends(table, choice.convention)[link], others)
    options, true = [], _read(table, choice, truth)
    for o in range(len(found.choices)):
        bodies = list(true)
        bodies[link] = found.body(o)
        if scrambled_tables.same_bodies(table, tuple(bodies), scrambled.bodies) or not is_physical(bodies[link]):
            continue
        if _second(scrambled, bodies):
            options.append(bodies[link])
    right = Recursion.of(with_bodies(scrambled.chain, true))
    others = (Recursion.of(with_bodies(scrambled.chain, (*true[:link], b, *true[link + 1 :]))) for b in options)
    return any(_numbers_agree(scrambled, other, right) for other in others)


def _numbers_agree(scrambled: scrambled_tables.ScrambledTable, recursion: Recursion, true: Recursion) -> bool:
    """Whether every published number is that of the truth as the table prints it."""
    for x in scrambled.evidence.numbers:
        ours, theirs = (_number(each, x) for each in (recursion, true))
        if abs(ours - theirs) > ROOM * x.printed.half:
            return False
    return True


def _number(recursion: Recursion, number: DerivedNumber) -> float:
    """B_ii or g_i of one arm at the pose of a number."""
    if number.quantity == "gravity":
        return float(recursion.gravity_vector(number.q)[number.joint])
    return float(recursion.mass_matrix(number.q)[number.joint, number.joint])
