"""Mutants of the data: every numeric cell of a paper's files changed, one at a time, and whether a verdict changes.

A number that can be changed without effect is a number without a check. Effects of a changed cell:

    refused    by the reader, or by an erratum whose printed value is no longer there
    verdict    a printed or derived number has another verdict, or needs other errata
    unseen     none; `moved` says by how many last digits the most sensitive number moved all the same
"""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from typing import Any

from lwr_dyn.foundation.errors import LwrDynError
from lwr_dyn.model.printed_number import last_digit
from lwr_dyn.reproduction.case import Value
from lwr_dyn.reproduction.compare import Verdicts, compare_numbers
from lwr_dyn.reproduction.paper_study import paper_study

KINDS = ("sign", "times ten", "neighbour", "one percent")
REFUSED, VERDICT, UNSEEN = "refused", "verdict", "unseen"
NEVER = ("source", "schema", "unit", "rows", "symbols")
"""Keys of numbers that are no data: versions, the unit "1", labels."""
Path = tuple[str | int, ...]
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


@dataclass(frozen=True, slots=True)
class Mutant:
    """One changed cell: in the data file ("tables") or in `results.toml` ("results")."""

    paper: str
    file: str
    path: Path
    kind: str
    before: Any
    after: Any

    @property
    def place(self) -> str:
        """As errata name cells: "inertial.mass.values[2]"."""
        text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in self.path).lstrip(".")
        return text if self.file == "tables" else f"results.{text}"


@dataclass(frozen=True, slots=True)
class Fate:
    """What became of a mutant."""

    mutant: Mutant
    seen: str
    turned: tuple[str, ...] = ()
    """Cells of results whose verdict turned."""
    moved: float = 0.0
    """Largest move of a recomputed number whose verdict stayed, in units of its last printed digit."""
    mover: str = ""
    """Which number that was."""

    @property
    def missed(self) -> bool:
        """It moved a printed or derived number by more than its last digit, and no check failed."""
        return self.seen == UNSEEN and self.moved > 1.0


def mutants(paper: str) -> Iterator[Mutant]:
    """Every mutant of a paper's two files, in the order of the files; changes that change nothing are left out."""
    data = paper_study(paper).data
    for file, raw in (("tables", data.tables), ("results", data.results.raw)):
        cells = list(numeric_cells(raw))
        for i, (path, value) in enumerate(cells):
            after = {"sign": _times(value, -1), "times ten": _times(value, 10), "one percent": _one_percent(value)}
            follower = cells[i + 1] if i + 1 < len(cells) else None
            if follower is not None and follower[0][:2] == path[:2]:
                after["neighbour"] = follower[1]
            for kind in KINDS:
                if kind in after and float(after[kind]) != float(value):
                    yield Mutant(paper, file, path, kind, value, after[kind])


