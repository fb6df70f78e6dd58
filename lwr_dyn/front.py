"""What `import lwr_dyn` offers. Each function imports what it needs when it is called."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from lwr_dyn.arms.loading import FUNCTIONS as FUNCTIONS
from lwr_dyn.arms.loading import arm_of, load_with_paper
from lwr_dyn.foundation.arrays import arm_argument
from lwr_dyn.foundation.errors import OptionError

if TYPE_CHECKING:
    from lwr_dyn.codegen.kernels.batch import BatchDynamics
    from lwr_dyn.codegen.rollouts.rollouts import rollouts as rollouts
    from lwr_dyn.control.protocol import Controller
    from lwr_dyn.design.margins import margins as margins
    from lwr_dyn.dynamics.protocol import Dynamics
    from lwr_dyn.foundation.arrays import Array
    from lwr_dyn.kinematics.inverse import inverse_kinematics as inverse_kinematics
    from lwr_dyn.kinematics.pose_solver import ik_solver as ik_solver
    from lwr_dyn.krl.robot.kuka_units import KukaUnits
    from lwr_dyn.model.arm import Arm
    from lwr_dyn.model.run import Reference, Run
    from lwr_dyn.pages.explorer.shown import show as show
    from lwr_dyn.pages.notebook.plot import plot as plot
    from lwr_dyn.simulation.simulate import simulate as simulate
    from lwr_dyn.studies.compare.comparison import compare as compare


_ELSEWHERE = {
    "inverse_kinematics": "lwr_dyn.kinematics.inverse",
    "ik_solver": "lwr_dyn.kinematics.pose_solver",
    "simulate": "lwr_dyn.simulation.simulate",
}
"""Functions that are offered as they stand in their modules."""
_LENT = ("compare", "margins", "plot", "rollouts", "show")
"""Functions of optional packages that are offered as they stand."""


def __getattr__(name: str) -> Any:
    if name in _LENT:
        return FUNCTIONS.load(name)
    if name not in _ELSEWHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_ELSEWHERE[name]), name)


def robots() -> tuple[str, ...]:
    """Names of the robots that come with the package."""
    from lwr_dyn.arms.papers import catalog

    return catalog.robots()


def readings(robot: str) -> tuple[str, ...]:
    """Readings of a robot or of a `.toml` file, its default first; raises as `load`."""
    from lwr_dyn.arms.papers import catalog

    return catalog.readings(robot)


def load(
    robot: str | Path,
    reading: str | None = None,
    *,
    tip: str | None = None,
    lock: Mapping[str, float] | None = None,
    mount: Any = None,
    tool: Any = None,
    xacro_args: Mapping[str, str] | None = None,
) -> Arm:
    """A robot by name, from a user's own `.toml`, a `.urdf` or `.xacro`, or the `$machine.dat` of a KUKA robot.

    Parameters
    ----------
    robot : str or path
    reading : str, optional
        One of `readings(robot)`; the paper's default if not given.
    tip : str, optional
        Last link of the chain, for a `.urdf`; if not given that of the one obvious arm. `notes` of the arm say which
        was taken and where joints beside the chain are held.
    lock : mapping, optional
        Joint name -> value [rad or m] at which it is held.
    mount : "floor", "wall", "ceiling", mapping, path of a .toml file or (4, 4) array_like, optional
        The base in the world, whose z is up: fields `on` (one of the names), `xyz` [m], and `rpy` [rad] or `rpy_deg`,
        which turn the base there. Poses of the arm are then in the world.
    tool : mapping, path of a .toml file or (4, 4) array_like, optional
        What is fixed to the flange: the tool centre point in the flange by `xyz`, `rpy` or `rpy_deg`; `mass` [kg]; its
        `com` [m] in the flange; `inertia` about `com` in axes of the flange [kg m^2] (3 or 6 numbers, or a matrix).
        Poses of the arm, payloads and the URDF's tip are then those of the tool centre point.
    xacro_args : mapping, optional
        Arguments of a `.xacro` file, which the package `xacro` expands. That runs the Python expressions of the file:
        load only a xacro that you trust.

    Raises
    ------
    UnknownNameError
        No robot, reading, tip or joint of that name.
    FileAccessError, PaperError, UrdfError
        The file cannot be read, or is not what it should be, or holds several arms and no tip is given.
    MissingPackageError
        A `.xacro` without the extra `urdf`.
    OptionError, ShapeError
        A tip for a robot that is no `.urdf`, a lock outside the joint's limits, a mount or tool that cannot be.

    >>> load("lwr4plus").n, load("lwr4plus", lock={"joint_3": 0.0}).n
    (7, 6)
    >>> forward_kinematics(load("lwr4plus", mount="ceiling", tool={"xyz": [0, 0, 0.1]}), [0] * 7)[2, 3].round(3)
    np.float64(-0.968)
    """
    return load_with_paper(robot, reading, tip=tip, lock=lock, mount=mount, tool=tool, xacro_args=xacro_args)[0]


def urdf_text(arm: Arm) -> str:
    """The arm as URDF text; the same arm gives the same bytes."""
    from lwr_dyn.arms.urdf import writer

    return writer.urdf_text(arm_argument(arm))


def dynamics_of(arm: Arm, engine: str = "pinocchio", rotors: str = "armature") -> Dynamics:
    """The dynamics of an arm by one of `engines()`: "pinocchio", "newton-euler", or "kernels" for large batches.

    Rotors other than "armature" ("full", "none") need one of the last two; see `dynamics.engines.dynamics_of`.
    Raises `UnknownNameError` (no such engine), `OptionError` (rotors it does not know), `MissingDataError` (no masses),
    `MissingPackageError` ("kernels" without the extra `batch`).
    """
    from lwr_dyn.dynamics import engines

    return engines.dynamics_of(arm_argument(arm), engine, rotors)


def engines() -> dict[str, str]:
    """Names of the engines of `dynamics_of`, with a line on each.

    >>> list(engines())[:2]
    ['pinocchio', 'newton-euler']
    """
    from lwr_dyn.dynamics.engines import ENGINES

    return {name: ENGINES[name].about for name in ENGINES.names}


def controller(name: str, arm: Arm, *, engine: str | Dynamics = "pinocchio", **options: Any) -> Controller:
    """A controller by name ("pd-gravity", "pid", "inverse-dynamics", or one that a package adds), or from a .py file.

    Options are those of its factory, such as omega_n [rad/s]; errors as of `control.controllers.make_controller`. The
    engine computes the model of the arm.

    >>> controller("inverse-dynamics", load("lwr4plus"), omega_n=20.0).Kp[0]
    np.float64(400.0)
    """
    from lwr_dyn.control.controllers import make_controller

    return make_controller(name, arm_argument(arm), engine, **options)


def reference(name: str, arm: Arm, **options: Any) -> Reference:
    """A reference for the joints by name: "ist", "ist-clear", "point-to-point", "lspb", "hold", or an added one.

    Options are those of its factory in `lwr_dyn.trajectory.references`, such as q [rad or m] or duration [s] of "hold".
    Raises `UnknownNameError`, `OptionError`, and the factory's own (`PathLimitError`: the path leaves the limits).

    >>> move = reference("point-to-point", load("lwr4plus"), start=[0] * 7, end=[1] * 7, duration=3.0)
    >>> move.duration
    3.0
    """
    from lwr_dyn.trajectory.references.tasks import REFERENCES

    motion: Reference = REFERENCES.make(name, arm_argument(arm), **options)
    return motion


def batch_dynamics(
    arm: Arm,
    dtype: str = "float64",
    threads: int | None = 1,
    inputs: Iterable[str] = (),
    friction: str = "none",
    rotors: str = "armature",
    layout: str = "rows",
    structure: str = "dense",
) -> BatchDynamics:
    """An arm's dynamics over rows of states by generated kernels; needs the extra `batch`.

    dtype: "float64" or "float32". threads: None for all processors. inputs: names out of inertia, payload, gravity,
    friction, which kernels take as inputs instead of the arm's constants. friction: "arm" adds the arm's friction to
    inverse and subtracts it in forward dynamics. rotors: "armature", "full" or "none". layout: "rows", "padded" or
    "blocks" in memory. structure: "dense", or "compact" for the distinct values of a matrix alone.
    Raises `OptionError` for another choice, `MissingDataError` (no inertias), `MissingPackageError`.
    """
    make = FUNCTIONS.load("batch_dynamics")
    batch: BatchDynamics = make(arm_argument(arm), dtype, threads, inputs, friction, rotors, layout, structure)
    return batch


def kuka_units(arm: Arm) -> KukaUnits | None:
    """Poses and solutions of an arm in KUKA's units; None without KUKA's axes or without the package `krl`."""
    units = FUNCTIONS.load("kuka_units")(arm_argument(arm)) if FUNCTIONS["kuka_units"].is_installed else None
    return units if units and units.has_axes else None


def forward_kinematics(arm: Arm, q: ArrayLike) -> Array:
    """Pose of the flange in the base, (..., 4, 4), for q (..., n) [rad or m]; raises `ShapeError`.

    >>> forward_kinematics(load("lwr4plus"), [0] * 7)[2, 3].round(3)
    np.float64(0.868)
    """
    from lwr_dyn.kinematics import forward

    return forward.forward_kinematics(arm_argument(arm).chain, q)


def replay(
    runs: Run | Sequence[Run],
    path: str | Path,
    *,
    labels: Sequence[str] | None = None,
    title: str | None = None,
    trace: bool = True,
    frames: bool = False,
    layout: str = "overlaid",
    rate: float = 100.0,
) -> None:
    """Write one HTML page to `path`, no network, that replays runs in 3D with the arms that they name.

    labels: one per run; the controllers' names if not given. title: headline; the arm's title if not given. trace,
    frames: whether the trace and the source's frames are shown at the start. layout: "overlaid" or "beside". rate:
    samples a second on the page. Raises `FileAccessError`, `UnknownNameError` (an unknown robot), `OptionError`,
    `ShapeError`.
    """
    from lwr_dyn.model.run import Run
    from lwr_dyn.pages.replay.replay_page import write_replay

    if not isinstance(runs, (Run, Sequence)):
        raise OptionError("runs", repr(runs), "a run or a list of runs, as simulate or Run.load give them")
    several = [runs] if isinstance(runs, Run) else list(runs)
    arms = [arm_of(run) for run in several]
    write_replay(path, several, arms, labels=labels, title=title, trace=trace, frames=frames, layout=layout, rate=rate)
