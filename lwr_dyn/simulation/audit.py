"""The energy audit of a run: the change of the arm's energy must be the work of the channels."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.dynamics.protocol import Dynamics, mechanical_energy
from lwr_dyn.model.run import Run

TOLERANCE = 1e-9
"""[J] for a run of 14 s at 1 kHz: the arm exchanges joules, and RK4 with rounding leaves 1e-11 of them."""


@dataclass(frozen=True, slots=True, eq=False)
class Audit:
    """E(t) - E(0) against the sum of the channels' work.

    `residual` is the largest difference over the run [J]; `channels` the work of each at the end [J].
    """

    residual: float
    energy_change: float
    channels: Mapping[str, float]
    actuator_gap: float | None  # actuator work against sum tau . (q_{k+1} - q_k) [J]; None for continuous runs
    energy_gap: float | None  # change of energy against another engine's [J]; None without one

    @property
    def worst(self) -> float:
        """The largest of the gaps [J]."""
        gaps = (self.residual, self.actuator_gap, self.energy_gap)
        return float(np.max([gap for gap in gaps if gap is not None]))

    def is_closed(self, tolerance: float = TOLERANCE) -> bool:
        """Whether every gap is within the tolerance [J]; NaN is not."""
        return self.worst <= tolerance

    def to_json(self) -> dict[str, Any]:
        """The audit as JSON values."""
        return {
            "residual": self.residual, "energy_change": self.energy_change, "channels": dict(self.channels),
            "actuator_gap": self.actuator_gap, "energy_gap": self.energy_gap,
        }  # fmt: skip


def audit(run: Run, dynamics: Dynamics | None = None) -> Audit:
    """The energy audit of a run.

    Parameters
    ----------
    run : Run
    dynamics : Dynamics, optional
        The plant's dynamics by any engine: the energies are then computed once more, from q and dq.

    Notes
    -----
    Under hold, rigid-body energy is exact but for the integrator's error, since the actuator's work is known exactly.
    """
    actuator_gap = energy_gap = None
    change = run.energy - run.energy[0]
    if not run.meta.get("options", {}).get("continuous", False):
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
    )
