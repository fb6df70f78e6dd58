"""Random arguments of a function of single states: of every kind that it must refuse, or read rightly."""

import ctypes
import operator

import numpy as np


class Own(np.ndarray):
    """A class of a user."""


def misaligned(x):
    """The same numbers one byte beyond a whole address."""
    memory = np.zeros(x.nbytes + 1, dtype=np.uint8)
    out = memory[1:].view(x.dtype).reshape(x.shape)
    out[:] = x
    return out


def read_only(x):
    x.flags.writeable = False
    return x


def strided(x):
    wide = np.full((x.size, 3), np.nan)
    wide[:, 1] = x.ravel()
    return wide[:, 1]


def with_one(value):
    """The numbers, but one of them is this."""
    return lambda x, rng: np.where(np.arange(x.size) == rng.integers(x.size), value, x)


GOOD = {
    "as it is": lambda x, rng: x, "read-only": lambda x, rng: read_only(x.copy()),
    "every third": lambda x, rng: strided(x), "backwards": lambda x, rng: x[::-1].copy()[::-1],
    "misaligned": lambda x, rng: misaligned(x), "swapped": lambda x, rng: x.astype(">f8"),
    "a class of its own": lambda x, rng: x.view(Own), "a list": lambda x, rng: x.tolist(),
    "a tuple": lambda x, rng: tuple(x.tolist()), "within": lambda x, rng: np.r_[0, x, 0][1:-1],
    "a dtype of its own": lambda x, rng: np.array(x, dtype=np.dtype("f8", copy=True)),
    "objects": lambda x, rng: x.astype(object), "long doubles": lambda x, rng: x.astype(np.longdouble),
    "texts of numbers": lambda x, rng: np.array([repr(float(each)) for each in x]),
}  # fmt: skip
"""What has the meaning of x (n,); exactly these numbers."""

BAD = {
    "too short": lambda x, rng: x[:-1], "too long": lambda x, rng: np.r_[x, 0.0],
    "no numbers": lambda x, rng: np.zeros(0), "a column": lambda x, rng: x[:, None], "NaN": with_one(np.nan),
    "infinite": with_one(-np.inf), "text": lambda x, rng: "text", "none": lambda x, rng: None,
    "complex": lambda x, rng: x + 1j, "texts": lambda x, rng: np.array(["text"] * x.size),
    "no axis": lambda x, rng: np.array(rng.uniform()), "a cube": lambda x, rng: np.zeros((2, 2, 2)),
    "a set": lambda x, rng: {1.0}, "dates": lambda x, rng: np.zeros(x.size, dtype="M8[s]"),
    "records": lambda x, rng: np.zeros(x.size, dtype="f8,f8"),
}  # fmt: skip
"""What no engine takes."""


def drawn(rng, states):
    """Arguments made of `states`, and whether all of them are right."""
    rows, right = [], True
    for x in states:
        kinds = GOOD if rng.uniform() < 0.7 else BAD
        kind = list(kinds)[rng.integers(len(kinds))]
        right &= kinds is GOOD
        rows.append(kinds[kind](x, rng))
    return rows, right


def refused_or_right(call, count, n, arrays, seed):
    """Calls with that many arguments: (refused, answered); raises where a wrong one is answered, or a number is not
    that of the same call with plain arrays."""
    rng, refused, answered = np.random.default_rng(seed), 0, 0
    for _ in range(arrays // count):
        states = rng.uniform(-3.0, 3.0, (count, n))
        rows, right = drawn(rng, states)
        if not right:
            try:
                call(*rows)
            except (ValueError, TypeError):
                refused += 1
                continue
            raise AssertionError(f"answered: {rows}")
        answered += 1
        if not np.array_equal(call(*rows), call(*(x.copy() for x in states))):
            raise AssertionError(f"another answer: {rows}")
    return refused, answered


def references(x):
    """How many names an object has, as C counts them."""
    return ctypes.c_ssize_t.from_address(operator.index(id(x))).value
