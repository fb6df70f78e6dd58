"""A controller that believes one reading on a plant that is another: every pair simulated."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.audit.sensitivity.jobs import Job, Law
from lwr_dyn.audit.sensitivity.statics import Statics
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.inverse_dynamics import InverseDynamics
from lwr_dyn.control.protocol import Controller
from lwr_dyn.control.sampled_damping import UNSTABLE
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.errors import LwrDynError
from lwr_dyn.model.arm import Arm
from lwr_dyn.simulation.metrics import Metrics, metrics
from lwr_dyn.simulation.simulate import simulate

Progress = Callable[[float], None]
PLACES = 50
"""Places along the reference at which a loop's damping is looked at."""
QUIET = 1.25
"""T lambda that is sampled for where `UNSTABLE` would be passed."""


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """One run: who believes what, what is really moved, and how it went."""

    law: str
    believed: str
    real: str
    figures: Metrics | None
    """None when the run came to nothing."""
    fault: str = ""
    rate: float = 0.0
    """Samples a second: more than asked for where a torque held that long would make the loop chatter [Hz]."""

    @property
    def tip_rms_mm(self) -> float:
        """RMS error of the tip [mm], NaN when the run came to nothing."""
        return np.nan if self.figures is None else self.figures.tip_rms_mm

    @property
    def worst_mrad(self) -> float:
        """Largest error of a joint [mrad; mm for a sliding one]."""
        if self.figures is None:
            return np.nan
        found = self.figures.position_mrad
        return float(np.maximum(found.max, -found.min).max())


def outcomes(
    arms: Mapping[str, Arm], job: Job, statics: Mapping[str, Statics], rate: float, progress: Progress | None = None
) -> Iterator[Outcome]:
    """Every law, believed reading and plant of a job."""
    total, done = len(job.laws) * len(arms) ** 2, 0
    for law in job.laws:
        for believed in arms:
            controller = _controller(arms[believed], law, statics[believed])
            for real in arms:
                yield _outcome(arms, job, law, controller, believed, real, rate)
                done += 1
                if progress is not None:
                    progress(done / total)


def _controller(arm: Arm, law: Law, statics: Statics) -> Controller:
    searched: dict[str, Any] = {"inertia": statics.b} if law.controller == "pd-gravity" else {}
    return make_controller(law.controller, arm, **law.options, **searched)


def _outcome(
    arms: Mapping[str, Arm], job: Job, law: Law, controller: Controller, believed: str, real: str, rate: float
) -> Outcome:
    plant = arms[real]
    damping = loop_damping(arms[believed], plant, controller, job) / rate
    used = rate if damping < UNSTABLE else rate * math.ceil(damping / QUIET)
    try:
        run = simulate(arms[believed], controller, job.reference, plant=plant, rate=used, substeps=job.substeps)
    except LwrDynError as fault:
        return Outcome(law.name, believed, real, None, str(fault), used)
    return Outcome(law.name, believed, real, metrics(run, plant), rate=used)


def loop_damping(believed: Arm, real: Arm, controller: Controller, job: Job) -> float:
    """Largest |lambda(B_real^-1 D)| along the reference [1/s]: D is Kd, or B_believed Kd of inverse dynamics."""
    q = job.reference.sample(np.linspace(0.0, job.reference.duration, PLACES)).q
    Kd = np.diag(np.asarray(controller.Kd))  # type: ignore[attr-defined] # both kinds of law have it
    D = dynamics_of(believed).mass_matrix(q) @ Kd if isinstance(controller, InverseDynamics) else Kd
    loop = np.linalg.solve(dynamics_of(real).mass_matrix(q), np.broadcast_to(D, (len(q), *Kd.shape)))
    return float(np.abs(np.linalg.eigvals(loop)).max())
