"""What explains an odd density: the unit of the mass, or the unit of the shapes.

A mass that is f times too large makes the density f times too large and the spread S f times too small; shapes that
are k times too large make the density k^3 times too small and the spread k^2 times too small: so the two differ.
"""

from dataclasses import dataclass

import numpy as np

from lwr_dyn.checks.urdf.finding import number_text, vector_text
from lwr_dyn.checks.urdf.judgement import Judgement

MASS, SHAPES = "mass", "shapes"
_SMALL, _LARGE = "10 times too small", "10 times too large"
_MASS_UNITS = (("g", 1e-3), ("lb", 0.45359237), (_SMALL, 10.0), (_LARGE, 0.1), ("t", 1000.0))
_TWICE = "1000 times too small"
"""Of shapes whose scale turns mm into m a second time."""
_LENGTH_UNITS = (("mm", 1e-3), (_TWICE, 1e3), ("cm", 1e-2), ("inches", 0.0254))
_FIT = 1.4
"""Largest length of the remaining logarithms of density and spread."""
_GAIN = 1.2
_BOTH = 0.2
"""Least logarithm that volume and inertia must each tell before they are believed."""


@dataclass(frozen=True, slots=True)
class MassSlip:
    """A slip in the unit of the mass or of the shapes: which, its name in the file, the clause, what to write."""

    about: str
    cause: str
    says: str
    instead: str


def mass_slip(found: Judgement) -> MassSlip | None:
    """The unit of mass or shapes that explains density and spread together; None where none does."""
    density = float(np.log(found.density / found.usual))
    spread = found.spread
    if abs(density) < _GAIN:
        return None
    tried = [(np.hypot(density + np.log(f), spread - np.log(f)), MASS, name, f) for name, f in _MASS_UNITS]
    tried += [
        (np.hypot(density - 3.0 * np.log(k), spread - 2.0 * np.log(k)), SHAPES, name, k) for name, k in _LENGTH_UNITS
    ]
    rest, about, name, factor = min(tried)
    if rest > _FIT or float(np.hypot(density, spread)) - rest < _GAIN:
        return None
    return _of_mass(found, name, factor) if about == MASS else _of_shapes(found, name, factor)


def _of_mass(found: Judgement, name: str, factor: float) -> MassSlip:
    tenfold = name in (_SMALL, _LARGE)
    cause, says = (f"masses {name}", name) if tenfold else (f"masses in {name}", f"given in {name}")
    return MassSlip(MASS, cause, f"the mass looks {says}", f'<mass value="{number_text(found.point.mass * factor)}"/>')


def _of_shapes(found: Judgement, name: str, factor: float) -> MassSlip:
    shape = found.body.link.shapes[0]
    instead = "shapes in metres"
    if shape.kind == "mesh" and shape.scale is not None:
        instead = f'<mesh filename="{shape.mesh}" scale="{vector_text(shape.scale * factor)}"/>'
    cause, says = (f"shapes {name}", name) if name == _TWICE else (f"shapes in {name}", f"given in {name}")
    return MassSlip(SHAPES, cause, f"the shapes look {says}", instead)


def misfit(found: Judgement) -> float:
    """Logarithm of the factor by which the mass is too large for volume and inertia alike; 0 where the two disagree.

    Both are taken against the file's medians.
    """
    density = float(np.log(found.density / found.usual))
    spread = found.usual_spread - found.spread
    return (density + spread) / 2.0 if min(density, spread) > _BOTH else 0.0
