"""References for the joints by name, as `simulate --task` takes them."""

from collections.abc import Callable
from typing import Annotated, Any

from numpy.typing import ArrayLike

from lwr_dyn.foundation.arrays import arm_argument
from lwr_dyn.foundation.registry import Option, Quantity, Registry, Row, check_options
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference

REFERENCES: Registry[Callable[..., Reference]] = Registry(
    "reference",
    {
        "ist": Row("lwr_dyn.trajectory.references.ist:ist_reference", "the letters IST of the LWR 4+ paper"),
        "ist-clear": Row(
            "lwr_dyn.trajectory.references.ist:ist_clear_reference",
            "IST where every joint of the LWR 4+ keeps 50 deg to its limits",
        ),
        "ist-clear-twice": Row(
            "lwr_dyn.trajectory.references.ist:ist_clear_twice", "ist-clear, back to its start, and again"
        ),
        "point-to-point": Row("lwr_dyn.trajectory.references.joint_moves:one_move", "a quintic from rest to rest"),
        "move": Row(
            "lwr_dyn.trajectory.references.chosen_move:chosen_move", "a move that is chosen inside the arm's own limits"
        ),
        "lspb": Row("lwr_dyn.trajectory.references.joint_moves:lspb_move", "a move with a trapezoid of speed"),
        "line": Row("lwr_dyn.trajectory.cartesian.tasks:line_reference", "a straight line of the tip, of any arm"),
        "waypoints": Row(
            "lwr_dyn.trajectory.cartesian.tasks:waypoints_reference", "waypoints in a file, of the tip or the joints"
        ),
        "least-time": Row("lwr_dyn.design.time_optimal:least_time_reference", "paths in the least time", "design"),
        "csv": Row(
            "lwr_dyn.trajectory.references.recorded_motion:csv_reference",
            "a motion from a CSV: joint positions or poses",
        ),
        "step": Row(
            "lwr_dyn.trajectory.references.excitations:step_reference", "a step of one joint, or of each in turn"
        ),
        "chirp": Row(
            "lwr_dyn.trajectory.references.excitations:chirp_reference", "a chirp of one joint, or of each in turn"
        ),
        "hold": Row("lwr_dyn.trajectory.references.joint_moves:hold", "standing still"),
    },
)
"""Each row makes a reference: `factory(arm, **options)`."""

Duration = Annotated[float, Option(float, "Duration, s.")]

Start = Annotated[ArrayLike, Option(Quantity.JOINT_POSITIONS, "Where the joints start (m for sliding).", "from-deg")]

StartIfGiven = Annotated[
    ArrayLike | None, Option(Quantity.JOINT_POSITIONS, "Where the joints start (m for sliding).", "from-deg")
]

End = Annotated[ArrayLike, Option(Quantity.JOINT_POSITIONS, "Where the joints end (m for sliding).", "to-deg")]


def reference(name: str | Callable[[Any], Any], arm: Arm, **options: Any) -> Reference:
    """A reference for the joints from a function q(t), or by name: "ist", "point-to-point", "hold", or an added one.

    Options of a name are those of its factory in `lwr_dyn.trajectory.references`, such as q [rad or m] or duration [s]
    of "hold". A function takes the time [s] and gives (n,) [rad or m]; its options are `duration` [s], and `dq`, `ddq`
    as functions where they are known, `limits=False` to leave the limits (see `function_reference`). Raises
    `UnknownNameError`, `OptionError`, and the factory's own (`PathLimitError`: the path leaves the limits).

    >>> import numpy as np
    >>> import lwr_dyn
    >>> arm = lwr_dyn.load("lwr4plus")
    >>> reference("point-to-point", arm, start=[0] * 7, end=[1] * 7, duration=3.0).duration
    3.0
    >>> wave = reference(lambda t: 0.1 * np.sin(t * np.arange(1, 8)), arm, duration=2.0)
    >>> wave.sample(np.array([0.0])).dq[0, :3].round(9).tolist()
    [0.1, 0.2, 0.3]
    """
    motion: Reference
    if callable(name):
        from lwr_dyn.trajectory.references.function_reference import function_reference

        check_options("a reference from a function", function_reference, 2, options)
        motion = function_reference(name, arm_argument(arm), **options)
    else:
        motion = REFERENCES.make(name, arm_argument(arm), **options)
    return motion
