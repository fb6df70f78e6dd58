"""How the orientation is led along a path: $ORI_TYPE, $CIRC_TYPE, $IPO_MODE, as far as they are modelled."""

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.krl.running.controller import ControllerState
from lwr_dyn.krl.running.values import EnumValue

TURNED = {
    "$ORI_TYPE": ("JOINT", "the orientation of LIN and CIRC turns about one axis, as with #VAR"),
    "$CIRC_TYPE": ("PATH", "the orientation of CIRC is led as with #BASE"),
    "$IPO_MODE": ("TCP", "a fixed tool is not modelled: as with #BASE"),
}
"""Values of system variables that are not modelled, and what is done instead."""


def led_pose(c: ControllerState, start: Array, end: Array) -> Array:
    """The pose (4, 4) [m] at the end of a path from `start`; $ORI_TYPE #CONSTANT keeps the orientation."""
    values = {name: c.variables[name].value for name in TURNED if name in c.variables}
    for name, (value, text) in TURNED.items():
        if values.get(name) == EnumValue(value):
            c.assumptions.note(f"{name} #{value}", "", text)
    if values.get("$ORI_TYPE") != EnumValue("CONSTANT"):
        return end
    kept = end.copy()
    kept[:3, :3] = start[:3, :3]
    return kept
