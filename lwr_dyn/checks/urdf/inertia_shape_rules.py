"""Rules of mass, centre of mass and inertia against the shapes of the link, and masses as far as they can be believed.

An odd density is explained by the unit of the mass or of the shapes: a mass that is f times too large makes the density
f times too large and the spread S f times too small; shapes that are k times too large make the density k^3 times too
small and the spread k^2 times too small: so the two differ. Odd masses and centres are replaced by usual ones, so that
one fault raises no alarm at other links.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lwr_dyn.checks.urdf.document import TURNING, FindingSeverity, Sureness, UrdfDocument, UrdfFinding, vector_text
from lwr_dyn.checks.urdf.elements import JointElement
from lwr_dyn.checks.urdf.judgement import NAMED, NOTED, Judgement, judgements
from lwr_dyn.checks.urdf.undoings import Undoing, off_centre, outside, spread_ratios
from lwr_dyn.checks.urdf.xml_tree import Place
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.number_text import number_text

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
    unit, given = (name, name) if name in (_SMALL, _LARGE, _TWICE) else (f"in {name}", f"given in {name}")
    if about == MASS:
        instead = f'<mass value="{number_text(found.point.mass * factor)}"/>'
        return MassSlip(MASS, f"masses {unit}", f"the mass looks {given}", instead)
    shape, instead = found.body.link.shapes[0], "shapes in metres"
    if shape.kind == "mesh" and shape.scale is not None:
        instead = f'<mesh filename="{shape.mesh}" scale="{vector_text(shape.scale * factor)}"/>'
    return MassSlip(SHAPES, f"shapes {unit}", f"the shapes look {given}", instead)


def misfit(found: Judgement) -> float:
    """Logarithm of the factor by which the mass is too large for volume and inertia alike; 0 where the two disagree.

    Both are taken against the file's medians.
    """
    density = float(np.log(found.density / found.usual))
    spread = found.usual_spread - found.spread
    return (density + spread) / 2.0 if min(density, spread) > _BOTH else 0.0


FAR = 0.3
"""[diameters] A centre further outside the hull than this is taken at the hull's centroid."""
EMPTY_BELIEVED, SOLID_BELIEVED = 5.0, 12000.0
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
        usual = EMPTY_BELIEVED < found.density < SOLID_BELIEVED
        inside = found.outside <= FAR
        out[name] = (mass if usual else found.usual * found.hull.volume, com if inside else found.hull.centroid)
    return out


_GRAVITY, _ARM = 9.81, 0.05
"""[m/s^2], [m]."""


def largest_weight(
    document: UrdfDocument, joint: JointElement, poses: dict[str, Array], upright: bool = False
) -> tuple[float, float]:
    """The weight of all links behind a joint in any mounting: its largest moment [N m], and that at 5 cm.

    With `upright`, the first as the file stands, z of its root upward. For sliding joints both are the weight [N].
    """
    masses, centres = _behind(document, joint.child, poses)
    length = 0.0 if joint.axis is None else float(np.linalg.norm(joint.axis))
    weight = sum(masses) * _GRAVITY
    if joint.axis is None or not length > 0.0 or not weight > 0.0 or joint.child not in poses:
        return 0.0, 0.0
    if joint.type not in TURNING:
        return (weight, weight) if joint.type == "prismatic" else (0.0, 0.0)
    frame = poses[joint.child]
    centre = np.einsum("k,kpi->pi", np.array(masses), np.array(centres)) / sum(masses)
    arm = centre - frame[:, :3, 3]
    axis = frame[:, :3, :3] @ (joint.axis / length)
    across = np.cross(axis, arm)
    moments = np.abs(across[:, 2]) if upright else np.linalg.norm(across, axis=1)
    return weight * float(moments.max()), weight * _ARM


def _behind(document: UrdfDocument, child: str, poses: dict[str, Array]) -> tuple[list[float], list[Array]]:
    """Masses and centres (12, 3) of the links behind a joint, in the root's frame."""
    believed = believed_masses(document)
    names = [name for name in document.carried_by(child) if name in poses and name in believed]
    centres = [poses[name][:, :3, :3] @ believed[name][1] + poses[name][:, :3, 3] for name in names]
    return [believed[name][0] for name in names], centres


