"""The options of a simulation, checked before anything moves."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.arrays import Array, joint_array
from lwr_dyn.control.protocol import Controller, WithMemory
from lwr_dyn.errors import OptionError, ShapeError
from lwr_dyn.model.run import Motion, Reference
from lwr_dyn.simulation.integrators import Integrator, dop853, rk4
from lwr_dyn.simulation.plant import Plant

MOST_SUBSTEPS = 1000
MOST_SAMPLES = 1e7
"""A run of more does not fit a common memory: 7 joints take 0.5 kB a sample."""
METHODS = ("rk4", "dop853")
GRID = 1e-9
"""Share of a step by which a duration may miss the grid of samples."""


@dataclass(frozen=True, slots=True)
class Settings:
    """How a run is computed: `rate` [Hz] of samples, method, RK4 steps a sample, tolerance of the adaptive method."""

    rate: float = 1000.0
    method: str = "rk4"
    substeps: int = 1
    rtol: float = 1e-12
    continuous: bool = False
    saturate: bool = True
    position_limits: bool = True
    allow_unphysical: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("rate", "rtol"):
            value = getattr(self, name)
            if not (isinstance(value, float | int) and isfinite(value) and value > 0.0):
                raise OptionError(name, value, "a number above 0")
        if self.method not in METHODS:
            raise OptionError("method", repr(self.method), ", ".join(METHODS))
        for name, least, most in (("substeps", 1, MOST_SUBSTEPS), ("seed", 0, None)):
            value = getattr(self, name)
            if not (isinstance(value, int) and value >= least and (most is None or value <= most)):
                end = "on" if most is None else f"to {most}"
                raise OptionError(name, value, f"a whole number from {least} {end}")

    def integrator(self) -> Integrator:
        """The method."""
        return rk4(self.substeps) if self.method == "rk4" else dop853(self.rtol, self.rtol / 10)

    def times(self, duration: float) -> Array:
        """Samples from 0 to the first one not before `duration` [s]; raises `OptionError` unless it is above 0."""
        if not (isfinite(duration) and duration > 0.0):
            raise OptionError("duration", duration, "a number above 0, in s")
        if duration * self.rate > MOST_SAMPLES:
            found = f"{self.rate:g} samples a second over {duration:g} s"
            raise OptionError("rate, duration", found, f"at most {MOST_SAMPLES:.0e} samples in all")
        steps = max(1, int(np.ceil(duration * self.rate - GRID)))
        return np.arange(steps + 1) / self.rate


def sampled_reference(reference: Reference, t: Array, n: int) -> Motion:
    """The reference at every sample in one call; raises `ShapeError` when it is for another number of joints."""
    motion = reference.sample(t)
    for name in ("q", "dq", "ddq"):
        found = getattr(motion, name).shape
        if found != (t.size, n):
            raise ShapeError(f"reference {name}", f"shape {found}", f"({t.size}, {n})")
    return motion


def start_state(plant: Plant, motion: Motion, q0: ArrayLike | None, dq0: ArrayLike | None) -> Array:
    """Where the run begins, (2, n): on the reference unless said otherwise.

    Raises `ShapeError`, or `OptionError` for a start outside the position limits.
    """
    q = joint_array("q0", motion.q[0] if q0 is None else q0, plant.n)
    dq = joint_array("dq0", motion.dq[0] if dq0 is None else dq0, plant.n)
    outside = np.flatnonzero(plant.beyond(q))
    if outside.size:
        j = int(outside[0])
        allowed = f"{plant.lower[j]:.6g} to {plant.upper[j]:.6g}, or position_limits=False"
        raise OptionError(f"q0 of {plant.arm.joint_names[j]}", f"{q[j]:.6g}", allowed)
    return np.array([q, dq])


def check_continuous(controller: Controller, encoder: object) -> None:
    """A continuous run needs a controller without hidden memory and the true state; raises `OptionError`."""
    if encoder is not None:
        raise OptionError("encoder", "given for a continuous run", "a sampled run: an encoder is read at instants")
    if hasattr(controller, "reset") and not isinstance(controller, WithMemory):
        raise OptionError(
            "continuous", "with a controller that remembers between calls",
            "a sampled run, or a controller with `law` and `memory_size`",
        )  # fmt: skip
