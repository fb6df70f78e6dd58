"""What rollouts give: metrics of every run, flags, and each run again, whole, by `simulate`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.run import Run
from lwr_dyn.model.shown import repr_html

STOP, NOT_FINITE, OUT_OF_RANGE = "stop", "not finite", "out of range"
FLAGS = ("", STOP, NOT_FINITE, OUT_OF_RANGE)
"""What ended a run's course in the kernel, in words: nothing; a joint reached its stop, which the kernel does not have;
a state or torque that is not finite; a speed above `small_turn.LARGEST` (0.2 rad) a step of RK4, or an angle beyond the
range reduction."""


@dataclass(frozen=True, slots=True, eq=False)
class Rollouts:
    """Runs of one closed loop with parameters of their own. The plant has no stick friction and no stops.

    Runs that met a stop, or left what the kernel can follow, carry a flag; their metrics are those of `simulate` where
    they were handed over (`simulated`), else NaN.
    """

    metrics: Mapping[str, Array]
    """By name, a row a run: tip_rms, tip_max, tip_final (runs,) [m]; position_rms, position_max (runs, n) [rad];
    peak_torque, peak_command, torque_rms, peak_speed (runs, n); saturated_s (runs, n) [s]; limit_margin (runs, n)
    [rad]; first_violation (runs,) [s], inf for none; tip_q95 ... (runs,) [m] for quantiles over time."""
    flags: tuple[str, ...]
    """One of `FLAGS` a run."""
    simulated: NDArray[np.bool_]
    """(runs,): whether the metrics are those of `simulate`."""
    t: Array | None = None
    """Times (k,) [s] of the recorded samples; None without a record."""
    q: Array | None = None
    """(runs, k, n) [rad or m]; NaN for runs with a flag."""
    dq: Array | None = None
    tau: Array | None = None
    """Torques that were applied, (runs, k, n) [N m]."""
    setup: Mapping[str, Any] = field(default_factory=dict)
    """What was computed, as JSON values: arm, plant, law, options, first run, digest of the kernel."""
    digest: str = ""
    """Of all on which the kernel depends but processor and versions: runs of one digest may stand side by side."""
    again: Callable[[int], Run] | None = field(default=None, repr=False)
    _repr_html_ = repr_html

    def __repr__(self) -> str:
        flagged = ", ".join(f"{self.flags.count(flag)} {flag}" for flag in FLAGS if flag in self.flags and flag)
        by_simulate = f", {int(self.simulated.sum())} of them by simulate" if self.simulated.any() else ""
        record = "" if self.t is None else f", record of {self.t.size} samples"
        return (
            f"Rollouts({self.count} runs, flags: {flagged or 'none'}{by_simulate}, {len(self.metrics)} metrics{record})"
        )

    @property
    def count(self) -> int:
        """Number of runs."""
        return len(self.flags)

    def run(self, i: int) -> Run:
        """Run `i` (from 0) again, whole, by `simulate` with the same plant, gains and noise.

        With the resolution of an encoder the two agree for 2 to 6 s only: rounding grows between two counts until
        a reading falls into the next; the figures stay those of the same loop, to about 1e-3.
        Raises `OptionError` for what is no number of a run, and as `simulate`, above all `DivergenceError`.
        """
        whole = isinstance(i, int | np.integer) and not isinstance(i, bool)
        if self.again is None or not whole or not -self.count <= i < self.count:
            raise OptionError("run", repr(i), f"0 to {self.count - 1}")
        return self.again(int(i) % self.count)
