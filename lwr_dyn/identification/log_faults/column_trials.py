"""Wrong signs, order and units of columns, recognised: the change under which the arm explains the log.

    q' = q Q,  dq' = dq Q,  ddq' = ddq Q,  tau' = tau T,   Q and T permutations with signs and factors

Every change is tried on some hundred instants: base parameters and friction are fitted with the table as a loose prior,
and the change is judged by

    N sum_j log(RSS_j / |tau_j|^2 + floor) + prior + friction that drives

The geometry tells most, as no bodies and friction can explain torques of an arm that moves another way; friction that
adds energy tells a torque of the wrong sign where inertia is small; the table keeps parameters from absurd values. An
arm and its mirror image (all signs at once) are alike to it.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations, groupby
from math import pi
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.bodies.body_prior import scaled_inverse
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.regression.samples import SampleRule, Samples, samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm

FaultKind = Literal["saturated", "stop", "still", "silent", "sign", "order", "unit"]


@dataclass(frozen=True, slots=True)
class LogFault:
    """What is wrong with logs: `kind`, which `joints` (from 1), `where` (files, columns), `found` and `needed`.

    A `severe` one makes any fit meaningless; with another the fit stands and says less.
    """

    kind: FaultKind
    joints: tuple[int, ...]
    where: str
    found: str
    needed: str
    severe: bool = False

    def __str__(self) -> str:
        return f"{self.where}: {self.found}; needed: {self.needed}"


Side = Literal["q", "tau", "both"]
SIDES: tuple[Side, ...] = ("both", "q", "tau")
TURN = 180.0 / pi
TURN_SLIPS = {TURN: "in rad, read as deg", 1.0 / TURN: "in deg, read as rad"}
"""Factors that mend positions in the wrong unit, and what went wrong; torques: see `torque_scale`."""
_WHOSE: Mapping[Side, str] = {"q": "positions", "tau": "torques", "both": "positions and torques"}


@dataclass(frozen=True, slots=True, eq=False)
class ColumnChange:
    """A change that would mend a log: `kind`, `joints` (from 1; empty for all), `side`, and its maps (n, n)."""

    kind: FaultKind
    joints: tuple[int, ...]
    side: Side
    text: str
    Q: Array
    T: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, "Q", "T")


def column_changes(n: int) -> Iterator[ColumnChange]:
    """Every single change for an arm of n joints: one sign, two columns exchanged, one unit of q; and of all.

    >>> sum(1 for _ in column_changes(7))
    112
    """
    for side in SIDES:
        for j in range(n):
            one = np.diag(np.where(np.arange(n) == j, -1.0, 1.0))
            yield _change("sign", (j + 1,), side, one, f"{_columns(side, j + 1)} with the opposite sign")
        yield _change("sign", (), side, np.diag(-np.ones(n)), f"all {_WHOSE[side]} with the opposite sign")
    for side in SIDES:
        yield from _order_changes(n, side)
    for factor, slip in TURN_SLIPS.items():
        text = f"{factor:.4g} times as large ({slip})"
        yield _change("unit", (), "q", factor * np.eye(n), f"all positions {text}")
        for j in range(n):
            one = np.diag(np.where(np.arange(n) == j, factor, 1.0))
            yield _change("unit", (j + 1,), "q", one, f"q{j + 1} {text}")


def _order_changes(n: int, side: Side) -> Iterator[ColumnChange]:
    for i, j in combinations(range(n), 2):
        order = list(range(n))
        order[i], order[j] = j, i
        text = f"{_columns(side, i + 1)} exchanged with {_columns(side, j + 1)}"
        yield _change("order", (i + 1, j + 1), side, np.eye(n)[order], text)
    if n > 3:
        yield _change("order", (), side, np.eye(n)[::-1], f"all {_WHOSE[side]} in reverse order")
        for shift, way in ((1, "up"), (-1, "down")):
            moved = np.roll(np.eye(n), shift, axis=1)
            yield _change("order", (), side, moved, f"all {_WHOSE[side]} one joint further {way}")


def _change(kind: FaultKind, joints: tuple[int, ...], side: Side, map_: Array, text: str) -> ColumnChange:
    none = np.eye(len(map_))
    return ColumnChange(kind, joints, side, text, none if side == "tau" else map_, none if side == "q" else map_)


def _columns(side: Side, joint: int) -> str:
    return {"q": f"q{joint}", "tau": f"tau{joint}", "both": f"q{joint} and tau{joint}"}[side]


DEVIATION = 0.5
"""Share of a link's mass, mass times reach, mass times reach squared."""
REACH = 0.15
"""[m] of a link's mass about its frame."""
EFFORT = 100.0
"""[N m or N] for a joint without a known limit."""


def efforts(arm: Arm) -> Array:
    """Limits of torque (n,) with `EFFORT` where they are not known."""
    return np.where(np.isfinite(arm.effort), arm.effort, EFFORT)


