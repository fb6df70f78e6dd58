"""From a name or a file to an arm, with the options it is loaded with; what a run records of them finds it again."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arrays import fixed_array, real_array
from lwr_dyn.errors import FileAccessError, OptionError, ShapeError, UnknownNameError
from lwr_dyn.files import ends_in, read_text
from lwr_dyn.kinematics.forward import pose_array
from lwr_dyn.model.arm import Arm, Source
from lwr_dyn.model.chain import Body
from lwr_dyn.model.feasibility import is_physical
from lwr_dyn.model.installation import MOUNTS, Tool
from lwr_dyn.model.run import Run
from lwr_dyn.model.spatial import Pose, from_rpy
from lwr_dyn.papers.fields import parse_toml
from lwr_dyn.papers.schema import Paper
from lwr_dyn.papers.units import to_si

_POSE = ("xyz", "rpy", "rpy_deg", "pose")
_FIELDS = {"mount": ("on", *_POSE), "tool": (*_POSE, "mass", "com", "inertia")}
_LARGEST = 1e6
"""Of a number of a mount or tool [m, kg, kg m^2]."""


def load_with_paper(
    robot: str | Path,
    reading: str | None = None,
    *,
    tip: str | None = None,
    lock: Mapping[str, float] | None = None,
    mount: Any = None,
    tool: Any = None,
    xacro_args: Mapping[str, str] | None = None,
) -> tuple[Arm, Paper | None]:
    """As `lwr_dyn.load`, with the paper that the arm comes from; None for a `.urdf`."""
    name = str(robot)
    if "\0" in name:
        raise FileAccessError(repr(name), "a null character", "a robot's name or a path")
    options: dict[str, Any] = {"tip": tip, "lock": dict(lock or {}), "xacro_args": dict(xacro_args or {})}
    options = {key: value for key, value in options.items() if value}
    if xacro_args and not ends_in(name, ".xacro"):
        raise OptionError("xacro_args", f"given for {name}", "only with a .xacro file")
    given = {key: _description(key, value) for key, value in (("mount", mount), ("tool", tool)) if value is not None}
    if ends_in(name, ".urdf", ".xacro"):
        from lwr_dyn.urdf.reader import read_urdf

        if reading is not None:
            raise UnknownNameError("reading of a URDF", reading, ())
        arm, paper = read_urdf(name, tip, lock, xacro_args), None
    elif tip is not None:
        raise OptionError("tip", f"given for {name}", "only with a .urdf file")
    else:
        arm, paper = _of_paper(name, reading, lock or {})
    file = str(Path(name).resolve()) if ends_in(name, ".urdf", ".xacro", ".toml") else ""
    return replace(_installed(arm, given), file=file, loaded_with=options | given), paper


def _of_paper(name: str, reading: str | None, lock: Mapping[str, float]) -> tuple[Arm, Paper]:
    from lwr_dyn.papers import assembly, catalog

    paper = catalog.open_paper(name, reading)
    arm = assembly.arm_from_paper(paper)
    for joint, value in lock.items():
        arm = arm.with_locked_joint(joint, value)
    return arm, paper


def _description(what: str, given: Any) -> dict[str, Any]:
    """A mount or tool as JSON values: a place by name, a table, that of a `.toml` file, or a pose (4, 4)."""
    if isinstance(given, str | Path) and ends_in(given, ".toml"):
        given = parse_toml(read_text(given, f"a readable .toml file of a {what}"), Path(given).name)
    elif isinstance(given, str | Path) and what == "mount":
        given = {"on": str(given)}
    elif isinstance(given, str | Path):
        raise OptionError(what, repr(str(given)), f"a .toml file, or fields: {', '.join(_FIELDS[what])}")
    elif not isinstance(given, Mapping):
        given = {"pose": given}
    for key in given:
        if key not in _FIELDS[what]:
            raise UnknownNameError(f"field of a {what}", key, _FIELDS[what])
    return {key: x if key == "on" else _numbers(f"{what} {key}", x) for key, x in given.items()}


def _numbers(name: str, given: Any) -> Any:
    array = real_array(name, given)
    if np.abs(array).max(initial=0.0) > _LARGEST:
        raise OptionError(name, given, f"numbers up to {_LARGEST:g}, in SI")
    return array.tolist()


def _installed(arm: Arm, given: Mapping[str, dict[str, Any]]) -> Arm:
    """The arm on its mount and with its tool; their numbers are sources of what they change."""
    if not given:
        return arm
    mount = _mount(given["mount"]) if "mount" in given else None
    tool = _tool(given.get("tool", {}))
    out, last = arm.installed(mount, tool), arm.chain.links[-1].link
    cells = {key: Source(key, "option of loading", "given", row, "SI", "multiplied") for key, row in given.items()}
    sources: dict[str, tuple[Source, ...]] = {key: (cell,) for key, cell in cells.items()}
    if tool.mass:
        changed = [f"{last}.{part}" for part in ("mass", "com", "inertia")]
        sources |= {name: (*arm.sources.get(name, ()), replace(cells["tool"], conversion="added")) for name in changed}
    return replace(out, sources={**out.sources, **sources})


def _mount(table: Mapping[str, Any]) -> Pose:
    place = str(table.get("on", "floor"))
    if place not in MOUNTS:
        raise UnknownNameError("mount", place, MOUNTS)
    pose = _pose("mount", table)
    return Pose(MOUNTS[place].rotation @ pose.rotation, pose.position)


def _pose(what: str, table: Mapping[str, Any]) -> Pose:
    turns = [key for key in ("rpy", "rpy_deg", "pose") if key in table]
    if len(turns) > 1 or {"pose", "xyz"} <= set(table):
        raise OptionError(what, " and ".join({**dict.fromkeys(turns), **table}), "xyz with rpy or rpy_deg, or pose")
    if "pose" in table:
        matrix = pose_array(f"{what} pose", fixed_array(f"{what} pose", table["pose"], (4, 4)))
        return Pose(matrix[:3, :3], matrix[:3, 3])
    angles = fixed_array(f"{what} {turns[0]}", table[turns[0]], (3,)) if turns else np.zeros(3)
    rpy = [to_si(x, "deg") for x in angles] if "rpy_deg" in table else angles
    return Pose(from_rpy(rpy), fixed_array(f"{what} xyz", table.get("xyz", np.zeros(3)), (3,)))


def _tool(table: Mapping[str, Any]) -> Tool:
    mass = float(fixed_array("tool mass", table.get("mass", 0.0), ()))
    com = fixed_array("tool com", table.get("com", np.zeros(3)), (3,))
    given = np.asarray(table.get("inertia", np.zeros(3)))
    if given.shape not in ((3,), (6,), (3, 3)):
        allowed = "3 numbers (ixx, iyy, izz), 6 (ixx, ixy, ixz, iyy, iyz, izz) or a matrix, kg m^2"
        raise ShapeError("tool inertia", f"shape {given.shape}", allowed)
    six = given[[0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(3, 3) if given.shape == (6,) else given
    tensor = np.diag(six) if six.ndim == 1 else six
    if not is_physical(Body(mass, com, tensor)):
        raise OptionError("tool", f"mass {mass:g}, inertia {given.tolist()}", "an inertia that a body can have")
    return Tool(_pose("tool", table), mass, com, tensor)


def arm_of(run: Run) -> Arm:
    """The arm of a run, from the run's record; raises as `lwr_dyn.load`, and `OptionError` when the run names none."""
    robot, reading = run.meta.get("file") or run.meta.get("robot"), run.meta.get("reading")
    if not isinstance(robot, str):
        raise OptionError("run", "does not say of which robot it is", "a run made by simulate")
    try:
        options = run.meta.get("loaded_with") or {}
        reading = None if ends_in(robot, ".urdf", ".xacro") else reading
        arm, _ = load_with_paper(robot, reading, **options)
    except (TypeError, AttributeError):  # a record that another hand has changed
        raise OptionError("run", "loaded with options that do not exist", "a run made by simulate") from None
    if arm.file and run.meta.get("digest") not in (arm.digest, None):
        raise FileAccessError(arm.file, "has changed since the run was made", "the file as it was then")
    return arm
