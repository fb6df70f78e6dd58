"""What a loop made of steps: rise, overshoot, settling, joint by joint, from a run of the task `step`."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from lwr_dyn.arms.loading import arm_of
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run

RISE = (0.1, 0.9)
"""Shares of the step between which the rise time counts."""
BAND = 0.02
"""Share of the step within which it counts as settled."""
LAST = 0.1
"""Share of the window, at its end, over which the error that is left is averaged."""


@dataclass(frozen=True, slots=True, eq=False)
class StepResponse:
    """The response of one joint to its step: times from the step on [s], NaN where the window ended before.

    `joint` from 1; `rise` from 10 to 90 %, `peak` when it is largest, `overshoot` beyond the step as a share of it,
    `settling` when it comes within 2 % for good, `left` the error at the end as a share. `cut` [s]: how long some
    torque was cut at its limit; then the response is not that of a linear loop. `t` (k,) [s], `y` (k,) from 0 to 1.
    """

    joint: int
    size: float
    rise: float
    peak: float
    overshoot: float
    settling: float
    left: float
    cut: float
    t: Array
    y: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "t", "y")

    def to_json(self) -> dict[str, Any]:
        """The figures as JSON values; None for NaN."""
        figures = {key: value for key, value in asdict(self).items() if key not in ("t", "y")}
        return {key: None if np.isnan(value) else value for key, value in figures.items()}


def about_task(run: Run, task: str) -> dict[str, Any]:
    """What a run's record says of its reference; raises `OptionError` unless it is of the task given."""
    about = dict(run.meta.get("reference", {}).get("about", {}))
    if about.get("task") != task:
        raise OptionError("run", f"of the task {about.get('task', 'unknown')!r}", f"a run of the task {task!r}")
    return about


def step_responses(run: Run, arm: Arm | None = None) -> tuple[StepResponse, ...]:
    """The response of each joint that stepped; `arm` is the run's own if not given.

    Raises `OptionError` for a run of another task.
    """
    about = about_task(run, "step")
    return tuple(
        _response(run, arm, joint - 1, about["size"], about["begin"] + k * about["window"], about["window"])
        for k, joint in enumerate(about["joints"])
        if about["begin"] + k * about["window"] < run.t[-1]
    )


def _response(run: Run, arm: Arm | None, joint: int, size: float, begin: float, window: float) -> StepResponse:
    rows = slice(*np.searchsorted(run.t, [begin - 1e-9, begin + window - 1e-9]))
    t = run.t[rows] - run.t[rows][0]
    y = (run.q[rows, joint] - run.q[rows, joint][0]) / size
    target = (run.q_ref[rows, joint][0] - run.q[rows, joint][0]) / size  # 1 where it was at rest on its reference
    low, high = (_first(t, y - share * target) for share in RISE)
    outside = np.flatnonzero(np.abs(y - target) > BAND * abs(target))
    settling = _first(t, BAND * abs(target) - np.abs(y - target), int(outside[-1]) if outside.size else 0)
    last = t >= t[-1] - LAST * window
    return StepResponse(
        joint=joint + 1, size=size, rise=high - low, peak=float(t[np.argmax(y)]),
        overshoot=max(0.0, float(y.max() - target)), settling=settling,
        left=float(np.mean(target - y[last])), cut=seconds_cut(run, arm, rows), t=t, y=y,
    )  # fmt: skip


def seconds_cut(run: Run, arm: Arm | None, rows: slice) -> float:
    """How long the command of some joint was beyond its torque limit [s]."""
    effort = (arm_of(run) if arm is None else arm).effort
    return float(np.sum((np.abs(run.tau_command[rows]) > effort).any(axis=1)) * np.mean(np.diff(run.t[rows])))


def _first(t: Array, y: Array, begin: int = 0) -> float:
    """When y first comes to 0 from below after row `begin`, between two samples by a line; NaN where it does not."""
    above = np.flatnonzero(y[begin:] >= 0.0)
    if above.size == 0:
        return float("nan")
    k = begin + int(above[0])
    if k == 0:
        return float(t[0])
    return float(t[k - 1] + (t[k] - t[k - 1]) * y[k - 1] / (y[k - 1] - y[k]))
