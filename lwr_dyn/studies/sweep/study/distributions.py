"""How the values of a parameter are distributed: from shares in (0, 1) to values, by the inverse distribution."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from lwr_dyn.foundation.arrays import Array

DISTRIBUTIONS = ("uniform", "normal", "choice", "levels", "fixed")
EDGE = 2.0**-53
"""Nearest that a share of a normal distribution comes to 0 and 1."""
Values = Array | NDArray[np.str_]
"""Numbers, or texts of a choice such as that of a reading."""


@dataclass(frozen=True, slots=True)
class VariedParameter:
    """A path, how its values are distributed, and the columns that it fills (one value of a run each).

    Parameters
    ----------
    path : str
        As "payload.mass", see `parameter_paths`.
    distribution : {"uniform", "normal", "choice", "levels", "fixed"}
    columns : tuple of str
        Names of its numbers of a run: ("payload.mass",), or ("arm.com.1.x", "arm.com.1.y", ...), each drawn by itself.
    unit, words : str
        Of the path.
    values : tuple
        Of "choice", "levels" (evenly from the lowest to the highest) and "fixed" (one).
    low, high : float
        Of "uniform"; where a "normal" distribution is cut, infinite where it is not.
    mean, deviation : float
        Of "normal".
    kind, note : str
        Where the distribution comes from: a kind of the data files ("assumed", "datasheet", ...), and free words.
    nominal : float or None
        As modelled; None where it depends on the controller or the task.
    """

    path: str
    distribution: str
    columns: tuple[str, ...]
    unit: str = ""
    words: str = ""
    values: tuple[float, ...] | tuple[str, ...] = ()
    low: float = -np.inf
    high: float = np.inf
    mean: float = 0.0
    deviation: float = 0.0
    kind: str = "assumed"
    note: str = ""
    nominal: float | None = None

    @property
    def is_varied(self) -> bool:
        """Whether runs differ in it."""
        return self.distribution != "fixed"

    @property
    def is_text(self) -> bool:
        """Whether its values are names."""
        return bool(self.values) and isinstance(self.values[0], str)

    @property
    def lowest(self) -> float | str:
        """The least value; three deviations below the mean where a normal distribution is not cut there."""
        if self.values:
            return self.values[0] if self.is_text else min(self.values)
        return self.low if np.isfinite(self.low) else self.mean - 3.0 * self.deviation

    @property
    def highest(self) -> float | str:
        """The largest value; three deviations above the mean where a normal distribution is not cut there."""
        if self.values:
            return self.values[-1] if self.is_text else max(self.values)
        return self.high if np.isfinite(self.high) else self.mean + 3.0 * self.deviation

    def values_of(self, shares: Array) -> Values:
        """Values of shares in [0, 1), of any shape, by the inverse of the distribution.

        >>> half = VariedParameter("payload.mass", "uniform", ("payload.mass",), low=0.0, high=7.0)
        >>> half.values_of(np.array([0.0, 0.5]))
        array([0. , 3.5])
        """
        if self.values:
            index = np.minimum((shares * len(self.values)).astype(int), len(self.values) - 1)
            chosen: Values = np.asarray(self.values)[index]
            return chosen
        if self.distribution == "uniform":
            return np.asarray(self.low + (self.high - self.low) * shares)
        least, most = ndtr((self.low - self.mean) / self.deviation), ndtr((self.high - self.mean) / self.deviation)
        inside = np.clip(least + (most - least) * shares, EDGE, 1.0 - EDGE)
        return np.asarray(np.clip(self.mean + self.deviation * ndtri(inside), self.low, self.high))

    @property
    def distribution_words(self) -> str:
        """The distribution in words, without a unit.

        >>> VariedParameter("loop.delay", "choice", ("loop.delay",), values=(0.0, 1.0, 2.0)).distribution_words
        'one of 0, 1, 2'
        """
        if self.distribution == "uniform":
            return f"uniform from {self.low:g} to {self.high:g}"
        if self.distribution == "normal":
            ends = [f"from {self.low:g}"] * bool(np.isfinite(self.low)) + [f"to {self.high:g}"] * bool(
                np.isfinite(self.high)
            )
            return " ".join(
                [f"normal, mean {self.mean:g}, deviation {self.deviation:g}", *(["cut"] if ends else []), *ends]
            )
        shown = ", ".join(x if isinstance(x, str) else f"{x:g}" for x in self.values)
        return {"fixed": shown, "choice": f"one of {shown}", "levels": f"levels {shown}"}[self.distribution]
