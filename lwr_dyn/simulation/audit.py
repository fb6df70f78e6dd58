"""The audit of a run: its energy must be the work of the channels; its motion, by another engine, that of its torques.

The energy is blind to what does no work; the residual of inverse dynamics (`other_road`) sees it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.dynamics.protocol import Dynamics, mechanical_energy
from lwr_dyn.model.run import Run
from lwr_dyn.simulation.other_road import OtherRoad, other_road

TOLERANCE = 1e-9
"""[J] for a run of 14 s at 1 kHz: the arm exchanges joules, and RK4 with rounding leaves 1e-11 of them. Fast motion and
dry friction at one RK4 step a sample leave more (1e-6 J seen): smaller steps close them."""


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
    tolerance: float = TOLERANCE  # of the energies [J]

    @property
    def worst_energy(self) -> float:
        """The largest of the gaps of the energy [J]."""
        return _largest(self.residual, self.actuator_gap, self.energy_gap)

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
            "inverse_dynamics": None if self.other_road is None else self.other_road.to_json(),
            "closed": self.is_closed(),
        }  # fmt: skip


def audit_lines(record: Mapping[str, Any]) -> list[str]:
    """The energy and the inverse dynamics of an audit's record, each with its verdict, in one line each."""
    channels = ", ".join(f"{_CHANNELS.get(name, name)} {value:.4g} J" for name, value in record["channels"].items())
    worst = _worst_energy(record)
    closed = worst <= record["tolerance"]
    energy = f"energy audit: {channels}, arm {record['energy_change']:.4g} J, unexplained"
    hint = "" if closed else "; smaller steps (rate, substeps) leave less"
    verdict = f"{_verdict(closed)} to {record['tolerance']:.0e} J{hint}"
    return [f"{energy} {worst:.2g} J: {verdict}", inverse_dynamics_line(record)]


_CHANNELS = {"actuator": "motors"}
"""Plain names of channels."""


def inverse_dynamics_line(record: Mapping[str, Any]) -> str:
    """The residual of inverse dynamics in an audit's record, with its verdict and what was looked at."""
    road = record["inverse_dynamics"]
    if road is None:
        return "inverse dynamics: not judged (no other engine models the plant, or an event in every sample)"
    verdict = f"{_verdict(road['closed'])} to {road['tolerance']:.1e} N m and {road['gap_tolerance']:.1e} rad"
    words = inverse_dynamics_words(record)
    return f"inverse dynamics {words}: residual {road['residual']:.2g} N m, {road['gap']:.2g} rad: {verdict}"


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
    energy = record["tolerance"] if record["closed"] else _worst_energy(record)
    return f"{_verdict(record['closed'])}, {name} {energy:.0e} J, {motion}"


def _worst_energy(record: Mapping[str, Any]) -> float:
    """As `Audit.worst_energy`, of an audit's record."""
    return _largest(record["residual"], record["actuator_gap"], record["energy_gap"])


def _largest(residual: float, *gaps: float | None) -> float:
    """The residual or a larger gap, of those that were computed; NaN where one is."""
    return float(np.max([residual, *(gap for gap in gaps if gap is not None)]))


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
    change = run.energy - run.energy[0]
    if run.meta.get("elasticity") is None and not run.meta.get("options", {}).get("continuous", False):
        held = np.einsum("ki,ki->k", run.tau_applied[:-1], np.diff(run.q, axis=0))
        actuator_gap = float(np.abs(run.work["actuator"] - np.concatenate([[0.0], np.cumsum(held)])).max())
    if dynamics is not None:
        again = mechanical_energy(dynamics, run.q, run.dq)
        energy_gap = float(np.abs(again - again[0] - change).max())
    return Audit(
        residual=float(np.abs(change - sum(run.work.values())).max()),
        energy_change=float(change[-1]),
        channels={name: float(each[-1]) for name, each in run.work.items()},
        actuator_gap=actuator_gap,
        energy_gap=energy_gap,
        other_road=None if run.meta.get("elasticity") else other_road(run),
    )