@lru_cache(maxsize=4)
def misscaled(document: UrdfDocument) -> frozenset[str]:
    """The links whose shapes are in another unit."""
    slips = ((found.body.link.name, mass_slip(found)) for found in judgements(document))
    return frozenset(name for name, slip in slips if slip is not None and slip.about == SHAPES)


WIDEST, WIDE = 18.0, 4.5
"""Largest eigenvalue of H^-1 S that is impossible, and that no good arm but UR3 and UR3e (5.1) reaches."""
NARROWEST, NARROW, NARROW_MIDDLE = 0.02, 0.11, 0.33
"""Largest eigenvalue below which nothing is left of the body; smallest and middle one below those of good arms."""
BOUND_ERROR, BOUND_WARNING = 2.0, 1.35
OUTSIDE_ERROR, OUTSIDE_WARNING = 0.3, 0.02
OFF = 2.0
EMPTY, LIGHT, HEAVY, SOLID = 5.0, 60.0, 5000.0, 12000.0
"""[kg/m^3] Impossible, odd; odd, impossible. Good arms: 250 to 3 030, a cover 13, a display 68."""
STEEL, SMALL_PART = 8000.0, 0.2
"""[kg/m^3] Of a small part [kg] of solid steel, such as the cross of a universal joint."""
UNUSUAL = 6.0
SPARSE, DENSE = 100.0, 3000.0
"""[kg/m^3] Between these a density unlike the others of the file is worth a note only."""
MISFIT, MISFIT_WARNING, POUND, _NEAR_POUND = 0.45, 0.55, 0.45359237, 0.3


