"""The options of a simulation, and the checks of reference, start and friction before a run begins."""

from dataclasses import dataclass
from math import ceil, isfinite

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.control.protocol import Controller, WithMemory
from lwr_dyn.foundation.arrays import Array, joint_array
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.run import Motion, Reference
from lwr_dyn.simulation.integrators import Integrator, dop853, rk4
from lwr_dyn.simulation.plant import Plant

MOST_SUBSTEPS = 1000
MOST_DELAY = 100
MOST_SAMPLES = 1e7
"""A run of more does not fit a common memory: 7 joints take 0.5 kB a sample."""
METHODS = ("rk4", "dop853", "radau")
GRID = 1e-9
"""Share of a step by which a duration may miss the grid of samples."""
STABLE = 2.7
"""Product of rate and step up to which RK4 is stable on the negative real axis (2.785)."""


@dataclass(frozen=True, slots=True)
class SimulationOptions:
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
    delay: int = 0  # samples from a command to its torque

    def __post_init__(self) -> None:
        for name in ("rate", "rtol"):
            value = getattr(self, name)
            if not (isinstance(value, float | int) and isfinite(value) and value > 0.0):
                raise OptionError(name, value, "a number above 0")
        if self.method not in METHODS:
            raise OptionError("method", repr(self.method), ", ".join(METHODS))
        for name, least, most in (("substeps", 1, MOST_SUBSTEPS), ("seed", 0, None), ("delay", 0, MOST_DELAY)):
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
            samples = f"{self.rate:g} samples a second over {duration:g} s"
            raise OptionError("rate, duration", samples, f"at most {MOST_SAMPLES:.0e} samples in all")
        steps = max(1, int(np.ceil(duration * self.rate - GRID)))
        if self.delay > steps:
            raise OptionError("delay", f"{self.delay} samples in a run of {steps}", "a delay shorter than the run")
        return np.arange(steps + 1) / self.rate


def sampled_reference(reference: Reference, t: Array, n: int) -> Motion:
    """The reference at every sample in one call; raises `ShapeError` when it is for another number of joints."""
    motion = reference.sample(t)
    for name in ("q", "dq", "ddq"):
        shape = getattr(motion, name).shape
        if shape != (t.size, n):
            raise ShapeError(f"reference {name}", f"shape {shape}", f"({t.size}, {n})")
    return motion


def start_state(plant: Plant, motion: Motion, q0: ArrayLike | None, dq0: ArrayLike | None) -> Array:
    """The state (q, dq) in which the run begins, (2, n): on the reference if not given.

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


def check_continuous(controller: Controller, encoder: object, delay: int = 0) -> None:
    """A continuous run needs a controller without hidden memory, the true state, no delay; raises `OptionError`."""
    if delay:
        raise OptionError("delay", f"{delay} samples in a continuous run", "0, or a sampled run")
    if encoder is not None:
        raise OptionError("encoder", "given for a continuous run", "a sampled run: an encoder is read at instants")
    if hasattr(controller, "reset") and not isinstance(controller, WithMemory):
        raise OptionError(
            "continuous", "with a controller that remembers between calls",
            "a sampled run, or a controller with `torque_and_rate` and `memory_size`",
        )  # fmt: skip


def friction_rate(plant: Plant, q: Array, options: SimulationOptions) -> float:
    """Fastest rate at which friction brakes [1/s], the largest eigenvalue of B(q)^-1 diag(slope), where a run begins.

    Raises `OptionError` where RK4's step is too long for it: the motion would grow instead of coming to rest.
    """
    form, slope = plant.friction.form, plant.friction.slope
    if not slope.any():
        return 0.0
    rate = float(np.linalg.eigvals(np.linalg.solve(plant.ungated.mass_matrix(q), np.diag(slope))).real.max())
    step = 1.0 / (options.rate * options.substeps)
    if options.method == "rk4" and rate * step > STABLE:
        need = ceil(rate / options.rate / STABLE)
        other = ", or friction set-valued" if form == "smooth" else ""
        fault = f"{form}, brakes at up to {rate:.4g} 1/s, too fast for RK4 steps of {step:.3g} s"
        raise OptionError("friction", fault, f"substeps from {need} on, method dop853{other}")
    return rate
