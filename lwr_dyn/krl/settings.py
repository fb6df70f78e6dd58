"""What a controller's machine data would say: not published for this arm, so assumed here, and open to change."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

from lwr_dyn.errors import OptionError

INTERPOLATION = 0.012
"""[s] KUKA's interpolation cycle; a movement is written out at this rate."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Assumed machine data and bounds of a run; raises `OptionError` for what is out of range."""

    ramp: float = 0.4
    """[s] From rest to rated speed of each axis at 100 % of $ACC_AXIS (assumed)."""
    vel_cp: float = 2.0
    """[m/s] $VEL.CP after BAS(#INITMOV, 0) (assumed)."""
    acc_cp: float = 2.3
    """[m/s^2] $ACC.CP (assumed)."""
    vel_ori: float = 200.0
    """[deg/s] $VEL.ORI1 and ORI2 (assumed)."""
    acc_ori: float = 500.0
    """[deg/s^2] $ACC.ORI1 and ORI2 (assumed)."""
    steps: int = 200_000
    """Statements that are carried out at most."""
    seconds: float = 3600.0
    """Simulated time at most."""
    motions: int = 20_000
    """Motions at most."""

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if not (isinstance(value, int | float) and math.isfinite(value) and 1e-3 <= value <= 1e9):
                raise OptionError(f.name, value, "a number from 0.001 to 1e9")

    def to_json(self) -> dict[str, Any]:
        """As JSON values."""
        return {f.name: getattr(self, f.name) for f in fields(self)}
