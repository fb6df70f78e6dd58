"""Fourier motions that begin and end at rest, and how much their torques say of the base parameters.

    q_j(t) = q0_j + sum_k a_jk / (k w) sin(k w t) - b_jk / (k w) cos(k w t),   w = 2 pi / T,  k = 1 ... H

With sum_k a_jk = 0 and sum_k k b_jk = 0 the speed and the acceleration vanish at t = 0 and t = T, so that a controller
can start and stop there. Both conditions are linear: the series has 2 H - 1 free coordinates a joint.

    M = W^T S^-1 W / k,   W: the base columns of k states, S: variance of each joint's torque

    d      -log det(M) / b: exp(d / 2) / sqrt(k) is the mean half-axis (geometric) of the parameters' error ellipsoid,
           which is at most the geometric mean of their sigmas (Hadamard's inequality)
    cond   log of the condition number of W with its columns scaled to length 1

The gradient goes through the regressor: with G = df/dW the derivative is that of <G, Y(q, dq, ddq)>, whose differences
the compiled kernel gives state by state. The sign of a speed is smoothed to tanh(dq / `SMOOTH`); `MotionScore` is
unsmoothed.
"""

import math
from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lwr_dyn.codegen.kernels.batch import BatchDynamics
from lwr_dyn.foundation.arrays import Array, freeze_arrays, real_array
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.identification.regression.torque_columns import FROM_KERNEL, TorqueColumns
from lwr_dyn.model.run import Motion, short_repr

MOST_HARMONICS = 50


@dataclass(frozen=True, slots=True, eq=False)
class FourierMotion:
    """A motion of n joints for `duration` [s]: `centre` (n,) [rad or m], `sines`, `cosines` (H, n) [rad/s or m/s].

    A reference that any simulation takes: before 0 and after its end it stands still.

    References
    ----------
    Swevers et al., Optimal robot excitation and identification (1997), eq. 13.
    """

    duration: float
    centre: Array
    sines: Array
    cosines: Array
    name: ClassVar[str] = "FourierMotion"
    """In run files."""
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "centre", "sines", "cosines")

    def sample(self, t: ArrayLike) -> Motion:
        """The motion at times t (k,) [s], exact derivatives; raises `ShapeError`."""
        times = np.atleast_1d(real_array("t", t))
        at = np.clip(times, 0.0, self.duration)
        moving = (times == at)[:, None]
        w = 2.0 * np.pi / self.duration * np.arange(1, len(self.sines) + 1)
        S, C = np.sin(np.outer(at, w)), np.cos(np.outer(at, w))
        q = self.centre + S @ (self.sines / w[:, None]) - C @ (self.cosines / w[:, None])
        dq = C @ self.sines + S @ self.cosines
        ddq = C @ (self.cosines * w[:, None]) - S @ (self.sines * w[:, None])
        return Motion(times, q, moving * dq, moving * ddq)


@dataclass(frozen=True, slots=True, eq=False)
class FourierBasis:
    """The series at fixed times: q = position @ X, dq = speed @ X, ddq = acceleration @ X, coordinates X (2 H - 1, n).

    `position`, `speed`, `acceleration` are (k, 2 H - 1); the first coordinate is the centre, the others move about it.
    """

    duration: float
    harmonics: int
    position: Array
    speed: Array
    acceleration: Array
    free: Array
    """(2 H + 1, 2 H - 1): centre, a, b of the free coordinates."""

    @property
    def count(self) -> int:
        """Free coordinates of a joint."""
        return int(self.free.shape[1])

    def motion(self, X: Array) -> FourierMotion:
        """The series of coordinates X (2 H - 1, n)."""
        centre, sines, cosines = np.split(self.free @ X, [1, 1 + self.harmonics])
        return FourierMotion(self.duration, centre[0], sines, cosines)


