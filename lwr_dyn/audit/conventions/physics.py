"""What a body can be: positive definite, triangle inequality, a radius of gyration that its link's length allows.

`lwr_dyn.model.feasibility` and `lwr_dyn.checks.feasibility` ask this of one arm; here of every option of a link at
once, with the rounding of its printed cells forgiven.
"""

from __future__ import annotations

import numpy as np

from lwr_dyn.arrays import Array
from lwr_dyn.audit.conventions.choices import LinkOptions
from lwr_dyn.model.spatial import principal_moments

FORGIVEN = 4.0
"""Standard deviations of rounding by which a moment may miss its bound."""


def shortfalls(options: LinkOptions, reach: Array) -> Array:
    """How far each option is from a body, (O, 3), each not above 0 for one that can be.

    Smallest principal moment below 0, I3 - I1 - I2, and m (k^2 - reach^2) for the largest radius of gyration k; all in
    units of the largest printed entry, less what rounding may do.
    """
    moments = principal_moments(options.inertia_com)
    slack = FORGIVEN * options.deviation_com
    low = -moments[:, 0] - slack
    triangle = moments[:, 2] - moments[:, 0] - moments[:, 1] - 2 * slack
    gyration = moments[:, 2] - options.mass * reach**2 - slack
    found: Array = np.stack([low, triangle, gyration], axis=-1) / max(options.scale, 1e-300)
    return found


def fullness(options: LinkOptions) -> Array:
    """log det of the second moments of mass about the com, (O,): the wrong sign or point makes flat or thin bodies.

    Sigma = tr(I)/2 E - I; larger is more plausible, -inf where no body is. The determinant is the part of that of the
    pseudo-inertia which a sign can change (Wensing, Kim, Slotine, "Linear matrix inequalities for physically consistent
    inertial parameter identification", 2018, eq. 16).
    """
    trace = np.trace(options.inertia_com, axis1=-2, axis2=-1)
    second = trace[:, None] / 2 - principal_moments(options.inertia_com)
    good = (second > 0.0).all(axis=-1)
    found: Array = np.where(good, np.log(np.where(good[:, None], second, 1.0)).sum(axis=-1), -np.inf)
    return found
