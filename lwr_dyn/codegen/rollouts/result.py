"""What rollouts give: metrics of every run, flags, and each run again, whole, by `simulate`.

Metrics come from a kernel's figures, or from a `Run`, by the conventions of `simulation.metrics` in SI units. Runs that
carry a flag are computed again by `simulate`, or their metrics marked as not known.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.rollouts.kernel import Computed
from lwr_dyn.codegen.rollouts.loop_setup import LoopSetup
from lwr_dyn.codegen.rollouts.step import FIGURES, Slots
from lwr_dyn.codegen.rollouts.symbolic_arm import LARGEST
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import DivergenceError, OptionError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.contact import TURN

STOP, NOT_FINITE, OUT_OF_RANGE = "stop", "not finite", "out of range"

FLAGS = ("", STOP, NOT_FINITE, OUT_OF_RANGE)
"""What ended a run's course in the kernel, in words: nothing; a joint reached its stop, which the kernel does not have;
a state or torque that is not finite; a speed above `symbolic_arm.LARGEST` (0.2 rad) a step of RK4, or an angle beyond
the range reduction."""


@dataclass(frozen=True, slots=True, eq=False)
class Rollouts:
    """Runs of one closed loop with parameters of their own. The plant has no stick friction and no stops.

    Runs that met a stop, or left what the kernel can follow, carry a flag; their metrics are those of `simulate` where
    they were handed over (`simulated`), else NaN.
    """

    metrics: Mapping[str, Array]
    """By name, a row a run: tip_rms, tip_max, tip_final (runs,) [m]; position_rms, position_max (runs, n) [rad];
    peak_torque, peak_command, torque_rms, peak_speed (runs, n); saturated_s (runs, n) [s], NaN where
    no torque limit is known; limit_margin (runs, n) [rad]; first_violation (runs,) [s], inf for none; tip_q95 ...
    (runs,) [m] for quantiles over time."""
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

    def __repr__(self) -> str:
        flagged = ", ".join(f"{self.flags.count(flag)} {flag}" for flag in FLAGS if flag in self.flags and flag)
        by_simulate = f", {int(self.simulated.sum())} of them by simulate" if self.simulated.any() else ""
        record = "" if self.t is None else f", record of {self.t.size} samples"
        error = self.setup.get("step_error")
        step = "" if error is None else f", step error {error:.1g} rad (estimated)"
        return (
            f"Rollouts({self.count} runs, flags: {flagged or 'none'}{by_simulate}, {len(self.metrics)} metrics"
            f"{record}{step})"
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


def quantile_name(share: float) -> str:
    """The metric of a quantile over time of the tip error.

    >>> quantile_name(0.95), quantile_name(0.999), quantile_name(0.5)
    ('tip_q95', 'tip_q999', 'tip_q50')
    """
    digits = f"{share:.9f}".removeprefix("0.").rstrip("0")
    return f"tip_q{digits.ljust(2, '0')}"


def checked_quantiles(quantiles: Sequence[float]) -> tuple[float, ...]:
    """The shares, each between 0 and 1; raises `OptionError`."""
    if not isinstance(quantiles, Iterable):
        raise OptionError("quantiles", quantiles, "a sequence, as [0.95]")
    for share in quantiles:
        if not (isinstance(share, float | int) and 0.0 < share < 1.0):
            raise OptionError("quantiles", share, "shares of time between 0 and 1")
    return tuple(float(share) for share in quantiles)


def metrics_of_computed(
    setup: LoopSetup,
    slots: Slots,
    computed: Computed,
    quantiles: Sequence[float],
    effort_given: bool = False,
) -> tuple[dict[str, Array], list[str]]:
    """Metrics of all runs, and the flag of each in words (`FLAGS`); each run may have its own torque limits."""
    known = np.isfinite(setup.plant.effort) | effort_given
    first, places = slots.first(FIGURES[0]), {name: slots.places(name) for name in FIGURES}
    rows = {name: computed.figures[:, at.start - first : at.stop - first] for name, at in places.items()}
    samples, rate = setup.samples, setup.loop.rate
    late = rows["violation"][:, 0]
    with np.errstate(invalid="ignore"):
        metrics = {
            "tip_rms": np.sqrt(rows["tip_squares"][:, 0] / samples), "tip_max": np.sqrt(rows["tip_worst"][:, 0]),
            "tip_final": np.sqrt(rows["tip_square"][:, 0]),
            "position_rms": np.sqrt(rows["position_squares"] / samples), "position_max": rows["position_worst"],
            "peak_torque": rows["torque_worst"], "peak_command": rows["command_worst"],
            "torque_rms": np.sqrt(rows["torque_squares"] / samples), "peak_speed": rows["speed_worst"],
            "saturated_s": np.where(known, rows["saturated"] / rate, np.nan), "limit_margin": rows["margin"],
            "first_violation": np.where(late < samples, setup.t[np.where(late < samples, late, 0).astype(int)], np.inf),
        }  # fmt: skip
    for j, share in enumerate(quantiles):
        metrics[quantile_name(share)] = computed.quantiles[:, j].copy()
    return metrics, _flags(setup, rows)


def _flags(setup: LoopSetup, rows: Mapping[str, Array]) -> list[str]:
    speed = min(TURN * setup.loop.rate, LARGEST * setup.loop.rate * setup.loop.substeps)
    angle = (sincos("float64").most_half_turns - 1) * np.pi
    met = {
        STOP: (rows["margin"] <= 0.0).any(axis=1) & setup.loop.position_limits,
        NOT_FINITE: rows["trouble"][:, 0] != 0.0,
        OUT_OF_RANGE: (rows["speed_worst"] > speed).any(axis=1) | (rows["angle_worst"][:, 0] > angle**2),
    }
    return [next((word for word in met if met[word][i]), "") for i in range(len(met[STOP]))]


def figures_of(run: Run, arm: Arm, tolerance: float | None = None, quantiles: Sequence[float] = ()) -> dict[str, Array]:
    """The metrics of one run of `simulate`, as `Rollouts.metrics` has them, without the axis of runs.

    Parameters
    ----------
    run : Run
    arm : Arm
        The plant: its limits and kinematics.
    tolerance : float, optional
        [m] of the tip error whose first violation is given.
    quantiles : sequence of float
        Shares of time.
    """
    tip = [flange_pose(arm.chain, q)[:, :3, 3] for q in (run.q_ref, run.q)]
    away, error = np.linalg.norm(tip[0] - tip[1], axis=1), run.q_ref - run.q
    steps = np.diff(run.t, append=run.t[-1])
    beyond = np.flatnonzero(away > (np.inf if tolerance is None else tolerance))
    out = {
        "tip_rms": np.sqrt(np.mean(away**2)), "tip_max": away.max(), "tip_final": away[-1],
        "position_rms": np.sqrt(np.mean(error**2, axis=0)), "position_max": np.abs(error).max(axis=0),
        "peak_torque": np.abs(run.tau_applied).max(axis=0), "peak_command": np.abs(run.tau_command).max(axis=0),
        "torque_rms": np.sqrt(np.mean(run.tau_applied**2, axis=0)), "peak_speed": np.abs(run.dq).max(axis=0),
        "saturated_s": np.where(np.isfinite(arm.effort), steps @ (np.abs(run.tau_command) > arm.effort), np.nan),
        "limit_margin": np.minimum(run.q - arm.lower, arm.upper - run.q).min(axis=0),
        "first_violation": run.t[beyond[0]] if beyond.size else np.inf,
    }  # fmt: skip
    out |= {quantile_name(share): np.quantile(away, share) for share in quantiles}
    return {name: np.asarray(value, dtype=np.float64) for name, value in out.items()}


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
