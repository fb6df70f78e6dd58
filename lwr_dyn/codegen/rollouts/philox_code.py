"""Random numbers by counting, Philox 4x32-10: (run, sample, block) and a seed become numbers; in NumPy and in kernels.

A sequential generator gives numbers that depend on what was drawn before. Here the numbers of a run are a function of
its number alone: they are the same whatever the batch, the thread, or the place in a block. `CountedEncoder` has the
noise of a rollout, so that `simulate` repeats one run of many. In a kernel vector instructions fill slots of its block;
lane k has the run `run + k`, and words and uniform numbers are bit for bit those of `uniform_numbers`.

Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011, section 3.3 (Philox);
Box, Muller, "A note on the generation of random normal deviates", Ann. Math. Stat. 29 (1958).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from llvmlite import ir
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.loop_helpers import Helper, helper
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.simulation.plant import Encoder

Words = NDArray[np.uint32]

ROUNDS = 10

MULTIPLIERS = (0xD2511F53, 0xCD9E8D57)

WEYL = (0x9E3779B9, 0xBB67AE85)
"""What the two words of the key are raised by from round to round."""

WORD = 2.0**-32

MOST_SEED = 2**64 - 1
"""Largest seed, and largest number of a run."""


def philox(counter: Words, key: Words) -> Words:
    """The four words (..., 4) that belong to counters (..., 4) under keys (..., 2).

    >>> [hex(w) for w in philox(np.zeros(4, np.uint32), np.zeros(2, np.uint32))]
    ['0x6627e8d5', '0xe169c58d', '0xbc57ac4c', '0x9b00dbd8']
    """
    c = [counter[..., i].astype(np.uint64) for i in range(4)]
    k = [key[..., i].astype(np.uint64) for i in range(2)]
    low, half = np.uint64(0xFFFFFFFF), np.uint64(32)
    for _ in range(ROUNDS):
        first, second = (np.uint64(m) * x for m, x in zip(MULTIPLIERS, (c[0], c[2]), strict=True))
        c = [(second >> half) ^ c[1] ^ k[0], second & low, (first >> half) ^ c[3] ^ k[1], first & low]
        k = [(x + np.uint64(w)) & low for x, w in zip(k, WEYL, strict=True)]
    return np.stack(np.broadcast_arrays(*c), axis=-1).astype(np.uint32)


def uniform_numbers(seed: int, run: int, samples: int, count: int) -> Array:
    """Numbers between 0 and 1 of the first samples of a run, (samples, count), count a multiple of 4.

    Block j of four words of sample k has the counter (k, j, low and high half of the run's number); the key is the low
    and the high half of the seed. A word w becomes (w + 1/2) / 2^32, so neither 0 nor 1 occurs. Raises `OptionError`: a
    seed or a number of a run that is not a whole number from 0 to 2^64 - 1.
    """
    halves = [_halves(name, value) for name, value in (("seed", seed), ("number of the run", run))]
    counter = np.zeros((samples, count // 4, 4), dtype=np.uint32)
    counter[..., 0], counter[..., 1] = np.arange(samples)[:, None], np.arange(count // 4)
    counter[..., 2:] = halves[1]
    words = philox(counter, np.array(halves[0], dtype=np.uint32))
    return np.asarray((words.reshape(samples, -1) + 0.5) * WORD)


def normal_numbers(seed: int, run: int, samples: int, n: int) -> Array:
    """Independent numbers of the standard normal distribution, (samples, n); no one is larger than 6.8.

    Uniform numbers u, v (2i and 2i + 1 of the sample) give number 2i = sqrt(-2 ln u) cos 2 pi v and number 2i + 1, the
    same with the sine. Raises as `uniform_numbers`.
    """
    uniform = uniform_numbers(seed, run, samples, words_of(n))
    radius, angle = np.sqrt(-2.0 * np.log(uniform[:, ::2])), 2.0 * np.pi * uniform[:, 1::2]
    pairs = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    return np.ascontiguousarray(pairs.reshape(samples, -1)[:, :n])


def words_of(n: int) -> int:
    """Words that n normal numbers take: whole blocks of four."""
    return 4 * -(-n // 4)


def _halves(name: str, value: int) -> tuple[int, int]:
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not (whole and 0 <= value <= MOST_SEED):
        raise OptionError(name, value, "a whole number from 0 to 2^64 - 1")
    return int(value) & 0xFFFFFFFF, int(value) >> 32


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


_INT, _NUMBER = ir.IntType(64), ir.DoubleType()
_LOW = 0xFFFFFFFF


def uniform_code(name: str, lanes: int, words: int, first_slot: int) -> Helper:
    """A helper `(b, seed, run, sample)` of a kernel's loop.

    It writes `words` uniform numbers (a multiple of 4) to the slots from `first_slot` on of the block `b` of float64;
    lane k has the number `run + k`.
    """

    def write_numbers(builder: Any, arguments: Any) -> None:
        data, seed, run, sample = arguments
        write = _Words(builder, lanes)
        runs = builder.add(write.all_lanes(run), ir.Constant(write.vector, list(range(lanes))))
        counter = [write.low(write.all_lanes(sample)), write.low(runs), write.high(runs)]
        key = [write.low(write.all_lanes(seed)), write.high(write.all_lanes(seed))]
        for block in range(words // 4):
            four = write.philox([counter[0], write.number(block), *counter[1:]], key)
            for i, word in enumerate(four):
                place = builder.gep(data, [ir.Constant(_INT, (first_slot + 4 * block + i) * lanes)])
                target = builder.bitcast(place, ir.VectorType(_NUMBER, lanes).as_pointer())
                builder.store(write.uniform(word), target, align=8 * lanes)

    arguments = (("double*", "b"), ("int", "seed"), ("int", "run"), ("int", "sample"))
    return helper(name, "void", arguments, _NUMBER, write_numbers)


@dataclass(frozen=True, slots=True)
class _Words:
    """Instructions on vectors of words, each in 64 bits."""

    builder: Any
    lanes: int

    @property
    def vector(self) -> Any:
        return ir.VectorType(_INT, self.lanes)

    def number(self, x: int) -> Any:
        return ir.Constant(self.vector, [x] * self.lanes)

    def all_lanes(self, x: Any) -> Any:
        """One number in every lane."""
        value: Any = ir.Constant(self.vector, ir.Undefined)
        for lane in range(self.lanes):
            value = self.builder.insert_element(value, x, ir.Constant(ir.IntType(32), lane))
        return value

    def low(self, x: Any) -> Any:
        return self.builder.and_(x, self.number(_LOW))

    def high(self, x: Any) -> Any:
        return self.builder.lshr(x, self.number(32))

    def philox(self, counter: list[Any], key: list[Any]) -> list[Any]:
        """The four words of a counter, as the function `philox`."""
        xor, c = self.builder.xor, counter
        for _ in range(ROUNDS):
            first, second = (
                self.builder.mul(x, self.number(m)) for m, x in zip(MULTIPLIERS, (c[0], c[2]), strict=True)
            )
            upper = (xor(xor(self.high(product), other), k) for product, other, k in (
                (second, c[1], key[0]), (first, c[3], key[1])
            ))  # fmt: skip
            c = [next(upper), self.low(second), next(upper), self.low(first)]
            key = [self.low(self.builder.add(k, self.number(w))) for k, w in zip(key, WEYL, strict=True)]
        return c

    def uniform(self, word: Any) -> Any:
        """(word + 1/2) / 2^32, exact."""
        kind = ir.VectorType(_NUMBER, self.lanes)
        half, size = (ir.Constant(kind, [ir.Constant(_NUMBER, x)] * self.lanes) for x in (0.5, WORD))
        return self.builder.fmul(self.builder.fadd(self.builder.sitofp(word, kind), half), size)
