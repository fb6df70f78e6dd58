"""What a search for gains aims at: a quantile over runs of one of their metrics."""

from collections.abc import Sequence
from dataclasses import dataclass

from lwr_dyn.foundation.arrays import Array, number_of
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.studies.sweep.statistics.intervals import quantile_of
from lwr_dyn.studies.sweep.statistics.metric_words import MetricWords, metric_words


@dataclass(frozen=True, slots=True)
class GainAim:
    """A quantile over runs of a metric of one run: of `share` of the runs it is to be small."""

    metric: MetricWords
    share: float

    def __post_init__(self) -> None:
        if not 0.0 < self.share < 1.0:
            raise OptionError("share of the aim", self.share, "between 0 and 1")

    @property
    def words(self) -> str:
        """As in "99 % quantile over runs: error of the tip, largest"."""
        return f"{100 * self.share:g} % quantile over runs: {self.metric.title}"

    def of(self, runs: Array) -> float:
        """The quantile of runs (k,); inf for one that reaches into runs without a number."""
        return quantile_of(runs, self.share).value


def gain_aim(text: str, quantiles: Sequence[float] = ()) -> GainAim:
    """The aim of a text such as "tip_max:0.99"; `quantiles` over time are those of the study.

    Raises
    ------
    OptionError
        Another form, a share that is not between 0 and 1, a metric of which more is better.
    UnknownNameError
        No metric of that name.

    >>> gain_aim("tip_max:0.99").words
    '99 % quantile over runs: error of the tip, largest'
    """
    name, _, share = text.partition(":")
    try:
        number = number_of(share)
    except ValueError:
        raise OptionError("aim", repr(text), "METRIC:SHARE, as tip_max:0.99") from None
    words = metric_words(name.strip(), quantiles)
    if words.worse < 0:
        raise OptionError("aim", repr(name), "a metric that is to be small, as tip_max")
    return GainAim(words, number)
