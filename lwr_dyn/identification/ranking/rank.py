"""Published sets of one robot on a log of the real one: how much of the measured torques each leaves unexplained.

Every set gets the same filter, the same rows and the same friction columns, fitted on the rows that train; it is scored
on rows that no fit saw, as published and with more freed. An unknown load turns a ranking round: so look at the column
with a free load before a set is called wrong.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from lwr_dyn.arms.loading import load
from lwr_dyn.arms.papers.catalog import readings, robots
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import LogError, OptionError
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.identification.logs.joint_log import JointLog, check_arm, read_log
from lwr_dyn.identification.logs.log_columns import NO_MAP, ColumnMap
from lwr_dyn.identification.ranking.filtered_log import FilteredLog, FilterRule, filtered_log, trained_and_tested
from lwr_dyn.identification.ranking.identified_set import IDENTIFIED, identified_arm
from lwr_dyn.identification.ranking.published_logs import PublishedLog, published_log, published_logs, recognised
from lwr_dyn.identification.ranking.ranking_result import AHEAD, BLOCK, Ranking, SetScore, rms_of
from lwr_dyn.identification.ranking.set_fits import COUPLING, FREE, ROTOR, Torques, fit_set, floor_of, with_own_friction
from lwr_dyn.model.arm import LINK_SIDE, Arm
from lwr_dyn.model.chain import Body, is_physical
from lwr_dyn.model.spatial import principal_moments

DRAWS, LEVEL = 2000, 0.95
FEWEST_BLOCKS = 5
EXPLAINED = 1e-3
"""Share of the torques below which what is left says that they were computed from the set: no real robot is so."""
FILES = (".urdf", ".xacro", ".xml", ".toml", ".dat")


def rank(
    robot: str, log: str | Path | JointLog, sets: Sequence[str | Arm] = (), *, free: Sequence[str] = (),
    test: str | Path | JointLog | None = None, cutoff: float | None = None, folder: str | Path | None = None,
    columns: ColumnMap = NO_MAP, units: dict[str, str] | None = None, loading: Mapping[str, Any] = MappingProxyType({}),
) -> Ranking:  # fmt: skip
    """Rank sets of inertial parameters of one robot on a log of the real one.

    Parameters
    ----------
    robot : str
        Name or file of the robot, whose readings are its sets.
    log : str, path or JointLog
        Name of a published log, a file of one (recognised by its digest), or your own log.
    sets : sequence of str or Arm
        Readings of the robot, `ROBOT:READING` of another one, files, arms; all readings if not given. "identified": the
        bodies that `identify_motion` finds on the rows that train, near the first of the sets.
    free : sequence of {"load", "gain", "rotor", "coupling"}
        What is fitted beside the friction, one after the other in this order: each has a column of its own.
    test : str, path or JointLog, optional
        The log that tests; the last 40 % of `log` if not given.
    cutoff : float, optional
        Of the filter [Hz]; that of the published log, or 10, if not given.
    folder : str or path, optional
        Where fetched logs lie.
    columns, units
        Of logs of your own, as `read_log` takes them.
    loading : mapping
        Options of `load` for the robot and every set that is not an `Arm`: `mount`, `tool`, `rotor`, `tip`, ...; with
        `reading` that one is the only set.

    Returns
    -------
    Ranking

    Raises
    ------
    LogError
        Torques that were computed, not measured; too few rows; joints that are not the robot's; files to be fetched.
    UnknownNameError, OptionError
        A set, log or quantity that does not exist; sets of another number of joints; a set twice; options that a set
        cannot be loaded with; sets and a reading.
    MissingDataError
        A set without masses.

    Examples
    --------
    >>> found = rank("panda", "panda_salerno", ["gaz", "fer"], free=["load"])  # doctest: +SKIP
    """
    arms = named_sets(robot, [one for one in sets if one != IDENTIFIED], loading)
    steps = _steps(free, [arm for _, arm in arms])
    first, measured = _log(log, arms[0][1], folder, columns, units)
    usual = FilterRule() if first is None else FilterRule(first.cutoff, first.spacing)
    rule = usual if cutoff is None else replace(usual, cutoff=cutoff)
    whole = filtered_log(measured, rule)
    if test is None:
        tested_on, (train, tested) = measured.source, trained_and_tested(whole, rule.share)
    else:
        _, other = _log(test, arms[0][1], folder, columns, units)
        tested_on, train, tested = other.source, whole, filtered_log(other, rule)
    if IDENTIFIED in sets:
        arms.append((IDENTIFIED, identified_arm(arms[0][1], measured, train, rule)))
    torques, blocks = Torques(train, tested), _blocks(tested)
    scores = sorted((_scored(torques, name, arm, steps, blocks) for name, arm in arms), key=lambda x: x.fits[0].total)
    _refuse_computed(measured, scores, tested)
    scores = [replace(a, ahead=_ahead(a, b, blocks)) for a, b in pairwise(scores)] + scores[-1:]
    floors = tuple(floor_of(torques, arms[0][1], one) for one in steps)
    return Ranking(
        robot, measured, first, tested_on, rule, steps, tuple(scores), floors, train, tested, _with_load(scores, blocks)
    )


def named_sets(
    robot: str, sets: Sequence[str | Arm] = (), loading: Mapping[str, Any] = MappingProxyType({})
) -> list[tuple[str, Arm]]:
    """Sets by their names, each as an arm; raises as `rank`."""
    options = dict(loading)
    reading = options.pop("reading", None)
    if sets and reading is not None:
        raise OptionError("reading", f"{reading}, and sets", "the sets alone: each reading is one")
    known = readings(robot) if robot in robots() or ends_in(robot, ".toml") else ()
    chosen = sets or (known if reading is None else [reading])
    read = partial(_arm, robot, known, options)
    found = [(one.name, one) if isinstance(one, Arm) else (one, read(one)) for one in chosen]
    if not found:
        found = [(robot, load(robot, **options))]
    names = [name for name, _ in found]
    for name, arm in found:
        if names.count(name) > 1:
            raise OptionError("sets", f"{name} twice", "each once")
        if arm.n != found[0][1].n:
            raise OptionError("sets", f"{name} has {arm.n} joints", f"{found[0][1].n}, as {names[0]}")
        arm.require_dynamics()
    return found


def _arm(robot: str, known: Sequence[str], options: Mapping[str, Any], name: str) -> Arm:
    if ends_in(name, *FILES):
        return load(name, **options)
    other, colon, reading = name.partition(":")
    if colon:
        return load(other, reading, **options)
    return load(name, **options) if name not in known and name in robots() else load(robot, name, **options)


def _steps(free: Sequence[str], arms: Sequence[Arm]) -> tuple[tuple[str, ...], ...]:
    for i, name in enumerate(free):
        if name not in FREE or name in free[:i]:
            raise OptionError("free", name, f"of {', '.join(FREE)}, each once")
    if ROTOR in free and all(arm.torques == LINK_SIDE for arm in arms):
        raise OptionError("free", f"{ROTOR}, with torques measured behind the gears", "load, gain: no rotor is in them")
    if COUPLING in free and all(arm.transmission is None for arm in arms):
        raise OptionError("free", COUPLING, "a robot whose data file has a transmission")
    return tuple(tuple(free[:i]) for i in range(len(free) + 1))


def _log(
    log: str | Path | JointLog, arm: Arm, folder: str | Path | None, columns: ColumnMap, units: dict[str, str] | None
) -> tuple[PublishedLog | None, JointLog]:
    if isinstance(log, JointLog):
        found: tuple[PublishedLog | None, JointLog] = None, log
    elif str(log) in published_logs() or recognised(log) is not None:
        found = published_log(str(log), folder)
    else:
        if ends_in(log, ".npz"):
            raise LogError(str(log), "torques", "of a simulated run, computed", "a log of measured torques or currents")
        found = None, read_log(log, units, arm, columns)
    check_arm(found[1].source, found[1].joints, arm)
    return found


def _refuse_computed(log: JointLog, scores: Sequence[SetScore], tested: FilteredLog) -> None:
    """Raise `LogError` where a set explains the torques to `EXPLAINED`."""
    share = scores[0].fits[0].total / rms_of(tested.tau)
    if share < EXPLAINED:
        found = f"computed, not measured: {scores[0].name} leaves {share:.1g} of them"
        raise LogError(log.source, "torques", found, "a log of measured torques or currents")


def _scored(torques: Torques, name: str, arm: Arm, steps: Sequence[tuple[str, ...]], blocks: Array) -> SetScore:
    both = torques.of(arm)
    fits = tuple(fit_set(both, one, arm.transmission) for one in steps)
    alone = tuple(fit_set(both, (one,), arm.transmission) for one in FREE[: 2 if arm.torques == LINK_SIDE else 3])
    bodies = zip(arm.chain.links, arm.chain.bodies or (), strict=True)
    wrong = tuple(f"{link.link}: {_excess(body)}" for link, body in bodies if not is_physical(body))
    intervals = tuple(_interval(one.left, blocks) for one in fits)
    return SetScore(name, arm, fits, alone, intervals, wrong, own=with_own_friction(both, arm))


def _excess(body: Body) -> str:
    small, middle, large = principal_moments(body.inertia_com)
    if small + middle > 0.0 and small >= 0.0 and body.mass > 0.0:
        return f"the smaller two moments sum to {100.0 * (1.0 - (small + middle) / large):.3g} % less than the largest"
    return "a mass or moment that is not above 0"


def _blocks(log: FilteredLog) -> Array:
    """Number of the block of each row, (k,)."""
    count = int((log.t[-1] - log.t[0]) / BLOCK)
    return np.asarray(np.minimum(np.floor((log.t - log.t[0]) / BLOCK), max(count - 1, 0)))


def _drawn(left: Array, blocks: Array) -> Array | None:
    """RMS over all joints of `DRAWS` draws of the blocks, (DRAWS,); the same draws for every set."""
    which, place = np.unique(blocks, return_inverse=True)
    if which.size < FEWEST_BLOCKS:
        return None
    squares, rows = np.bincount(place, np.square(left).sum(axis=1)), np.bincount(place) * float(left.shape[1])
    draws = np.random.default_rng(0).integers(which.size, size=(DRAWS, which.size))
    return np.asarray(np.sqrt(squares[draws].sum(axis=1) / rows[draws].sum(axis=1)))


def _interval(left: Array, blocks: Array) -> tuple[float, float]:
    drawn = _drawn(left, blocks)
    if drawn is None:
        return float("nan"), float("nan")
    low, high = np.quantile(drawn, [(1.0 - LEVEL) / 2.0, (1.0 + LEVEL) / 2.0])
    return float(low), float(high)


def _with_load(scores: Sequence[SetScore], blocks: Array) -> str:
    """The set that leaves least with a free load, where it is ahead of the first by more than chance; else that."""
    best = min(scores, key=lambda one: one.alone[0].total)
    one, other = (_drawn(x.alone[0].left, blocks) for x in (best, scores[0]))
    turned = one is not None and other is not None and np.mean(one < other) >= AHEAD
    return best.name if turned else scores[0].name


def _ahead(a: SetScore, b: SetScore, blocks: Array) -> float | None:
    one, other = _drawn(a.fits[0].left, blocks), _drawn(b.fits[0].left, blocks)
    return None if one is None or other is None else float(np.mean(one < other))
