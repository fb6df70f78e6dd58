"""Metrics of runs from a kernel's figures, or from a `Run`, by the conventions of `simulation.metrics` in SI units."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from lwr_dyn.codegen.kernels.sincos import sincos
from lwr_dyn.codegen.rollouts.kernel import Computed
from lwr_dyn.codegen.rollouts.loop_setup import LoopSetup
from lwr_dyn.codegen.rollouts.result import NOT_FINITE, OUT_OF_RANGE, STOP
from lwr_dyn.codegen.rollouts.slots import FIGURES, Slots
from lwr_dyn.codegen.rollouts.small_turn import LARGEST
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.events import TURN


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
    setup: LoopSetup, slots: Slots, computed: Computed, quantiles: Sequence[float]
) -> tuple[dict[str, Array], list[str]]:
    """Metrics of all runs, and the flag of each in words (`result.FLAGS`)."""
    places = {name: [p - slots.first(FIGURES[0]) for p in slots.places(name)] for name in FIGURES}
    rows = {name: computed.figures[:, at] for name, at in places.items()}
    samples, rate = setup.samples, setup.rate
    late = rows["violation"][:, 0]
    with np.errstate(invalid="ignore"):
        metrics = {
            "tip_rms": np.sqrt(rows["tip_squares"][:, 0] / samples), "tip_max": np.sqrt(rows["tip_worst"][:, 0]),
            "tip_final": np.sqrt(rows["tip_square"][:, 0]),
            "position_rms": np.sqrt(rows["position_squares"] / samples), "position_max": rows["position_worst"],
            "peak_torque": rows["torque_worst"], "peak_command": rows["command_worst"],
            "torque_rms": np.sqrt(rows["torque_squares"] / samples), "peak_speed": rows["speed_worst"],
            "saturated_s": rows["saturated"] / rate, "limit_margin": rows["margin"],
            "first_violation": np.where(late < samples, setup.t[np.where(late < samples, late, 0).astype(int)], np.inf),
        }  # fmt: skip
    for j, share in enumerate(quantiles):
        metrics[quantile_name(share)] = computed.quantiles[:, j].copy()
    return metrics, _flags(setup, rows)


def _flags(setup: LoopSetup, rows: Mapping[str, Array]) -> list[str]:
    speed = min(TURN * setup.rate, LARGEST * setup.rate * setup.substeps)
    angle = (sincos("float64").most_half_turns - 1) * np.pi
    met = {
        STOP: (rows["margin"] <= 0.0).any(axis=1) & setup.position_limits,
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
        "saturated_s": steps @ (np.abs(run.tau_command) > arm.effort),
        "limit_margin": np.minimum(run.q - arm.lower, arm.upper - run.q).min(axis=0),
        "first_violation": run.t[beyond[0]] if beyond.size else np.inf,
    }  # fmt: skip
    out |= {quantile_name(share): np.quantile(away, share) for share in quantiles}
    return {name: np.asarray(value, dtype=np.float64) for name, value in out.items()}
