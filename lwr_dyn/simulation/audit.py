"""The audit of a run: its energy must be the work of the channels; its motion, by another engine, that of its torques.

Energy is blind to what does no work: a gyroscopic torque, a time column that is stretched. So at samples of the run the
other engine moves the arm from (q_k, dq_k) through one interval h under the recorded torque, by the run's own method of
integration, and its end (q', dq') is compared with sample k + 1:

    residual = B(q_k) (dq_{k+1} - dq') / h [N m],   gap = |q_{k+1} - q'| [rad]

The residual is the torque that would have to act beside the recorded one. Both engines make the same error of
integration, which the energy audit sees; so what is left is rounding. The recorded friction is taken at sample k, and
the plant's friction model for its change within the interval. A joint at rest is held; where friction alone holds it,
the recorded friction is compared with what has to hold it. Intervals with an event in them are left out.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Self, TypedDict

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics, mass_and_bias, mechanical_energy
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.arm_friction import FrictionTorque
from lwr_dyn.simulation.contact import ACTIVE_FRICTION
from lwr_dyn.simulation.plant import Plant

JUDGED = 200
"""Intervals of a run, evenly spread; each costs as much as 40 inverse dynamics."""
NODES = 6
"""Samples of the polynomial that stands for the torque between the samples of a continuous run."""
TORQUE_TOLERANCE = 1e-9
"""Of the largest torque: the engines agree to 1e-14, and rounding of dq over a sample of 1 us leaves 1e-10 of it."""
GAP_TOLERANCE = 1e-12
"""[rad or m] Rounding leaves 1e-15; a stretched time column shows as the way of a whole sample."""

CONTINUOUS = 1e-6
"""Of the largest torque, in continuous runs: there the engines do not make the same error of integration, since the
controller's torque at the stages is not recorded; RK4 at 1 kHz leaves 1e-7 with the default gains."""

Rows = NDArray[np.signedinteger[Any]]


class OtherRoadRecord(TypedDict):
    """`OtherRoad.to_json`."""

    engine: Annotated[str, "That moves the arm again."]
    residual: Annotated[float, "Largest torque that the motion lacks, N m (N)."]
    joint: Annotated[int, "Where it is, from 0."]
    tolerance: Annotated[float, "What the residual may be."]
    gap: Annotated[float, "Largest distance to where that engine ends, rad (m)."]
    gap_tolerance: Annotated[float, "What the gap may be."]
    uncertainty: Annotated[float, "Of the torque between samples, N m; 0 where it is held."]
    judged: Annotated[int, "Intervals that were looked at."]
    eventful: Annotated[int, "Intervals with an event in them, left out."]
    intervals: Annotated[int, "Of the run."]
    closed: Annotated[bool, "Whether residual and gap are within their tolerances."]


@dataclass(frozen=True, slots=True, eq=False)
class OtherRoad:
    """The largest residual [N m; N for a sliding joint], at a joint (0-based), and the largest gap [rad or m].

    Of `intervals`, `eventful` hold an event; of the others `judged` were looked at. `uncertainty` [N m] is that of the
    torque between samples, 0 where it is held, and `gap_uncertainty` [rad] what it does to the motion; `scale` [N m] is
    the largest torque, at least 1.
    """

    engine: str
    residual: float
    joint: int
    gap: float
    uncertainty: float
    gap_uncertainty: float
    scale: float
    judged: int
    eventful: int
    intervals: int

    @property
    def tolerance(self) -> float:
        """What the residual may be [N m]: `TOLERANCE` of the largest torque, and the uncertainty of the torque."""
        return TORQUE_TOLERANCE * self.scale + self.uncertainty

    @property
    def gap_tolerance(self) -> float:
        """What the gap may be [rad or m]: `GAP_TOLERANCE`, and what the uncertainty of the torque does."""
        return GAP_TOLERANCE + self.gap_uncertainty

    @property
    def share(self) -> float:
        """The larger of residual and gap as a share of its tolerance; 1 is the most that is allowed."""
        return float(np.max([self.residual / self.tolerance, self.gap / self.gap_tolerance]))

    @property
    def closed(self) -> bool:
        """Whether residual and gap are within their tolerances."""
        return self.share <= 1.0

    def to_json(self) -> dict[str, Any]:
        """The result as JSON values, an `OtherRoadRecord`."""
        return {name: getattr(self, name) for name in OtherRoadRecord.__annotations__}


