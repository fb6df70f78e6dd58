"""Whether bodies exist that have the identified base parameters: two tests, each of which proves that none do.

A base parameter is a sum over links of the ten inertial parameters. With the pseudo-inertia of a link

    P = integral of [x y z 1]^T [x y z 1] dm = [[Sigma, m c], [(m c)^T, m]],      Sigma = trace(I)/2 1 - I
    sum_j c_j pi_j = trace(G(c) P)

P is linear in the parameters; its eigenvalues are positive exactly if mass in space, not all in one plane, has them.
The sum cannot be negative, whatever the bodies, exactly if G(c) of every link is positive semidefinite (that cone is
its own dual) and no rotor enters with a minus. And the mass matrix B(q), which the base parameters give, is positive
definite at every q. That both hold does not prove that such bodies exist: for that they would have to be found.
"""

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from lwr_dyn.dynamics.regressor import INERTIAL
from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.document import Fact
from lwr_dyn.foundation.tables import Heading, Table
from lwr_dyn.identification.regression.least_squares import SIGMAS, Estimate
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.kinematics.solution import drawing_range
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.inertial_parameters import pseudo_inertia_weights, pseudo_inertias


def are_bodies(parameters: Array) -> NDArray[np.bool_]:
    """Which parameters (..., 10) a body of mass in space can have: P positive definite, (...)."""
    P = pseudo_inertias(np.where(np.isfinite(parameters), parameters, -1.0))
    return np.asarray(np.linalg.eigvalsh(P)[..., 0] > 0.0)


CONFIGURATIONS = 400
"""Random ones inside the position limits, at which the mass matrix is looked at."""
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class NegativeParameter:
    """A base parameter below 0 that no bodies can have below 0; value and interval in SI."""

    parameter: str
    links: tuple[int, ...]
    """Whose bodies it sums, from 1."""
    value: float
    three_sigma: float

    @property
    def noise_can_explain(self) -> bool:
        """Whether 0 is within its interval."""
        return not self.value < -self.three_sigma


@dataclass(frozen=True, slots=True, eq=False)
class IndefiniteMassMatrix:
    """A mass matrix that is not positive definite somewhere inside the position limits."""

    lowest: float
    """Its lowest eigenvalue at `q` [kg m^2; kg for a sliding joint]."""
    q: Array
    """(n,) [rad or m]"""
    joint: int
    """The joint, from 1, that moves most in the motion whose kinetic energy would be negative."""
    share: float
    """Of `CONFIGURATIONS` at which it is not positive definite."""
    noise_can_explain: bool
    """False: at some configuration it is negative beyond the simultaneous interval of all combinations (Scheffe)."""

    def __post_init__(self) -> None:
        freeze_arrays(self, "q")


@dataclass(frozen=True, slots=True, eq=False)
class BodyVerdict:
    """What proves that no bodies have the base parameters; nothing found proves nothing."""

    negative: tuple[NegativeParameter, ...]
    mass_matrix: IndefiniteMassMatrix | None

    @property
    def impossible(self) -> bool:
        """Whether no bodies can have them."""
        return bool(self.negative) or self.mass_matrix is not None


def judge_bodies(arm: Arm, columns: TorqueColumns, estimate: Estimate) -> BodyVerdict:
    """Both tests on the estimate of the base parameters of an arm's torque columns.

    A parameter with an infinite error is not looked at, and no mass matrix is made with it.

    References
    ----------
    Wensing, Kim, Slotine, Linear matrix inequalities for physically consistent inertial parameter identification
    (2018), for the pseudo-inertia; Scheffe, The Analysis of Variance (1959), section 3.5.
    """
    base, known = columns.base(), np.isfinite(estimate.standard_errors)
    names, values, half_widths = base.statements(), estimate.values, estimate.half_widths
    negative = tuple(
        NegativeParameter(names[i], _links(columns, base.grouping[i]), float(values[i]), float(half_widths[i]))
        for i in np.flatnonzero(never_negative(columns) & (values < 0.0) & known)
    )
    return BodyVerdict(negative, _indefinite(arm, columns, estimate) if known.all() else None)


def never_negative(columns: TorqueColumns) -> NDArray[np.bool_]:
    """Which base parameters (b,) no bodies and rotors can have below 0."""
    grouping = columns.base().grouping
    inertial = grouping[:, : columns.bodies].reshape(len(grouping), columns.n, len(INERTIAL))
    rotors = grouping[:, columns.rotor_indices]
    size = np.abs(grouping).max(axis=1)
    bodies = np.linalg.eigvalsh(pseudo_inertia_weights(inertial)).min(axis=(1, 2))
    friction = np.abs(grouping[:, columns.friction_indices]).max(axis=1, initial=0.0)
    no_friction = (friction < _ROUNDING * size) & (size > 0.0)
    return np.asarray(no_friction & (np.minimum(bodies, rotors.min(axis=1)) > -_ROUNDING * size))


