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

    @property
    def broken(self) -> list[FirstBreak]:
        """The lines on which a limit breaks."""
        return [line for line in self.lines if line.share is not None]


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
    names, ways = [words.name for words in limits], [(span, end) for span in spans for end in span.ends]
    steps = np.arange(1, STEPS + 1) / STEPS

    def broken(rows: Mapping[str, NDArray[Any]]) -> NDArray[np.bool_]:
        """Which limit each run breaks (limits, runs)."""
        metrics = evaluate(rows)
        return np.array([~words.is_within(np.asarray(metrics[words.name]), x) for words, x in limits.items()])

    first = broken(_rows(spans, [(span, end, steps) for span, end in ways], nominal=True))
    if first[:, 0].any():
        return OutwardSearch((), first.shape[1], tuple(np.array(names)[first[:, 0]].tolist()))
    coarse = first[:, 1:].reshape(len(names), len(ways), STEPS)
    hits = [k for k in range(len(ways)) if coarse[:, k].any()]
    fine = [(*ways[k], (coarse[:, k].any(axis=0).argmax() + steps) / STEPS) for k in hits]
    second = broken(_rows(spans, fine)).reshape(len(names), len(fine), STEPS) if fine else coarse
    lines = [FirstBreak(span.path, end) for k, (span, end) in enumerate(ways) if k not in hits]
    for i, (span, end, shares) in enumerate(fine):
        found, before = second[:, i], coarse[:, hits[i]]
        at = int(found.any(axis=0).argmax())
        which = found[:, at]
        if not which.any():  # sensor noise differs in each run: the last step broke in the coarse pass
            at, which = STEPS - 1, before[:, before.any(axis=0).argmax()]
        last, start = float(span.at(shares[at], end)), float(span.nominal)
        kept, metric = span.before(last, end, STEPS**-2.0), names[int(which.argmax())]
        lines.append(FirstBreak(span.path, end, (last - start) / (end - start), kept, last, metric))
    runs = 1 + STEPS * (len(ways) + len(fine))
    return OutwardSearch(tuple(sorted(lines, key=lambda one: 2.0 if one.share is None else one.share)), runs)


def _rows(
    spans: Sequence[Span], moved: Sequence[tuple[Span, float, Array]], nominal: bool = False
) -> dict[str, NDArray[Any]]:
    """Values of every path, a row a run: nominal but for the path that is moved to shares of its way."""
    count = int(nominal) + STEPS * len(moved)
    values = {span.path: np.full(count, span.nominal) for span in spans}
    for k, (span, end, shares) in enumerate(moved):
        begin = int(nominal) + k * STEPS
        values[span.path][begin : begin + STEPS] = span.at(shares, end)
    return {s.path: values[s.path] if s.draws == 1 else np.tile(values[s.path][:, None], s.draws) for s in spans}
