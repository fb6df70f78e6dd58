"""Every foreign arm, and every number of every paper."""

from __future__ import annotations

import sys
from collections import Counter


def foreign_arms() -> tuple[str, bool]:
    """`check` on every URDF of the installed packages: no traceback, none over 30 s (a line each: foreign_arms.py)."""
    from foreign_arms import BAD_KINDS, has_moving_joint, installed_urdfs, survey

    outcomes = survey([path for path in installed_urdfs(sys.path[1:]) if has_moving_joint(path)], processes=2)
    kinds = Counter(outcome.kind for outcome in outcomes)
    words = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    return f"{words}; longest {max(x.seconds for x in outcomes):.1f} s", not BAD_KINDS & set(kinds)


def foreign_lint() -> tuple[str, bool, str]:
    """`lint` on every URDF of the installed packages: no traceback, none over 30 s."""
    from foreign_arms import BAD_KINDS, installed_urdfs
    from foreign_lint import survey, table

    outcomes = survey(installed_urdfs(sys.path[2:]), processes=2)
    kinds = Counter(outcome.kind for outcome in outcomes)
    words = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    longest = max(outcome.seconds for outcome in outcomes)
    return f"{words}; longest {longest:.1f} s", not BAD_KINDS & set(kinds), table(outcomes)


def default_arms() -> tuple[str, bool, str]:
    """`simulate` without an option on 40 public arms: a tenth refused at most, none diverges."""
    return _of_default("simulate")


def default_compare() -> tuple[str, bool, str]:
    """`compare` without an option on 40 public arms: a tenth refused at most, none diverges."""
    return _of_default("compare")


def default_gains() -> tuple[str, bool, str]:
    """`gains` without an option on 40 public arms: a tenth refused at most."""
    return _of_default("gains")


def default_study() -> tuple[str, bool, str]:
    """`new study` of 40 public arms, then `sweep` and `tune` of it: a tenth refused at most, no run diverges."""
    return _of_default("study")


def _of_default(command: str) -> tuple[str, bool, str]:
    from default_arms import BAD_KINDS, RAN, listed_arms, survey, table, words

    arms = listed_arms()
    outcomes = survey([arm for arm in arms if arm.path.is_file()], 2, command)
    ran = sum(one.kind == RAN for one in outcomes)
    holds = ran >= 0.9 * len(outcomes) and not BAD_KINDS & {one.kind for one in outcomes}
    return words(arms, outcomes), holds, table(outcomes)


def data_mutants() -> tuple[str, bool]:
    """Every numeric cell of every data file changed in four ways, one at a time; survivors: scripts/data_mutants.py."""
    from data_mutants import surveyed

    from lwr_dyn.reproduction.papers import studies
    from tests.reproduction.mutants import mutants

    surveys = {paper: surveyed(paper, list(mutants(paper)), 2) for paper in studies()}
    missed = sum(len(one.missed) for one in surveys.values())
    words = ", ".join(f"{paper} {one.share:.1%} of {len(one.fates)} seen" for paper, one in surveys.items())
    return f"{words}; moved a number by more than its last digit unseen: {missed}", missed == 0
