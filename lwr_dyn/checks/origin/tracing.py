"""Which published set the links of a file agree with, digit by digit, whatever its frames and units; where they differ.

Two numbers that agree in d digits do so by chance in one of about 10^d cases, so digits in which numbers agree are
evidence, and they add up over numbers that do not follow from each other. Of a link's numbers those count that a
copier leaves alone: entries as they are; their magnitudes where axes were exchanged; length and principal moments where
a frame was turned. A power of ten is one of a whole column. The freedom of a comparison is taken off its digits.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from lwr_dyn.checks.origin.link_numbers import KnownSet, LinkNumbers, known_sets
from lwr_dyn.foundation.arrays import Array

MOST_DIGITS = 6.0
"""Of one number: beyond, a file is rounded or computed."""
AGREE = 5e-3
"""Relative difference up to which two numbers agree at all."""
POWERS = range(-9, 10)
"""Of ten, that a column may differ by."""
PAIR = 3.0
"""Digits of a pair of links that any two may have by chance; the rest counts."""
ENOUGH = 8.0
"""Digits over all pairs from which a file is a copy; 8 times by chance in 1e8."""
LEAST_LINKS = 2
"""Links that must agree: one alone may be a gripper or a motor that two robots have in common."""
_DIAGONAL, _PRODUCTS = ((0, 0), (1, 1), (2, 2)), ((0, 1), (0, 2), (1, 2))
CELLS = {"masses": ("mass",), "centres": ("x", "y", "z"), "tensors": ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")}
"""Kind -> its numbers of a link."""
_FREE = {"as written": 0.0, "signs changed": 1.0, "axes exchanged": 1.5, "frame turned": 1.0}
"""How a column may be compared -> digits that this freedom is worth."""


@dataclass(frozen=True, slots=True)
class CellDifference:
    """A number of the file that is not the set's: both, as they stand, the file's power of ten taken off."""

    link: str
    cell: str
    file: float
    published: float


@dataclass(frozen=True, slots=True, eq=False)
class KindTrace:
    """One kind of number (of `CELLS`): in how many paired links it agrees, how it was compared, its power of ten.

    `elsewhere` are other sets with the same numbers.
    """

    kind: str
    agree: int
    how: str
    power: int
    digits: float
    elsewhere: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """The set that a file agrees with most: pairs (link of the file, link of the set), digits, where they differ."""

    known: KnownSet
    pairs: tuple[tuple[int, int], ...]
    digits: float
    kinds: tuple[KindTrace, ...]
    differences: tuple[CellDifference, ...]

    @property
    def is_copy(self) -> bool:
        """Whether chance does not explain it."""
        return self.digits >= ENOUGH and len(self.pairs) >= LEAST_LINKS


def significant_digits(values: Array) -> Array:
    """How many digits numbers have, written as short as they are; 0 of 0.

    >>> significant_digits(np.array([0.0, 7.1, 0.0340])).tolist()
    [0.0, 2.0, 2.0]
    """
    texts = [f"{abs(x):.8e}".split("e")[0].replace(".", "").rstrip("0") for x in np.ravel(values)]
    return np.array([float(len(text)) for text in texts]).reshape(np.shape(values))


def agreeing_digits(a: Array, b: Array, known: Array) -> Array:
    """Digits in which numbers agree, at most those that both have (`known`) and `MOST_DIGITS`; 0 where they do not.

    >>> agreeing_digits(np.array([3.0, 3.14159]), np.array([3.0, 3.14160]), np.array([1.0, 6.0])).round(1)
    array([1. , 5.5])
    """
    size = np.maximum(np.abs(a), np.abs(b))
    off = np.abs(a - b) / np.where(size > 0.0, size, 1.0)
    digits = np.minimum(-np.log10(np.maximum(off, 1e-12)), np.minimum(known, MOST_DIGITS))
    return np.where((off <= AGREE) & (size > 0.0), digits, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class _Forms:
    """Numbers of links as they are compared: form -> (m, numbers), with the digits that they have."""

    values: dict[str, tuple[Array, Array]]


def _with_digits(values: Array) -> tuple[Array, Array]:
    """Of equal numbers in a row one counts."""
    digits = significant_digits(values)
    for row, known in zip(np.abs(values), digits, strict=True):
        for k in range(1, row.size):
            if (np.abs(row[:k] - row[k]) <= 1e-9 * row[k]).any():
                known[k] = 0.0
    return values, digits


def _forms(links: LinkNumbers) -> dict[str, _Forms]:
    diagonal, products = (np.stack([links.tensor[:, i, j] for i, j in of], axis=1) for of in (_DIAGONAL, _PRODUCTS))
    entries, size = np.concatenate([diagonal, products], axis=1), np.sort(np.abs(links.com), axis=1)
    exchanged = np.concatenate([np.sort(diagonal, axis=1), np.sort(np.abs(products), axis=1)], axis=1)
    turned = np.linalg.eigvalsh((links.tensor + links.tensor.transpose(0, 2, 1)) / 2.0)
    forms = {
        "masses": {"as written": links.mass[:, None]},
        "centres": {"as written": links.com, "axes exchanged": size,
                    "frame turned": np.linalg.norm(links.com, axis=1)[:, None]},
        "tensors": {"as written": entries, "signs changed": np.concatenate([diagonal, np.abs(products)], axis=1),
                    "axes exchanged": exchanged, "frame turned": turned},
    }  # fmt: skip
    return {kind: _Forms({how: _with_digits(x) for how, x in of.items()}) for kind, of in forms.items()}


_known_forms = cache(_forms)


@dataclass(frozen=True, slots=True, eq=False)
class _Column:
    """Evidence (m, n) of one kind in one form at one power of ten."""

    evidence: Array
    how: str
    power: int


def _column(kind: str, file: _Forms, known: _Forms) -> _Column:
    """The form and the power of ten of a kind with most evidence over all links."""
    best = _Column(np.zeros((1, 1)), "as written", 0)
    most = -1.0
    for how, (values, digits) in file.values.items():
        others, theirs = known.values[how]
        both = np.minimum(digits[:, None], theirs[None])
        for power in POWERS:
            found = agreeing_digits(values[:, None] / 10.0**power, others[None], both).sum(axis=2)
            found = np.maximum(found - _FREE[how] * (found > 0.0), 0.0)
            total = float(found.max(axis=1).sum()) - (1.3 if power else 0.0)
            if total > most + 1e-9:
                best, most = _Column(found, how, power), total
    return best


def _aligned(evidence: Array) -> tuple[float, tuple[tuple[int, int], ...]]:
    """The pairs, in order in both, with most digits beyond `PAIR` each."""
    gain = np.maximum(evidence - PAIR, 0.0)
    m, n = gain.shape
    best = np.zeros((m + 1, n + 1))
    for i in range(m):
        for j in range(n):
            best[i + 1, j + 1] = max(best[i, j + 1], best[i + 1, j], best[i, j] + gain[i, j])
    pairs, i, j = [], m, n
    while i and j:
        if best[i, j] == best[i - 1, j]:
            i -= 1
        elif best[i, j] == best[i, j - 1]:
            j -= 1
        else:
            i, j = i - 1, j - 1
            pairs.append((i, j))
    return float(best[m, n]), tuple(reversed(pairs))


def trace_origin(links: LinkNumbers, sets: Sequence[KnownSet] | None = None) -> Trace | None:
    """The set that the links of a file agree with most; None where nothing agrees.

    Parameters
    ----------
    links : LinkNumbers
        Of the file.
    sets : sequence of KnownSet, optional
        Those of the package if not given.
    """
    known = known_sets() if sets is None else sets
    mine = _forms(links)
    found = [_against(mine, one, form) for one in known for form in (one.links, one.native)]
    if not found:
        return None
    digits, one, form, columns, pairs = max(found, key=lambda x: x[0])
    if not pairs:
        return None
    rest = [other for other in found if other[1].name != one.name]
    kinds = tuple(_kind(kind, columns[kind], pairs, rest) for kind in CELLS)
    return Trace(one, pairs, digits, kinds, tuple(_differences(links, form, columns, pairs)))


_Found = tuple[float, KnownSet, LinkNumbers, dict[str, _Column], tuple[tuple[int, int], ...]]


def _against(mine: dict[str, _Forms], one: KnownSet, form: LinkNumbers) -> _Found:
    theirs = _known_forms(form)
    columns = {kind: _column(kind, mine[kind], theirs[kind]) for kind in CELLS}
    digits, pairs = _aligned(np.sum([columns[kind].evidence for kind in CELLS], axis=0))
    return digits, one, form, columns, pairs


def _kind(kind: str, column: _Column, pairs: Sequence[tuple[int, int]], rest: Sequence[_Found]) -> KindTrace:
    own = np.array([column.evidence[i, j] for i, j in pairs])
    digits = float(own.sum())
    elsewhere = []
    for _, other, _, columns, _ in rest:
        same = float(_aligned(columns[kind].evidence + PAIR)[0])
        if digits >= ENOUGH and same >= 0.95 * digits:
            elsewhere.append(other.name)
    return KindTrace(kind, int(np.sum(own >= 1.0)), column.how, column.power, digits, tuple(dict.fromkeys(elsewhere)))


def _differences(
    links: LinkNumbers, form: LinkNumbers, columns: dict[str, _Column], pairs: Sequence[tuple[int, int]]
) -> Sequence[CellDifference]:
    """Cells that are not the set's, of columns that are compared as written."""
    out = []
    for i, j in pairs:
        for kind, names in CELLS.items():
            if columns[kind].how != "as written":
                continue
            mine, theirs = _cells(links, kind, i) / 10.0 ** columns[kind].power, _cells(form, kind, j)
            for name, a, b in zip(names, mine, theirs, strict=True):
                if abs(a - b) > 1e-6 * max(abs(a), abs(b)) and abs(a - b) > 1e-12:
                    out.append(CellDifference(links.names[i], name, float(a), float(b)))
    return out


def _cells(links: LinkNumbers, kind: str, i: int) -> Array:
    """The numbers of link i, as `CELLS` names them."""
    if kind == "masses":
        return links.mass[[i]]
    return links.com[i] if kind == "centres" else np.array([links.tensor[i][at] for at in (*_DIAGONAL, *_PRODUCTS)])
