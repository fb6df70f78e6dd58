"""What a paper concludes, as propositions that every pair of readings either bears out or does not."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from lwr_dyn.audit.sensitivity.jobs import INVERSE, PD, Job, Said
from lwr_dyn.audit.sensitivity.pairs import Outcome
from lwr_dyn.audit.sensitivity.statics import Statics

Runs = Mapping[str, Outcome]
"""Law -> its run, of one pair of readings."""
Rule = Callable[[Runs], bool | None]
SAME_GAINS = (0.01, 0.05)
"""Shares within which gains count as the same."""


@dataclass(frozen=True, slots=True)
class Conclusion:
    """A proposition and whether it holds for each (believed, real); None where a run came to nothing."""

    text: str
    holds: Mapping[tuple[str, ...], bool | None]
    """By (believed, real), or by (reading,) where only one is asked."""

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
        said = [k for k, h in self.holds.items() if h is True]
        fails = [k for k, h in self.holds.items() if h is not True]
        over = "pairs" if len(next(iter(self.holds))) == 2 else "readings"
        if not fails:
            return f"holds under all {len(said)} {over}"
        if not said:
            return f"holds under none of {len(fails)} {over}"
        names = said if len(said) <= len(fails) else fails
        word = "holds only" if names is said else "fails"
        return f"{word} for {', '.join(_pair(*key) for key in names)} ({len(said)} of {len(self.holds)} hold)"


def _pair(believed: str, real: str = "") -> str:
    if not real:
        return believed
    return f"{believed} on {real}" if believed != real else f"{believed} on itself"


def conclusions(job: Job, runs: Sequence[Outcome], statics: Mapping[str, Statics]) -> tuple[Conclusion, ...]:
    """The propositions about a job, each judged for every pair."""
    pairs: dict[tuple[str, str], dict[str, Outcome]] = {}
    for run in runs:
        pairs.setdefault((run.believed, run.real), {})[run.law] = run
    judged = [Conclusion(text, {(*key,): rule(r) for key, r in pairs.items()}) for text, rule in _rules(job, runs)]
    return (*judged, *_gains(statics))


def _rules(job: Job, runs: Sequence[Outcome]) -> Iterator[tuple[str, Rule]]:
    """Propositions that can be judged: an arm without a known limit keeps to none."""
    figures = [run.figures for run in runs if run.figures is not None]
    names = [law.name for law in job.laws]
    for pd, other in itertools.product(names, names):
        if pd.startswith(PD) and other.startswith(INVERSE):
            yield f"{other} tracks better than {pd} (RMS of the tip)", partial(_better, other, pd)
    for name in names:
        if any(np.isfinite(f.torque_use).any() for f in figures):
            yield f"torques keep to their limits under {name}", partial(_torques, name)
        if any(np.isfinite(f.speed_use).any() for f in figures):
            yield f"speeds keep to their limits under {name}", partial(_speeds, name)
    for said in job.said:
        yield said.text, partial(_largest, said)


def _better(law: str, other: str, runs: Runs) -> bool | None:
    if runs[law].figures is None or runs[other].figures is None:
        return None
    return runs[law].tip_rms_mm < runs[other].tip_rms_mm


def _torques(law: str, runs: Runs) -> bool | None:
    """No torque was cut at a known limit."""
    figures = runs[law].figures
    return None if figures is None else bool((figures.saturated_s == 0.0).all())


def _speeds(law: str, runs: Runs) -> bool | None:
    figures = runs[law].figures
    return None if figures is None else bool(np.nanmax([0.0, *figures.speed_use]) <= 1.0)


def _largest(said: Said, runs: Runs) -> bool | None:
    figures = runs[said.law].figures
    if figures is None:
        return None
    sizes = np.abs(getattr(figures.position_mrad, said.figure))
    return set(np.argsort(-sizes)[: len(said.joints)].tolist()) == set(said.joints)


def _gains(statics: Mapping[str, Statics]) -> Iterator[Conclusion]:
    """The gains of a reading are those of the first one, within some share."""
    first = next(iter(statics))
    for share in SAME_GAINS:
        text = f"gains from max B_ii are those of {first} within {share:.0%}"
        off = {name: np.abs(s.b / statics[first].b - 1.0).max() for name, s in statics.items() if name != first}
        yield Conclusion(text, {(name,): bool(o <= share) for name, o in off.items()})
