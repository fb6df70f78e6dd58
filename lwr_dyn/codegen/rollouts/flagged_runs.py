"""Runs that carry a flag: computed again by `simulate`, or their metrics marked as not known."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import DivergenceError
from lwr_dyn.model.run import Run


def settle(
    flags: Sequence[str],
    metrics: dict[str, Array],
    record: Array | None,
    stride: int,
    again: Callable[[int], Run] | None,
    figures: Callable[[Run, int], Mapping[str, Array]],
) -> NDArray[np.bool_]:
    """Put right the metrics and the record of runs with a flag; gives which of them are now those of `simulate`.

    Parameters
    ----------
    again : function, optional
        The run of a number by `simulate`; None leaves NaN. A run that diverges there leaves NaN too.
    figures : function
        (run, number) -> its metrics.
    """
    simulated = np.zeros(len(flags), dtype=bool)
    for i in (i for i, flag in enumerate(flags) if flag):
        for values in metrics.values():
            values[i] = np.nan
        if record is not None:
            record[i] = np.nan
        if again is None:
            continue
        simulated[i] = True
        try:
            run = again(i)
        except DivergenceError:
            continue
        for name, value in figures(run, i).items():
            metrics[name][i] = value
        if record is not None:
            record[i] = np.hstack([run.q, run.dq, run.tau_applied])[::stride]
    return simulated
