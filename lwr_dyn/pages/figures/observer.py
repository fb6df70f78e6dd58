"""The figure of a momentum observer: its estimate joint by joint, the levels, and the truth where the run has it."""

from collections.abc import Sequence

import numpy as np

from lwr_dyn.control.laws.collision_threshold import CollisionThreshold
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay.figures import GREY, Curve, Figure, Level, Panel


def observer_figure(run: Run, joints: Sequence[int] | None = None) -> Figure:
    """Estimate, levels and true external torque [N m] over time [s], a panel a joint; `joints` are 0-based.

    Raises `MissingDataError` for a run without an observer, such as a continuous one.
    """
    own = run.meta.get("controller", {}).get("parameters", {}).get("observer")
    if own is None or "external_torque" not in run.signals or run.t.size < 2:
        raise MissingDataError("the run", "signals of a momentum observer", "its figure (a law as LAW+observer)")
    inertia = None if own["inertia"] is None else np.array(own["inertia"])
    threshold = CollisionThreshold(np.array(own["bias"]), inertia, own["noise"], own["cutoff_hz"])
    level = threshold.level(np.array(own["gain"]), float(run.t[1] - run.t[0]))
    estimate, true, panels = run.signals["external_torque"], run.signals.get("tau_external"), []
    for j in range(run.n) if joints is None else joints:
        curves = [Curve("estimate", estimate[:, j], run.t, colour=0)]
        if true is not None:
            curves.insert(0, Curve("true", true[:, j], run.t, dashed=True, colour=GREY))
        ends = (Level("level", float(level[j])), Level("level", -float(level[j])))
        panels.append(Panel(f"joint_{j + 1}", "external torque", "N m", tuple(curves), ends))
    title = "External torque by the momentum observer"
    return Figure("external-torque", title, "", "time", "s", tuple(panels), over_time=True, columns=2)
