"""From a name or a file to an arm, with the options it is loaded with; what a run records of them finds it again."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from lwr_dyn.arms.mount_and_tool import installed
from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.errors import FileAccessError, OptionError, UnknownNameError
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run

FILE_FORMATS: Registry[Callable[[str, str | None, Mapping[str, float] | None], Arm]] = Registry(
    "file_format",
    {
        ".dat": Row("lwr_dyn.krl.robot.machine_arm:load_machine_arm", "KUKA's machine data", extra="krl"),
        ".kuka.toml": Row("lwr_dyn.krl.robot.machine_arm:load_machine_arm", "KUKA's machine data", extra="krl"),
    },
)
"""Further files that hold an arm, by their ending; each row is a function of path, reading and locked joints."""


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
    >>> load("lwr4plus", mount="ceiling", tool={"xyz": [0, 0, 0.1]}).installation.mount.on
    'ceiling'
    """
    return load_with_paper(robot, reading, tip=tip, lock=lock, mount=mount, tool=tool, xacro_args=xacro_args)[0]


def load_with_paper(
    robot: str | Path,
    reading: str | None = None,
    *,
    tip: str | None = None,
    lock: Mapping[str, float] | None = None,
    mount: Any = None,
    tool: Any = None,
    xacro_args: Mapping[str, str] | tuple[str, ...] | None = None,
) -> tuple[Arm, Paper | None]:
    """As `lwr_dyn.load`, with the paper that the arm comes from; None for a `.urdf`."""
    name = str(robot)
    if "\0" in name:
        raise FileAccessError(repr(name), "a null character", "a robot's name or a path")
    if isinstance(xacro_args, tuple):  # options of the command
        xacro_args = xacro_arguments(xacro_args)
    options: dict[str, Any] = {"tip": tip, "lock": dict(lock or {}), "xacro_args": dict(xacro_args or {})}
    options = {key: value for key, value in options.items() if value}
    if xacro_args and not ends_in(name, ".xacro"):
        raise OptionError("xacro_args", f"given for {name}", "only with a .xacro file")
    if ends_in(name, ".urdf", ".xacro"):
        from lwr_dyn.arms.urdf.reader import read_urdf

        if reading is not None:
            raise UnknownNameError("reading of a URDF", reading, ())
        arm, paper = read_urdf(name, tip, lock, xacro_args), None
    elif tip is not None:
        raise OptionError("tip", f"given for {name}", "only with a .urdf file")
    elif ending := next((ending for ending in FILE_FORMATS.names if ends_in(name, ending)), None):
        arm, paper = FILE_FORMATS.load(ending)(name, reading, lock), None
    else:
        arm, paper = _of_paper(name, reading, lock or {})
    file = str(Path(name).resolve()) if ends_in(name, ".urdf", ".xacro", ".toml", ".dat") else ""
    arm = replace(arm, file=file, loaded_with=options)
    return (arm if mount is tool is None else installed(arm, mount, tool)), paper


def xacro_arguments(texts: Iterable[str]) -> dict[str, str]:
    """Arguments of a `.xacro` from texts NAME:=VALUE; raises `OptionError`."""
    parts = {text: text.partition(":=") for text in texts}
    for text in (text for text, (name, mark, _) in parts.items() if not (name and mark)):
        raise OptionError("--xacro-arg", repr(text), "NAME:=VALUE, such as ur_type:=ur10e")
    return {name: value for name, _, value in parts.values()}


def _of_paper(name: str, reading: str | None, lock: Mapping[str, float]) -> tuple[Arm, Paper]:
    paper = open_paper(name, reading)
    arm = arm_from_paper(paper)
    for joint, value in lock.items():
        arm = arm.with_locked_joint(joint, value)
    return arm, paper


def arm_of(run: Run) -> Arm:
    """The arm of a run: that of its setup, else that of its record.

    Raises as `lwr_dyn.load`, and `OptionError` when the record names none.
    """
    if run.setup is not None:
        arm: Arm = run.setup.arm
        return arm
    robot, reading = run.meta.get("file") or run.meta.get("robot"), run.meta.get("reading")
    if not isinstance(robot, str):
        raise OptionError("run", "does not say of which robot it is", "a run made by simulate")
    try:
        options = run.meta.get("loaded_with") or {}
        reading = None if ends_in(robot, ".urdf", ".xacro", ".dat", ".kuka.toml") else reading
        arm, _ = load_with_paper(robot, reading, **options)
    except (TypeError, AttributeError):  # a record that another hand has changed
        raise OptionError("run", "loaded with options that do not exist", "a run made by simulate") from None
    if arm.file and run.meta.get("digest") not in (arm.digest, None):
        raise FileAccessError(arm.file, "has changed since the run was made", "the file as it was then")
    return arm
