"""What the gains of a law may be where they differ from run to run: the rules of the controllers' own constructors."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.parameters import FRICTION
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError

ABOVE_ZERO = (
    "Kp", "Kd", "Ki", "tracking_time", "law_effort", "omega_n", "rho", "layer", "law_friction_width",
)  # fmt: skip
NOT_NEGATIVE = ("adaptation_gains", "friction_gains", "upper_load")
COULOMB = [i for i, name in enumerate(FRICTION) if name.endswith("coulomb")]
_ABOVE_ZERO: tuple[Callable[[Array], NDArray[np.bool_]], str] = (lambda x: x <= 0.0, "numbers above 0")
_NOT_NEGATIVE: tuple[Callable[[Array], NDArray[np.bool_]], str] = (lambda x: x < 0.0, "numbers from 0 on")
RULES = (
    dict.fromkeys(ABOVE_ZERO, _ABOVE_ZERO)
    | dict.fromkeys(NOT_NEGATIVE, _NOT_NEGATIVE)
    | {
        "lower_load": (lambda x: x > 0.0, "numbers up to 0"),
        "law_friction": (lambda x: (x < 0.0) & np.isin(np.arange(len(FRICTION)), COULOMB)[:, None], "levels from 0 on"),
    }
)
"""Name -> what is refused, and what is allowed."""


def check_gains(given: Mapping[str, Array]) -> None:
    """Raise `OptionError` for gains (runs, ...) that no controller has, naming the first run."""
    for name, (refused, allowed) in RULES.items():
        bad = refused(given[name]) if name in given else np.zeros(0, dtype=bool)
        if bad.any():
            where = np.argwhere(bad)[0]
            raise OptionError(f"parameter {name}", f"{given[name][tuple(where)]:g} in run {where[0]}", allowed)
