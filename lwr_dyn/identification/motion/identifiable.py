"""Which parameters logs identify, which of them only together, why the others not, and which motion would.

Such motions are swings of one or two joints, tried on paper: of each joint, and of each pair with different
frequencies, the others held in a few poses. What `SECONDS` of one would add to the precision of the base parameters
follows from the columns and the noise of this log; the best for a parameter is the one with the smallest sigma after
both. What several logs differ in beyond noise is not known ahead.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.regression.information import Information, normal_equations
from lwr_dyn.identification.regression.least_squares import IDENTIFIED, NO_ERROR, NOT_EXCITED, SIGMAS, ZERO
from lwr_dyn.identification.regression.samples import exact_samples
from lwr_dyn.model.arm import Arm

NOT_DETERMINED = "not determined"
"""The motion does not show the parameter at all."""
TOGETHER = 0.9
"""Correlation from which two parameters count as known only together."""
FROM_LOG, FROM_BOTH, FROM_TABLE = "log", "log and table", "table"
"""Where a parameter of a body comes from: its standard error is below a third of what the table alone gives, below nine
tenths, or is not."""
MOSTLY_LOG, MOSTLY_TABLE = 1.0 / 3.0, 0.9


def parameter_states(information: Information, own: Array) -> tuple[str, ...]:
    """Of each base parameter, beside the arm's own values (b,): identified, or why not."""
    half, values = information.half_widths, information.values
    rows = [
        ~information.determined, np.isnan(half), np.abs(values) > half, (own != 0.0) & (np.abs(own) <= half),
    ]  # fmt: skip
    return tuple(np.select(rows, [NOT_DETERMINED, NO_ERROR, IDENTIFIED, NOT_EXCITED], ZERO).tolist())


MEANING = {
    IDENTIFIED: f"|value| above {SIGMAS:g} sigma (Student's t of 99.73 %)",
    NOT_EXCITED: f"nor is the model's own value above {SIGMAS:g} sigma: this motion cannot separate it from 0",
    ZERO: f"within {SIGMAS:g} sigma of 0, and the model's own value is not, or is 0",
    NOT_DETERMINED: "this motion does not show it at all",
    NO_ERROR: "as many equations as parameters",
}
"""What the states of a parameter mean."""


@dataclass(frozen=True, slots=True)
class CorrelatedGroup:
    """Base parameters, by index, that logs know only together: each has a correlation above `TOGETHER` with another."""

    members: tuple[int, ...]
    largest: float
    """Correlation of the closest pair, signed."""


def correlated_groups(information: Information) -> tuple[CorrelatedGroup, ...]:
    """Groups of two and more of the determined base parameters, the closest first."""
    chosen = np.flatnonzero(information.determined & np.isfinite(information.sigma))
    covariance = information.covariance[np.ix_(chosen, chosen)]
    sigma = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(sigma, sigma)
    np.fill_diagonal(correlation, 0.0)
    near = np.abs(correlation) > TOGETHER
    left, out = set(np.flatnonzero(near.any(axis=1)).tolist()), []
    while left:
        group, border = set(), {min(left)}
        while border:
            group |= border
            border = {int(i) for j in border for i in np.flatnonzero(near[j])} - group
        left -= group
        rows = sorted(group)
        block = correlation[np.ix_(rows, rows)]
        largest = float(block.flat[int(np.argmax(np.abs(block)))])
        out.append(CorrelatedGroup(tuple(int(chosen[i]) for i in rows), largest))
    return tuple(sorted(out, key=lambda group: -abs(group.largest)))


def cell_origins(left: Array) -> tuple[str, ...]:
    """Where parameters (p,) come from, by the share of the table's standard errors that the log leaves."""
    return tuple(np.select([left < MOSTLY_LOG, left < MOSTLY_TABLE], [FROM_LOG, FROM_BOTH], FROM_TABLE).tolist())


SECONDS = 10.0
"""Length of a candidate."""
RATE = 100.0
"""Its instants a second, as those of a log thinned to uncorrelated ones [Hz]; `STRIDE` of them are looked at."""
STRIDE = 10
POSES = 3
"""Random poses of the joints that are held."""
SWING = 0.5
"""Largest amplitude [rad or m], and the share of a range that a swing takes at most is half of it."""
HERTZ = (0.4, 0.7)
"""Frequencies of the first and the second joint of a swing."""
SPEED_SHARE = 0.8
"""Of the speed limits."""
WORTH = 0.5
"""Share to which a motion must bring a parameter's sigma to be named."""


@dataclass(frozen=True, slots=True)
class MissingMotion:
    """A swing that would identify base parameters: joints (from 1), amplitudes [rad or m], frequencies [Hz], `SECONDS`.

    The others are held, and the swing is about `pose` (n,) [rad or m]. `parameters` are their indices, `sigma` their
    standard errors after it (SI), `before` those of the log.
    """

    joints: tuple[int, ...]
    amplitudes: tuple[float, ...]
    hertz: tuple[float, ...]
    pose: tuple[float, ...]
    parameters: tuple[int, ...]
    before: tuple[float, ...]
    sigma: tuple[float, ...]

    @property
    def swing(self) -> str:
        """`5 (0.5 at 0.4 Hz) and 6 (...)`: the joints with amplitude and frequency."""
        swings = zip(self.joints, self.amplitudes, self.hertz, strict=True)
        return " and ".join(f"{j} ({a:.2g} at {f:g} Hz)" for j, a, f in swings)

    def gains(self, names: Sequence[str]) -> str:
        """`A from x to y; B ...`: the 3 sigma of the parameters before and after."""
        gains = zip(self.parameters, self.before, self.sigma, strict=True)
        return "; ".join(f"{names[i]} from {_width(a)} to {_width(b)}" for i, a, b in gains)


