"""What a plus-minus is held against: arms, truths about their tables, noise and seeds, fixed before any fit was made.

`TUNED` are the arms on which the priors of `bodies` were found, `NEW` those on which they never were. Truths:

    near      each link's P is L exp(S) L^T, S 10 %; rotors 10 %
    natural   masses and tensors 15 % (log-normal), centres 10 mm in every direction, axes turned .1 rad; rotors 15 %
    rotors    natural, with large rotors: .6 to .06 kg m^2 where the table has none, .01 or 10 times the table's
    one link  natural with 5 %, 3 mm; but one link, drawn, with 40 % and 40 mm            (off the model of the fit)
    all far   natural with 30 % and 30 mm                                                 (off it too)

Noise of .1 N m: white, or half of its variance from an autoregression of .9 a row of 10 ms.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio
from scipy.linalg import expm
from scipy.signal import lfilter

import lwr_dyn
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.inertial_parameters import inertial_parameters, pseudo_inertias
from lwr_dyn.model.run import Motion
from tests.identification.plants import congruent
from tests.random_arms import random_arm

_DESCRIBED = Path(pinocchio.__file__).parents[4] / "share" / "example-robot-data" / "robots"
_HERE = Path(__file__).parent / "cover_arms"
TUNED = {
    "panda": _DESCRIBED / "panda_description/urdf/panda.urdf",
    "ur5": _DESCRIBED / "ur_description/urdf/ur5_robot.urdf",
    "iiwa14": _HERE / "iiwa14.toml",
    "lwr4plus": "lwr4plus",
}
NEW = {
    "ur10": _DESCRIBED / "ur_description/urdf/ur10_robot.urdf",
    "xarm7": _DESCRIBED / "xarm_description/urdf/xarm7.urdf",
    "wam7": "wam7",
    "random6": 45,
}
"""Two real robots, a paper's table, and a random arm of six revolute joints by its seed."""
TRUTHS, OFF_MODEL, NOISES = ("near", "natural", "rotors"), ("one link", "all far"), ("white", "coloured")
MOTIONS, RUNS = 2, 20
SECONDS, UNSEEN, RATE, HARMONICS = 12.0, 8.0, 100.0, 5
EDGE = 0.2
"""[s] Left out at both ends."""
NOISE, KEPT = 0.1, 0.9
"""[N m], and the share of slow noise that stays after a row."""
BIG_ROTORS = (0.6, 0.6, 0.4, 0.4, 0.2, 0.1, 0.06)
USUAL_ROTOR = 0.1
"""[kg m^2] Of joints whose table has none, give or take 30 %."""


@cache
def cover_arm(name: str) -> Arm:
    """One of `TUNED` or `NEW`."""
    source = (TUNED | NEW)[name]
    if isinstance(source, int):
        return random_arm(source, "RRRRRR")
    return lwr_dyn.load(source, "physical") if source == "lwr4plus" else lwr_dyn.load(source)


@cache
def cover_motion(name: str, number: int, unseen: bool = False) -> Motion:
    """The motion of a log, or the one its fit is judged on: Fourier series inside 2 rad, 2.2 rad/s and the limits."""
    arm, seconds = cover_arm(name), UNSEEN if unseen else SECONDS
    rng = np.random.default_rng((950 if unseen else 50) + number)
    lower, upper = (
        np.where(np.isfinite(x), np.clip(x, -2.0, 2.0), s) for x, s in ((arm.lower, -2.0), (arm.upper, 2.0))
    )
    fastest = np.where(np.isfinite(arm.velocity), np.minimum(arm.velocity, 2.2), 2.2)
    a, b = rng.normal(size=(2, arm.n, HARMONICS))
    t = np.arange(EDGE, seconds - EDGE, 1.0 / RATE)
    w = 2.0 * np.pi / seconds * np.arange(1, HARMONICS + 1)
    C, S = np.cos(np.outer(t, w)), np.sin(np.outer(t, w))
    q, dq, ddq = S @ a.T + C @ b.T, (C * w) @ a.T - (S * w) @ b.T, -(S * w**2) @ a.T - (C * w**2) @ b.T
    room = 0.85 * (upper - lower) / 2.0
    fit = np.minimum(room / np.abs(q).max(axis=0), 0.8 * fastest / np.abs(dq).max(axis=0))
    return Motion(t, (lower + upper) / 2.0 + fit * q, fit * dq, fit * ddq)


