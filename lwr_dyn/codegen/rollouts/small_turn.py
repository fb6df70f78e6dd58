"""Sine and cosine of an angle near one whose sine and cosine are known: what a stage of RK4 needs of its angles."""

from typing import Any

from lwr_dyn.codegen.rollouts.symbolic_model import SymbolicAngle

LARGEST = 0.2
"""[rad] Largest change of an angle; the series then leaves 6e-16."""
_SINE = (-1 / 6, 1 / 120, -1 / 5040, 1 / 362880)
_COSINE = (-1 / 2, 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800)


def turned(angle: SymbolicAngle, by: Any) -> SymbolicAngle:
    """The angle and `by` [rad] more, of a size up to `LARGEST`, by the series of sin and cos - 1."""
    square = by * by
    sine = by + by * (square * _series(_SINE, square))
    less_one = square * _series(_COSINE, square)
    return SymbolicAngle(
        angle.cosine + (angle.cosine * less_one - angle.sine * sine),
        angle.sine + (angle.sine * less_one + angle.cosine * sine),
    )


def _series(coefficients: tuple[float, ...], x: Any) -> Any:
    total: Any = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        total = total * x + c
    return total
