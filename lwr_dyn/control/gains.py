"""Gains of a second-order loop from its natural frequency and damping ratio."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.foundation.arrays import Array, freeze_arrays, real_array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Option
from lwr_dyn.model.arm import Arm

OMEGA_N, XI = 50.0, 1.0
"""Natural frequency [rad/s] and damping ratio of the LWR 4+ paper."""
NaturalFrequency = Annotated[float, Option(float, "Natural frequency, rad/s.", unless="own_gains")]
DampingRatio = Annotated[float, Option(float, "Damping ratio.", unless="own_gains")]
LARGEST = 1e9
"""[rad/s] No joint moves faster; beyond it gains overflow."""


@dataclass(frozen=True, slots=True, eq=False)
class Gains:
    """Diagonal gains: Kp (n,) [N m/rad], Kd (n,) [N m s/rad], and the loop they belong to."""

    Kp: Array
    Kd: Array
    omega_n: float
    xi: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "Kp", "Kd")


def second_order_gains(inertia: ArrayLike, omega_n: float = OMEGA_N, xi: float = XI) -> Gains:
    """Kp = omega_n^2 b, Kd = 2 xi omega_n b (LWR 4+ paper, before Table VI; Siciliano eq. 8.22).

    Parameters
    ----------
    inertia : (n,) array_like
        Inertia b of each joint [kg m^2]; ones for inverse dynamics, which sees unit masses.
    omega_n : float
        Natural frequency [rad/s].
    xi : float
        Damping ratio.

    Raises
    ------
    ShapeError
        Inertias that are not finite numbers.
    OptionError
        A value that is not positive.

    >>> second_order_gains([2.0], omega_n=10.0).Kp
    array([200.])
    """
    b = real_array("inertia", inertia)
    for name, value in (("omega_n", omega_n), ("xi", xi), ("inertia", float(b.min(initial=1.0)))):
        if not (np.isfinite(value) and value > 0.0):
            raise OptionError(name, value, "a number above 0")
    if max(omega_n, xi) > LARGEST:
        raise OptionError("omega_n, xi", max(omega_n, xi), f"at most {LARGEST:g}")
    return Gains(omega_n**2 * b, 2 * xi * omega_n * b, float(omega_n), float(xi))


def worst_case_gains(arm: Arm, omega_n: float = OMEGA_N, xi: float = XI, inertia: ArrayLike | None = None) -> Gains:
    """`second_order_gains` of the largest inertia that each joint can have over its box (Table IV of the LWR 4+ paper).

    `inertia` (n,) [kg m^2] takes its place. Raises as `second_order_gains` and `worst_case_inertia`.
    """
    second_order_gains([1.0], omega_n, xi)  # refuse bad options before the search
    b = [w.value for w in worst_case_inertias(arm)] if inertia is None else inertia
    return second_order_gains(b, omega_n, xi)
