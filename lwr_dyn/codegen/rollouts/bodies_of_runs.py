"""Arms of single runs from rows of parameters, and rows of parameters as what kernels take.

A load is a point mass at its centre in the flange's frame, as `model.changed_arm.arm_with_payload` without an inertia.
"""

from collections.abc import Mapping
from dataclasses import replace

import casadi
import numpy as np

from lwr_dyn.codegen.kernels.parameters import TENSOR, inertial_parameters
from lwr_dyn.codegen.rollouts.symbolic_model import KeptParameters, SymbolicModel, armature_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm, JointLimits
from lwr_dyn.model.chain import Body, Chain, Rotor, with_bodies, with_payload
from lwr_dyn.model.spatial import steiner


def kept_values(chain: Chain, inertia: Array | None, load: Array | None, com: Array | None) -> Array:
    """Kept parameters of every run, (runs, kept).

    Parameters
    ----------
    inertia : (runs, 10 n) array, optional
        As `codegen.parameters.inertial_parameters`, flat; the chain's own if not given.
    load : (runs,) array, optional
        [kg] at the flange, with its centre `com` (runs, 3) [m] there; at its origin if not given.
    """
    kept = KeptParameters.of(chain)
    out = kept.own[None] if inertia is None else _product(inertia, kept.matrix)
    return out if load is None else out + _product(_point_masses(load, com), kept.payload_matrix)


def mass_matrices(chain: Chain, q: Array, given: Mapping[str, Array]) -> Array:
    """Mass matrices (runs, n, n) at q (n,) of plants with the rows `inertia`, `payload`, `armature`; (1, n, n) of none.

    A mass matrix is linear in the kept parameters: one evaluation of its matrix serves all runs.
    """
    n, own = chain.n, KeptParameters.of(chain).own
    symbols = casadi.SX.sym("kept", own.size)
    rows = SymbolicModel.of(chain, symbols, [0.0] * n).mass_matrix(casadi.DM(q))
    flat = casadi.vertcat(*(x for row in rows for x in row))
    linear = np.array(casadi.Function("B", [symbols], [casadi.jacobian(flat, symbols)])(own).full())
    kept = kept_values(chain, *(given.get(name) for name in ("inertia", "payload", "payload_com")))
    rotors = given.get("armature", armature_of(chain)[None])
    return _product(kept, linear).reshape(-1, n, n) + rotors[:, :, None] * np.eye(n)


def _product(rows: Array, matrix: Array) -> Array:
    """rows matrix^T, summed in order: the same bits for any number of rows."""
    out = np.zeros((len(rows), len(matrix)))
    for k in np.flatnonzero(matrix.any(axis=0)):
        column = matrix[:, k]
        used = np.flatnonzero(column)
        out[:, used] += rows[:, k, None] * column[used]
    return out


def _point_masses(load: Array, com: Array | None) -> Array:
    """Inertial parameters (runs, 10) of point masses."""
    x, y, z = np.zeros((3, len(load))) if com is None else com.T
    second = {(0, 0): y * y + z * z, (1, 1): x * x + z * z, (2, 2): x * x + y * y}
    second |= {(0, 1): -x * y, (0, 2): -x * z, (1, 2): -y * z}
    columns = [np.ones_like(load), x, y, z, *(second[place] for place in TENSOR)]
    return np.asarray(load[:, None] * np.stack(columns, axis=1))


def arm_of_run(arm: Arm, row: Mapping[str, Array], prefix: str = "") -> Arm:
    """The arm with one run's inertia, payload, armature and effort; `prefix` "model_" is the arm that its law knows."""
    chain = arm.chain
    if prefix + "inertia" in row:
        chain = with_bodies(chain, _bodies(row[prefix + "inertia"].reshape(chain.n, 10)))
    if prefix + "payload" in row:
        chain = with_payload(chain, float(row[prefix + "payload"]), row.get(prefix + "payload_com", np.zeros(3)))
    limits: tuple[JointLimits, ...] = arm.limits
    if not prefix and "armature" in row:
        rotors = [Rotor(1.0, float(x), reflected=True) for x in row["armature"]]
        links = [replace(link, rotor=rotor) for link, rotor in zip(chain.links, rotors, strict=True)]
        chain = replace(chain, links=tuple(links))
    if not prefix and "effort" in row:
        limits = tuple(replace(x, effort=float(e)) for x, e in zip(limits, row["effort"], strict=True))
    return arm if chain is arm.chain and limits is arm.limits else replace(arm, chain=chain, limits=limits)


def _bodies(rows: Array) -> list[Body]:
    """Bodies from their inertial parameters (n, 10)."""
    bodies = []
    for m, *rest in rows.tolist():
        tensor = np.zeros((3, 3))
        for (i, j), value in zip(TENSOR, rest[3:], strict=True):
            tensor[i, j] = tensor[j, i] = value
        com = np.array(rest[:3]) / m if m else np.zeros(3)
        bodies.append(Body(m, com, tensor - steiner(m, com)))
    return bodies


def parameters_of(arm: Arm) -> Array:
    """Inertial parameters of an arm, flat, (10 n,): the row `inertia` of a run with its own bodies."""
    return inertial_parameters(arm.chain).ravel()
