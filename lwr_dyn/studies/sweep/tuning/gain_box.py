"""What a search may vary: paths of a study with a lowest and a highest value, and the unit cube that it walks in."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lwr_dyn.foundation.arrays import Array, number_of
from lwr_dyn.foundation.errors import OptionError

FORM = "PATH=LOW:HIGH, as controller.omega_n=5:200"


@dataclass(frozen=True, slots=True)
class SearchedGain:
    """A path between `low` and `high`; its logarithm is searched where both are above 0.

    Raises
    ------
    OptionError
        Bounds that are not finite, or not low < high.
    """

    path: str
    low: float
    high: float

    def __post_init__(self) -> None:
        if not (np.isfinite([self.low, self.high]).all() and self.low < self.high):
            raise OptionError(f"bounds of {self.path}", f"{self.low:g} to {self.high:g}", "two numbers, low < high")

    @property
    def is_logarithmic(self) -> bool:
        """Whether equal steps of the search are equal ratios."""
        return self.low > 0.0

    @property
    def name(self) -> str:
        """The path without its group: controller.omega_n is omega_n."""
        return self.path.removeprefix("controller.")

    def value(self, share: Array) -> Array:
        """Values of shares (...) of the way from `low` to `high`.

        >>> SearchedGain("controller.omega_n", 1.0, 100.0).value(np.array([0.0, 0.5, 1.0])).round(9).tolist()
        [1.0, 10.0, 100.0]
        """
        if not self.is_logarithmic:
            return np.asarray(self.low + (self.high - self.low) * share)
        return np.asarray(np.clip(self.low * (self.high / self.low) ** share, self.low, self.high))

    def share(self, value: float) -> float:
        """The share of a value, clipped to 0 ... 1."""
        inside = min(max(value, self.low), self.high)
        if not self.is_logarithmic:
            return float((inside - self.low) / (self.high - self.low))
        return float(np.log(inside / self.low) / np.log(self.high / self.low))


def searched_gain(text: str) -> SearchedGain:
    """The gain of a text such as "controller.omega_n=5:200"; a name without a dot is an option of the controller.

    Raises
    ------
    OptionError
        Another form, or bounds that are no numbers, not finite or not low < high.

    >>> searched_gain("omega_n=5:200")
    SearchedGain(path='controller.omega_n', low=5.0, high=200.0)
    """
    path, _, bounds = (part.strip() for part in text.partition("="))
    low, colon, high = bounds.partition(":")
    if not (path and colon):
        raise OptionError("gain", repr(text), FORM)
    try:
        ends = number_of(low), number_of(high)
    except ValueError:
        raise OptionError(f"bounds of {path}", repr(bounds), FORM) from None
    name = path.replace("-", "_")
    return SearchedGain(name if "." in name else f"controller.{name}", *ends)


def values_of(gains: Sequence[SearchedGain], shares: Array) -> Array:
    """Values (k, d) of points (k, d) of the unit cube."""
    return np.stack([gain.value(shares[:, i]) for i, gain in enumerate(gains)], axis=-1)