def fourier_basis(duration: float, harmonics: int, instants: int) -> FourierBasis:
    """The basis at `instants` times, equally spaced from 0, the last one before `duration`.

    Raises
    ------
    OptionError
        A duration that is not above 0; less than 2 or more than `MOST_HARMONICS` harmonics.

    >>> basis = fourier_basis(10.0, 5, 50)
    >>> basis.count, float(np.abs(basis.speed[0]).max().round(12)), float(np.abs(basis.acceleration[0]).max().round(12))
    (9, 0.0, 0.0)
    """
    if not (math.isfinite(duration) and duration > 0.0):
        raise OptionError("duration", duration, "a time above 0 s")
    if not 2 <= harmonics <= MOST_HARMONICS:
        raise OptionError("harmonics", harmonics, f"2 to {MOST_HARMONICS}")
    k = np.arange(1, harmonics + 1)
    w = 2.0 * np.pi / duration * k
    angle = np.outer(np.arange(instants) * (duration / instants), w)
    S, C, none = np.sin(angle), np.cos(angle), np.zeros((instants, 1))
    free = np.zeros((2 * harmonics + 1, 2 * harmonics - 1))
    free[0, 0] = 1.0
    free[1 : harmonics + 1, 1:harmonics] = _across(np.ones(harmonics))
    free[harmonics + 1 :, harmonics:] = _across(k.astype(np.float64))
    position, speed = np.hstack([none + 1.0, S / w, -C / w]) @ free, np.hstack([none, C, S]) @ free
    return FourierBasis(duration, harmonics, position, speed, np.hstack([none, -S * w, C * w]) @ free, free)


def _across(direction: Array) -> Array:
    """An orthonormal basis (H, H - 1) across a vector of positive numbers, by a Householder mirror."""
    v = direction / np.linalg.norm(direction)
    v = v + np.eye(len(v))[0]
    mirror = np.eye(len(v)) - 2.0 * np.outer(v, v) / (v @ v)
    return np.asarray(mirror[:, 1:])


