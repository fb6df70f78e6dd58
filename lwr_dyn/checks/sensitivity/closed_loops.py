"""Every pair of readings in a closed loop, the controller's model one and the plant the other; what a paper concludes.

A conclusion is a proposition that holds or fails for every pair (model, plant). Beside the runs stand figures of a
reading without motion: gravity torques over poses, largest inertias, gains.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import cast

import numpy as np

from lwr_dyn.checks.sensitivity.study_tasks import PublishedClaim, SimulatedTask, controller_of
from lwr_dyn.control.gains import Gains, Linearised, second_order_gains
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.design.sampled_loop import RestingLoop, Sampling
from lwr_dyn.design.sampled_stability import stability_at
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import LwrDynError, OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.metrics import Metrics, metrics
from lwr_dyn.simulation.setup import Loop, prepare
from lwr_dyn.simulation.simulate import run_setup


@dataclass(frozen=True, slots=True, eq=False)
class Statics:
    """One reading: gravity torques at the sampled poses (k, n), largest inertias and gains (n,)."""

    gravity: Array
    """[N m]"""
    b: Array
    """max B_ii over the joint box [kg m^2]."""
    gains: Gains

    def gravity_off(self, other: Statics) -> Array:
        """Largest |g - g'| of each joint over the poses, (n,) [N m]."""
        return read_only(np.abs(self.gravity - other.gravity).max(axis=0))


def shared_poses(arms: Mapping[str, Arm], count: int, seed: int) -> Array:
    """Joint positions uniform in the box that all arms allow (+-pi where nothing is known), (count, n).

    A joint whose ranges do not overlap is sampled over the first arm's range.
    """
    lower = np.array([np.where(np.isfinite(a.lower), a.lower, -np.pi) for a in arms.values()])
    upper = np.array([np.where(np.isfinite(a.upper), a.upper, np.pi) for a in arms.values()])
    low, high = lower.max(axis=0), upper.min(axis=0)
    disjoint = low >= high
    low, high = np.where(disjoint, lower[0], low), np.where(disjoint, upper[0], high)
    return np.random.default_rng(seed).uniform(low, high, (count, lower.shape[1]))


def statics_of(arms: Mapping[str, Arm], poses: int, seed: int, omega_n: float, xi: float) -> dict[str, Statics]:
    """The statics of every arm at the same poses; raises `MissingDataError` for one without inertias."""
    q = shared_poses(arms, poses, seed)
    out = {}
    for name, arm in arms.items():
        b = np.array([w.value for w in worst_case_inertias(arm)])
        gravity = dynamics_of(arm, "newton-euler").gravity_vector(q)
        out[name] = Statics(read_only(gravity), read_only(b), second_order_gains(b, omega_n, xi))
    return out


Progress = Callable[[float], None]
PLACES = 50
"""Places along the reference at which the sampled loop is judged."""
SAFE = 1.6
"""Times the least rate that holds: the rate that is chosen where the usual one would not hold."""


@dataclass(frozen=True, slots=True, eq=False)
class ClosedLoopResult:
    """One closed-loop run: the controller's label, its model, the simulated plant, and the result."""

    controller: str
    model: str
    plant: str
    metrics: Metrics | None
    """None when the simulation failed."""
    fault: str = ""
    rate: float = 0.0
    """Samples a second [Hz] that the loop needs: more than wanted where a torque held that long would make it chatter.

    Such a loop is simulated with its controller at every moment where the plant has neither stick nor a stop in reach,
    and at this rate otherwise.
    """

    @property
    def tip_rms_mm(self) -> float:
        """RMS error of the tip [mm], NaN when the simulation failed."""
        return np.nan if self.metrics is None else self.metrics.tip_rms_mm

    @property
    def worst_mrad(self) -> float:
        """Largest error of a joint [mrad; mm for a sliding one]."""
        if self.metrics is None:
            return np.nan
        errors = self.metrics.position_mrad
        return float(np.maximum(errors.max, -errors.min).max())


def closed_loops(
    arms: Mapping[str, Arm],
    study: SimulatedTask,
    statics: Mapping[str, Statics],
    rate: float,
    progress: Progress | None = None,
) -> Iterator[ClosedLoopResult]:
    """A run for every controller, model and plant."""
    choices = study.task.controllers
    total, done = len(choices) * len(arms) ** 2, 0
    plants = {name: dynamics_of(arm) for name, arm in arms.items()}
    for choice in choices:
        for model in arms:
            controller = controller_of(arms[model], choice, statics[model].b)
            for plant in arms:
                yield _run(arms, plants[plant], study, controller, model, plant, rate)
                done += 1
                if progress is not None:
                    progress(done / total)


def _run(
    arms: Mapping[str, Arm], dynamics: Dynamics, study: SimulatedTask, controller: Controller, model: str, plant: str,
    rate: float,
) -> ClosedLoopResult:  # fmt: skip
    name, used = label_of(controller), _rate_that_holds(dynamics, controller, study, rate)
    loop = Loop(plant=arms[plant], engine=dynamics, rate=used, substeps=study.task.substeps)
    try:
        run = None if used == rate else _at_every_moment(arms[model], controller, study, replace(loop, rate=rate))
        run = run or run_setup(prepare(arms[model], controller, study.reference, loop))
    except LwrDynError as fault:
        return ClosedLoopResult(name, model, plant, None, str(fault), used)
    return ClosedLoopResult(name, model, plant, metrics(run, arms[plant]), rate=used)