def other_engine(plant: Plant) -> str | None:
    """The engine that checks a plant: Newton-Euler, or Pinocchio where that one ran.

    None for rotors that are not `armature`: a single engine has them.
    """
    if getattr(plant.ungated, "rotors", "armature") != "armature":
        return None
    return "pinocchio" if getattr(plant.dynamics, "name", "") == "newton-euler" else "newton-euler"


def other_road(run: Run, most: int = JUDGED) -> OtherRoad | None:
    """The residual of a run that knows its setup; None where no other engine can judge it, or nothing is left to judge.

    Parameters
    ----------
    run : Run
        As `simulate` gives it.
    most : int
        Largest number of intervals.
    """
    engine = None if run.setup is None else other_engine(run.setup.plant)
    if engine is None:
        return None
    plain = uneventful(run, run.setup.loop.continuous)
    rows = plain[np.unique(np.linspace(0, plain.size - 1, min(most, plain.size)).astype(int))]
    if not rows.size:
        return None
    judge = Intervals(run, rows, dynamics_of(run.setup.plant.arm, engine))
    residual, gap = judge.residuals()
    intervals = len(run.t) - 1
    return OtherRoad(
        engine, _largest_of(residual), int(np.argmax(residual.max(axis=0))), _largest_of(gap), *judge.uncertainties(),
        judge.scale(), rows.size, intervals - plain.size, intervals,
    )  # fmt: skip


def _largest_of(values: Array) -> float:
    """The largest value; NaN where one is not finite."""
    return float(values.max()) if np.isfinite(values).all() else float("nan")


def uneventful(run: Run, continuous: bool) -> Rows:
    """The intervals, by their first sample, in which the contact mode stays and the torque is known."""
    good = np.ones(len(run.t) - 1, dtype=bool)
    reach, h = NODES if continuous else 0, 1.0 / run.setup.loop.rate
    for event in run.events:
        if event.kind != ACTIVE_FRICTION:
            k = event.t / h
            good[max(0, int(np.ceil(k - 1e-6)) - 1 - reach) : int(np.floor(k + 1e-6)) + 1 + reach] = False
    if continuous:
        cut = run.tau_command != run.tau_applied
        for k in np.flatnonzero((cut[1:] != cut[:-1]).any(axis=1)):
            good[max(0, k - reach) : k + 1 + reach] = False
    return np.flatnonzero(good)


