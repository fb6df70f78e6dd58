"""B_ii as a table of values at the nodes of every joint that moves it, and its control values on every first box."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from lwr_dyn.control.inertia.bounds.bernstein import PARABOLA, WAVES, Precise, control_matrix, harmonics, nodes
from lwr_dyn.control.inertia.maxima import JointInertia
from lwr_dyn.dynamics.recursion import inverse_dynamics
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.vectors import ZERO

MOST_VALUES = WAVES**7
"""Size of the largest table that is made."""
WIDEST = np.radians(100.0)
"""First boxes are no wider than this along a turning joint; below 180 deg all weights are positive."""
OPERATIONS = 200
"""Rounding errors of one value of B_ii in units of the last place of the largest value: some 100 operations a joint."""


@dataclass(frozen=True, slots=True, eq=False)
class InertiaTable:
    """B_ii [kg m^2; kg for a sliding joint] at the nodes: one axis a joint of `joints`, which has moved it."""

    values: Precise
    joints: tuple[int, ...]
    is_turning: tuple[bool, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    left_out: float = 0.0
    """What joints that were left out can add at most."""

    @classmethod
    def of(cls, inertia: JointInertia) -> "InertiaTable":
        """The table of B_ii over the box of `inertia`, in extended precision where the machine has it.

        Raises `OptionError` for more joints than `MOST_VALUES` allows.
        """
        joints = tuple(inertia.moving)
        is_turning = tuple(inertia.kinds[j] is JointKind.REVOLUTE for j in joints)
        size = int(np.prod([WAVES if turns else PARABOLA for turns in is_turning], dtype=float))
        if size > MOST_VALUES:
            raise OptionError("joints behind", f"{len(joints)}, a table of {size} values", f"at most {MOST_VALUES}")
        lower, upper = (tuple(float(x[j]) for j in joints) for x in (inertia.lower, inertia.upper))
        axes = [nodes(*each) for each in zip(is_turning, lower, upper, strict=True)]
        grid = np.meshgrid(*axes, indexing="ij")
        q: list[Any] = [np.longdouble(x) for x in inertia.lower]
        for j, places in zip(joints, grid, strict=True):
            q[j] = places
        unit = [1.0 if j == inertia.joint else 0.0 for j in range(len(q))]
        links, rotors = inertia.recursion.links, inertia.recursion.rotors
        tau = inverse_dynamics(links, ZERO, q, [0.0] * len(q), unit, rotors)[inertia.joint]
        shape = tuple(len(axis) for axis in axes)
        return cls(np.array(np.broadcast_to(tau, shape), dtype=np.longdouble), joints, is_turning, lower, upper)

    @property
    def shape(self) -> tuple[int, ...]:
        """Values along each joint."""
        return tuple(WAVES if turns else PARABOLA for turns in self.is_turning)

    def without_idle(self, allowed: float) -> "InertiaTable":
        """The table without turning joints that add, all together, at most `allowed`, which is kept in `left_out`.

        Without a joint there is its mean over the turn; the rest is at most the sum of the sizes of all amplitudes that
        go with its angle.
        """
        table = self
        for place in reversed(range(len(self.joints))):
            if not table.is_turning[place]:
                continue
            added = float(np.abs(np.delete(table._amplitudes(), 0, axis=place)).sum())
            if table.left_out + added <= allowed:
                kept = [x for x in range(len(table.joints)) if x != place]
                table = InertiaTable(
                    table.values.mean(axis=place), tuple(table.joints[x] for x in kept),
                    tuple(table.is_turning[x] for x in kept), tuple(table.lower[x] for x in kept),
                    tuple(table.upper[x] for x in kept), table.left_out + added,
                )  # fmt: skip
        return table

    def _amplitudes(self) -> Precise:
        """Amplitudes of the products of 1, cos, sin, cos 2, sin 2 of all angles; control values of sliding joints."""
        out = self.values
        for place, turns in enumerate(self.is_turning):
            matrix = harmonics() if turns else control_matrix(False, 0.0, 0.0)
            out = np.moveaxis(np.tensordot(matrix, out, axes=(1, place)), 0, place)
        return out

    def boxes(self) -> Iterator[tuple[Precise, float]]:
        """Control values on every first box, and how far errors of the table's values may be multiplied there."""
        yield from self._from(0, self.values, 1.0)

    def half_width(self, place: int) -> float:
        """Half of the width of the first boxes along a joint [rad or m]."""
        return (self.upper[place] - self.lower[place]) / self._count(place) / 2

    def rounding(self, growth: float) -> float:
        """What rounding may have taken from a bound whose table's errors were multiplied by `growth`.

        It allows for double precision once more, without growth: in that B_ii is computed by whoever compares with it.
        """
        units = growth * np.finfo(self.values.dtype).eps + np.finfo(np.float64).eps
        return float(units * OPERATIONS * np.abs(self.values).max(initial=0.0))

    def _count(self, place: int) -> int:
        width = self.upper[place] - self.lower[place]
        return int(np.ceil(width / WIDEST)) if self.is_turning[place] else 1

    def _from(self, place: int, values: Precise, growth: float) -> Iterator[tuple[Precise, float]]:
        if place == len(self.joints):
            yield values, growth
            return
        width = 2 * self.half_width(place)
        for k in range(self._count(place)):
            low = self.lower[place] + k * width
            matrix = control_matrix(self.is_turning[place], low, low + width)
            turned = np.moveaxis(np.tensordot(matrix, values, axes=(1, place)), 0, place)
            yield from self._from(place + 1, turned, growth * float(np.abs(matrix).sum(axis=1).max()))
