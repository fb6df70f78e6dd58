"""What the report shows, as plain values: made from a fit, or by hand."""

from dataclasses import dataclass

from lwr_dyn.foundation.arrays import Array, freeze_arrays
from lwr_dyn.foundation.tables import Table
from lwr_dyn.identification.report.parameter_rows import ShownParameter
from lwr_dyn.identification.report.torque_charts import ShownRecording
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.dh import JointKind
from lwr_dyn.model.friction import JointFriction

_UNITS = {JointKind.REVOLUTE: ("rad/s", "N m"), JointKind.PRISMATIC: ("m/s", "N")}

Section = tuple[str, tuple[Table, ...], tuple[str, ...]]
"""Heading, tables and notes."""


@dataclass(frozen=True, slots=True, eq=False)
class ShownFit:
    """A fit as the page shows it.

    Parameters
    ----------
    arm : Arm
        Whose shapes are drawn.
    title, command : str
        Headline; what made the page, as "lwr-dyn identify motion".
    said : tuple of str
        Sentences below the headline.
    figures : tuple of (str, str)
        Name and value of each head figure.
    recordings : tuple of ShownRecording
    noise : (n,) array
        Standard deviation of the torques [N m or N].
    before, after : (n, 10) array
        Inertial parameters of the links in the frames of the source: the table's, the result's.
    sigma : (n, 10) array or None
        Standard errors of `after`.
    speed, friction_torque : (k, n) array
        Of the friction maps; NaN where a torque is not used.
    friction, friction_before : tuple of n JointFriction or None
    friction_at : tuple of n str
        Whose friction it is: names of joints, or of motors.
    parameters : tuple of ShownParameter
    caption : str
        Of the table of parameters.
    notes : tuple of str
        Below that table.
    more : tuple of Section
        Cards at the end: validation, slips, logs.
    """

    arm: Arm
    title: str
    command: str
    said: tuple[str, ...]
    figures: tuple[tuple[str, str], ...]
    recordings: tuple[ShownRecording, ...]
    noise: Array
    before: Array
    after: Array
    sigma: Array | None
    speed: Array
    friction_torque: Array
    friction: tuple[JointFriction | None, ...]
    friction_before: tuple[JointFriction | None, ...]
    friction_at: tuple[str, ...]
    parameters: tuple[ShownParameter, ...]
    caption: str
    notes: tuple[str, ...] = ()
    more: tuple[Section, ...] = ()

    def __post_init__(self) -> None:
        freeze_arrays(self, "noise", "before", "after", "speed", "friction_torque")
        if self.sigma is not None:
            freeze_arrays(self, "sigma")

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self.arm.joint_names

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the moved links."""
        return tuple(link.link for link in self.arm.chain.links)

    @property
    def units(self) -> tuple[tuple[str, str], ...]:
        """Of speed and torque, per joint."""
        return tuple(_UNITS[link.kind] for link in self.arm.chain.links)
