"""Encoder and delay of a run as casadi expressions: what stands between the true state and the law, and behind it.

They repeat `simulation.sensors.Encoder` with `control.velocity.FilteredDifference`, and the delay of
`simulation.loops`, number for number.
"""

from typing import Any, NamedTuple

import casadi

Column = Any
"""A casadi.SX column."""


class EncoderReading(NamedTuple):
    """What the controller sees, columns (n,), and the memory (2 n,) of the next sample: reading, filtered velocity."""

    q: Column
    dq: Column
    memory: Column


class LateCommand(NamedTuple):
    """The command (n,) that acts now, and the memory of the next sample: the commands before it, latest first."""

    command: Column
    memory: Column


def normals(uniform: Column, n: int) -> Column:
    """n numbers of the standard normal distribution from uniform ones, as `philox.normal_numbers`."""
    out: list[Any] = []
    for i in range(0, n, 2):
        radius, angle = casadi.sqrt(-2.0 * casadi.log(uniform[i])), 2.0 * casadi.pi * uniform[i + 1]
        out += [radius * casadi.cos(angle), radius * casadi.sin(angle)]
    return casadi.vertcat(*out[:n])


def rounded(x: Column) -> Column:
    """The nearest whole numbers, halves to the even one, as `numpy.round`."""
    return x - casadi.remainder(x, 1.0)


def encoder_reading(
    q: Column, dq: Column, memory: Column, noise: Column | None, resolution: Any, pole: float, rate: float, first: Any
) -> EncoderReading:
    """A sample of an encoder.

    Parameters
    ----------
    q, dq : columns (n,)
        The true state.
    memory : column (2 n,)
        Of the sample before; finite numbers at the first.
    noise : column (n,), optional
        What is added to q before rounding.
    resolution : number or symbol
        One count; 0 for no rounding. A symbol may be 0 in some runs; a number folds.
    pole, rate : float
        Of the velocity filter, and samples a second [Hz].
    first : symbol
        1 at the first sample, which starts the filter with the true speed, else 0.
    """
    n = q.numel()
    noisy = q if noise is None else q + noise
    reading = _rounded_to(noisy, resolution)
    last, value = memory[:n], memory[n:]
    difference = (reading - last) * rate
    filtered = difference + pole * (value - difference)
    seen = casadi.if_else(first > 0.5, dq, filtered)
    return EncoderReading(reading, seen, casadi.vertcat(reading, seen))


def _rounded_to(x: Column, resolution: Any) -> Column:
    if isinstance(resolution, float | int):
        return rounded(x / resolution) * resolution if resolution > 0.0 else x
    rounds = resolution > 0.0
    count = casadi.if_else(rounds, resolution, 1.0)
    return casadi.if_else(rounds, rounded(x / count) * count, x)


def late_command(command: Column, memory: Column, delay: Any, sample: Any) -> LateCommand:
    """The command of `delay` samples ago; until the first arrives, it acts already.

    Parameters
    ----------
    command : column (n,)
        The command of this sample.
    memory : column (m n,)
        The m commands before it, latest first; finite numbers where there were none yet.
    delay : number or symbol
        Whole samples from 0 to m.
    sample : symbol
        Number of this sample, from 0.
    """
    n, most = command.numel(), memory.numel() // command.numel()
    behind = casadi.fmin(delay, sample)
    out = command
    for i in range(1, most + 1):
        out = casadi.if_else(behind > i - 0.5, memory[n * (i - 1) : n * i], out)
    return LateCommand(out, casadi.vertcat(command, memory[: n * (most - 1)]) if most else memory)