def cover_seed(arm: str, truth: str, noise: str, run: int) -> np.random.Generator:
    """Of one log: the same in every process."""
    return np.random.default_rng([run, *map(ord, arm + truth + noise)])


@dataclass(frozen=True, slots=True)
class Natural:
    """How far: log-normal share of masses and tensors, [m] of centres, [rad] of axes."""

    share: float
    centre: float
    turned: float = 0.1


_NATURAL = {
    "natural": Natural(0.15, 0.01), "rotors": Natural(0.15, 0.01), "all far": Natural(0.3, 0.03),
    "one link": Natural(0.05, 0.003),
}  # fmt: skip
_FAR = Natural(0.4, 0.04)


def cover_truth(arm: Arm, columns: TorqueColumns, table: Array, truth: str, rng: np.random.Generator) -> Array:
    """Parameters (p,) of an arm about a table (p,) every link of which is a body."""
    out, rotors, own = table.copy(), columns.rotor_indices, columns.own(arm)
    far = int(rng.integers(arm.n)) if truth == "one link" else -1
    for i in range(arm.n):
        ten = slice(10 * i, 10 * i + 10)
        kind = _FAR if i == far else _NATURAL.get(truth)
        out[ten] = congruent(table[ten], rng) if kind is None else moved(table[ten], kind, rng)
    known, n = own[rotors] > 0.0, arm.n
    if truth == "rotors":
        off = rng.choice([0.01, 10.0]) * np.exp(rng.normal(0.0, 0.2, n))
        lacking = np.array(BIG_ROTORS)[:n] * np.exp(rng.normal(0.0, 0.3, n))
    else:
        off = np.exp(rng.normal(0.0, 0.1 if truth == "near" else 0.15, n))
        lacking = USUAL_ROTOR * np.exp(rng.normal(0.0, 0.3, n))
    out[rotors] = np.where(known, own[rotors] * off, lacking)
    for j in range(n):
        for k in range(columns.of_joint(j).start, columns.of_joint(j).stop):
            if columns.names[k].startswith(("coulomb", "viscous")):
                drawn = own[k] * np.exp(rng.normal(0.0, 0.3)) if own[k] > 0.0 else rng.uniform(0.4, 3.0)
                out[k] = drawn if own[k] > 0.0 or j < 4 else 0.4 * drawn
    return out


def moved(link: Array, kind: Natural, rng: np.random.Generator) -> Array:
    P = pseudo_inertias(link)
    m, c = P[3, 3], P[:3, 3] / P[3, 3]
    second = (P[:3, :3] - m * np.outer(c, c)) * np.exp(rng.normal(0.0, kind.share))
    x, y, z = rng.normal(0.0, kind.turned, 3)
    turn = expm(np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]))
    m, c = m * np.exp(rng.normal(0.0, kind.share)), c + rng.normal(0.0, kind.centre, 3)
    Q = np.empty((4, 4))
    Q[:3, :3], Q[:3, 3], Q[3, :3], Q[3, 3] = turn @ second @ turn.T + m * np.outer(c, c), m * c, m * c, m
    return inertial_parameters(Q)


def cover_noise(shape: tuple[int, int], noise: str, rng: np.random.Generator) -> Array:
    """Of torques (k, n) [N m]."""
    white = rng.normal(0.0, NOISE, shape)
    if noise == "white":
        return white
    drive = rng.normal(0.0, NOISE * np.sqrt(1.0 - KEPT**2), (shape[0] + 300, shape[1]))
    return np.sqrt(0.5) * (white + lfilter([1.0], [1.0, -KEPT], drive, axis=0)[300:])