def _width(sigma: float) -> str:
    return f"{SIGMAS * sigma:.2g}" if np.isfinite(sigma) else "unknown"


@dataclass(frozen=True, slots=True, eq=False)
class _Swing:
    joints: tuple[int, ...]
    amplitudes: tuple[float, ...]
    pose: Array
    q: Array
    dq: Array
    ddq: Array


def missing_motions(information: Information, arm: Arm, wanted: Sequence[int]) -> tuple[MissingMotion, ...]:
    """For base parameters by index, the swings that would tell most of them; those that no swing helps are left out."""
    if not len(wanted):
        return ()
    swings = list(_swings(arm))
    sigmas = np.array([_after(information, swing)[list(wanted)] for swing in swings])
    before = information.sigma[list(wanted)]
    best = np.argmin(sigmas, axis=0)
    out = []
    for i in dict.fromkeys(best.tolist()):
        helped = [int(k) for k in np.flatnonzero(best == i) if sigmas[i, k] < WORTH * before[k]]
        if helped:
            swing = swings[i]
            out.append(
                MissingMotion(
                    swing.joints, swing.amplitudes, HERTZ[: len(swing.joints)],
                    tuple(swing.pose.tolist()), tuple(wanted[k] for k in helped),
                    tuple(before[helped].tolist()), tuple(sigmas[i, helped].tolist()),
                )
            )  # fmt: skip
    return tuple(sorted(out, key=lambda motion: -len(motion.parameters)))


def _after(information: Information, swing: _Swing) -> Array:
    """Standard errors (b,) with the log and a swing."""
    t, slowest = np.arange(len(swing.q)) / RATE * STRIDE, 0.1 * float(np.abs(swing.dq).max())
    samples = exact_samples(t, swing.q, swing.dq, swing.ddq, np.zeros(swing.q.shape), slowest)
    known = information.noise[np.isfinite(information.noise)]  # a joint that never moved is taken to have the largest
    noise = np.where(np.isfinite(information.noise), information.noise, known.max(initial=0.0) or 1.0)
    more, _ = normal_equations(samples, information.columns, information.base).weighted(noise)
    together = information.precision + STRIDE * more
    size = np.sqrt(np.diag(together))
    scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    lengths, turned = np.linalg.eigh(together * np.outer(scale, scale))
    shown = lengths > 1e-12 * lengths[-1]
    root = turned[:, shown] / np.sqrt(lengths[shown])
    hidden = np.linalg.norm(turned[:, ~shown], axis=1) > 1e-3
    return np.where(hidden | (size == 0.0), np.inf, np.linalg.norm(root, axis=1) * scale)


def _swings(arm: Arm) -> Iterator[_Swing]:
    t = np.arange(0.0, SECONDS, STRIDE / RATE)
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    poses = np.random.default_rng(0).uniform(lower, upper, (POSES, arm.n)) / 2 + (lower + upper) / 4
    single = [(j,) for j in range(arm.n)]
    for joints in (*single, *combinations(range(arm.n), 2)):
        for pose in poses:
            q, dq, ddq = np.tile(pose, (len(t), 1)), np.zeros((len(t), arm.n)), np.zeros((len(t), arm.n))
            sizes = []
            for j, hertz in zip(joints, HERTZ, strict=False):
                w = 2.0 * np.pi * hertz
                size = float(min(SWING, (upper[j] - lower[j]) / 4, SPEED_SHARE * arm.velocity[j] / w))
                q[:, j] += size * np.sin(w * t)
                dq[:, j], ddq[:, j] = size * w * np.cos(w * t), -size * w**2 * np.sin(w * t)
                sizes.append(size)
            yield _Swing(tuple(j + 1 for j in joints), tuple(sizes), pose, q, dq, ddq)


FEW = 5
"""Groups and motions that the text names."""


def together(groups: Sequence[CorrelatedGroup], names: Sequence[str]) -> Table:
    """Base parameters, by their names (b,), that are known only together."""
    columns = (
        Heading("correlation", format="+.3f", key="largest_correlation", kind=float),
        Heading("parameters", key="parameters", kind=list[int], format=lambda g: ", ".join(names[i] for i in g)),
    )
    rows = [(g.largest, g.members) for g in groups]
    says = "Parameters, by index from 0, that are known only together."
    return Table(f"known only together (correlation above {TOGETHER:g})", columns, rows, "", "together", says, most=FEW)


def missing(motions: Sequence[MissingMotion], names: Sequence[str]) -> Table:
    """Motions that would identify more of the base parameters with these names (b,)."""
    columns = (
        Heading("10 s of a swing", key=None),
        Heading("about q", key="pose", kind=list[float], format=lambda q: ", ".join(f"{x:.2g}" for x in q)),
        Heading("3 sigma then", key=None), Heading(key="joints", kind=list[int]),
        Heading(key="amplitudes", kind=list[float]), Heading(key="hertz", kind=list[float]),
        Heading(key="parameters", kind=list[int]),
        Heading(key="before", kind=list[float], says="Standard errors of the log."),
        Heading(key="sigma", kind=list[float], says="Standard errors with 10 s of the swing."),
    )  # fmt: skip
    rows = [(m.swing, m.pose, m.gains(names), m.joints, m.amplitudes, m.hertz, m.parameters, m.before, m.sigma)
            for m in motions]  # fmt: skip
    says = "Swings that would identify what is not."
    return Table("not identified yet; what would do it", columns, rows, "", "missing_motions", says, most=FEW)
