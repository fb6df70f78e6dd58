"""What a loop writes while it runs: whole arrays laid out beforehand, cut to what was computed when it ends early."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.model.run import Motion


@dataclass(slots=True, eq=False)
class Log:
    """Samples 0..k of a run: states (k + 1, 2, n), torques (k + 1, n), work since the sample before (k + 1,) [J]."""

    reference: Motion
    states: Array
    command: Array
    applied: Array
    friction: Array | None
    """tau_friction (k + 1, n) where it depends on more than the speeds (joints at rest); else None."""
    friction_work: Array
    stop_work: Array
    actuator_work: Array
    """Filled by continuous runs only; under hold it is tau . (q_{k+1} - q_k), exactly."""
    continuous: bool
    done: int = 0
    """Samples that are whole: state and torque."""

    @classmethod
    def blank(cls, reference: Motion, start: Array, continuous: bool, sticks: bool = False) -> Log:
        """A log for the times of a reference, with the first state (2, n) in it."""
        samples, n = reference.q.shape
        states = np.zeros((samples, 2, n))
        states[0] = start
        command, applied = np.zeros((2, samples, n))
        work, stop, actuator = np.zeros((3, samples))
        held = np.zeros((samples, n)) if sticks else None
        return cls(reference, states, command, applied, held, work, stop, actuator, continuous)

    @property
    def t(self) -> Array:
        """Times of the samples [s]."""
        return self.reference.t

    def work(self) -> dict[str, Array]:
        """What each channel has put in since t = 0, (done,) [J] each: actuator, friction, stop."""
        done = self.done
        steps = self.actuator_work[:done]
        if not self.continuous:
            travel = np.diff(self.states[:done, 0], axis=0)
            steps = np.concatenate([[0.0], np.einsum("ki,ki->k", self.applied[: done - 1], travel)])
        channels = {"actuator": steps, "friction": self.friction_work[:done], "stop": self.stop_work[:done]}
        return {name: np.cumsum(each) for name, each in channels.items()}
