"""Masses and centres as far as they can be believed, so that one fault raises no alarm at other links."""

from functools import lru_cache

from lwr_dyn.checks.urdf.document import UrdfDocument
from lwr_dyn.checks.urdf.judgement import judgements
from lwr_dyn.checks.urdf.mass_slips import SHAPES, mass_slip
from lwr_dyn.foundation.arrays import Array

FAR = 0.3
"""[diameters] A centre further outside the hull than this is taken at the hull's centroid."""
EMPTY, SOLID = 5.0, 12000.0
"""[kg/m^3] A mass that makes the density lie beyond these is taken at the file's usual density."""


@lru_cache(maxsize=4)
def believed_masses(document: UrdfDocument) -> dict[str, tuple[float, Array]]:
    """Mass [kg] and centre in the link frame, (3,) [m], by link; of bodies as usual where the written ones are odd."""
    out = {}
    for link in document.links:
        inertial = link.inertial
        if inertial is not None and inertial.com is not None and inertial.mass and inertial.mass > 0.0:
            out[link.name] = (inertial.mass, inertial.com)
    for found in judgements(document):
        name = found.body.link.name
        if name in misscaled(document):
            continue
        mass, com = out[name]
        usual = EMPTY < found.density < SOLID
        inside = found.outside <= FAR
        out[name] = (mass if usual else found.usual * found.hull.volume, com if inside else found.hull.centroid)
    return out


@lru_cache(maxsize=4)
def misscaled(document: UrdfDocument) -> frozenset[str]:
    """The links whose shapes are in another unit."""
    slips = ((found.body.link.name, mass_slip(found)) for found in judgements(document))
    return frozenset(name for name, slip in slips if slip is not None and slip.about == SHAPES)
