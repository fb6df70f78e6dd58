"""`ComparedRun`: a run of a comparison with its figures of merit, and whether its loop kept still.

Under what a run was made: what of its plant the controller's model lacks; whether two runs follow the same.

Parts of a run: from a time on, as the second pass of a task done twice; fewer samples of it, for pages.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.pages.replay.replay_page import subsample
from lwr_dyn.pages.replay.replayed_runs import PLAIN, ReplayedRun, facts
from lwr_dyn.simulation.metrics import Metrics
from lwr_dyn.trajectory.references.ist import part_of

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


SAME = 1e-9
"""[rad or m] References that differ by less are the same: they come from one task, to rounding."""
TIME = 1e-9
"""[s] Times nearer than this are the same."""
ENOUGH = 0.1
"""Share of the samples of the slower run at which references are compared, at least."""


def conditions(run: Run) -> str:
    """What of a run's plant and sensors the controller's model has not, in words, as its file has it."""
    known, meta = facts(run), run.meta
    words = [known[key] for key in ("plant", "payload") if key in known]
    law, options = meta.get("friction_law") or {}, meta.get("options") or {}
    found = {
        "elastic": meta.get("elasticity") is not None,
        "friction": law.get("form", "none") != "none", "encoder": meta.get("encoder") is not None,
        "delay": bool(options.get("delay")),
    }  # fmt: skip
    words += [name for name, is_there in found.items() if is_there and name not in ", ".join(words)]
    return ", ".join(words) or PLAIN


def check_same(a: Run, name_a: str, b: Run, name_b: str) -> None:
    """Raise `OptionError` for runs of different robots or references."""
    subject = f"{name_a} and {name_b}"
    robots = [run.meta.get("file") or run.meta.get("robot") for run in (a, b)]
    if robots[0] != robots[1] or a.n != b.n:
        raise OptionError(subject, f"runs of {robots[0]} and {robots[1]}", "runs of one robot")
    if abs(a.t[-1] - b.t[-1]) > TIME:
        found = f"different references, {a.t[-1]:g} s and {b.t[-1]:g} s long"
        raise OptionError(subject, found, "runs of one reference")
    ticks_a, ticks_b = (np.round(run.t / TIME).astype(np.int64) for run in (a, b))
    _, at_a, at_b = np.intersect1d(ticks_a, ticks_b, return_indices=True)
    if at_a.size < max(2.0, ENOUGH * min(a.t.size, b.t.size)):
        raise OptionError(subject, "few common times", "runs sampled at rates one of which divides the other")
    apart = np.abs(a.q_ref[at_a] - b.q_ref[at_b]).max(axis=1)
    if apart.max() > SAME:
        k = int(np.argmax(apart))
        found = f"different references, {apart[k]:.3g} rad or m apart at t = {a.t[at_a[k]]:g} s"
        raise OptionError(subject, found, "runs of one reference")


_SAMPLED = ("t", "q", "dq", "q_ref", "dq_ref", "tau_command", "tau_applied", "tau_friction", "energy")


def since(run: Run, start: float) -> Run:
    """The run from `start` [s] on, with its time counted from there; its audit is that of the whole run.

    Raises
    ------
    OptionError
        A start that is negative or not below the end.
    """
    if start == 0.0:
        return run
    if not 0.0 < start < run.t[-1]:
        raise OptionError("since", f"{start:g} s", f"a time from 0 to below {run.t[-1]:g} s, the end of the run")
    part = part_of(run, start)
    note = {**(run.meta.get("note") or {}), "since": start}
    return replace(part, meta={**part.meta, "audit": dict(run.audit), "note": note})


def thinned(run: Run, rate: float) -> Run:
    """The run at about `rate` samples a second [Hz], its last sample included; a run with fewer is kept as it is.

    >>> import lwr_dyn
    >>> arm = lwr_dyn.load("lwr4plus")
    >>> hold = lwr_dyn.reference("hold", arm, q=[0.1] * 7, duration=0.1)
    >>> thinned(lwr_dyn.simulate(arm, lwr_dyn.controller("inverse-dynamics", arm), hold), 100.0).t.size
    11
    """
    stride = round((run.t.size - 1) / max(float(np.ptp(run.t)) * rate, 1e-9))
    if stride < 2:
        return run
    rows = subsample(run.t.size, stride)
    kept: dict[str, Any] = {name: getattr(run, name)[rows] for name in _SAMPLED}
    for what in ("work", "signals"):
        kept[what] = {name: x[rows] for name, x in getattr(run, what).items()}
    return replace(run, **kept)
