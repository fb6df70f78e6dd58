"""How much the torques along a motion say of the base parameters: two objectives with their gradients.

    M = W^T S^-1 W / k,   W: the base columns of k states, S: variance of each joint's torque

    d      -log det(M) / b: exp(d / 2) / sqrt(k) is the mean half-axis (geometric) of the parameters' error ellipsoid,
           which is at most the geometric mean of their sigmas (Hadamard's inequality)
    cond   log of the condition number of W with its columns scaled to length 1

The gradient goes through the regressor: with G = df/dW the derivative is that of <G, Y(q, dq, ddq)>, whose differences
the compiled kernel gives state by state. The sign of a speed is smoothed to tanh(dq / `SMOOTH`).
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.batch import BatchDynamics
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.identification.excitation.fourier import FourierBasis
from lwr_dyn.identification.regression.torque_columns import FROM_KERNEL, TorqueColumns

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
        Without numba: the gradient needs the compiled columns.
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
        if self.columns.kernel is None:
            raise MissingPackageError("numba", "batch")
        check_columns(self.columns)
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


def check_columns(columns: TorqueColumns) -> None:
    """Raise `OptionError` for columns whose smooth sign and gradient are not written here."""
    allowed = "symmetric friction without Stribeck columns or a transmission: TorqueColumns(chain)"
    if columns.friction != "symmetric":
        raise OptionError("columns of a motion", f"friction {columns.friction!r}", allowed)
    if any(len(joint.names) > OWN for joint in columns.joints):
        raise OptionError("columns of a motion", "Stribeck columns", allowed)
    if columns.transmission is not None:
        raise OptionError("columns of a motion", "a transmission", allowed)


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
        raise MissingPackageError("numba", "batch")
    return columns.kernel