def numeric_cells(raw: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Path and value of every number, and of every text that is a number, of parsed TOML."""
    if isinstance(raw, Mapping):
        for key, value in raw.items():
            if key not in NEVER:
                yield from numeric_cells(value, (*path, key))
    elif isinstance(raw, Sequence) and not isinstance(raw, str):
        for i, value in enumerate(raw):
            yield from numeric_cells(value, (*path, i))
    elif _is_number(raw):
        yield path, raw


def _is_number(raw: Any) -> bool:
    if isinstance(raw, str):
        return _NUMBER.fullmatch(raw) is not None
    return isinstance(raw, int | float) and not isinstance(raw, bool)


def mutated(raw: Mapping[str, Any], mutant: Mutant) -> dict[str, Any]:
    """A copy of parsed TOML with the mutant in it; an exchange changes the neighbour too."""
    out = copy.deepcopy(dict(raw))
    _put(out, mutant.path, mutant.after)
    if mutant.kind == "neighbour":
        paths = [path for path, _ in numeric_cells(raw)]
        _put(out, paths[paths.index(mutant.path) + 1], mutant.before)
    return out


def by_cell(verdicts: Verdicts) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Path of a cell -> its verdict and the errata that it takes."""
    return {number.cell.path: (number.verdict, number.errata) for number in verdicts.numbers}


def fate(mutant: Mutant, usual: Verdicts) -> Fate:
    """The verdicts of a paper with one changed cell; `usual` are those without the change."""
    study = paper_study(mutant.paper)
    raw = study.data.tables if mutant.file == "tables" else study.data.results.raw
    try:
        found = compare_numbers(study.with_data(**{mutant.file: mutated(raw, mutant)}), from_known_maxima=True)
    except LwrDynError:
        return Fate(mutant, REFUSED)
    before, after = by_cell(usual), by_cell(found)
    turned = tuple(path for path in before if before[path] != after.get(path))
    moved, mover = _largest_move(usual, found)
    return Fate(mutant, VERDICT if turned else UNSEEN, turned, moved, mover)


@cache
def usual_judgement(paper: str) -> Verdicts:
    """The verdicts that mutants are compared with: quick numbers only, searches from known maxima, as for mutants."""
    return compare_numbers(paper_study(paper), from_known_maxima=True)


def _largest_move(usual: Verdicts, found: Verdicts) -> tuple[float, str]:
    now = {j.cell.path: j for j in found.numbers}
    moves = [(_move(j.value, now[j.cell.path].value, j.cell.printed), j.cell.path) for j in usual.numbers
             if j.cell.path in now and j.verdict == now[j.cell.path].verdict]  # fmt: skip
    return max(moves, default=(0.0, ""))


def _move(before: Value, after: Value, printed: str) -> float:
    if not (isinstance(before, float) and isinstance(after, float)) or before == after:
        return 0.0
    return abs(after - before) / float(last_digit(printed))


def _put(holder: Any, path: Path, value: Any) -> None:
    for step in path[:-1]:
        holder = holder[step]
    holder[path[-1]] = value


def _times(value: Any, factor: int) -> Any:
    if isinstance(value, str):
        return str(Decimal(value) * factor)
    return value * factor


def _one_percent(value: Any) -> Any:
    """A hundredth more; of a text, in its own digits, and at least one of the last."""
    if not isinstance(value, str):
        return value * 1.01
    number, unit = Decimal(value), last_digit(value)
    step = max((abs(number) / 100).quantize(unit), unit)
    return str(number + step.copy_sign(number))


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """The fates of many mutants."""

    fates: tuple[Fate, ...]

    def counts(self) -> dict[str, int]:
        """How many were refused, turned a verdict, or were not seen."""
        return {seen: sum(f.seen == seen for f in self.fates) for seen in (REFUSED, VERDICT, UNSEEN)}

    @property
    def share(self) -> float:
        """Of the mutants, how many were seen."""
        return 1.0 - self.counts()[UNSEEN] / max(1, len(self.fates))

    @property
    def missed(self) -> tuple[Fate, ...]:
        """Those that moved a number by more than its last digit and were not seen."""
        return tuple(f for f in self.fates if f.missed)

    def survivors(self) -> dict[str, tuple[int, float]]:
        """Column -> how many of its mutants were not seen, and the largest move in last digits."""
        out: dict[str, tuple[int, float]] = {}
        for f in (f for f in self.fates if f.seen == UNSEEN):
            column = re.sub(r"\[\d+\]", "", f.mutant.place)
            count, moved = out.get(column, (0, 0.0))
            out[column] = (count + 1, max(moved, f.moved))
        return dict(sorted(out.items(), key=lambda item: -item[1][0]))


def survey(paper: str, chosen: Sequence[Mutant] | None = None) -> Survey:
    """The fates of the chosen mutants of a paper; all of them if not given."""
    usual = usual_judgement(paper)
    return Survey(tuple(fate(m, usual) for m in (tuple(mutants(paper)) if chosen is None else chosen)))
