"""When a run is sampled, and axes that are over their speed in it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.diagnostics import Diagnostic
from lwr_dyn.krl.motion.timeline import Timeline
from lwr_dyn.krl.running.motions import ExecutedMotion
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Motion

INTERPOLATION = 0.012
"""[s] KUKA's interpolation cycle: the sampling period of a run."""
OVER = 1e-6
"""Relative excess of an axis speed that is rounding."""


def sample_times(timeline: Timeline, longest: float) -> Array:
    """The interpolation cycle, and each time at which a motion begins or ends, up to `longest` [s]."""
    end = min(timeline.duration, longest)
    cycle = np.minimum(np.arange(int(np.ceil(end / INTERPOLATION)) + 1) * INTERPOLATION, end)
    marks = [x for item in timeline.items for x in (item.begin, item.end) if x <= end]
    times = np.unique(np.concatenate([cycle, marks]))
    # times that are equal up to rounding count once
    return np.asarray(times[np.concatenate([[True], np.diff(times) > 1e-9])])


def overspeed(arm: Arm, motion: Motion, executed: Sequence[ExecutedMotion]) -> list[Diagnostic]:
    """An error for each motion in which an axis is over its rated speed."""
    diagnostics = []
    use = np.abs(motion.dq) / arm.velocity
    for x in executed:
        part = use[(motion.t >= x.begin) & (motion.t <= x.end)]
        if not part.size:
            continue
        k, i = np.unravel_index(int(np.argmax(part)), part.shape)
        if part[k, i] > 1.0 + OVER:
            message = f"{arm.joint_names[int(i)]} turns at {100 * part[k, i]:.4g} % of its speed"
            diagnostics.append(Diagnostic(x.position, "error", "axis-speed", message, "a lower velocity, or no blend"))
    return diagnostics
