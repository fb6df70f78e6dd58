"""Rotors and friction of motors that turn several joints, as numbers of the joints.

A table or a model has places for one rotor and one friction a joint. They are what a motion of that joint alone shows.
With T the motor map, speeds of motors seen at the joints of their numbers (`Transmission.at_joints`),

    armature_j = sum_i T_ij^2 J_i,   coulomb_j = sum_i |T_ij| coulomb_i,   viscous_j = sum_i T_ij^2 viscous_i

where a motor's directions are exchanged if T_ij < 0. What motors add where several of their joints move has no place.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.transmission import Transmission

_POWERS = {"armature": 2, "coulomb": 1, "viscous": 2, "offset": 1}
"""Of |T_ij|, that brings a motor's number to a joint."""
_OTHER_SIDE = {"+": "-", "-": "+", "": ""}


def seen_alone(names: Sequence[str], motors: Transmission | None) -> Array | None:
    """Matrix from parameters of motors to those that each joint shows when it moves alone.

    Parameters
    ----------
    names : (p,) sequence of str
        Of the parameters, as `TorqueColumns.names`: those of bodies, and Stribeck drops, stay what they are. A drop is
        its own joint's alone: two with other speeds are no third.
    motors : Transmission or None

    Returns
    -------
    (p, p) array or None
        None where the parameters are those of joints already, or of motors with units of their own.

    >>> seen_alone(["armature_1", "armature_2"], Transmission([[1.0, 0.0], [1.0, 1.0]])).tolist()
    [[1.0, 1.0], [0.0, 1.0]]
    """
    if motors is None or not motors.seen_at_joints:
        return None
    out, at = np.eye(len(names)), {name: k for k, name in enumerate(names)}
    for k, (kind, side, joint) in enumerate(map(_parts, names)):
        if kind not in _POWERS:
            continue
        for i, ratio in enumerate(motors.matrix[:, joint]):
            if i != joint and ratio != 0.0:
                own = side if ratio > 0.0 else _OTHER_SIDE[side]
                sign = np.sign(ratio) if kind == "offset" else 1.0
                out[k, at[f"{kind}{own}_{i + 1}"]] = sign * abs(ratio) ** _POWERS[kind]
    return out


def motor_words(motors: Transmission | None) -> str:
    """Which motors turn several joints, where their speeds are seen at the joints; empty where none does.

    >>> motor_words(Transmission([[1.0, 0.0], [1.0, 1.0]]))
    'motor 2 turns with joints 1 and 2'
    """
    if motors is None or not motors.seen_at_joints:
        return ""
    turned = [(i, np.flatnonzero(row) + 1) for i, row in enumerate(motors.matrix, 1)]
    return ", ".join(f"motor {i} turns with joints {_listed(joints)}" for i, joints in turned if joints.size > 1)


def between_words(motors: Transmission | None, rotors: Array) -> str:
    """What a model of joints lacks of motors with rotors (n,), for a provenance; empty where no motor turns several."""
    if not (turned := motor_words(motors)) or motors is None:
        return ""
    added = np.triu(motors.matrix.T @ (rotors[:, None] * motors.matrix), 1)
    pairs = [f"{added[i, j]:.3g} kg m^2 between joints {i + 1} and {j + 1}" for i, j in np.argwhere(added != 0.0)]
    return f"{turned}: {', '.join(pairs)}, and friction where several of its joints move (not in the model)"


def _listed(joints: NDArray[np.intp]) -> str:
    first, last = joints[:-1].tolist(), joints[-1]
    return f"{', '.join(map(str, first))} and {last}"


def _parts(name: str) -> tuple[str, str, int]:
    """Kind, direction and joint (from 0) of the name of a parameter: coulomb+_2 is ("coulomb", "+", 1)."""
    word, _, number = name.rpartition("_")
    kind = word.rstrip("+-")
    return kind, word[len(kind) :], int(number) - 1
