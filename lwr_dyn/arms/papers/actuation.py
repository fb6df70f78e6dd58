"""Actuation of the joints: rotors, motor map, gains and friction of a paper, each with its source cells."""

from collections.abc import Iterator

import numpy as np

from lwr_dyn.arms.papers.schema import FRICTION_OF_A_SIDE, SIDES, Paper
from lwr_dyn.foundation.arrays import read_only
from lwr_dyn.model.arm import JointGains
from lwr_dyn.model.chain import Rotor
from lwr_dyn.model.elasticity import JointElasticity
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.model.transmission import Transmission

Part = tuple[str, int, str]
"""Column, row, and how its number is converted."""


def rotor_of(paper: Paper, i: int) -> Rotor | None:
    """The rotor of joint i, from gear ratio and inertia or from the inertia reflected to the joint."""
    ratio, inertia, armature = (paper.cell(f"rotors.{name}", i) for name in ("gear_ratio", "inertia", "armature"))
    if armature is not None:
        return Rotor(1.0, armature, reflected=True)
    return None if ratio is None or inertia is None else Rotor(ratio, inertia)


def transmission_of(paper: Paper) -> Transmission | None:
    """The motor map T_ij = signs_ij ratio_j / stage_j; None if not given."""
    if "transmission.ratio" not in paper.columns:
        return None
    ratio, signs = (paper.columns[f"transmission.{name}"].si() for name in ("ratio", "signs"))
    stage = paper.columns["transmission.stage"].si() if "transmission.stage" in paper.columns else np.ones(paper.n)
    return Transmission(signs * (ratio / stage))


def gains_of(paper: Paper) -> JointGains | None:
    """The controller gains of the source; None if not given."""
    if "gains.kp" not in paper.columns:
        return None
    Kp, Kd = (read_only(paper.columns[f"gains.{name}"].si()) for name in ("kp", "kd"))
    optional = (paper.columns.get(f"gains.{name}") for name in ("ki", "effort"))
    return JointGains(Kp, Kd, *(None if column is None else read_only(column.si()) for column in optional))


def elasticity_of(paper: Paper) -> JointElasticity | None:
    """Springs and dampers of the gears; None if not given."""
    if "elasticity.stiffness" not in paper.columns:
        return None
    stiffness, damping = (paper.columns[f"elasticity.{name}"] for name in ("stiffness", "damping"))
    return JointElasticity(stiffness.si(), damping.si(), f"{stiffness.kind}, {stiffness.where}")


def friction_per_direction(paper: Paper) -> tuple[JointFriction, ...]:
    """Friction of every joint if the paper gives it per direction; empty otherwise."""
    if "friction.positive_coulomb" not in paper.columns:
        return ()
    return tuple(
        JointFriction(
            positive=_direction(paper, "positive", i),
            negative=_direction(paper, "negative", i),
            offset=paper.cell("friction.offset", i) or 0.0,
            covered=paper.cell("friction.covered", i),
        )
        for i in range(paper.n)
    )


def _direction(paper: Paper, side: str, i: int) -> Direction:
    cells = {name: paper.cell(f"friction.{side}_{name}", i) for name in FRICTION_OF_A_SIDE}
    return Direction(cells["coulomb"] or 0.0, cells["viscous"] or 0.0, cells["static"], cells["stribeck_velocity"])


def actuation_parts(paper: Paper) -> Iterator[tuple[str, tuple[Part, ...]]]:
    """Quantity of the arm -> the columns and rows it is computed from."""
    for i, joint in enumerate(paper.joints):
        product = [(f"rotors.{name}", i, "k_r^2 I_m") for name in ("gear_ratio", "inertia")]
        yield f"{joint}.armature", (*product, ("rotors.armature", i, "to SI"))
        for name in ("stiffness", "damping"):
            yield f"{joint}.{name}", ((f"elasticity.{name}", i, "to SI"),)
        for name in ("viscous", "coulomb"):
            yield f"{joint}.{name}", ((f"friction.{name}", i, "to SI"),)
        for name in (*(f"{side}_{x}" for side in SIDES for x in FRICTION_OF_A_SIDE), "offset", "covered"):
            yield f"{joint}.friction.{name}", ((f"friction.{name}", i, "to SI"),)
        for name in ("kp", "ki", "kd", "effort"):
            yield f"{joint}.gains.{name}", ((f"gains.{name}", i, "to SI"),)
        factors = [(f"transmission.{name}", i, "T_ij = signs_ij ratio_j / stage_j") for name in ("ratio", "stage")]
        columns = [("transmission.signs", k, "column of the motor map") for k in range(paper.n)]
        yield f"{joint}.motors", (*factors, *columns)
