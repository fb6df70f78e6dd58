"""The runs of one controller of a study, as columns."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError


@dataclass(frozen=True, slots=True, eq=False)
class ControllerRuns:
    """What a study keeps of k runs of one controller; a study that is not finished has fewer.

    `run` are their numbers in the study, ascending. `values` are what was varied: path -> (k,), (k, m) where a path has
    several draws, texts where it is chosen by name. `metrics` are in SI units: name -> (k,), or (k, n) for joints.
    `flags` say what a kernel could not follow, "" for nothing; `simulated` which metrics are those of `simulate`.

    Raises
    ------
    OptionError
        A column with another number of rows.
    """

    label: str
    run: NDArray[np.int64]
    values: Mapping[str, NDArray[Any]]
    metrics: Mapping[str, Array]
    flags: NDArray[np.str_]
    simulated: NDArray[np.bool_]

    def __post_init__(self) -> None:
        own: dict[str, NDArray[Any]] = {"flags": self.flags, "simulated": self.simulated}
        for name, column in (*self.values.items(), *self.metrics.items(), *own.items()):
            if column.shape[:1] != self.run.shape:
                raise OptionError(f"runs of {self.label}: {name}", f"{column.shape[0]} rows", f"{self.run.size}")

    @property
    def count(self) -> int:
        """How many runs."""
        return int(self.run.size)