class Intervals:
    """Some intervals of a run, by their first samples `rows` (k,), under another engine."""

    def __init__(self, run: Run, rows: Rows, dynamics: Dynamics) -> None:
        plant, self.rows, self.run, self.dynamics = run.setup.plant, rows, run, dynamics
        self.loop, self.model = run.setup.loop, plant.friction
        self.q, self.dq, self.after_q, self.after_dq = run.q[rows], run.dq[rows], run.q[rows + 1], run.dq[rows + 1]
        self.h = np.diff(run.t)[rows][:, None]
        self.at_limit = (self.q >= plant.upper) | (self.q <= plant.lower)
        still = (self.dq == 0.0) & (self.after_dq == 0.0) & (self.q == self.after_q)
        self.rest = still & (plant.friction.directional | self.at_limit)
        self.friction = self._friction()
        self.at_start = mass_and_bias(dynamics, self.q, self.dq)

    def residuals(self) -> tuple[Array, Array]:
        """Residuals and gaps, (k, n) each; NaN where the other engine cannot follow."""
        k, n = self.q.shape

        def rates(s: float, y: Array) -> Array:
            x, v = y.reshape(2, k, n)
            return np.concatenate([self.h * v, self.h * self.motion(x, v, s)[0]]).ravel()

        start = np.concatenate([self.q, self.dq]).ravel()
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                end = self.loop.integrator()(rates, 0.0, start, 1.0).reshape(2, k, n)
            ddq, B, net = self.motion(self.q, self.dq, 0.0)
        except (ShapeError, np.linalg.LinAlgError):
            unknown = np.full((k, n), np.nan)
            return unknown, unknown
        free = B * ~self.rest[:, :, None] * ~self.rest[:, None, :]
        moving = np.einsum("kij,kj->ki", free, self.after_dq - end[1]) / self.h
        holding = np.where(self.at_limit, 0.0, net - np.einsum("kij,kj->ki", B, ddq))  # less the recorded friction
        return np.abs(np.where(self.rest, holding, moving)), np.abs(self.after_q - end[0])

    def motion(self, x: Array, v: Array, s: float) -> tuple[Array, Array, Array]:
        """ddq (k, n), 0 of joints at rest, with B (k, n, n) and tau - tau_friction + tau_external - C dq - g (k, n)."""
        is_start = np.array_equal(x, self.q) and np.array_equal(v, self.dq)
        B, bias = self.at_start if is_start else mass_and_bias(self.dynamics, x, v)
        keep, net = ~self.rest, self.torque(s) - self.friction(v) - bias + self.external(x, v, s)
        held = B * keep[:, :, None] * keep[:, None, :] + np.eye(self.run.n) * self.rest[:, None, :]
        return np.linalg.solve(held, (net * keep)[..., None])[..., 0], B, net

    def torque(self, s: float, nodes: int = NODES) -> Array:
        """The torque (k, n) at a share s of each interval; continuous: a polynomial through samples around it."""
        if not self.loop.continuous:
            return np.asarray(self.run.tau_applied[self.rows])
        nodes = min(nodes, len(self.run.t))
        first = np.clip(self.rows - (nodes // 2 - 1), 0, len(self.run.t) - nodes)
        around = self.run.tau_applied[first[:, None] + np.arange(nodes)]
        place, grid = (self.rows - first + s)[:, None, None], np.arange(nodes, dtype=np.float64)
        others = [[j for j in range(nodes) if j != i] for i in range(nodes)]
        weights = np.prod((place - grid[others]) / (grid[:, None] - grid[others]), axis=-1)
        return np.asarray(np.einsum("km,kmn->kn", weights, around))

    def external(self, x: Array, v: Array, s: float) -> Array:
        """The plant's external torque (k, n) at a share s of each interval."""
        act, times = self.run.setup.loop.external, self.run.t[self.rows] + s * self.h[:, 0]
        return np.zeros_like(x) if act is None else np.array([act(*at) for at in zip(times, x, v, strict=True)])

    def uncertainties(self) -> tuple[float, float]:
        """Of the torque between samples [N m], by what two nodes less change; of the motion, h^2 B^-1 of that."""
        if not self.loop.continuous:
            return 0.0, 0.0
        torque = max(_largest_of(np.abs(self.torque(s) - self.torque(s, NODES - 2))) for s in (0.25, 0.5, 0.75))
        softest = np.abs(np.linalg.inv(self.at_start[0])).max()
        torque += CONTINUOUS * self.scale()
        return torque, float(torque * softest * (self.h**2).max())

    def scale(self) -> float:
        """The largest torque, applied or of speeds and weight [N m], at least 1."""
        return float(max(1.0, *(np.abs(x).max() for x in (self.at_start[1], self.run.tau_applied[self.rows]))))

    def _friction(self) -> Callable[[Array], Array]:
        """tau_friction(dq) (k, n): that of the record at the first sample, changed as the plant's model changes."""
        recorded, dq = self.run.tau_friction[self.rows], self.dq
        if self.model.smooth is not None:
            one = self.model.smooth
            every = one if self.model.form in ("smooth", "viscous") else lambda v: np.array([one(x) for x in v])
            base = recorded - every(dq)
            return lambda v: base + every(v)
        parts = list(self._by_side())

        def change(v: Array) -> Array:
            out = recorded.copy()
            for members, torque in parts:
                out[members] += torque(v[members]) - torque(dq[members])
            return out

        return change

    def _by_side(self) -> Iterator[tuple[Rows, FrictionTorque]]:
        """The intervals whose joints move to the same sides, and the friction of these sides."""
        sides = np.where(self.dq != 0.0, np.sign(self.dq), np.sign(self.after_dq)).astype(int) * ~self.rest
        patterns, which = np.unique(np.hstack([sides, self.rest]), axis=0, return_inverse=True)
        for i, pattern in enumerate(patterns):
            torque = self.model.torque(pattern[: self.run.n], pattern[self.run.n :].astype(bool))
            if torque is not None:
                yield np.flatnonzero(which.ravel() == i), torque


ENERGY_TOLERANCE = 1e-9
"""[J] for a run of 14 s at 1 kHz: the arm exchanges joules, and RK4 with rounding leaves 1e-11 of them. Fast motion and
dry friction at one RK4 step a sample leave more (1e-6 J seen): smaller steps close them."""


class AuditRecord(TypedDict):
    """`Audit.to_json`."""

    residual: Annotated[float, "Largest difference of energy and work over the run, J."]
    energy_change: Annotated[float, "Of the arm, from first to last sample, J."]
    channels: Annotated[dict[str, float], "Channel -> its work at the end, J."]
    actuator_gap: Annotated[float | None, "The motors' work against tau dq of the samples, J; null where continuous."]
    energy_gap: Annotated[float | None, "Change of energy against another engine's, J; null without one."]
    tolerance: Annotated[float, "Of these, J."]
    inverse_dynamics: Annotated[OtherRoadRecord | None, "The motion by another engine; null where none can judge it."]
    closed: Annotated[bool, "Whether every gap is within its tolerance."]


@dataclass(frozen=True, slots=True, eq=False)
class Audit:
    """E(t) - E(0) against the sum of the channels' work, and the motion against the torques.

    `residual` is the largest difference over the run [J]; `channels` the work of each at the end [J].
    """

    residual: float
    energy_change: float
    channels: Mapping[str, float]
    actuator_gap: float | None  # actuator work against sum tau . (q_{k+1} - q_k) [J]; None for continuous runs
    energy_gap: float | None  # change of energy against another engine's [J]; None without one
    other_road: OtherRoad | None  # None where no other engine can judge the run
    tolerance: float = ENERGY_TOLERANCE  # of the energies [J]

    @classmethod
    def of(cls, run: Run, **judged: Any) -> Self:
        """With the energy of a run against the work of its channels; `judged` are the other fields."""
        change = run.energy - run.energy[0]
        works = {name: float(each[-1]) for name, each in run.work.items()}
        return cls(float(np.abs(change - sum(run.work.values())).max()), float(change[-1]), works, **judged)

    @property
    def worst_energy(self) -> float:
        """The largest of the gaps of the energy [J]."""
        return _worst_energy(self.residual, self.actuator_gap, self.energy_gap)

    @property
    def worst(self) -> float:
        """The largest gap, of energy or of inverse dynamics, as a share of its tolerance."""
        road = 0.0 if self.other_road is None else self.other_road.share
        return float(np.max([self.worst_energy / self.tolerance, road]))

    def is_closed(self) -> bool:
        """Whether every gap is within its tolerance; NaN is not."""
        return self.worst <= 1.0

    def to_json(self) -> dict[str, Any]:
        """The audit as JSON values."""
        return {
            "residual": self.residual, "energy_change": self.energy_change, "channels": dict(self.channels),
            "actuator_gap": self.actuator_gap, "energy_gap": self.energy_gap, "tolerance": self.tolerance,
            "inverse_dynamics": self.other_road and self.other_road.to_json(), "closed": self.is_closed(),
        }  # fmt: skip


GAPS = ("residual", "actuator_gap", "energy_gap")
"""Of the energy, in an audit's record."""


def audit_lines(record: Mapping[str, Any]) -> list[str]:
    """The energy and the inverse dynamics of an audit's record, each with its verdict, in one line each."""
    works = [f"{'motors' if name == 'actuator' else name} {value:.4g} J" for name, value in record["channels"].items()]
    worst, road = _worst_energy(*map(record.get, GAPS)), record["inverse_dynamics"]
    closed = worst <= record["tolerance"]
    hint = "" if closed else "; smaller steps (rate, substeps) leave less"
    energy = f"energy audit: {', '.join(works)}, arm {record['energy_change']:.4g} J, unexplained {worst:.2g} J"
    energy += f": {_verdict(closed)} to {record['tolerance']:.0e} J{hint}"
    if road is None:
        return [energy, "inverse dynamics: not judged (no other engine models the plant, or an event in every sample)"]
    left = f"residual {road['residual']:.2g} N m, {road['gap']:.2g} rad"
    verdict = f"{_verdict(road['closed'])} to {road['tolerance']:.1e} N m and {road['gap_tolerance']:.1e} rad"
    return [energy, f"inverse dynamics {inverse_dynamics_words(record)}: {left}: {verdict}"]


def inverse_dynamics_words(record: Mapping[str, Any]) -> str:
    """By which engine and where the inverse dynamics of an audit's record were judged."""
    road = record["inverse_dynamics"]
    left_out = f" ({road['eventful']} with an event in them left out)" if road["eventful"] else ""
    return f"by {road['engine']} at {road['judged']} of {road['intervals']} samples{left_out}"


def audit_words(record: Mapping[str, Any]) -> str:
    """An audit's record in short: closed to what, or the residuals that are too large; empty without a verdict."""
    if "closed" not in record:
        return ""
    road, name = record["inverse_dynamics"], "tolerance" if record["closed"] else "residual"
    motion = "inverse dynamics not judged" if road is None else f"{road[name]:.0e} N m"
    energy = record["tolerance"] if record["closed"] else _worst_energy(*map(record.get, GAPS))
    return f"{_verdict(record['closed'])}, {name} {energy:.0e} J, {motion}"


def _worst_energy(*gaps: float | None) -> float:
    """The largest of those that were computed; NaN where one is."""
    return float(np.max([gap for gap in gaps if gap is not None]))


def _verdict(closed: bool) -> str:
    return "closed" if closed else "NOT closed"


def audit(run: Run, dynamics: Dynamics | None = None) -> Audit:
    """The audit of a run.

    Parameters
    ----------
    run : Run
        As `simulate` gives it; of a run from a file, or of elastic joints, only the energy can be judged again.
    dynamics : Dynamics, optional
        The plant's dynamics by any engine: the energies are then computed once more, from q and dq.

    Notes
    -----
    Under hold, rigid-body energy is exact but for the integrator's error, since the actuator's work is known exactly.
    """
    actuator_gap = energy_gap = None
    if run.meta.get("elasticity") is None and not run.meta.get("options", {}).get("continuous", False):
        held = np.einsum("ki,ki->k", run.tau_applied[:-1], np.diff(run.q, axis=0))
        actuator_gap = float(np.abs(run.work["actuator"] - np.concatenate([[0.0], np.cumsum(held)])).max())
    if dynamics is not None:
        again = mechanical_energy(dynamics, run.q, run.dq)
        energy_gap = float(np.abs(again - again[0] - (run.energy - run.energy[0])).max())
    road = None if run.meta.get("elasticity") else other_road(run)
    return Audit.of(run, actuator_gap=actuator_gap, energy_gap=energy_gap, other_road=road)
