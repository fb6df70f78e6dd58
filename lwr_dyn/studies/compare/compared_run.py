"""`ComparedRun`: a run of a comparison with its figures of merit, and whether its loop kept still."""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay.replayed_runs import ReplayedRun
from lwr_dyn.simulation.metrics import Metrics

CUT, SWITCHES = 0.02, 10
"""A run counts as unstable where one joint's torque is cut for more than this share of the time, and goes from one
limit to the other more than so often: torque limits turn an unstable loop into a bounded one, which shakes between them
while no number overflows. A motion too fast for the arm is cut as well, at its start and its end, on one side each."""


@dataclass(frozen=True, slots=True)
class TorqueCuts:
    """Of the joint whose torque is cut most often: the `share` of the time, and how often it `switches` limits."""

    share: float
    switches: int

    @property
    def shakes(self) -> bool:
        """Whether the loop counts as unstable."""
        return self.share > CUT and self.switches > SWITCHES

    def __str__(self) -> str:
        return f"cut in {100 * self.share:.0f} % of the time, {self.switches} times from one limit to the other"


def torque_cuts(run: Run, arm: Arm) -> TorqueCuts:
    """How a run's torques are cut at the limits of its arm."""
    sides = np.where(np.abs(run.tau_command) > arm.effort, np.sign(run.tau_command), 0.0).T
    of_joints = []
    for side in sides:
        cut = side[side != 0.0]
        of_joints.append(TorqueCuts(cut.size / side.size, int((cut[1:] != cut[:-1]).sum())))
    return max(of_joints, key=lambda cuts: (cuts.share, cuts.switches))


@dataclass(frozen=True, slots=True, eq=False)
class ComparedRun:
    """A run of a comparison: its controller and plant in words, and its figures of merit."""

    shown: ReplayedRun
    controller: str
    plant: str
    figures: Metrics
    cuts: TorqueCuts

    @property
    def typed(self) -> str:
        """The controller as it was typed; its label where the run does not say."""
        typed = (self.shown.run.meta.get("note") or {}).get("typed")
        return typed if isinstance(typed, str) else self.controller

    @property
    def errors(self) -> dict[str, float]:
        """RMS and largest error of the tip [mm]."""
        return {"tip_rms_mm": self.figures.tip_rms_mm, "tip_max_mm": self.figures.tip_max_mm}

    @property
    def peak_torque(self) -> float:
        """The largest torque of any joint [N m or N]."""
        return float(self.figures.peak_torque.max())

    @property
    def share(self) -> float:
        """The largest share of a known torque limit; NaN where none is known."""
        use = self.figures.torque_use
        return float(np.nanmax(use)) if np.isfinite(use).any() else float("nan")

    @property
    def shakes(self) -> bool:
        """Whether the loop counts as unstable (`CUT`)."""
        return self.cuts.shakes

    @property
    def audit(self) -> float:
        """Energy that the audit leaves unexplained [J]; NaN for a run without one."""
        return float(self.shown.run.audit.get("residual", float("nan")))
