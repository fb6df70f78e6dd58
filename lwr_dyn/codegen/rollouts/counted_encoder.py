"""An encoder whose noise is that of a rollout: `simulate` with it repeats one run of many."""

from dataclasses import dataclass

from lwr_dyn.codegen.rollouts.philox import normal_numbers
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.simulation.sensors import Encoder


@dataclass(frozen=True, slots=True)
class CountedEncoder(Encoder):
    """As `Encoder`, with the noise that run number `run` of `rollouts` has under the same seed.

    >>> CountedEncoder(noise=1e-5, run=3).noise_of(samples=2, n=7, seed=0).shape
    (2, 7)
    """

    run: int = 0

    def noise_of(self, samples: int, n: int, seed: int) -> Array:
        """Noise of each reading (samples, n) [rad or m]; raises `OptionError` for a seed of more than 64 bits."""
        return self.noise * normal_numbers(seed, self.run, samples, n)
