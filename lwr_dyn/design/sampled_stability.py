"""Where in the joint box, or along a motion, a sampled loop is unstable at rest: share, worst pose, least rate.

What a share of drawn poses says of the whole box stands as an interval beside it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, TypedDict

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from lwr_dyn.design.sampled_loop import GROWS, RestingLoop, Sampling
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind

DIFFERENCE = 1e-5
"""[rad or m] Step of the search's slopes."""


def joint_box(arm: Arm) -> tuple[Array, Array, tuple[str, ...]]:
    """Lower and upper position limits (n,) [rad or m], and the joints whose limits are unknown.

    An unknown limit is taken as half a turn to both sides, or as 1 m for a sliding joint.
    """
    kinds = (link.kind for link in arm.chain.links)
    reach = np.array([np.pi if kind is JointKind.REVOLUTE else 1.0 for kind in kinds])
    unknown = ~(np.isfinite(arm.lower) & np.isfinite(arm.upper))
    lower, upper = (np.where(unknown, side * reach, x) for side, x in ((-1.0, arm.lower), (1.0, arm.upper)))
    return lower, upper, tuple(name for name, is_unknown in zip(arm.joint_names, unknown, strict=True) if is_unknown)


def wilson_interval(found: int, tries: int, z: float = 1.959964) -> tuple[float, float]:
    """The interval of a share of which `found` of `tries` independent draws were met; 95 % with the default z.

    Wilson, J. Am. Stat. Assoc. 22 (1927) 209: it stays within 0 to 1 and says something where none, or all, are met.

    >>> [round(x, 4) for x in wilson_interval(459, 2000)], [round(x, 4) for x in wilson_interval(0, 2000)]
    ([0.2116, 0.2484], [0.0, 0.0019])
    """
    share, weight = found / tries, z * z / tries
    middle, half = share + weight / 2, z * np.sqrt(share * (1 - share) / tries + weight / tries / 4)
    low, high = (middle - half) / (1 + weight), (middle + half) / (1 + weight)
    return (0.0 if found == 0 else float(low)), (1.0 if found == tries else float(high))


def climb(function: Any, start: Array, lower: Array, upper: Array) -> Array:
    """A local maximum of log function(q (k, n)) inside the box, by L-BFGS-B with differences of one batch."""
    n = start.size
    offsets = DIFFERENCE * np.concatenate([np.zeros((1, n)), np.eye(n), -np.eye(n)])

    def descent(x: Array) -> tuple[float, Array]:
        values = -np.log(np.clip(function(x + offsets), 1e-300, 1e300))
        return float(values[0]), (values[1 : n + 1] - values[n + 1 :]) / (2 * DIFFERENCE)

    end = minimize(descent, start, jac=True, method="L-BFGS-B", bounds=list(zip(lower, upper, strict=True)))
    return np.asarray(np.clip(end.x, lower, upper))


POSES, SEED = 2000, 0
"""Poses drawn evenly from the joint box."""

PLACES = 200
"""Largest number of poses of a motion that are judged."""

STARTS = 2
"""Worst poses, by radius and by damping each, from which the worst one is searched."""

CANDIDATES = 256
"""Worst poses, by radius and by damping each, at which the least rate is confirmed."""

WHOLE_DELAY, FEWEST = 5, 10
"""[samples] Beyond this delay fewer poses are judged by default, at least so many; see `judged_count`."""

SLOWEST, FASTEST = 1.0, 1e6
"""[Hz] The least rate is searched between these."""

Rows = NDArray[np.signedinteger[Any]]
"""Indices of poses."""

Loops = Callable[[Array], RestingLoop]
"""Poses q (k, n) -> the loops there."""


class StabilityRecord(TypedDict):
    """`SampledStability.to_json`."""

    rate: Annotated[float, "Hz."]
    delay: Annotated[int, "Samples."]
    velocity_cutoff_hz: Annotated[float | None, "Of the filter of the velocities; null without."]
    poses: Annotated[int, "How many were looked at."]
    unstable: Annotated[int, "Those at which a deviation grows."]
    share: Annotated[float, "Of the poses that are unstable."]
    standard_error: Annotated[float, "Of the share, as that of the whole box."]
    worst: Annotated[list[float], "The worst pose found, rad (m for sliding joints)."]
    radius: Annotated[float, "Factor on a small deviation a sample there."]
    least_rate: Annotated[float | None, "From this rate on, Hz, it holds at all of them; null where none does."]
    unknown_limits: Annotated[list[str], "Joints without limits, taken as half a turn to both sides."]
    holds: Annotated[bool, "Whether no unstable pose was found."]


