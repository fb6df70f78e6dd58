"""What a paper concludes, as propositions that hold or fail for every pair of readings (model, plant)."""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from lwr_dyn.checks.sensitivity.closed_loops import ClosedLoopResult
from lwr_dyn.checks.sensitivity.simulated_task import SimulatedTask
from lwr_dyn.checks.sensitivity.statics import Statics
from lwr_dyn.checks.sensitivity.study_tasks import PublishedClaim
from lwr_dyn.simulation.metrics import Metrics

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
        over = "pairs" if len(next(iter(self.holds))) == 2 else "readings"
        if not bad:
            return f"holds under all {len(good)} {over}"
        if not good:
            return f"holds under none of {len(bad)} {over}"
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
            yield f"torques keep to their limits under {name}", partial(_judge, name, _within_torques)
        if any(np.isfinite(m.speed_use).any() for m in known):
            yield f"speeds keep to their limits under {name}", partial(_judge, name, _within_speeds)
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


def _within_torques(result: Metrics) -> bool:
    """No torque was cut at a known limit."""
    return bool((result.saturated_s == 0.0).all())


def _within_speeds(result: Metrics) -> bool:
    return bool(np.nanmax([0.0, *result.speed_use]) <= 1.0)


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
