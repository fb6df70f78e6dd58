"""What a log and a table say together of links and rotors, with scales of their difference that the log finds.

    y = A pi + unit noise,   links of pi ~ N(table, C(scales, local)),   log rotor ~ N(log of the table's, rotor^2)

y = R b and A = R G are the base parameters of the log in units of their noise: R^T R is their precision, G the
grouping. C is the covariance of `link_spreads`. A rotor that the table lacks has a guess for its size and a spread of a
factor of seven. The scales have wide log-normal distributions of their own about `USUAL`. `local` are factors on the
variances of single links and kinds, those of Student's t: one link far off does not make all doubtful. Given all these
everything is normal, but for the rotors, whose logarithm is linear about a value that moves to where they are. With
d = y - A table and S = 1 + A C A^T

    2 log p(y | scales) = -d^T S^-1 d - log det S + const
    mean = table + C A^T S^-1 d,   covariance = C - C A^T S^-1 A C

The likeliest scales are found by a climb along each; the mean and the covariance are those of a mixture over scales
about them, weighted by evidence, so that errors count the doubt of the scales. Nothing here knows that links are
bodies: see `consistent`. What is known for certain counts as a measurement with next to no noise, and the evidence is
that of the log given it: a mass that was read off the table says nothing of the scales.

References
----------
MacKay, Bayesian interpolation (1992), section 3, for the evidence; Rue, Martino, Chopin, Approximate Bayesian inference
for latent Gaussian models (2009), section 3, for the mixture; Lange, Little, Taylor, Robust statistical modeling using
the t distribution (1989), section 3, for the factors.
"""

from dataclasses import astuple, dataclass

import numpy as np
from scipy.linalg import block_diag, solve_triangular
from scipy.stats import norm, qmc

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.identification.bodies.body_prior import BodyPrior, Constraints
from lwr_dyn.identification.bodies.link_spreads import Scales, covariances, link_spreads
from lwr_dyn.identification.regression.information import Information
from lwr_dyn.identification.regression.least_squares import Spectrum

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
_RIDGE = 1e-9
"""Added to a link's covariance, scaled to a diagonal of 1, before it is inverted."""
_SUREST = 1e6
"""How much surer than the usual table a log counts at most: rounding takes what it knows better."""
CERTAIN = 1e-5
"""Noise of what is known, in units of the prior."""
SECOND = slice(1, 3)
"""Places of the kinds that have a part of second order: centre and tensor."""


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """Parameters (p,) as a normal distribution: mean, covariance (p, p); and the log evidence that it has."""

    mean: Array
    covariance: Array
    evidence: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "mean", "covariance")