def spread(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The mass is spread wider or narrower than the shape of the link allows.

    S = (tr I / 2 E - I) / m is the covariance of the link's mass, H that of the solid convex hull of its shapes. The
    eigenvalues of H^-1 S are 1 for a full body; on 163 moving links of 25 good arms they lie between 0.15 and 2.8 (UR3,
    UR3e to 5.1), on 123 of 13 other makers that nothing was chosen by between 0.11 and 2.7. Error: the largest above 18
    or below 0.02. Warning: the largest above 4.5, the smallest below 0.11, or the middle one below 0.33. Mend the
    tensor; where one slip explains it, the text to write is given.
    """
    for found in judgements(document):
        severity = _spread_severity(found)
        if severity and not _shape_is_off(found):
            low, middle, high = found.ratios
            what = f"its inertia is that of {_times(low, high)}"
            why = f"eigenvalues of H^-1 S are {low:.3g}, {middle:.3g}, {high:.3g}; 1 for a full body of its shape"
            yield _of_tensor(found, what, why, severity)


def _times(low: float, high: float) -> str:
    if low < -0.001:
        return "no body: its spread in one direction is below 0"
    wide = high > 1.0 / max(low, 1e-9)
    factor = (high if wide else 1.0 / max(low, 1e-6)) ** 0.5
    return f"a body about {factor:.2g} times as {'wide' if wide else 'narrow'} as its shape in one direction"


def _spread_severity(found: Judgement) -> FindingSeverity | None:
    low, middle, high = found.ratios
    if high > WIDE and fits_welded(found):
        return "note"
    if high > WIDEST or high < NARROWEST:
        return "error"
    return "warning" if high > WIDE or low < NARROW or middle < NARROW_MIDDLE else None


def bound(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The mass varies more about its centre than any mass inside the hull of the shapes can.

    Along every direction the variance is at most (max - c)(c - min), which half the mass at either end of the body
    reaches. Good arms stay below 1 of that bound (two links of 147: 1.1 and 1.3), 123 links
    of other makers below 0.83. Error above 2, warning above 1.35.
    """
    for found in judgements(document):
        quiet = _spread_severity(found) is None and not _is_off_centre(found)  # else said there
        if found.bound > BOUND_WARNING and quiet and not _shape_is_off(found):
            what = f"its inertia needs {found.bound:.2g} times the variance that its shape allows"
            why = "along one direction, with half the mass at either end of the body"
            severity: FindingSeverity = "error" if found.bound > BOUND_ERROR else "warning"
            yield _of_tensor(found, what, why, "note" if fits_welded(found) else severity)


def slip(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """A tensor in the usual range that fits the shape of the link much better with one slip undone.

    Tried are: two moments exchanged, moments permuted, the six numbers by rows, products permuted, of the opposite sign
    or of the mirrored side, powers of ten, rpy in degrees or a quarter turn off, a tensor about the link frame. The
    distance is the length of the three logarithms of the eigenvalues of H^-1 S. An undoing that shortens it by 0.8 is a
    warning (rpy 1.0, moments permuted 1.1, signs of products 1.55), by 0.2 less a note. On 145 good links the best
    exchange of moments shortens it by 0.55, signs of products by 1.5; on 123 of other makers by 0.76 and 0.78. The text
    to write is given.
    """
    for found in judgements(document):
        quiet = _spread_severity(found) is None and found.bound <= BOUND_WARNING
        named = found.tensor_slip
        if named and found.cut > NOTED and quiet and not _shape_is_off(found):
            severity: FindingSeverity = "warning" if found.cut > NAMED else "note"
            sure: Sureness = "likely" if found.cut > NAMED else "possible"
            yield UrdfFinding(
                named.says, _figures(found.cut, named), found.inertial.tensor_place, found.body.link.subject,
                named.instead, sure, named.cause, severity, found.body.link.name,
            )  # fmt: skip


def _figures(cut: float, slip: Undoing) -> str:
    text = f"the logarithms of H^-1 S come nearer to those of a full body by {cut + slip.prior:.2g}"
    return f"{text}; {slip.prior:.2g} of it is not counted for this slip" if slip.prior else text


def _of_tensor(found: Judgement, what: str, why: str, severity: FindingSeverity) -> UrdfFinding:
    """A finding of the tensor; led by the slip that explains it, if one does."""
    named: MassSlip | Undoing | None = mass_slip(found) or (found.tensor_slip if found.cut > NAMED else None)
    return _named(found, what, why, severity, named, found.inertial.tensor_place)


def _named(
    found: Judgement, what: str, why: str, severity: FindingSeverity, slip: MassSlip | Undoing | None, place: Place
) -> UrdfFinding:
    """A finding of a link, led by the slip that explains it."""
    if slip is not None:
        what, why = slip.says, f"{what}: {why}"
    instead, cause = (slip.instead, slip.cause) if slip is not None else ("", "")
    link = found.body.link
    return UrdfFinding(what, why, place, link.subject, instead, "likely", cause, severity, link.name)


def density(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The mass over the volume of the hull of the shapes is none that an arm has.

    Good arms: 250 to 3 030 kg/m^3 (covers 13, a display 68), those of other makers 166 to 3 240 (a bellows 24). Error
    below 5 and above 12 000, warning below 60, above 5 000, and for 6 times or a sixth of the median over the file's
    links above 50 g (a note between 100 and 3 000). Parts below 0.2 kg may be of solid steel: up to 8 000. A factor of
    1000 in the mass, or of 1000^3 in the volume (a mesh in mm), is named. Where most of the body is drawn at links that
    are fixed to it, which have less than half its mass, and mass, centre and tensor fit all of it: a note, as in the
    rules of centre and spread.
    """
    for found in judgements(document):
        if not _density_is_odd(found):
            continue
        rho = found.density
        impossible = rho < EMPTY or rho > SOLID
        noted = SPARSE < rho < DENSE or fits_welded(found)
        severity: FindingSeverity = "note" if noted else "error" if impossible else "warning"
        named = mass_slip(found)
        what = f"mass over volume is {rho:.3g} kg/m^3"
        why = f"mass {found.point.mass:.4g} kg, hull {found.hull.volume:.3g} m^3; the file's usual is {found.usual:.0f}"
        place = found.inertial.mass_place
        if named is not None and named.about == SHAPES:
            place = found.body.link.shapes[0].geometry_place
        yield _named(found, what, why, severity, named, place)


def mass_fit(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The mass is too large for the volume and for the inertia alike, against the other links of the file.

    A mass that is f times too large makes the density f times too large and the spread f times too small. The mean of
    the two logarithms, each above 0.2, reaches 0.53 on 287 good links, 0.47 on 123 others. A note above 0.45, a warning
    above 0.55; a mass in lb adds 0.79.
    """
    for found in judgements(document):
        factor = misfit(found)
        if factor <= MISFIT or _spread_severity(found) or _density_is_odd(found) or found.point.mass <= 0.05:
            continue
        in_pounds = abs(factor - np.log(1.0 / POUND)) < _NEAR_POUND
        what = "the mass looks given in lb" if in_pounds else f"the mass looks {np.exp(factor):.2g} times too large"
        why = f"{found.density / found.usual:.2g} times the file's usual density; "
        why += f"{np.exp(found.spread - found.usual_spread):.2g} times its usual spread of the mass"
        instead = f'<mass value="{number_text(found.point.mass * POUND)}"/>' if in_pounds else ""
        link = found.body.link
        yield UrdfFinding(
            what, why, found.inertial.mass_place, link.subject, instead, "possible",
            "masses in lb" if in_pounds else "", "warning" if factor > MISFIT_WARNING else "note", link.name,
        )  # fmt: skip


def fits_welded(found: Judgement) -> bool:
    """Whether mass, centre and tensor fit the body that is drawn at the links fixed to it."""
    hull, point = found.welded, found.point
    if hull is None or not LIGHT < point.mass / hull.volume < HEAVY or outside(point.com, hull) > 0.0:
        return False
    return bool(spread_ratios(point.inertia, point.mass, hull)[2] < WIDE)


def _density_is_odd(found: Judgement) -> bool:
    rho, relative = found.density, found.density / found.usual
    if found.point.mass < SMALL_PART and HEAVY < rho <= STEEL:
        return False
    return rho < LIGHT or rho > HEAVY or (found.point.mass > 0.05 and not 1.0 / UNUSUAL < relative < UNUSUAL)


def _shape_is_off(found: Judgement) -> bool:
    slip = mass_slip(found)
    return slip is not None and slip.about == SHAPES


def centre(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """The centre of mass lies outside the hull of the shapes, or far from its middle.

    On good arms it lies 0.01 to 0.25 diameters inside, and 0.03 to 1.7 standard deviations of the hull from its
    centroid; on those of other makers 0.05 to 0.29, and 0 to 1.4. Error more than 0.3 diameters outside; warning more
    than 0.02, or more than 2 standard deviations off.
    """
    for found in judgements(document):
        if not _is_off_centre(found) or _shape_is_off(found):
            continue
        severity: FindingSeverity = "error" if found.outside > OUTSIDE_ERROR else "warning"
        severity = "note" if fits_welded(found) else severity
        lies = "outside the hull of its shapes" if found.outside > 0.0 else "far from the middle of its shapes"
        what = f"the centre of mass lies {lies}"
        why = f"{max(found.outside, 0.0):.2g} diameters outside, {found.off:.2g} standard deviations off the middle"
        yield _named(found, what, why, severity, found.centre_slip, found.inertial.origin.place)


def centre_slip(document: UrdfDocument) -> Iterable[UrdfFinding]:
    """A centre of mass inside the shapes that lies much nearer to their middle with one slip undone.

    Tried are the sign of each coordinate, their order, mm, the parent's and the base frame. The distance is in standard
    deviations of the hull; on 147 good links a sign brings at most 0.34, another order 0.71. Warning above 0.55 (order
    0.85), with the text to write.
    """
    for found in judgements(document):
        named = found.centre_slip
        if named is not None and not _is_off_centre(found) and not _shape_is_off(found):
            nearer = off_centre(named.com, found.hull)
            why = f"{found.off:.2g} standard deviations off the middle of its shapes, {nearer:.2g} without it"
            link = found.body.link
            yield UrdfFinding(
                named.says, why, found.inertial.origin.place, link.subject, named.instead, "possible", named.cause,
                "warning", link.name,
            )  # fmt: skip


def _is_off_centre(found: Judgement) -> bool:
    return found.outside > OUTSIDE_WARNING or found.off > OFF
