"""How an arm is drawn: the cylinders of its file, or sizes for shapes that are derived from its joints."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class DrawnCylinder:
    """A cylinder drawn for a link, in its URDF frame (in a `Paper`: the frame of its DH row): ends, radius [m]."""

    link: str
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float
    colour: str


@dataclass(frozen=True, slots=True)
class Drawing:
    """How the arm is drawn; the dynamics uses none of these numbers."""

    pedestal: float = 0.0
    radius: tuple[float, ...] = ()
    cylinders: tuple[DrawnCylinder, ...] = ()
    """The file's own shapes; if empty, shapes are derived from the joints."""