class TablePosterior:
    """What one log and one table say.

    `local` (n, 4) and `local_rotors` (r,) are the factors, `rotors` (r,) the inertias about which their logarithm is
    linear.
    """

    def __init__(self, information: Information, prior: BodyPrior, known: Constraints | None = None) -> None:
        self.prior, table = prior, prior.table
        self.links = prior.bodies // TEN
        self._spreads = link_spreads(table[: prior.bodies].reshape(self.links, TEN))
        self.rotors = self._guess = table[prior.rotors]
        self.local, self.local_rotors = np.ones((self.links, DIMENSIONS.size)), np.ones(self.rotors.size)
        self.varied = [0, 1, 2, 3] + ([4] if prior.known_rotors.size else [])
        """Places of the scales that this table has."""
        self._A, self._y = _measured(information, None if known is None else known.scaled(prior.units))
        self._given = 0 if known is None else len(known.names)
        """Rows that are known, the first ones."""
        usual = np.sqrt(np.einsum("ia,ab,ib->i", self._A, self._covariance(logs_of(USUAL)), self._A))
        louder = np.maximum(usual / _SUREST, 1.0)
        self._A, self._y = self._A / louder[:, None], self._y / louder
        self._summed = self._sums()

    def _sums(self) -> Array:
        """A C A^T for a unit of every kind, (6, y, y): the four kinds, and the second order of centre and tensor."""
        A = self._A[:, : self.prior.bodies].reshape(len(self._A), self.links, TEN)
        local = np.hstack([self.local, np.square(self.local[:, SECOND])])
        return np.array([
            sum(local[i, k] * A[:, i] @ self._spreads[i, k] @ A[:, i].T for i in range(self.links))
            for k in range(local.shape[1])
        ])  # fmt: skip

    def _rest(self, logs: Array) -> Array:
        """Variances (p,) of rotors and friction; 0 of links."""
        prior = self.prior
        out = np.square(prior.spread)
        out[: prior.bodies] = 0.0
        known = np.exp(logs[4]) * np.sqrt(self.local_rotors)
        out[prior.rotors] = np.square(np.where(prior.unknown_rotors, UNKNOWN_SPREAD, known) * self.rotors)
        return out

    def _covariance(self, logs: Array) -> Array:
        """C (p, p)."""
        return block_diag(*covariances(self._spreads, scales_of(logs), self.local), self._diagonal(logs))

    def _diagonal(self, logs: Array) -> Array:
        return np.diag(self._rest(logs)[self.prior.bodies :])

    def _seen(self, logs: Array) -> tuple[Array, Array, float]:
        """The root L of S (y, y), L^-1 d (y,), and the log evidence."""
        squares = np.exp(2.0 * logs[:4])
        S = np.tensordot(np.hstack([squares, np.square(squares[SECOND])]), self._summed, 1)
        S += (self._A * self._rest(logs)) @ self._A.T + np.eye(len(S))
        root = np.linalg.cholesky(S)
        d = solve_triangular(root, self._y - self._A @ self._table(), lower=True)
        usual = (logs - logs_of(USUAL)) / SPREAD
        seen, sizes = d[self._given :], np.diag(root)[self._given :]
        return root, d, float(-0.5 * (seen @ seen + usual @ usual) - np.log(sizes).sum())

    def _table(self) -> Array:
        """Its parameters (p,); of rotors, where the line of the log about `rotors` has the table's or the guess."""
        table = self.prior.table.copy()
        table[self.prior.rotors] = self.rotors * (1.0 + np.log(self._guess / self.rotors))
        return table

    def given(self, logs: Array) -> Belief:
        """The belief under scales of these logs (5,)."""
        C, (root, d, evidence) = self._covariance(logs), self._seen(logs)
        W = solve_triangular(root, self._A @ C, lower=True)
        return Belief(self._table() + W.T @ d, C - W.T @ W, evidence)

    def evidence(self, logs: Array) -> float:
        """Its log evidence alone."""
        return self._seen(logs)[2]

    def table_sigma(self, logs: Array) -> Array:
        """Standard errors (p,) that the table alone has."""
        return np.sqrt(np.diag(self._covariance(logs)))

    def linearise(self, logs: Array) -> None:
        """Move the rotors to where their mean is, by Newton's method in their logs."""
        for _ in range(40):
            root, d, _ = self._seen(logs)
            at, before = self.prior.rotors, self.rotors
            mean = self._table()[at] + self._rest(logs)[at] * (self._A[:, at].T @ solve_triangular(root.T, d))
            step = np.clip(mean / before - 1.0, -1.0, 1.5)
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

    def weigh(self, local: Array) -> None:
        """Take the factors (n, 4) of another fit."""
        self.local = np.array(local)
        self._summed = self._sums()

    def _climbed(self, logs: Array) -> Array:
        """Along one scale after the other, in ever shorter steps."""
        best = self.evidence(logs)
        for k in self.varied:
            for step in _STEPS:
                for sign in (1.0, -1.0):
                    while True:
                        there = logs.copy()
                        there[k] = np.clip(logs[k] + sign * step, _LOW[k], _HIGH[k])
                        evidence = self.evidence(there)
                        if evidence <= best + _GAIN:
                            break
                        logs, best = there, evidence
        return logs

    def _reweigh(self, logs: Array) -> None:
        """Factors of Student's t: expected squares of each kind's part of a link's difference, over those of its scale.

        The part of kind k is C_k C^-1 e given the difference e = sum of the parts.
        """
        belief, kinds = self.given(logs), np.exp(2.0 * logs[:4])
        inverse = _inverses(covariances(self._spreads, scales_of(logs), self.local))
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
        self._summed = self._sums()
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
            return self.evidence(np.sum([logs, *moves], axis=0))

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


def _measured(information: Information, known: Constraints | None) -> tuple[Array, Array]:
    """A (y, p) and y: what is known, then the base parameters in the directions that the log shows."""
    spectrum = Spectrum.of(information.precision)
    R = (np.sqrt(np.maximum(spectrum.lengths, 0.0)) * spectrum.axes).T[spectrum.shown] * spectrum.scale
    A, y = R @ information.base.grouping, R @ information.values
    if known is None:
        return A, y
    return np.vstack([known.matrix / CERTAIN, A]), np.concatenate([known.values / CERTAIN, y])


def _inverses(matrices: Array) -> Array:
    """Of covariances (n, 10, 10) whose entries differ in unit."""
    s = np.sqrt(np.einsum("naa->na", matrices))
    scale = s[:, :, None] * s[:, None, :]
    return np.asarray(np.linalg.inv(matrices / scale + _RIDGE * np.eye(s.shape[1])) / scale)
