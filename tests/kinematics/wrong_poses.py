"""Poses for inverse kinematics: of every kind that it must refuse, or read rightly."""

import numpy as np

import lwr_dyn
from tests.codegen.kernels.wrong_arrays import Own, misaligned, read_only


def strided(T):
    wide = np.full((4, 3, 4, 2), np.nan)
    wide[:, 1, :, 1] = T
    return wide[:, 1, :, 1]


def with_one(place, value):
    out = np.eye(4)
    out[place] = value
    return lambda T: np.where(out == np.eye(4), T, out)


GOOD = {
    "as it is": lambda T: T, "read-only": lambda T: read_only(T.copy()), "strided": strided,
    "by columns": np.asfortranarray, "backwards": lambda T: T[::-1].copy()[::-1], "misaligned": misaligned,
    "swapped": lambda T: T.astype(">f8"), "a class of its own": lambda T: T.view(Own), "a list": lambda T: T.tolist(),
    "rows": tuple, "objects": lambda T: T.astype(object), "long doubles": lambda T: T.astype(np.longdouble),
    "a dtype of its own": lambda T: np.array(T, dtype=np.dtype("f8", copy=True)),
}  # fmt: skip
"""What has the meaning of T (4, 4); exactly these numbers."""

BAD = {
    "three rows": lambda T: T[:3], "flat": np.ravel, "a cube": lambda T: T[None], "one column": lambda T: T[:, :1],
    "no numbers": lambda T: T[:0], "NaN": with_one((0, 1), np.nan), "infinite": with_one((1, 3), np.inf),
    "no pose": with_one((3, 0), 0.5), "a mirror": lambda T: T @ np.diag([1.0, 1.0, -1.0, 1.0]),
    "sheared": with_one((0, 0), 3.0), "complex": lambda T: T + 1j, "a text": lambda T: "text", "none": lambda T: None,
    "texts": lambda T: np.full((4, 4), "text"), "a number": lambda T: 1.0, "dates": lambda T: T.astype("M8[s]"),
}  # fmt: skip
"""What is no pose."""


def numbers(result):
    """All that two results of one pose have in common, to the last bit."""
    rows = [np.array([s.q for s in each]) for each in (result.solutions, result.outside)]
    return result.status, result.distance, *(x.tobytes() for x in rows)


def refused_or_right(arm, count, seed):
    """(refused, answered) of calls; raises where no pose is answered, or numbers are not those of a plain array."""
    rng, kinds, tally = np.random.default_rng(seed), [*GOOD.items(), *BAD.items()], [0, 0]
    low, high = np.maximum(arm.lower, -6.0), np.minimum(arm.upper, 6.0)
    options = {"arm_angle": 0.3} if arm.n == 7 else {}
    for T in lwr_dyn.forward_kinematics(arm, rng.uniform(low, high, (count, arm.n))):
        name, make = kinds[rng.integers(len(kinds))]
        try:
            found = lwr_dyn.inverse_kinematics(arm, make(T), **options)
        except (ValueError, TypeError):
            assert name in BAD, name
            tally[0] += 1
            continue
        assert name in GOOD, name
        assert numbers(found) == numbers(lwr_dyn.inverse_kinematics(arm, T.copy(), **options)), name
        tally[1] += 1
    return tuple(tally)