def _links(columns: TorqueColumns, row: Array) -> tuple[int, ...]:
    parts = np.abs(row[: columns.bodies]).reshape(columns.n, len(INERTIAL)).max(axis=1)
    rotors = np.abs(row[columns.rotor_indices])
    return tuple(int(i) + 1 for i in np.flatnonzero(np.maximum(parts, rotors) > 0.0))


def _indefinite(arm: Arm, columns: TorqueColumns, estimate: Estimate) -> IndefiniteMassMatrix | None:
    turning = np.array([link.kind is JointKind.REVOLUTE for link in arm.chain.links])
    ends = drawing_range(turning, arm.lower, arm.upper)
    q = np.random.default_rng(0).uniform(*ends, (CONFIGURATIONS, arm.n))
    per_unit = mass_matrix_columns(columns, q)
    values, vectors = np.linalg.eigh(per_unit @ estimate.values)
    lowest, motion = values[:, 0], vectors[:, :, 0]
    bad = lowest < 0.0
    if not bad.any():
        return None
    # lowest = motion^T B motion is a sum of base parameters, chosen among all sums: hence Scheffe's factor
    sums = np.einsum("ki,kijb,kj->kb", motion, per_unit, motion)
    spread = np.sqrt(np.einsum("kb,bc,kc->k", sums, estimate.covariance, sums))
    worst, b, dof = int(np.argmin(lowest)), len(estimate.values), estimate.dof
    both_sides = 1.0 - 2.0 * stats.norm.sf(SIGMAS)
    scheffe = float(np.sqrt(b * stats.f.ppf(both_sides, b, dof))) if dof > 0 else float("inf")
    beyond = lowest + scheffe * spread < 0.0
    joint = int(np.argmax(np.abs(motion[worst]))) + 1
    return IndefiniteMassMatrix(float(lowest[worst]), q[worst], joint, float(bad.mean()), not beyond.any())


def mass_matrix_columns(columns: TorqueColumns, q: Array) -> Array:
    """B (k, n, n) at configurations q (k, n), per unit of each base parameter: (k, n, n, b)."""
    k, n = q.shape
    at_rest, kept = np.zeros((k, n)), columns.base().kept
    still = columns(q, at_rest, at_rest)[:, :, kept]
    rows = np.repeat(q, n, axis=0)
    Y = columns(rows, np.zeros((k * n, n)), np.tile(np.eye(n), (k, 1)))[:, :, kept] - np.repeat(still, n, axis=0)
    # row (k, i) is the torque of a unit acceleration of joint i: column i of B
    return np.swapaxes(Y.reshape(k, n, n, len(kept)), 1, 2)


LONGEST = 48
"""Letters of a parameter in a table."""


def body_parts(bodies: BodyVerdict) -> list[Fact | Table]:
    """The parts of a document on the verdict."""
    heads = ("parameter", "links", "value", "three_sigma", "noise_can_explain")
    rows = [[getattr(one, key) for key in heads] for one in bodies.negative]
    kinds = (str, list[int], float, float, bool)
    columns = [Heading(key=key, kind=kind) for key, kind in zip(heads, kinds, strict=True)]
    matrix = bodies.mass_matrix
    return [
        Fact("impossible", bodies.impossible, "Whether something shows that no bodies can have the values."),
        Table("", columns, rows, key="negative_parameters", says="Base parameters below 0 that no bodies have there."),
        Fact("mass_matrix", None if matrix is None else asdict(matrix), "A mass matrix that is not positive definite.",
             kind=IndefiniteMassMatrix | None),
        Fact("text", body_lines(bodies), "The same in words.", kind=list[str]),
    ]  # fmt: skip


def body_lines(bodies: BodyVerdict) -> list[str]:
    """What shows that no bodies can have the values, each with the links or joint; empty if nothing does."""
    lines = [
        f"impossible: {short(n.parameter)} = {n.value:.5g} +- {n.three_sigma:.2g} (99.73 %), never below 0 "
        f"for any bodies (link{'s' * (len(n.links) > 1)} {', '.join(map(str, n.links))}); {CAUSE[n.noise_can_explain]}"
        for n in bodies.negative
    ]
    m = bodies.mass_matrix
    if m is not None:
        q = ", ".join(f"{x:.4g}" for x in m.q)
        lines.append(
            f"impossible: B(q) is not positive definite at {m.share:.1%} of {CONFIGURATIONS} configurations; lowest "
            f"eigenvalue {m.lowest:.5g} at q = {q}, mostly joint {m.joint}; {CAUSE[m.noise_can_explain]}"
        )
    return lines


CAUSE = {
    True: "noise can explain it: a longer or faster motion may mend it",
    False: "noise cannot explain it: look at geometry, signs and units of the log",
}
"""Of values that no bodies can have: whether noise can explain them."""


def short(statement: str) -> str:
    """The start of a long combination of parameters."""
    return statement if len(statement) <= LONGEST else f"{statement[: LONGEST - 3]}..."
