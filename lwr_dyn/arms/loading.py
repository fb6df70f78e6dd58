"""From a name or a file to an arm, on its mount and with its tool; what a run records of that finds it again.

The load is given as robot controllers want it (KUKA's LOAD_DATA, UR, Franka): com in the flange, inertia about com.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.papers.assembly import arm_from_paper
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.arms.papers.schema import Paper, to_si
from lwr_dyn.foundation.arrays import fixed_array, number_of, real_array
from lwr_dyn.foundation.errors import FileAccessError, OptionError, ShapeError, UnknownNameError
from lwr_dyn.foundation.fields import parse_toml
from lwr_dyn.foundation.files import ends_in, read_text
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm, Source
from lwr_dyn.model.chain import MOUNTS, Body, Rotor, Tool, is_physical
from lwr_dyn.model.file_layout import FileLayout
from lwr_dyn.model.run import Run
from lwr_dyn.model.spatial import Pose, from_rpy, pose_array

_POSE = ("xyz", "rpy", "rpy_deg", "pose")
_FIELDS = {"mount": ("on", *_POSE), "tool": (*_POSE, "mass", "com", "inertia")}
WORLD = "world"
"""The root link of the URDF of a mounted arm."""
_LARGEST = 1e6
"""Of a number of a mount, tool or rotor [m, kg, kg m^2]."""


def installed(arm: Arm, mount: Any, tool: Any) -> Arm:
    """The arm on its mount and with its tool, each None where nothing is said.

    Their fields as JSON values are added to `loaded_with`; they are sources of the numbers that they change. Raises
    `FileAccessError` or `PaperError` for a .toml file that cannot be read; `UnknownNameError`, `OptionError`,
    `ShapeError` for a place or field that does not exist, two rotations, an inertia that no body can have, other
    shapes.
    """
    given = {key: _description(key, value) for key, value in (("mount", mount), ("tool", tool)) if value is not None}
    body, last = _tool(given.get("tool", {})), arm.chain.links[-1].link
    if "mount" in given and arm.layout is not None and arm.layout.root == WORLD:
        name = next(name for k in count(1) if (name := WORLD + "_" * k) not in arm.layout.shapes)
        arm = replace(arm, layout=_with_root(arm.layout, name))
    out = arm.installed(_mount(given["mount"]) if "mount" in given else None, body)
    cells = {key: Source(key, "option of loading", "given", row, "SI", "multiplied") for key, row in given.items()}
    sources: dict[str, tuple[Source, ...]] = {key: (cell,) for key, cell in cells.items()}
    if body.mass:
        changed = [f"{last}.{part}" for part in ("mass", "com", "inertia")]
        sources |= {name: (*arm.sources.get(name, ()), replace(cells["tool"], conversion="added")) for name in changed}
    return replace(out, sources={**out.sources, **sources}, loaded_with={**arm.loaded_with, **given})


def with_rotors(arm: Arm, inertias: Mapping[str, float]) -> Arm:
    """The arm with rotors of some joints, by name or number: k_r^2 I_m, as the joint feels it [kg m^2 or kg].

    They are added to `loaded_with`, and are sources of the numbers that they change. Raises `UnknownNameError` for a
    joint that does not exist, `ShapeError` or `OptionError` for an inertia that is no number of at least 0, or a joint
    named twice.
    """
    given: dict[str, float] = {}
    names = arm.joint_names
    for key, value in inertias.items():
        named = str(key)
        if named not in names and named.isdecimal() and 1 <= int(named) <= arm.n:
            named = names[int(named) - 1]
        if named not in names:
            raise UnknownNameError(f"joint of {arm.name}", named, names)
        if named in given:
            raise OptionError(f"rotor {key}", f"{named} twice", "each joint once")
        given[named] = float(fixed_array(f"rotor {key}", value, ()))
        if not 0.0 <= given[named] <= _LARGEST:
            raise OptionError(f"rotor {key}", value, f"a number from 0 to {_LARGEST:g}, kg m^2 at the joint")
    if not given:
        return arm
    links = [
        replace(x, rotor=Rotor(1.0, given[x.joint], reflected=True)) if x.joint in given else x for x in arm.chain.links
    ]
    cell = Source("rotor", "option of loading", "given", given, "SI", "to SI")
    gone = {f"{name}.gear_ratio" for name in given}
    sources = {name: cells for name, cells in arm.sources.items() if name not in gone}
    sources |= {f"{name}.{part}": (cell,) for name in given for part in ("armature", "rotor_inertia")}
    loaded = {**arm.loaded_with, "rotor": given}
    return replace(arm, chain=replace(arm.chain, links=tuple(links)), sources=sources, loaded_with=loaded)


def _rotors(given: Mapping[str, float] | str | Path | tuple[str, ...]) -> dict[str, float]:
    """Rotors by joint, also those of a `.toml` file, or the command's texts JOINT=VALUE or one file.

    Raises `OptionError`, and as `installed` for the file.
    """
    if isinstance(given, tuple) and len(given) == 1 and ends_in(given[0], ".toml"):
        given = given[0]
    if isinstance(given, str | Path):
        if not ends_in(given, ".toml"):
            raise OptionError("rotor", repr(str(given)), "a .toml file with a line joint = value a joint, or a mapping")
        return dict(parse_toml(read_text(given, "a readable .toml file of rotors"), Path(given).name))
    if not isinstance(given, tuple):
        return dict(given)
    out: dict[str, float] = {}
    for joint, mark, value in (text.partition("=") for text in given):
        try:
            if not mark or joint in out:
                raise ValueError
            out[joint] = number_of(value)
        except ValueError:
            allowed = "JOINT=VALUE once a joint, such as 2=0.5, kg m^2 at the joint, or one .toml file of them"
            raise OptionError("--rotor", repr(f"{joint}{mark}{value}"), allowed) from None
    return out


def _with_root(layout: FileLayout, name: str) -> FileLayout:
    """The layout with its root under another name: Drake takes any link `world` for its own world."""

    def named(link: str) -> str:
        return name if link == layout.root else link

    return replace(
        layout, root=name, joints=tuple(replace(joint, parent=named(joint.parent)) for joint in layout.joints),
        fixed=tuple(tuple(replace(x, parent=named(x.parent)) for x in row) for row in layout.fixed),
        shapes={named(link): shapes for link, shapes in layout.shapes.items()},
        inertials={named(link): inertial for link, inertial in layout.inertials.items()},
    )  # fmt: skip


def _description(what: str, given: Any) -> dict[str, Any]:
    """A mount or tool as JSON values: a place by name, a table, that of a `.toml` file, or a pose (4, 4)."""
    if isinstance(given, tuple) and given and all(isinstance(x, str) for x in given):
        given = _of_texts(what, given)
    if isinstance(given, str | Path) and ends_in(given, ".toml"):
        given = parse_toml(read_text(given, f"a readable .toml file of a {what}"), Path(given).name)
    elif isinstance(given, str | Path) and what == "mount":
        given = {"on": str(given)}
    elif isinstance(given, str | Path):
        raise OptionError(what, repr(str(given)), f"a .toml file, or xyz=0,0,0.15; fields: {', '.join(_FIELDS[what])}")
    elif not isinstance(given, Mapping):
        given = {"pose": given}
    for key in given:
        if key not in _FIELDS[what]:
            raise UnknownNameError(f"field of a {what}", key, _FIELDS[what])
    return {key: x if key == "on" else _numbers(f"{what} {key}", x) for key, x in given.items()}


def _of_texts(what: str, texts: tuple[str, ...]) -> Any:
    """Options of the command: a place or a file by its name, or KEY=NUMBERS one by one."""
    if len(texts) == 1 and "=" not in texts[0]:
        return texts[0]
    fields: dict[str, Any] = {}
    for key, mark, value in (text.partition("=") for text in texts):
        if (not mark and what == "tool") or (key if mark else "on") in fields:
            raise OptionError(f"--{what}", repr(key), "each KEY=NUMBERS once, or one file")
        fields[key if mark else "on"] = _plain_numbers(f"--{what} {key}", value) if mark else key
    return fields


def _plain_numbers(name: str, text: str) -> float | list[float]:
    try:
        numbers = [number_of(x) for x in text.split(",")]
    except ValueError:
        raise OptionError(name, repr(text), "numbers such as 0,0,0.15; one field an option") from None
    return numbers if "," in text else numbers[0]


def _numbers(name: str, given: Any) -> Any:
    array = real_array(name, given)
    if np.abs(array).max(initial=0.0) > _LARGEST:
        raise OptionError(name, given, f"numbers up to {_LARGEST:g}, in SI")
    return array.tolist()


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


FILE_FORMATS: Registry[Callable[[str, str | None, Mapping[str, float] | None], Arm]] = Registry(
    "file_format",
    {
        ".dat": Row("lwr_dyn.krl.robot.machine_data:load_machine_arm", "KUKA's machine data", extra="krl"),
        ".kuka.toml": Row("lwr_dyn.krl.robot.machine_data:load_machine_arm", "KUKA's machine data", extra="krl"),
    },
)
"""Further files that hold an arm, by their ending; each row is a function of path, reading and locked joints."""
_TREES = (".urdf", ".xacro", ".xml")
ONE_READING = (*_TREES, ".dat", ".kuka.toml")
"""Endings of files that hold an arm without readings."""


def load(
    robot: str | Path,
    reading: str | None = None,
    *,
    tip: str | None = None,
    lock: Mapping[str, float] | None = None,
    mount: Any = None,
    tool: Any = None,
    rotor: Mapping[str, float] | str | Path | None = None,
    xacro_args: Mapping[str, str] | None = None,
    trust_xacro: bool = False,
) -> Arm:
    """A robot by name, from a `.toml`, `.urdf`, `.xacro` or `.xml` (MJCF), or from a KUKA robot's `$machine.dat`.

    Parameters
    ----------
    robot : str or path
    reading : str, optional
        One of `readings(robot)`; the paper's default if not given.
    tip : str, optional
        Last link of the chain, for a `.urdf` or MJCF (body or site); if not given that of the one obvious arm. `notes`
        of the arm say which was taken, where joints beside the chain are held, and what of an MJCF is left out.
    lock : mapping, optional
        Joint name -> value [rad or m] at which it is held.
    mount : "floor", "wall", "ceiling", mapping, path of a .toml file or (4, 4) array_like, optional
        The base in the world, whose z is up: fields `on` (one of the names), `xyz` [m], and `rpy` [rad] or `rpy_deg`,
        which turn the base there. Poses of the arm are then in the world.
    tool : mapping, path of a .toml file or (4, 4) array_like, optional
        What is fixed to the flange: the tool centre point in the flange by `xyz`, `rpy` or `rpy_deg`; `mass` [kg]; its
        `com` [m] in the flange; `inertia` about `com` in axes of the flange [kg m^2] (3 or 6 numbers, or a matrix).
        Poses of the arm, payloads and the URDF's tip are then those of the tool centre point.
    rotor : mapping or path of a .toml file, optional
        Joint, by its name or number, -> rotor inertia as the joint feels it, k_r^2 I_m [kg m^2; kg where it slides]. It
        takes the place of the rotor that the source gives; 0 says that there is none, as of a direct drive.
    xacro_args : mapping, optional
        Arguments of a `.xacro` file, which the package `xacro` expands.
    trust_xacro : bool
        Whether the expressions of a `.xacro` file run as Python. Without, they may hold numbers, names, operators,
        indices and listed functions, and none of the file's code runs.

    Raises
    ------
    UnknownNameError
        No robot, reading, tip or joint of that name.
    FileAccessError, PaperError, UrdfError
        The file cannot be read, or is not what it should be, or holds several arms and no tip is given.
    MissingPackageError
        A `.xacro` without the extra `urdf`, an MJCF without the extra `parity` (MuJoCo compiles it).
    OptionError, ShapeError
        A tip for a robot that is no `.urdf` or MJCF, a lock outside the joint's limits, a mount or tool that cannot be.

    >>> load("lwr4plus").n, load("lwr4plus", lock={"joint_3": 0.0}).n
    (7, 6)
    >>> import lwr_dyn
    >>> arm = load("lwr4plus", mount="ceiling", tool={"xyz": [0, 0, 0.1]})
    >>> lwr_dyn.forward_kinematics(arm, [0] * 7)[2, 3].round(3)
    np.float64(-0.968)
    """
    return load_with_paper(
        robot, reading, tip=tip, lock=lock, mount=mount, tool=tool, rotor=rotor, xacro_args=xacro_args,
        trust_xacro=trust_xacro,
    )[0]  # fmt: skip


def load_with_paper(
    robot: str | Path,
    reading: str | None = None,
    *,
    tip: str | None = None,
    lock: Mapping[str, float] | None = None,
    mount: Any = None,
    tool: Any = None,
    rotor: Mapping[str, float] | str | Path | tuple[str, ...] | None = None,
    xacro_args: Mapping[str, str] | tuple[str, ...] | None = None,
    trust_xacro: bool = False,
) -> tuple[Arm, Paper | None]:
    """As `lwr_dyn.load`, with the paper that the arm comes from; None for a `.urdf`."""
    name = str(robot)
    if "\0" in name:
        raise FileAccessError(repr(name), "a null character", "a robot's name or a path")
    if isinstance(xacro_args, tuple):  # options of the command
        xacro_args = xacro_arguments(xacro_args)
    options: dict[str, Any] = {"tip": tip, "lock": dict(lock or {}), "xacro_args": dict(xacro_args or {})}
    options = {key: value for key, value in (options | {"trust_xacro": trust_xacro}).items() if value}
    _refuse_for_others(name, options)
    if ends_in(name, *_TREES):
        arm, paper = _of_tree(name, reading, tip, lock, xacro_args, trust_xacro), None
    elif tip is not None:
        raise OptionError("tip", f"given for {name}", "only with a .urdf, .xacro or .xml file")
    elif ending := next((ending for ending in FILE_FORMATS.names if ends_in(name, ending)), None):
        arm, paper = FILE_FORMATS.load(ending)(name, reading, lock), None
    else:
        arm, paper = _of_paper(name, reading, lock or {})
    file = str(Path(name).resolve()) if ends_in(name, *ONE_READING, ".toml") else ""
    arm = with_rotors(replace(arm, file=file, loaded_with=options), _rotors(rotor or {}))
    return (arm if mount is tool is None else installed(arm, mount, tool)), paper


def _of_tree(
    name: str,
    reading: str | None,
    tip: str | None,
    lock: Mapping[str, float] | None,
    xacro_args: Mapping[str, str] | None,
    trust_xacro: bool,
) -> Arm:
    """The arm of a file that holds a tree of links."""
    if reading is not None:
        raise UnknownNameError("reading of an MJCF" if ends_in(name, ".xml") else "reading of a URDF", reading, ())
    if ends_in(name, ".xml"):
        from lwr_dyn.arms.export.mjcf_reader import read_mjcf

        return read_mjcf(name, tip, lock)
    from lwr_dyn.arms.urdf.reader import read_urdf

    return read_urdf(name, tip, lock, xacro_args, trust_xacro)


def _refuse_for_others(name: str, options: Mapping[str, Any]) -> None:
    """Raise `OptionError` for options of a `.xacro` with another file."""
    given = next((option for option in ("xacro_args", "trust_xacro") if option in options), None)
    if given is not None and not ends_in(name, ".xacro"):
        raise OptionError(given, f"given for {name}", "only with a .xacro file")


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

    What the record trusts is not trusted again. Raises as `lwr_dyn.load`, and `OptionError` when the record names none.
    """
    if run.setup is not None:
        arm: Arm = run.setup.arm
        return arm
    robot, reading = run.meta.get("file") or run.meta.get("robot"), run.meta.get("reading")
    if not isinstance(robot, str):
        raise OptionError("run", "does not say of which robot it is", "a run made by simulate")
    try:
        kept = (run.meta.get("loaded_with") or {}).items()
        options = {key: x for key, x in kept if key != "trust_xacro"}  # a file does not say what to trust
        reading = None if ends_in(robot, *ONE_READING) else reading
        arm, _ = load_with_paper(robot, reading, **options)
    except (TypeError, AttributeError):  # a record that another hand has changed
        raise OptionError("run", "loaded with options that do not exist", "a run made by simulate") from None
    if arm.file and run.meta.get("digest") not in (arm.digest, None):
        raise FileAccessError(arm.file, "has changed since the run was made", "the file as it was then")
    return arm