ObjectiveName = Literal["d", "cond"]
OBJECTIVES: tuple[ObjectiveName, ...] = ("d", "cond")
SMOOTH = 0.05
"""[rad/s or m/s] Speed at which the smoothed sign of friction is tanh(1)."""
OWN = 4
"""Columns of a joint: rotor, Coulomb and viscous friction, offset."""
STEP = 1e-5
"""Step of the central differences [rad, rad/s, rad/s^2]."""
DEGENERATE = 1e-14
"""Smallest eigenvalue of the scaled M at which a motion says nothing of some parameter."""
LARGE = 20.0
"""The value of an objective there: a trial step of the search may come to such a motion."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionObjective:
    """One objective of the coordinates x (b n,) of a Fourier motion, over the states of one basis.

    Raises
    ------
    MissingPackageError
        Without the extra `batch`: the gradient needs the compiled columns.
    OptionError
        Columns with other friction than Coulomb, viscous and offset, the same in both directions, or of motors that
        are coupled.
    """

    columns: TorqueColumns
    basis: FourierBasis
    noise: Array
    """(n,) [N m or N] standard deviation of each joint's torque."""
    name: ObjectiveName = "d"
    _kept: NDArray[np.intp] = field(init=False)
    _places: NDArray[np.intp] = field(init=False)

    def __post_init__(self) -> None:
        _kernel(self.columns)
        allowed = "symmetric friction without Stribeck columns or a transmission: TorqueColumns(chain)"
        for fault, found in (
            (self.columns.friction != "symmetric", f"friction {self.columns.friction!r}"),
            (any(len(joint.names) > OWN for joint in self.columns.joints), "Stribeck columns"),
            (self.columns.transmission is not None, "a transmission"),
        ):
            if fault:
                raise OptionError("columns of a motion", found, allowed)
        object.__setattr__(self, "_kept", self.columns.base().kept)
        n = self.columns.n
        places = (len(FROM_KERNEL) * np.arange(n)[:, None] + FROM_KERNEL).ravel()
        object.__setattr__(self, "_places", np.concatenate([places, np.arange(len(places), self.columns.count)]))

    def __call__(self, x: Array) -> tuple[float, Array]:
        """The value and its gradient."""
        B, n = self.basis, self.columns.n
        X = x.reshape(-1, n)
        states = (B.position @ X, B.speed @ X, B.acceleration @ X)
        W = self._smooth_columns(*states)[:, :, self._places[self._kept]] / self.noise[:, None]
        k, _, b = W.shape
        rows = W.reshape(-1, b)
        M = rows.T @ rows / k
        value, slope = VALUES[self.name](M)
        if value >= LARGE:
            return LARGE, np.zeros_like(x)
        G = np.zeros((k, n, self.columns.count))
        G[:, :, self._places[self._kept]] = (rows @ (2.0 / k * slope)).reshape(W.shape) / self.noise[:, None]
        by_state = self._pulled_back(states, G)
        parts = zip((B.position, B.speed, B.acceleration), by_state, strict=True)
        return value, np.sum([P.T @ g for P, g in parts], axis=0).ravel()

    def _smooth_columns(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Columns in the kernel's order of a link's tensor, with a smoothed sign of the speed."""
        columns, n = self.columns, self.columns.n
        out = np.zeros((len(q), n, columns.count))
        out[:, :, : columns.bodies] = _kernel(columns).torque_regressor(q, dq, ddq)
        sign = np.tanh(dq / SMOOTH)
        for j in range(n):
            out[:, j, columns.of_joint(j)] = np.stack([ddq[:, j], sign[:, j], dq[:, j], np.ones(len(q))], axis=1)
        return out

    def _pulled_back(self, states: tuple[Array, Array, Array], G: Array) -> list[Array]:
        """d <G, Y> / d q, dq, ddq: (k, n) each."""
        columns, n = self.columns, self.columns.n
        k, bodies = len(G), self.columns.bodies
        weights = G[:, :, :bodies].reshape(k, -1, 1)
        out = []
        for place in range(3):
            moved = [np.repeat(z[:, None], 2 * n, axis=1) for z in states]
            for j in range(n):
                moved[place][:, 2 * j, j] += STEP
                moved[place][:, 2 * j + 1, j] -= STEP
            Y = _kernel(columns).torque_regressor(*(z.reshape(-1, n) for z in moved))
            e = (Y.reshape(k, 2 * n, -1) @ weights)[:, :, 0]
            out.append((e[:, ::2] - e[:, 1::2]) / (2.0 * STEP))
        tanh = np.tanh(states[1] / SMOOTH)
        for j in range(n):
            armature, coulomb, viscous, _ = G[:, j, columns.of_joint(j)].T
            out[1][:, j] += viscous + coulomb * (1.0 - tanh[:, j] ** 2) / SMOOTH
            out[2][:, j] += armature
        return out


def d_value(M: Array) -> tuple[float, Array]:
    """-log det(M) / b and its derivative by M; `LARGE` and zeros where M is singular."""
    scale = np.sqrt(np.diag(M))
    scaled = _scaled(M, scale)
    if scaled is None:
        return LARGE, np.zeros_like(M)
    factor = np.linalg.cholesky(scaled)
    value = -2.0 * (np.log(np.diag(factor)).sum() + np.log(scale).sum()) / len(M)
    return float(value), -np.linalg.inv(scaled) / np.outer(scale, scale) / len(M)


def cond_value(M: Array) -> tuple[float, Array]:
    """Log of the condition number of W with scaled columns, half that of the scaled M, and its derivative by M."""
    scale = np.sqrt(np.diag(M))
    scaled = _scaled(M, scale)
    if scaled is None:
        return LARGE, np.zeros_like(M)
    values, vectors = np.linalg.eigh(scaled)
    slope = np.zeros_like(M)
    for place, sign in ((-1, 0.5), (0, -0.5)):
        u = vectors[:, place] / scale
        slope += sign * (np.outer(u, u) / values[place] - np.diag(u**2))
    return float(0.5 * np.log(values[-1] / values[0])), slope


VALUES = {"d": d_value, "cond": cond_value}


def _scaled(M: Array, scale: Array) -> Array | None:
    """M with 1 on its diagonal; None where it is singular or not finite."""
    if not (np.isfinite(M).all() and (scale > 0.0).all()):
        return None
    scaled = M / np.outer(scale, scale)
    return scaled if np.linalg.eigvalsh(scaled)[0] > DEGENERATE else None


def _kernel(columns: TorqueColumns) -> BatchDynamics:
    if columns.kernel is None:
        raise MissingPackageError("llvmlite", "batch")
    return columns.kernel


SCORE_RATE = 100.0
"""[Hz] Rows of a log of which each counts as an equation of its own."""
APART = 1000.0
"""Above so many times the sigma that a parameter has alone, it is known only as part of a sum."""
_BLOCK = 500
"""Rows whose columns are in memory at a time."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionScore:
    """Objectives of a motion's rows at `SCORE_RATE`, and what noise leaves of the base parameters."""

    d: float
    """-log det of the information of one row, per parameter; each 2 less is an error ellipsoid e times as small."""
    condition: float
    """Of the regressor with its columns scaled to length 1."""
    sigma: Array
    """(b,) of the base parameters [SI], for torques with the stated noise."""
    alone: Array
    """(b,) The same of each parameter where all others are known [SI]."""
    names: tuple[str, ...]
    """(b,) Columns that stand for the base parameters."""
    __repr__ = short_repr

    def __post_init__(self) -> None:
        freeze_arrays(self, "sigma", "alone")

    @property
    def together(self) -> tuple[str, ...]:
        """Parameters that torques show only as a sum with others: their sigma is over `APART` times `alone`.

        Axes that a file gives as right angles in a few digits are the usual cause (1.5708 for pi / 2).
        """
        return tuple(name for name, here in zip(self.names, self.sigma > APART * self.alone, strict=True) if here)

    @property
    def mean_sigma(self) -> float:
        """Geometric mean of `sigma`, at least exp(d / 2) / sqrt(rows); NaN where a parameter is not shown."""
        return float(np.exp(np.log(self.sigma).mean()))


def motion_score(columns: TorqueColumns, rows: Motion, noise: Array) -> MotionScore:
    """The score of the rows of any motion for torque noise (n,) [N m or N], each an equation of every joint.

    A parameter that the motion does not show makes `d` 20 and `condition` its exponential, and sigma NaN.
    """
    M = information_per_row(columns, rows, noise)
    d, _ = d_value(M)
    condition, _ = cond_value(M)
    base = columns.base()
    scale = np.sqrt(np.diag(M))
    known = bool(np.isfinite(scale).all() and (scale > 0.0).all() and condition < LARGE)
    inverse = np.linalg.inv(M / np.outer(scale, scale)) if known else np.full_like(M, np.nan)
    alone = 1.0 / np.where(scale > 0.0, scale, np.nan) / np.sqrt(len(rows.t))
    sigma = np.sqrt(np.diag(inverse)) * alone
    return MotionScore(d, float(np.exp(condition)), sigma, alone, tuple(base.names[k] for k in base.kept))


def information_per_row(columns: TorqueColumns, rows: Motion, noise: Array) -> Array:
    """W^T S^-1 W / k (b, b) of the k rows of a motion."""
    kept, k = columns.base().kept, len(rows.t)
    M = np.zeros((len(kept), len(kept)))
    for i in range(0, k, _BLOCK):
        part = slice(i, i + _BLOCK)
        W = columns(rows.q[part], rows.dq[part], rows.ddq[part])[:, :, kept] / noise[:, None]
        flat = W.reshape(-1, len(kept))
        M += flat.T @ flat
    return M / k
