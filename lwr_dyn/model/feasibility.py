"""Physical feasibility: can a distribution of positive mass have this inertia?"""

import numpy as np

from lwr_dyn.model.chain import Body, Chain
from lwr_dyn.model.spatial import principal_moments

ROUNDING = 1e-12
"""Allowed rounding error relative to the largest principal moment; a point mass and a thin rod are limit cases."""


def is_physical(body: Body) -> bool:
    """Whether a distribution of mass can have this body's inertia.

    The mass is not negative, the tensor about the centre of mass is symmetric, its principal moments I1 <= I2 <= I3 are
    not negative, and I1 + I2 >= I3 (the second moments of mass are not negative). Zero mass needs zero inertia. A body
    of which a part is unknown is not judged.

    >>> is_physical(Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.0])))
    True
    >>> is_physical(Body(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.1])))
    False
    """
    tensor = body.inertia_com
    if body.unknown:
        return True
    if not (np.isfinite(body.mass) and np.isfinite(body.com).all() and np.isfinite(tensor).all()):
        return False
    if body.mass <= 0.0:
        return bool(body.mass == 0.0 and (tensor == 0.0).all())
    slack = ROUNDING * float(np.abs(tensor).max())
    if np.abs(tensor - tensor.T).max() > slack:
        return False
    smallest, middle, largest = principal_moments(tensor)
    return bool(smallest >= -slack and smallest + middle >= largest - slack)


def unphysical_links(chain: Chain) -> tuple[str, ...]:
    """Names of the links with an infeasible inertia, from the base outward; links without a body are skipped."""
    return tuple(link.link for link in chain.links if link.body is not None and not is_physical(link.body))