@dataclass(frozen=True, slots=True, eq=False)
class SampledStability:
    """How many of `poses` are unstable at rest, and the worst pose that was found, there or by search from there."""

    sampling: Sampling
    poses: int
    unstable: int
    worst: Array
    """(n,) [rad or m]"""
    radius: float
    """Spectral radius at the worst pose: a small deviation grows by it at each sample."""
    least_rate: float | None
    """[Hz] It holds at all of these poses and at the worst one from here on; None where no rate to `FASTEST` does."""
    unknown_limits: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze_arrays(self, "worst")

    @property
    def holds(self) -> bool:
        """Whether no unstable pose was found."""
        return self.unstable == 0 and self.radius <= GROWS

    @property
    def share(self) -> float:
        """Share of the poses that are unstable."""
        return self.unstable / self.poses

    @property
    def share_text(self) -> str:
        """The share with its standard error; without unstable poses the bound that they leave at 95 % (3 / N).

        >>> q = np.zeros(1)
        >>> SampledStability(Sampling(), 2000, 459, q, 13.0, 6900.0).share_text
        '22.9 +- 0.9 %'
        >>> SampledStability(Sampling(), 2000, 0, q, 0.9, 700.0).share_text
        'none (at 95 %: below 0.15 %)'
        """
        if self.unstable == 0:
            return f"none (at 95 %: below {300 / self.poses:.2g} %)"
        if self.unstable == self.poses:
            return f"all (at 95 %: above {100 - 300 / self.poses:.4g} %)"
        return f"{100 * self.share:.1f} +- {100 * self.standard_error:.1f} %"

    @property
    def interval(self) -> tuple[float, float]:
        """Of `share`, as that of the whole box, at 95 %; see `wilson_interval`."""
        return wilson_interval(self.unstable, self.poses)

    @property
    def standard_error(self) -> float:
        """Of `share`, as that of the whole box: sqrt(p (1 - p) / N)."""
        return float(np.sqrt(self.share * (1.0 - self.share) / self.poses))

    def to_json(self) -> StabilityRecord:
        """The result as JSON values."""
        return {
            "rate": self.sampling.rate, "delay": self.sampling.delay, "velocity_cutoff_hz": self.sampling.cutoff_hz,
            "poses": self.poses, "unstable": self.unstable, "share": self.share,
            "standard_error": self.standard_error, "worst": self.worst.tolist(), "radius": self.radius,
            "least_rate": self.least_rate, "unknown_limits": list(self.unknown_limits), "holds": self.holds,
        }  # fmt: skip


def judged_count(count: int, delay: int) -> int:
    """How many of `count` poses are judged: their eigenvalues cost about the cube of the states, 2 + delay a joint.

    >>> [judged_count(2000, delay) for delay in (0, 5, 10, 20, 100)]
    [2000, 2000, 396, 64, 10]
    """
    return min(count, max(FEWEST, int(count * ((2 + WHOLE_DELAY) / (2 + delay)) ** 3)))


