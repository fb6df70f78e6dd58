"""Units of data files and their factors to SI; the only place where degrees and millimetres are converted."""

import math

UNITS: dict[str, tuple[str, float]] = {
    "rad": ("angle", 1.0),
    "deg": ("angle", math.pi / 180.0),
    "m": ("length", 1.0),
    "mm": ("length", 1e-3),
    "m^3": ("volume", 1.0),
    "kg": ("mass", 1.0),
    "g": ("mass", 1e-3),
    "kg m^2": ("inertia", 1.0),
    "kg mm^2": ("inertia", 1e-6),
    "kg cm^2": ("inertia", 1e-4),
    "N m": ("torque", 1.0),
    "N mm": ("torque", 1e-3),
    "N": ("force", 1.0),
    "rad/s": ("angular velocity", 1.0),
    "deg/s": ("angular velocity", math.pi / 180.0),
    "rpm": ("angular velocity", math.pi / 30.0),
    "m/s": ("velocity", 1.0),
    "mm/s": ("velocity", 1e-3),
    "m/s^2": ("acceleration", 1.0),
    "N m s/rad": ("angular damping", 1.0),
    "N m/rad": ("angular stiffness", 1.0),
    "N m/(rad s)": ("angular integral gain", 1.0),
    "N s/m": ("damping", 1.0),
    "N/m": ("stiffness", 1.0),
    "N/(m s)": ("integral gain", 1.0),
    "1": ("number", 1.0),
}
"""Unit -> (quantity, factor to SI)."""


def to_si(value: float, unit: str) -> float:
    """A number in its printed unit as SI; degrees go through `math.radians`, so 90 deg is exactly pi/2.

    >>> to_si(90.0, "deg") == math.pi / 2
    True
    """
    if unit.startswith("deg"):
        return math.radians(value)
    return value * UNITS[unit][1]


def units_of(*quantities: str) -> tuple[str, ...]:
    """The units in which quantities may be printed.

    >>> units_of("mass")
    ('kg', 'g')
    """
    return tuple(unit for unit, (quantity, _) in UNITS.items() if quantity in quantities)
