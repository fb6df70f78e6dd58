"""A cell: what stands around a program: the robot, inputs, states, variables of a PLC, tools, stubs, its answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from lwr_dyn.krl.language import expressions as e
from lwr_dyn.krl.running.values import Value


@dataclass(frozen=True, slots=True, eq=False)
class Stub:
    """A routine that is not there: what its call returns (None: nothing) and puts into its arguments, from 1."""

    returns: Value | None = None
    out: Mapping[int, Value] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Reply:
    """What a PLC does: `after` [s] from the time at which `when` becomes true, or from the start, it sets values."""

    when: e.Expression | None
    after: float
    values: Mapping[str, Value]


@dataclass(frozen=True, slots=True, eq=False)
class RobotCell:
    """The surroundings of a program; an empty one gives nothing."""

    file: str = ""
    robot: str | None = None
    home_deg: tuple[float, ...] | None = None
    """Where the arm stands before the first motion, and XHOME."""
    called_at_deg: tuple[float, ...] | None = None
    """Where the arm stands when the routine that is run is called from another; None: it is started by itself."""
    ignore_turn: bool = False
    """Whether points are reached by the nearest solution with their Status, as of an assumed robot."""
    values: Mapping[str, Value] = field(default_factory=dict)
    """Inputs, states, variables, tools and bases: `$IN[3]`, `$T1`, `PART`, `TOOL_DATA[1]`, in capitals."""
    other_inputs: bool | None = None
    """The value of an input that is not listed; None: a program that asks for it stops."""
    stubs: Mapping[str, Stub] = field(default_factory=dict)
    """By name in capitals."""
    other_stubs: bool = False
    """Whether every other function that is not there returns FALSE, 0 or an empty structure."""
    arguments: Mapping[str, Value] = field(default_factory=dict)
    """Of the routine that is run, by the names of its parameters in capitals."""
    replies: tuple[Reply, ...] = ()
    submits: tuple[str, ...] = ()
    """Paths of submit programs (.sub) that run beside."""
    unmet_wait: float | None = None
    """[s] After which a WAIT FOR that nothing fulfils counts as fulfilled; None: the program stops there."""
