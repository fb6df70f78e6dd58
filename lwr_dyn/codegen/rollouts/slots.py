"""The numbers of one run by name: rows of lanes in a kernel's block."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

STATE = ("q", "dq", "memory", "encoder", "commands")
"""State, memory of the law, of the encoder, and commands on their way: the body replaces them."""
FIGURES = (
    "tip_squares", "tip_worst", "tip_square", "position_squares", "position_worst", "torque_worst", "command_worst",
    "torque_squares", "speed_worst", "saturated", "margin", "violation", "angle_worst", "trouble",
)  # fmt: skip
"""Sums, largest values and counts over the samples, which the body replaces; `margin` and `violation` are smallest.
`tip_square` is that of the last sample; `trouble` turns NaN where a state or torque is not finite."""
WHOLE = ("command", "applied", "friction_torque", "friction_work")
"""What a log of every sample needs beside the state at it: torques there, and the work of friction until the next."""
OF_JOINTS = (
    "q", "dq", "position_squares", "position_worst", "torque_worst", "command_worst", "torque_squares", "speed_worst",
    "saturated", "margin", "command", "applied", "friction_torque", "armature", "effort", "rating", "lower", "upper",
)  # fmt: skip
"""Those with a number a joint."""
CONSTANTS = (
    "plant", "armature", "effort", "rating", "lower", "upper", "friction", "model", "resolution", "noise", "delay",
    "tolerance", "last", "nothing",
)  # fmt: skip
"""Of a run: kept parameters of plant and model, limits, friction, encoder, delay, tip error^2, last sample.

Commands are cut at `effort`, and judged by `rating`, which is the same where torques saturate. `nothing` is a 0 that no
compiler knows: 0 x is NaN where x is not finite."""
SAMPLE = ("sample", "reference", "tip", "chance")
"""Of a sample: its number, q_ref, dq_ref, ddq_ref, the tip's place, uniform numbers or noise."""
GAIN = "gain "
"""Stands before the name of a parameter of the law."""


@dataclass(frozen=True, slots=True)
class Slots:
    """Names with their widths, in the order in which they stand."""

    widths: Mapping[str, int]

    def first(self, name: str) -> int:
        """The row at which a name begins."""
        names = list(self.widths)
        return sum(self.widths[x] for x in names[: names.index(name)])

    def places(self, name: str) -> range:
        """The rows of a name."""
        first = self.first(name)
        return range(first, first + self.widths[name])

    def all_places(self, names: Iterable[str]) -> list[int]:
        """The rows of several names."""
        return [place for name in names for place in self.places(name)]

    @property
    def size(self) -> int:
        """Rows in all."""
        return sum(self.widths.values())
