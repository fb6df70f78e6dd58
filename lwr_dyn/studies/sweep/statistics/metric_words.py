"""A metric of a run for people: its words, a unit that suits its size, and in which direction it is bad."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.dh import JointKind
from lwr_dyn.studies.sweep.study.metric_table import metric_row

SHOWN = {"m": ("mm", 1e3), "rad": ("mrad", 1e3), "rad or m": ("mrad or mm", 1e3)}
"""Unit -> the unit for people, and how many of it are one; others stay."""


@dataclass(frozen=True, slots=True)
class MetricWords:
    """Title and unit for people; `factor` times SI is that unit; `worse` is +1 where large values are bad, else -1."""

    name: str
    title: str
    unit: str
    factor: float
    worse: int

    def shown(self, badness: float) -> float:
        """The value of a `badness` in the unit for people."""
        return self.factor * self.worse * badness

    def badness(self, values: Array) -> Array:
        """One number a run (runs,) that is the larger the worse, of the worst joint of (runs, n); inf for NaN."""
        signed = self.worse * np.asarray(values, dtype=np.float64)
        whole = np.where(np.isnan(signed), inf, signed)
        return whole if whole.ndim == 1 else np.asarray(whole.max(axis=1))

    def is_within(self, values: Array, bound: float) -> NDArray[np.bool_]:
        """Which runs (runs,) keep a bound in SI units with all joints; a run without a number keeps none."""
        return np.asarray(self.badness(values) <= self.worse * bound)


def metric_words(name: str, quantiles: Sequence[float] = (), kinds: Collection[JointKind] = ()) -> MetricWords:
    """The words of a metric; `quantiles` over time are those of the study, `kinds` the kinds of the arm's joints.

    Raises
    ------
    UnknownNameError
        No metric of that name.

    >>> one = metric_words("limit_margin")
    >>> one.unit, one.worse, one.badness(np.array([[0.5, 0.2], [np.nan, 0.1]])).tolist()
    ('mrad or mm', -1, [-0.2, inf])
    """
    row = metric_row(name, tuple(quantiles))
    units = row.unit.split(" or ")  # of a turning joint, of a sliding one
    own = (
        units[0]
        if set(kinds) == {JointKind.REVOLUTE}
        else units[-1]
        if set(kinds) == {JointKind.PRISMATIC}
        else row.unit
    )
    unit, factor = SHOWN.get(own, (own, 1.0))
    title = f"{row.words}, worst joint" if row.per_joint else row.words
    return MetricWords(name, title, unit, factor, -1 if row.at_least else 1)
