"""From a name or a file to an arm, with the options it is loaded with; what a run records of them finds it again."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from lwr_dyn.errors import FileAccessError, OptionError, UnknownNameError
from lwr_dyn.files import ends_in
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run
from lwr_dyn.papers.schema import Paper


def load_with_paper(
    robot: str | Path, reading: str | None = None, *, tip: str | None = None, lock: Mapping[str, float] | None = None
) -> tuple[Arm, Paper | None]:
    """As `lwr_dyn.load`, with the paper that the arm comes from; None for a `.urdf`."""
    name = str(robot)
    if "\0" in name:
        raise FileAccessError(repr(name), "a null character", "a robot's name or a path")
    options = ({"tip": tip} if tip else {}) | ({"lock": dict(lock)} if lock else {})
    if ends_in(name, ".urdf", ".xacro"):
        from lwr_dyn.urdf.reader import read_urdf

        if reading is not None:
            raise UnknownNameError("reading of a URDF", reading, ())
        arm = read_urdf(name, tip=tip, lock=lock)
        return replace(arm, file=str(Path(name).resolve()), loaded_with=options), None
    if tip is not None:
        raise OptionError("tip", f"given for {name}", "only with a .urdf file")
    from lwr_dyn.papers import assembly, catalog

    paper = catalog.open_paper(name, reading)
    arm = assembly.arm_from_paper(paper)
    for joint, value in (lock or {}).items():
        arm = arm.with_locked_joint(joint, value)
    file = str(Path(name).resolve()) if ends_in(name, ".toml") else ""
    return replace(arm, file=file, loaded_with=options), paper


def arm_of(run: Run) -> Arm:
    """The arm of a run, from the run's record; raises as `lwr_dyn.load`, and `OptionError` when the run names none."""
    robot, reading = run.meta.get("file") or run.meta.get("robot"), run.meta.get("reading")
    if not isinstance(robot, str):
        raise OptionError("run", "does not say of which robot it is", "a run made by simulate")
    arm, _ = load_with_paper(robot, None if ends_in(robot, ".urdf") else reading, **run.meta.get("loaded_with", {}))
    if arm.file and run.meta.get("digest") not in (arm.digest, None):
        raise FileAccessError(arm.file, "has changed since the run was made", "the file as it was then")
    return arm
