"""Which parameter breaks a limit first: each alone is moved from its nominal value to the ends of its range.

This takes runs of its own, a few dozen a parameter: in the runs of a study all parameters vary at once, and none is at
its nominal value. What only a combination of parameters breaks is not seen here.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.studies.sweep.vocabulary import MetricWords

STEPS = 16
"""Of a line, and again of the step in which a limit breaks: 256 in all."""

Evaluate = Callable[[Mapping[str, NDArray[Any]]], Mapping[str, Array]]
"""Values of all paths, a row a run -> metrics of these runs in SI units."""


@dataclass(frozen=True, slots=True)
class Span:
    """A parameter's nominal value and its range; `draws` move together where a path has several.

    One that is chosen by name has no range: it stays as it is. `values` are those it can have, such as the delays.
    """

    path: str
    nominal: float | str
    lowest: float = 0.0
    highest: float = 0.0
    draws: int = 1
    values: tuple[float, ...] = ()

    @property
    def ends(self) -> tuple[float, ...]:
        """The ends to move to: that below the nominal value and that above it, where there are such."""
        if isinstance(self.nominal, str):
            return ()
        ways = self.lowest - self.nominal, self.highest - self.nominal
        both = (self.lowest, self.highest) if ways[0] * ways[1] < 0.0 else (self.nominal + max(ways, key=abs),)
        return tuple(end for end in both if end != self.nominal)

    def at(self, share: Array | float, end: float) -> Array:
        """The value at a share of the way from the nominal value to an end."""
        start = float(self.nominal)
        value = np.asarray(start + np.asarray(share, dtype=np.float64) * (end - start))
        if not self.values:
            return value
        known = np.array([start, *self.values])
        return np.asarray(known[np.abs(value[..., None] - known).argmin(axis=-1)])

    def before(self, value: float, end: float, step: float) -> float:
        """The value in front of one on the way to an end: the one before among `values`, or `step` of the way less."""
        start = float(self.nominal)
        if not self.values:
            return value - step * (end - start)
        nearer = [
            one
            for one in (start, *self.values)
            if 0.0 <= (one - start) / (end - start) < (value - start) / (end - start)
        ]
        return max(nearer, key=lambda one: abs(one - start))


@dataclass(frozen=True, slots=True)
class FirstBreak:
    """Where a parameter alone, moved from its nominal value to `end`, breaks a limit first.

    `kept` is the last value without a broken limit, `broken` the first with one, `share` how far `broken` is along the
    way; all three are None where every value keeps the limits. `metric` is the limit that breaks.
    """

    path: str
    end: float
    share: float | None = None
    kept: float | None = None
    broken: float | None = None
    metric: str | None = None


@dataclass(frozen=True, slots=True)
class OutwardSearch:
    """The lines of all parameters, the one that breaks a limit first in front, and the number of runs it took.

    `at_nominal` names the limits that are broken before anything is moved.
    """

    lines: tuple[FirstBreak, ...]
    runs: int
    at_nominal: tuple[str, ...] = ()


def outward_search(spans: Sequence[Span], limits: Mapping[MetricWords, float], evaluate: Evaluate) -> OutwardSearch:
    """Move each parameter alone from its nominal value outwards until a limit breaks; raises as `evaluate`.

    Parameters
    ----------
    spans : sequence of Span
        All varied parameters.
    limits : mapping
        Words of a metric -> its bound in SI units.
    evaluate : callable
        Makes runs, twice at most: `STEPS` of each line, then `STEPS` inside the step that breaks.
    """
    ways = [(span, end) for span in spans for end in span.ends]
    grid = np.arange(STEPS + 1) / STEPS
    first = _broken(_rows(spans, [(span, end, grid[1:]) for span, end in ways], nominal=True), limits, evaluate)
    at_nominal = tuple(metric for metric, broken in first.items() if broken[0])
    if at_nominal:
        return OutwardSearch((), first[at_nominal[0]].size, at_nominal)
    coarse = [
        {metric: rows[1 + k * STEPS : 1 + (k + 1) * STEPS] for metric, rows in first.items()} for k in range(len(ways))
    ]
    hit = [(way, found) for way, found in zip(ways, coarse, strict=True) if _first(found) is not None]
    fine = [(*way, (_index(found) + grid[1:]) / STEPS) for way, found in hit]
    second = _broken(_rows(spans, fine), limits, evaluate) if fine else {}
    lines = [
        FirstBreak(span.path, end) for (span, end), found in zip(ways, coarse, strict=True) if _first(found) is None
    ]
    for k, (span, end, shares) in enumerate(fine):
        found = {metric: rows[k * STEPS : (k + 1) * STEPS] for metric, rows in second.items()}
        lines.append(_line(span, end, shares, found, hit[k][1]))
    runs = 1 + STEPS * (len(ways) + len(fine))
    return OutwardSearch(tuple(sorted(lines, key=lambda one: 2.0 if one.share is None else one.share)), runs)


def _line(
    span: Span, end: float, shares: Array, broken: Mapping[str, NDArray[np.bool_]], coarse: Mapping[str, NDArray[Any]]
) -> FirstBreak:
    at = _index(broken)
    seen, row = (coarse, _index(coarse)) if _first(broken) is None else (broken, at)  # sensor noise differs in each run
    metric = next(name for name, rows in seen.items() if rows[row])
    last = float(span.at(shares[at], end))
    share = (last - float(span.nominal)) / (end - float(span.nominal))
    return FirstBreak(span.path, end, share, span.before(last, end, STEPS**-2.0), last, metric)


def _first(broken: Mapping[str, NDArray[np.bool_]]) -> int | None:
    """The first step of a line at which any limit is broken."""
    found = np.flatnonzero(np.any(list(broken.values()), axis=0))
    return int(found[0]) if found.size else None


def _index(broken: Mapping[str, NDArray[np.bool_]]) -> int:
    at = _first(broken)
    return STEPS - 1 if at is None else at  # the last step broke in the coarse pass


def _rows(
    spans: Sequence[Span], moved: Sequence[tuple[Span, float, Array]], nominal: bool = False
) -> dict[str, NDArray[Any]]:
    """Values of every path, a row a run: nominal but for the path that is moved to shares of its way."""
    count = int(nominal) + sum(shares.size for _, _, shares in moved)
    values = {span.path: np.full(count, span.nominal) for span in spans}
    at = int(nominal)
    for span, end, shares in moved:
        values[span.path][at : at + shares.size] = span.at(shares, end)
        at += shares.size
    return {s.path: values[s.path] if s.draws == 1 else np.tile(values[s.path][:, None], s.draws) for s in spans}


def _broken(
    values: Mapping[str, NDArray[Any]], limits: Mapping[MetricWords, float], evaluate: Evaluate
) -> dict[str, NDArray[np.bool_]]:
    metrics = evaluate(values)
    return {words.name: ~words.is_within(np.asarray(metrics[words.name]), bound) for words, bound in limits.items()}
