"""The WAM paper's eight simulations: 0.5 rad in 7 s on an LSPB, each joint alone, then all together, with its friction.

PD with the manufacturer's gains (the paper prints none), once with gravity assumed zero as in the paper, once with real
gravity and its compensation. In a steady cruise at v the error is what the friction needs: e = tau_friction(v) / kp.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from lwr_dyn.checks.sensitivity.study_tasks import study_tasks
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import FRICTIONLESS, JointFriction
from lwr_dyn.model.passivity import SidePassivity, certificate
from lwr_dyn.model.run import Run
from lwr_dyn.reproduction.paper_study import Progress
from lwr_dyn.simulation.simulate import simulate
from lwr_dyn.trajectory.references.joint_moves import JointReference, lspb_move

TASK = study_tasks()["lspb"]
START, TRAVEL, DURATION, BLEND = (TASK.options[key] for key in ("start", "travel", "duration", "blend"))
"""[rad], [rad], [s], [s]; the cruise is at 0.5/6 rad/s."""
PD = TASK.controllers[0].options
"""tau = Kp (q_ref - q) + Kd (dq_ref - dq) + g with the manufacturer's gains, eq. (1) of the paper."""
SETTLED = 3.5
"""[s] from which a cruise counts as steady: the slowest loop, joint 4 down, has forgotten its start to 1e-3 by then."""
AGREES = 0.005
"""Share by which a steady cruise error may miss tau_friction(v) / kp."""
GRAVITIES = ("zero gravity", "real gravity, compensated")


@dataclass(frozen=True, slots=True, eq=False)
class Experiment:
    """One simulation: which joint moves (None: all) to which side, under which gravity, with friction or without."""

    joint: int | None
    side: int
    gravity: str
    friction: bool
    run: Run

    @property
    def name(self) -> str:
        """For files and tables."""
        moved = "all joints" if self.joint is None else f"joint {self.joint + 1} {'+' if self.side > 0 else '-'}"
        return f"{moved}, {self.gravity}{'' if self.friction else ', no friction'}"

    @property
    def file(self) -> str:
        """Name of the file that keeps the run."""
        stem = self.name.replace(" +", "_up").replace(" -", "_down").replace(", ", "_").replace(" ", "_")
        return f"{stem}.npz"

    def record(self) -> dict[str, Any]:
        """As JSON values."""
        meta = {key: self.run.meta[key] for key in ("evaluations", "audit")}
        return {"name": self.name, **meta, "events": len(self.run.events)}


@dataclass(frozen=True, slots=True)
class CruiseError:
    """The second half of a cruise of one joint: errors q_ref - q [rad] and speeds [rad/s] from least to most."""

    joint: int
    side: int
    gravity: str
    predicted: float
    """tau_friction(v) / kp."""
    mean: float
    least: float
    most: float
    slowest: float
    fastest: float
    net_damping: float
    """kd + sigma [N m s/rad]."""
    sticks: int
    """How often the joint came to rest in it."""

    @property
    def stable(self) -> bool:
        """Whether a cruise can be steady."""
        return self.net_damping > 0.0

    @property
    def miss(self) -> float:
        """Mean over predicted error, less 1."""
        return self.mean / self.predicted - 1.0

    @property
    def holds(self) -> bool:
        """Whether it settles on the predicted error; nothing is claimed of a loop without damping."""
        return abs(self.miss) <= AGREES or not self.stable

    def record(self) -> dict[str, Any]:
        """As JSON values; joints are counted from 1."""
        return asdict(self) | {"joint": self.joint + 1, "stable": self.stable, "holds": self.holds}


def weightless(arm: Arm) -> Arm:
    """The arm with gravity zero, as the paper's simulations assume it."""
    return replace(arm, chain=replace(arm.chain, gravity=np.zeros(3)))


def under(arm: Arm, gravity: str) -> Arm:
    """The arm under one of `GRAVITIES`."""
    return weightless(arm) if gravity == GRAVITIES[0] else arm


def move(arm: Arm, joint: int | None, side: int = 1) -> JointReference:
    """0.5 rad in 7 s with 1 s blends, of one joint or of all, from `START` up, or down to it."""
    travel = np.zeros(arm.n)
    travel[slice(None) if joint is None else joint] = TRAVEL
    ends = [np.array(START), np.array(START) + travel]
    return lspb_move(arm, *ends[:: 1 if side > 0 else -1], duration=DURATION, blend=BLEND)


def experiment(
    arm: Arm,
    joint: int | None,
    side: int = 1,
    gravity: str = GRAVITIES[0],
    friction: bool = True,
    substeps: int = TASK.substeps,
) -> Experiment:
    """One of the simulations at 1 kHz."""
    moved = under(arm, gravity)
    run = simulate(
        moved, make_controller("pd-gravity", moved, **PD), move(moved, joint, side), substeps=substeps,
        friction="set-valued" if friction else "none",
        meta={"task": "lspb", "joint": None if joint is None else joint + 1, "side": side, "gravity": gravity},
    )  # fmt: skip
    return Experiment(joint, side, gravity, friction, run)


def experiments(arm: Arm, progress: Progress = lambda _: None) -> tuple[Experiment, ...]:
    """The eight simulations under both gravities, the first also without friction, and each joint's way back."""
    moves = [*range(arm.n), None]
    cases = [(joint, 1, gravity, True) for gravity in GRAVITIES for joint in moves]
    cases += [(joint, 1, GRAVITIES[0], False) for joint in moves]
    cases += [(joint, -1, gravity, True) for gravity in GRAVITIES for joint in range(arm.n)]
    out = []
    for joint, side, gravity, friction in cases:
        out.append(experiment(arm, joint, side, gravity, friction))
        progress(out[-1].name)
    return tuple(out)


def sides_of(arm: Arm) -> dict[tuple[int, int], SidePassivity]:
    """The passivity certificate by joint and side, +1 or -1."""
    return {(s.joint, 1 if s.side == "positive" else -1): s for s in certificate(arm.friction_models())}


def cruise_error(arm: Arm, experiment: Experiment) -> CruiseError:
    """What an experiment of one joint shows in the second half of its cruise."""
    joint, side, run, gains = experiment.joint, experiment.side, experiment.run, arm.gains
    if joint is None or gains is None:
        raise MissingDataError(arm.name, "gains, or an experiment of one joint", "a cruise error")
    end = DURATION - BLEND
    steady = (run.t >= SETTLED) & (run.t <= end)
    error, speed = (run.q_ref - run.q)[steady, joint], run.dq[steady, joint]
    model: JointFriction = arm.friction_models()[joint] or FRICTIONLESS
    return CruiseError(
        joint, side, experiment.gravity, float(model.torque(side * TRAVEL / end) / gains.Kp[joint]),
        float(error.mean()), float(error.min()), float(error.max()), float(speed.min()), float(speed.max()),
        sides_of(arm)[joint, side].net_damping(float(gains.Kd[joint])),
        sum(e.kind == "stick" and e.joint == joint and SETTLED <= e.t <= end for e in run.events),
    )  # fmt: skip


def cruise_errors(arm: Arm, simulated: Sequence[Experiment]) -> tuple[CruiseError, ...]:
    """Of all experiments of one joint with friction."""
    return tuple(cruise_error(arm, e) for e in simulated if e.joint is not None and e.friction)
