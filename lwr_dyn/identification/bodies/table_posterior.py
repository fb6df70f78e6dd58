"""What a log and a table say together of links and rotors, with scales of their difference that the log finds.

    b ~ N(G pi, Lambda^-1),   links ~ N(table, C(scales, local)),   log rotor ~ N(log of the table's, rotor^2)

b and Lambda are base parameters of the log and their precision, G the grouping, C the covariance of `link_spreads`. A
rotor that the table lacks has a guess for its size and a spread of a factor of seven. The scales have wide log-normal
distributions of their own about `USUAL`. `local` are factors on the variances of single links and kinds, those of
Student's t: one link far off does not make all doubtful. Given all these everything is normal, but for the rotors,
whose logarithm is linear about a value that moves to where they are: mean, covariance and evidence are closed forms,

    2 log p(b | scales) = -r^T Lambda r - e^T Q e + log det Q - log det(Lambda_pi + Q) + const,   Q = C^-1

with r and e what the mean leaves of the log and of the table. The likeliest scales are found by a climb along each; the
mean and the covariance are those of a mixture over scales about them, weighted by evidence, so that errors count the
doubt of the scales. Nothing here knows that links are bodies: see `consistent`.

References
----------
MacKay, Bayesian interpolation (1992), section 3, for the evidence; Rue, Martino, Chopin, Approximate Bayesian inference
for latent Gaussian models (2009), section 3, for the mixture; Lange, Little, Taylor, Robust statistical modeling using
the t distribution (1989), section 3, for the factors.
"""

from dataclasses import astuple, dataclass

import numpy as np
from scipy.stats import norm, qmc

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.bodies.body_prior import BodyPrior
from lwr_dyn.identification.bodies.link_spreads import Scales, covariances, link_spreads
from lwr_dyn.identification.regression.information import Information

USUAL = Scales(shape=0.08, centre=0.01, tensor=0.15, mass=0.13, rotor=0.3)
SPREAD = np.array([1.0, 1.0, 1.0, 0.4, 1.5])
"""Of the logs of the scales about the usual ones. Masses alone are hardly seen by a log: theirs is narrow."""
_LOW, _HIGH = np.log([0.005, 3e-4, 0.005, 0.02, 0.02]), np.log([2.0, 0.3, 2.0, 1.5, 10.0])
"""Between which the logs of the scales stay."""
UNKNOWN_SPREAD = 2.0
"""Of the log of a rotor that the table lacks."""
_FARTHEST = 8.0
"""Of a rotor's log from its guess: a log may say that it is 0, or less."""
FREEDOM, ROUNDS = 5.0, 3
"""Of Student's t, and how often its factors are found again."""
DIMENSIONS = np.array([10.0, 3.0, 6.0, 1.0])
"""Of the kinds: shape, centre, tensor, mass."""
TEN = len(INERTIAL)
"""Parameters of a link."""
_LEAST_FACTOR, _LARGEST_FACTOR = 0.1, 100.0
MIXED, _WIDER, _CURVED = 63, 1.2, 0.3
"""Scales that are mixed beside the likeliest; by how much more than the curvature says they are spread; the step in the
logs of scales over which it is taken."""
_STEPS, _GAIN = (1.0, 0.5, 0.25), 1e-3
"""In the logs of scales, and the log evidence for which a step is made."""
_RIDGE, _ROUNDING = 1e-9, 1e-13
"""Added to matrices that are scaled to a diagonal of 1: to a link's covariance, and to a precision, as a log without
noise is 1e16 times surer than a table."""


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """Parameters (p,) as a normal distribution: mean, covariance (p, p); and the log evidence that it has."""

    mean: Array
    covariance: Array
    evidence: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "mean", "covariance")


