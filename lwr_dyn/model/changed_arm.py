"""An arm with a payload at its flange, or with other masses: Chain -> Chain, before the two roads part."""

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.foundation.errors import OptionError, RatingWarning
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import with_bodies, with_payload


def arm_with_payload(arm: Arm, mass: float, com: ArrayLike = (0.0, 0.0, 0.0), inertia_com: Any = None) -> Arm:
    """The arm with a payload fixed to its flange: mass [kg], com (3,) [m] and inertia in the flange frame.

    Give it to the plant alone and the payload is unknown to the controller; build the controller's dynamics on it
    too and it is known. Raises `OptionError` for a negative mass, `ShapeError` for other shapes; warns with
    `RatingWarning` of a mass over the rated payload.
    """
    rated = arm.ratings.payload
    if rated is not None and mass > rated:
        warnings.warn(
            f"{arm.name}: a payload of {mass:g} kg is over the rated {rated:g} kg", RatingWarning, stacklevel=2
        )
    return arm.with_chain(with_payload(arm.chain, mass, com, inertia_com))


def arm_with_scaled_inertia(arm: Arm, factor: float) -> Arm:
    """The arm with every mass and inertia multiplied by `factor`; raises `OptionError` unless it is above 0."""
    if not (np.isfinite(factor) and factor > 0.0):
        raise OptionError("mass factor", factor, "a number above 0")
    bodies = [
        replace(b, mass=factor * b.mass, inertia_com=factor * b.inertia_com)
        for b in arm.require_dynamics().bodies or ()
    ]
    return replace(arm, chain=with_bodies(arm.chain, bodies))