def box_stability(
    arm: Arm, loops: Loops, sampling: Sampling, poses: int | None = None, seed: int = SEED
) -> SampledStability:
    """Sampled loops at rest over the joint box of an arm.

    Parameters
    ----------
    arm : Arm
        Its limits are the box; see `joint_box` for unknown ones.
    loops : function
        Poses q (k, n) -> the loops there, as `RestingLoop.of` or `LoopCase.loop` gives them.
    sampling : Sampling
    poses : int, optional
        Number of poses drawn evenly; if not given `judged_count` of `POSES`, and beyond `WHOLE_DELAY` no worse radius
        is searched from the worst of them.
    seed : int
        Of the drawing.
    """
    starts = 0 if poses is None and sampling.delay > WHOLE_DELAY else STARTS
    poses = judged_count(POSES, sampling.delay) if poses is None else poses
    lower, upper, unknown = joint_box(arm)
    q = np.random.default_rng(seed).uniform(lower, upper, (poses, arm.n))
    loop = loops(q)
    radii, rates = loop.radius(sampling), loop.damping_rates()
    ends = [climb(lambda x: loops(x).radius(sampling), q[i], lower, upper) for i in _largest(radii, starts)]
    ends += [climb(lambda x: loops(x).damping_rates(), q[i], lower, upper) for i in _largest(rates, STARTS)]
    found = np.array([*ends, q[int(np.argmax(radii))]])
    at_ends = loops(found)
    end_radii = at_ends.radius(sampling)
    worst = int(np.argmax(end_radii))
    candidates = np.union1d(_largest(radii, CANDIDATES), _largest(rates, CANDIDATES))
    least = _least_rate(at_ends, sampling)
    if least is not None and (loop.at(candidates).radius(replace(sampling, rate=least)) > GROWS).any():
        least = _least_rate(loop.at(candidates), sampling)
    return SampledStability(
        sampling, poses, int((radii > GROWS).sum()), found[worst], float(end_radii[worst]),
        least, unknown,
    )  # fmt: skip


def places_of(q: Array, places: int) -> Array:
    """Up to `places` poses of a motion q (k, n), evenly over its samples."""
    rows: Array = q[np.unique(np.linspace(0, len(q) - 1, min(places, len(q))).astype(int))]
    return rows


def stability_at(loop: RestingLoop, sampling: Sampling, rows: Array) -> SampledStability:
    """As `box_stability`, of a loop at all its poses, the rows (k, n)."""
    radii = loop.radius(sampling)
    worst, unstable = int(np.argmax(radii)), int((radii > GROWS).sum())
    return SampledStability(
        sampling, len(rows), unstable, rows[worst], float(radii[worst]), _least_rate(loop, sampling)
    )


def unstable_at(loop: RestingLoop, sampling: Sampling, rows: Array) -> SampledStability | None:
    """`stability_at` of a loop that is unstable at one of its poses; None where it holds: no least rate is searched."""
    return stability_at(loop, sampling, rows) if (loop.radius(sampling) > GROWS).any() else None


def _largest(values: Array, count: int) -> Rows:
    return np.argsort(-values, kind="stable")[:count]


def _least_rate(loop: RestingLoop, sampling: Sampling) -> float | None:
    """The rate [Hz] from which on the loop holds at all its poses, to 1e-4 relative and rounded up; None above all."""

    def radii(part: RestingLoop, rate: float) -> Array:
        return part.radius(replace(sampling, rate=rate))

    high = sampling.rate
    while ((found := radii(loop, high)) > GROWS).any():
        loop = loop.at(_largest(found, max(8, found.size // 4)))  # the others hold sooner
        high *= 2.0
        if high > FASTEST:
            return None
    worst = loop.at(_largest(found, 1))

    def holds(rate: float) -> bool:
        nonlocal worst
        if (radii(worst, rate) > GROWS).any():
            return False  # asked first, alone
        found = radii(loop, rate)
        worst = loop.at(_largest(found, 1))
        return not (found > GROWS).any()

    low = high / 2.0
    while low >= SLOWEST and holds(low):
        high, low = low, low / 2.0
    while high > low * (1 + 1e-4):
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def rate_text(rate: float | None) -> str:
    """A least rate, rounded up to three digits.

    >>> rate_text(6913.2), rate_text(754.9), rate_text(None)
    ('6920 Hz', '755 Hz', 'no rate up to 1e+06 Hz')
    """
    if rate is None:
        return f"no rate up to {FASTEST:.0e} Hz"
    unit = 10.0 ** (np.floor(np.log10(rate)) - 2)
    return f"{np.ceil(rate / unit - 1e-9) * unit:g} Hz"


def pose_text(q: Sequence[float] | Array, arm: Arm) -> str:
    """A pose in degrees, sliding joints in metres with their unit.

    >>> import lwr_dyn
    >>> pose_text(np.zeros(7), lwr_dyn.load("lwr4plus"))
    '(0 0 0 0 0 0 0) deg'
    """
    turning = [link.kind is JointKind.REVOLUTE for link in arm.chain.links]
    texts = [f"{round(np.degrees(x))}" if t else f"{x:.3g}m" for x, t in zip(q, turning, strict=True)]
    return f"({' '.join(texts)}){' deg' if any(turning) else ''}"
