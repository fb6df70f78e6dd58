"""Columns of one joint beside those of the bodies: its rotor and its friction, linear in their parameters."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.friction import FRICTIONLESS, Direction, JointFriction

FrictionForm = Literal["symmetric", "directions"]
FORMS = get_args(FrictionForm)
_NAMES = {
    "symmetric": ("armature", "coulomb", "viscous", "offset"),
    "directions": ("armature", "coulomb+", "viscous+", "coulomb-", "viscous-"),
}
_STRIBECK = {"symmetric": ("stribeck",), "directions": ("stribeck+", "stribeck-")}


@dataclass(frozen=True, slots=True)
class JointColumns:
    """Rotor and friction of a joint (or of a motor) as columns.

    symmetric:   tau = armature ddq + coulomb sign(dq) + viscous dq + offset + stribeck sign(dq) exp(-(dq/v_s)^2)
    directions:  the same with magnitudes of their own for dq > 0 and dq < 0, and without an offset, which is theirs:
                 half the difference of the two levels

    Parameters
    ----------
    form : {"symmetric", "directions"}
    stribeck : tuple of float
        v_s [rad/s or m/s]: none, one, or several to choose from (`regression.stribeck`).

    References
    ----------
    `lwr_dyn.model.friction.Direction`, whose static - coulomb is the parameter stribeck.
    """

    form: FrictionForm
    stribeck: tuple[float, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Of the columns, without the joint's number.

        >>> JointColumns("symmetric", (0.05,)).names
        ('armature', 'coulomb', 'viscous', 'offset', 'stribeck')
        """
        several = len(self.stribeck) > 1
        drops = [f"{name}@{v:g}" if several else name for v in self.stribeck for name in _STRIBECK[self.form]]
        return (*_NAMES[self.form], *drops)

    @property
    def linear(self) -> int:
        """How many columns stand before those of the Stribeck drops."""
        return len(_NAMES[self.form])

    def __call__(self, dq: Array, ddq: Array) -> Array:
        """(k, f) for dq, ddq (k,); at dq = 0 all friction but the offset is 0."""
        sign = np.sign(dq)
        drop = [sign * np.exp(-np.square(dq / v)) for v in self.stribeck]
        if self.form == "symmetric":
            return np.column_stack([ddq, sign, dq, np.ones_like(dq), *drop])
        up, down = dq > 0.0, dq < 0.0
        sides = [x * side for side in (up, down) for x in (sign, dq)]
        return np.column_stack([ddq, *sides, *(x * side for x in drop for side in (up, down))])

    def values_of(self, model: JointFriction | None, armature: float) -> list[float]:
        """The parameters (f,) of a friction model: the mean of its directions where the form is symmetric.

        The Stribeck term is taken as the model's own, whatever its v_s.
        """
        given = model or FRICTIONLESS
        sides = (given.positive, given.negative)
        drops = [side.holding - side.coulomb for side in sides] if self.stribeck else []
        if self.form == "symmetric":
            up, down = sides
            offset = given.offset + (up.coulomb - down.coulomb) / 2
            levels = [(up.coulomb + down.coulomb) / 2, (up.viscous + down.viscous) / 2, offset]
            return [armature, *levels, *([sum(drops) / 2] if drops else [])]
        offsets = (given.offset, -given.offset)
        pairs = [x for side, extra in zip(sides, offsets, strict=True) for x in (side.coulomb + extra, side.viscous)]
        return [armature, *pairs, *drops]

    def friction_of(self, values: Array) -> JointFriction:
        """The model that parameters (f,) describe; a level or a Stribeck term that noise put below 0 is 0.

        With directions the model has no offset of its own unless a level is below 0: then half the difference of the
        two levels is the offset.
        """
        v = [float(x) for x in values]
        if self.form == "symmetric":
            side = self._direction(v[1], v[2], v[4:])
            return JointFriction(side, side, v[3])
        offset = 0.0 if min(v[1], v[3]) >= 0.0 else (v[1] - v[3]) / 2
        up, down = self._direction(v[1] - offset, v[2], v[5:6]), self._direction(v[3] + offset, v[4], v[6:7])
        return JointFriction(up, down, offset)

    def _direction(self, coulomb: float, viscous: float, drop: list[float]) -> Direction:
        level = max(coulomb, 0.0)
        if not drop or drop[0] <= 0.0:
            return Direction(level, viscous)
        return Direction(level, viscous, level + drop[0], self.stribeck[0])