def table_spread(columns: TorqueColumns, arm: Arm, friction: float) -> Array:
    """Standard deviations (p,) of all parameters about the table; of friction and offset a share of the joint's limit.

    >>> import lwr_dyn
    >>> arm = lwr_dyn.load("lwr4plus")
    >>> table_spread(TorqueColumns(arm.chain), arm, 0.05)[70:74].round(2)
    array([1.16, 8.8 , 8.8 , 8.8 ])
    """
    own, n = columns.own(arm), columns.n
    masses = own[: columns.bodies : 10]
    known = masses[masses > 0.0]
    usual = np.where(masses > 0.0, masses, known.mean() if known.size else 1.0)
    by_kind = np.array([1.0, *[REACH] * 3, *[REACH**2] * 6])
    spread = np.empty(columns.count)
    spread[: columns.bodies] = (DEVIATION * usual[:, None] * by_kind).reshape(-1)
    for j in range(n):
        spread[columns.of_joint(j)] = friction * efforts(arm)[j]
    spread[columns.rotor_indices] = 1.0 + own[columns.rotor_indices]
    return spread


INSTANTS = 400
"""Instants that are tried on, evenly taken."""
SLOW = 0.15
"""Share of a joint's RMS speed below which its equation is left out: scale-free, as units are in question."""
FLOOR = 0.02
"""Share of a joint's torque that no fit is asked to explain."""
FREE = 10.0
"""Times its torque limit that a joint's friction may be, a priori."""
DRIVING = 300.0
"""Largest price of friction that adds energy."""
DECISIVE = 0.35
"""Drop of the score per instant that makes a change an answer."""
ALIKE = 0.05
"""Such a drop below which two changes are alike."""
MOST = 4
"""Changes that are looked for, one after the other."""
BEYOND = 0.35
"""[rad or m] past its limits by which a change may not put a joint."""
WHOLE = 0.5
"""Share of instants at which all torques must be known, or nothing is tried."""
LEAST = 50
"""Number of such instants, where torques were cut out."""
ROUNDING = 1e-12
_ROUNDS = 3


@dataclass(frozen=True, slots=True, eq=False)
class ColumnTrial:
    """How well an arm explains a log under some changes: `score` (less is better), RMS of residuals (n,) [N m or N]."""

    score: float
    rms: Array


@dataclass(frozen=True, slots=True, eq=False)
class _ColumnJudge:
    """The prior of base parameters in units of their `spread` about the table: values (b,), precision (b, b)."""

    columns: TorqueColumns
    arm: Arm
    spread: Array
    own: Array
    prior: Array
    friction: Array
    """The table's own, (b,) in SI."""

    @classmethod
    def of(cls, arm: Arm) -> "_ColumnJudge":
        columns = TorqueColumns(arm.chain, friction="directions")
        base, own = columns.base(), columns.own(arm)
        covariance = (base.grouping * table_spread(columns, arm, FREE) ** 2) @ base.grouping.T
        published = own[base.kept]
        own[columns.friction_indices] = 0.0
        spread = np.sqrt(np.diag(covariance))
        prior: Array = np.asarray(np.linalg.inv(covariance / np.outer(spread, spread)), dtype=np.float64)
        return cls(columns, arm, spread, base.of(own) / spread, prior, published)

    def states(self, samples: Samples, Q: Array) -> "_ColumnStates":
        """The arm's columns with the positions changed by Q."""
        dq = samples.dq @ Q
        used = np.abs(dq) > np.maximum(SLOW * np.sqrt(np.mean(np.square(dq), axis=0)), 1e-9)
        Y = self.columns(samples.q @ Q, dq, samples.ddq @ Q)[:, :, self.columns.base().kept]
        W = np.ascontiguousarray((Y * used[:, :, None] * self.spread).transpose(1, 0, 2))
        return _ColumnStates(W, W.transpose(0, 2, 1) @ W, np.abs(dq), used)

    def trial(self, states: "_ColumnStates", tau: Array) -> ColumnTrial:
        """How well torques (k, n) are explained along the states."""
        tau = np.where(states.used, tau, 0.0)
        count, squares = np.maximum(states.used.sum(axis=0), 1), np.sum(tau**2, axis=0)
        sides = np.matmul(tau.T[:, None, :], states.W)[:, 0]
        mean = np.where(squares > 0.0, squares / count, 1.0)
        variance = mean
        for _ in range(_ROUNDS):
            matrix = np.tensordot(1.0 / variance, states.matrices, 1) + self.prior
            inverse = scaled_inverse(matrix, ROUNDING)
            values = inverse @ ((1.0 / variance) @ sides + self.prior @ self.own)
            across = (states.matrices @ values) @ values
            left = np.maximum(squares - 2.0 * sides @ values + across, 0.0) / count
            variance = left + FLOOR**2 * mean
        away = values - self.own
        score = len(tau) * float(np.log(variance / mean).sum()) + float(away @ self.prior @ away)
        return ColumnTrial(score + self._driving(states, values, inverse), np.sqrt(left))

    def _driving(self, states: "_ColumnStates", values: Array, inverse: Array) -> float:
        """The price of friction whose mean power is above 0 by more than its error; an offset has none.

        No price where the table's own friction drives too, at speeds beyond those it was measured at.
        """
        at = {int(k): i for i, k in enumerate(self.columns.base().kept)}
        power = np.zeros((values.size, self.columns.n))
        for j in range(self.columns.n):
            up, down, speed = self.columns.of_joint(j).start + 1, self.columns.of_joint(j).start + 3, states.speed[:, j]
            speed = speed[states.used[:, j]]
            if speed.size:
                for first in (up, down):
                    power[[at[first], at[first + 1]], j] = [speed.mean() / 2, np.mean(speed**2) / 2]
        published = self.friction @ power < 0.0
        power *= self.spread[:, None]
        lost = values @ power
        error = np.sqrt(np.einsum("bj,bj->j", power, inverse @ power))
        driving = (lost < 0.0) & ~published
        return float(np.minimum(DRIVING, (lost[driving] / error[driving]) ** 2).sum())