class TablePosterior:
    """What one log and one table say. `local` (n, 4) and `local_rotors` are the factors, `rotors` (r,) the inertias
    about which their logarithm is linear; `free` (p, f) directions in which parameters may move from the table's.
    """

    def __init__(self, information: Information, prior: BodyPrior, free: Array | None = None) -> None:
        self.prior, self.free = prior, np.diag(prior.units) if free is None else free
        self._grouping, self._precision, self._values = (
            information.base.grouping, information.precision, information.values,
        )  # fmt: skip
        weighted = self._grouping.T @ self._precision
        self._curvature, self._pull = weighted @ self._grouping, weighted @ self._values
        self.links = prior.bodies // TEN
        self._spreads = link_spreads(prior.table[: prior.bodies].reshape(self.links, TEN))
        self.rotors = self._guess = prior.table[prior.rotors]
        self.local, self.local_rotors = np.ones((self.links, DIMENSIONS.size)), np.ones(self.rotors.size)
        self.varied = [0, 1, 2, 3] + ([4] if prior.known_rotors.size else [])
        """Places of the scales that this table has."""

    def given(self, logs: Array) -> Belief:
        """The belief under scales of these logs (5,)."""
        Q, log_det = self._table_precision(logs)
        table = self.prior.table.copy()
        table[self.prior.rotors] = self.rotors * (1.0 + np.log(self._guess / self.rotors))
        H = self.free.T @ (self._curvature + Q) @ self.free
        scale = 1.0 / np.sqrt(np.diag(H))
        root = np.linalg.cholesky(H * np.outer(scale, scale) + _ROUNDING * np.eye(scale.size))
        inverse = (np.linalg.inv(root) * scale).T
        ways = self.free @ inverse
        start = self.prior.table
        pull = self._pull - self._curvature @ start + Q @ (table - start)
        mean = start + ways @ (ways.T @ pull)
        r, e = self._grouping @ mean - self._values, mean - table
        usual = (logs - logs_of(USUAL)) / SPREAD
        half = np.log(np.diag(root)).sum() - np.log(scale).sum()
        squares = r @ self._precision @ r + e @ Q @ e + usual @ usual
        return Belief(mean, ways @ ways.T, float(0.5 * (log_det - squares) - half))

    def table_sigma(self, logs: Array) -> Array:
        """Standard errors (p,) that the table alone has."""
        Q, _ = self._table_precision(logs)
        scale = 1.0 / np.sqrt(np.diag(Q))
        return np.asarray(scale * np.sqrt(np.diag(np.linalg.inv(Q * np.outer(scale, scale)))))

    def _table_precision(self, logs: Array) -> tuple[Array, float]:
        """Q (p, p) and log det Q less what no scale changes."""
        inverse, log_det = _inverses(covariances(self._spreads, scales_of(logs), self.local))
        Q = np.zeros((self.prior.table.size,) * 2)
        for i, block in enumerate(inverse):
            ten = slice(TEN * i, TEN * (i + 1))
            Q[ten, ten] = block
        known = np.exp(logs[4]) * np.sqrt(self.local_rotors)
        spread = np.where(self.prior.unknown_rotors, UNKNOWN_SPREAD, known) * self.rotors
        rotors, friction = self.prior.rotors, self.prior.friction
        Q[rotors, rotors], Q[friction, friction] = spread**-2.0, self.prior.spread[friction] ** -2.0
        return Q, log_det - 2.0 * float(np.log(spread).sum())

    def linearise(self, logs: Array) -> None:
        """Move the rotors to where their mean is, by Newton's method in their logs."""
        for _ in range(40):
            step = np.clip(self.given(logs).mean[self.prior.rotors] / self.rotors - 1.0, -1.0, 1.5)
            before = self.rotors
            least, most = self._guess * np.exp(-_FARTHEST), self._guess * np.exp(_FARTHEST)
            self.rotors = np.clip(before * np.exp(step), least, most)
            if np.abs(self.rotors / before - 1.0).max(initial=0.0) < 1e-3:
                return

    def likeliest(self) -> Array:
        """The logs of the scales with the most evidence; the factors and rotors become those that go with them."""
        logs = logs_of(USUAL)
        self.linearise(logs)
        logs = self._climbed(self._climbed(logs))
        for _ in range(ROUNDS):
            self._reweigh(logs)
            logs = self._climbed(logs)
            self.linearise(logs)
        return logs

    def _climbed(self, logs: Array) -> Array:
        """Along one scale after the other, in ever shorter steps."""
        best = self.given(logs).evidence
        for k in self.varied:
            for step in _STEPS:
                for sign in (1.0, -1.0):
                    while True:
                        there = logs.copy()
                        there[k] = np.clip(logs[k] + sign * step, _LOW[k], _HIGH[k])
                        evidence = self.given(there).evidence
                        if evidence <= best + _GAIN:
                            break
                        logs, best = there, evidence
        return logs

    def _reweigh(self, logs: Array) -> None:
        """Factors of Student's t: expected squares of each kind's part of a link's difference, over those of its scale.

        The part of kind k is C_k C^-1 e given the difference e = sum of the parts.
        """
        belief, kinds = self.given(logs), np.exp(2.0 * logs[:4])
        inverse, _ = _inverses(covariances(self._spreads, scales_of(logs), self.local))
        away = belief.mean - self.prior.table
        for i in range(self.links):
            ten = slice(TEN * i, TEN * (i + 1))
            second = np.outer(away[ten], away[ten]) + belief.covariance[ten, ten]
            for k, dimension in enumerate(DIMENSIONS):
                share = inverse[i] @ (kinds[k] * self.local[i, k] * self._spreads[i, k])
                squares = np.trace(share @ inverse[i] @ second) + dimension - np.trace(share)
                found = (FREEDOM + self.local[i, k] * squares) / (FREEDOM + dimension)
                self.local[i, k] = np.clip(found, _LEAST_FACTOR, _LARGEST_FACTOR)
        rotors = self.prior.rotors
        off = np.log(self.rotors / self._guess) ** 2 + belief.covariance[rotors, rotors] / self.rotors**2
        self.local_rotors = (FREEDOM + off * np.exp(-2.0 * logs[4])) / (FREEDOM + 1.0)

    def mixed(self, logs: Array) -> Belief:
        """Over scales about the likeliest ones, drawn from a normal distribution with the curvature there."""
        root = self._spread_of_logs(logs)
        drawn = qmc.Sobol(len(self.varied), seed=1).random(MIXED + 1)[:MIXED]
        points = np.vstack([np.zeros(len(self.varied)), norm.ppf(np.clip(drawn, 1e-3, 1.0 - 1e-3))])
        beliefs = []
        for point in points:
            there = logs.copy()
            there[self.varied] += root @ point
            beliefs.append(self.given(np.clip(there, _LOW, _HIGH)))
        weights = np.array([belief.evidence for belief in beliefs]) + 0.5 * np.square(points).sum(axis=1)
        weights = np.exp(weights - weights.max())
        weights /= weights.sum()
        means = np.array([belief.mean for belief in beliefs])
        mean = weights @ means
        away = means - mean
        covariance = np.einsum("k,kab->ab", weights, np.array([belief.covariance for belief in beliefs]))
        return Belief(mean, covariance + (weights * away.T) @ away, beliefs[0].evidence)

    def _spread_of_logs(self, logs: Array) -> Array:
        """A root of the covariance of the logs of the scales that vary, by second differences of the evidence."""
        ways = _CURVED * np.eye(logs.size)[self.varied]

        def at(*moves: Array) -> float:
            return self.given(np.sum([logs, *moves], axis=0)).evidence

        curvature, best = np.zeros((len(ways),) * 2), at()
        for a, u in enumerate(ways):
            curvature[a, a] = 2.0 * best - at(u) - at(-u)
            for b, v in enumerate(ways[:a]):
                curvature[a, b] = curvature[b, a] = (at(u, -v) + at(-u, v) - at(u, v) - at(-u, -v)) / 4.0
        values, vectors = np.linalg.eigh(curvature / _CURVED**2)
        return np.asarray(vectors * np.sqrt(_WIDER / np.maximum(values, 0.5)))



def scales_of(logs: Array) -> Scales:
    """The scales of these logs (5,)."""
    return Scales(*np.exp(logs).tolist())


def logs_of(scales: Scales) -> Array:
    """The logs (5,) of scales."""
    return np.log(astuple(scales))


def _inverses(matrices: Array) -> tuple[Array, float]:
    """Of covariances (n, 10, 10) whose entries differ in unit, and the sum of the log dets of the inverses."""
    s = np.sqrt(np.einsum("naa->na", matrices))
    scale = s[:, :, None] * s[:, None, :]
    even = matrices / scale + _RIDGE * np.eye(s.shape[1])
    log_det = np.linalg.slogdet(even)[1].sum() + 2.0 * np.log(s).sum()
    return np.linalg.inv(even) / scale, -float(log_det)