def _at_every_moment(arm: Arm, controller: Controller, study: SimulatedTask, loop: Loop) -> Run | None:
    """The run of a controller that is called at every moment, by an implicit method; None where that has no such."""
    try:
        return run_setup(prepare(arm, controller, study.reference, replace(loop, continuous=True, loop="stiff")))
    except OptionError:
        return None


def _rate_that_holds(plant: Dynamics, controller: Controller, study: SimulatedTask, rate: float) -> float:
    """The wanted rate [Hz], or a multiple of it `SAFE` above the least that holds along the reference, if any does."""
    reference = study.reference
    q = reference.sample(np.linspace(0.0, reference.duration, PLACES)).q
    loop = RestingLoop.of(plant, cast(Linearised, controller), q)
    found = stability_at(loop, Sampling(rate), q)
    return rate if found.holds or found.least_rate is None else rate * math.ceil(SAFE * found.least_rate / rate)


Runs = Mapping[str, ClosedLoopResult]
"""Controller -> its run, of one pair of readings."""
Rule = Callable[[Runs], bool | None]
SAME_GAINS = (0.01, 0.05)
"""Shares within which gains count as the same."""


@dataclass(frozen=True, slots=True)
class Conclusion:
    """A proposition and whether it holds for each (model, plant); None where a simulation failed."""

    text: str
    holds: Mapping[tuple[str, ...], bool | None]
    """By (model, plant), or by (reading,) where there is only one."""

    @property
    def survives(self) -> bool:
        """It holds under every pair."""
        return all(self.holds.values())

    @property
    def share(self) -> float:
        """Share of the pairs under which it holds."""
        return sum(h is True for h in self.holds.values()) / len(self.holds)

    def verdict(self) -> str:
        """In words: under all pairs, under none, or under which, whichever list is shorter."""
        good = [k for k, h in self.holds.items() if h is True]
        bad = [k for k, h in self.holds.items() if h is not True]
        over = "pair" if len(next(iter(self.holds))) == 2 else "reading"
        if not bad:
            return f"holds under all {len(good)} {over}s" if len(good) > 1 else f"holds under the one {over}"
        if not good:
            return f"holds under none of {len(bad)} {over}s" if len(bad) > 1 else f"fails under the one {over}"
        shorter, word = (good, "holds only") if len(good) <= len(bad) else (bad, "fails")
        return f"{word} for {', '.join(_pair(*key) for key in shorter)} ({len(good)} of {len(self.holds)} hold)"


def _pair(model: str, plant: str = "") -> str:
    if not plant:
        return model
    return f"{model} on {plant}" if model != plant else f"{model} on itself"


def conclusions(
    study: SimulatedTask, runs: Sequence[ClosedLoopResult], statics: Mapping[str, Statics]
) -> tuple[Conclusion, ...]:
    """The propositions about a task, each judged for every pair."""
    pairs: dict[tuple[str, str], dict[str, ClosedLoopResult]] = {}
    for run in runs:
        pairs.setdefault((run.model, run.plant), {})[run.controller] = run
    judged = [Conclusion(text, {(*key,): rule(r) for key, r in pairs.items()}) for text, rule in _rules(study, runs)]
    return (*judged, *_gains(statics))


def _rules(study: SimulatedTask, runs: Sequence[ClosedLoopResult]) -> Iterator[tuple[str, Rule]]:
    """Propositions that can be judged: none about limits where the arm has no known ones."""
    known = [run.metrics for run in runs if run.metrics is not None]
    task, labels = study.task, study.labels
    for pd, other in itertools.product(task.controllers, task.controllers):
        if (pd.controller, other.controller) == ("pd-gravity", "inverse-dynamics"):
            better, worse = labels[other.id], labels[pd.id]
            yield f"{better} tracks better than {worse} (RMS of the tip)", partial(_better, better, worse)
    for name in labels.values():
        if any(np.isfinite(m.torque_use).any() for m in known):
            uncut = partial(_judge, name, lambda m: not (m.saturated_s > 0.0).any())
            yield f"torques keep to their limits under {name}", uncut
        if any(np.isfinite(m.speed_use).any() for m in known):
            within = partial(_judge, name, lambda m: bool(np.nanmax([0.0, *m.speed_use]) <= 1.0))
            yield f"speeds keep to their limits under {name}", within
    for claim in task.claims:
        name = labels[claim.controller]
        yield f"{claim.text} under {name}", partial(_judge, name, partial(_are_largest, claim))


def _better(controller: str, other: str, runs: Runs) -> bool | None:
    if runs[controller].metrics is None or runs[other].metrics is None:
        return None
    return runs[controller].tip_rms_mm < runs[other].tip_rms_mm


def _judge(controller: str, rule: Callable[[Metrics], bool], runs: Runs) -> bool | None:
    """A rule about one controller's run; None where its simulation failed."""
    result = runs[controller].metrics
    return None if result is None else rule(result)


def _are_largest(claim: PublishedClaim, result: Metrics) -> bool:
    """The claim's joints have the largest errors."""
    sizes = np.abs(getattr(result.position_mrad, claim.statistic))
    return set(np.argsort(-sizes)[: len(claim.joints)].tolist()) == set(claim.joints)


def _gains(statics: Mapping[str, Statics]) -> Iterator[Conclusion]:
    """The gains of a reading are those of the first one, within some share."""
    first = next(iter(statics))
    for share in SAME_GAINS:
        text = f"gains from max B_ii are those of {first} within {share:.0%}"
        gaps = {name: np.abs(s.b / statics[first].b - 1.0).max() for name, s in statics.items() if name != first}
        yield Conclusion(text, {(name,): bool(gap <= share) for name, gap in gaps.items()})