@dataclass(frozen=True, slots=True, eq=False)
class _ColumnStates:
    """Columns of each joint (n, k, b), 0 where it is slow, their products (n, b, b), speeds and which are used."""

    W: Array
    matrices: Array
    speed: Array
    used: NDArray[np.bool_]


def column_faults(samples: Samples, arm: Arm) -> tuple[LogFault, ...]:
    """The columns of logs that have a wrong sign, order or unit: those whose change lets the arm explain the log.

    Parameters
    ----------
    samples : Samples
        Of logs, low speeds in (`trial_samples`); torques in the right unit (`torque_scale`).
    arm : Arm
        With its table; parameters may be off it by some ten per cent, friction is free.

    Returns
    -------
    tuple of LogFault
        Empty where no change is decisively better.
    """
    judge = _ColumnJudge.of(arm)
    Q, T = np.eye(arm.n), np.eye(arm.n)
    now = judge.trial(judge.states(samples, Q), samples.tau)
    where = ", ".join(dict.fromkeys(samples.sources))
    faults: list[LogFault] = []
    changes = sorted(column_changes(arm.n), key=lambda change: change.Q.tobytes())
    for _ in range(MOST):
        tried: list[tuple[ColumnTrial, ColumnChange]] = []
        for _, alike in groupby(changes, key=lambda change: change.Q.tobytes()):
            group = list(alike)
            moved = Q @ group[0].Q
            q = samples.q @ moved
            if (q.min(axis=0) > arm.lower - BEYOND).all() and (q.max(axis=0) < arm.upper + BEYOND).all():
                states = judge.states(samples, moved)
                tried += [(judge.trial(states, samples.tau @ T @ change.T), change) for change in group]
        best, chosen = min(tried, key=lambda pair: pair[0].score)
        if now.score - best.score < DECISIVE * len(samples):
            break
        others = [c for trial, c in tried if trial.score < best.score + ALIKE * len(samples) and c is not chosen]
        faults.append(_said(where, chosen, others, now, best))
        now, Q, T = best, Q @ chosen.Q, T @ chosen.T
    return tuple(faults)


def trial_samples(logs: Iterable[JointLog]) -> Samples | None:
    """Some hundred instants of logs on even clocks, whose torques are all known; raises `LogError` as `samples_of`.

    None where torques are cut out of most instants, or of all but `LEAST`: those left are of one kind, such as few
    loads, and other signs and orders may explain them as well.
    """
    samples = samples_of(logs, SampleRule(slowest=0.0, reach=0.0))
    whole = np.flatnonzero((samples.used | (samples.dq == 0.0)).all(axis=1))
    if whole.size < max(LEAST, WHOLE * len(samples)) and whole.size < len(samples):
        return None
    return samples.select(whole[np.unique(np.linspace(0, whole.size - 1, min(INSTANTS, whole.size)).astype(np.intp))])


def not_tried(logs: Iterable[JointLog]) -> LogFault:
    """Says that `trial_samples` has none."""
    where = ", ".join(dict.fromkeys(log.source for log in logs))
    found = "torques are cut out of most instants: signs, order and units of columns were not checked"
    return LogFault("saturated", (), where, found, "a motion below the torques' bounds")


def _said(
    where: str, chosen: ColumnChange, alike: list[ColumnChange], before: ColumnTrial, after: ColumnTrial
) -> LogFault:
    joint = int(np.argmax(before.rms / np.maximum(after.rms, 1e-9)))
    others = "".join(f", or {c.text}" for c in alike[:3])
    found = (
        f"the arm explains the log with {chosen.text}{others}: the residual of joint {joint + 1} falls from "
        f"{before.rms[joint]:.3g} to {after.rms[joint]:.3g}"
    )
    return LogFault(chosen.kind, chosen.joints, where, found, "columns as the arm's axes have them", severe=True)
