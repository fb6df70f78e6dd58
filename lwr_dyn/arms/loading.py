"""From a name or a file to an arm, with the options it is loaded with; what a run records of them finds it again.

Here are also the functions that optional packages lend.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from lwr_dyn.arms.papers.schema import Paper
from lwr_dyn.foundation.errors import FileAccessError, OptionError, UnknownNameError
from lwr_dyn.foundation.files import ends_in
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Run

PARTS: Registry[Callable[[Arm, Any, Any], Arm]] = Registry(
    "part", {"installation": Row("lwr_dyn.arms.mount_and_tool:installed", "a mount and a tool")}
)
"""Parts of loading that an optional package does."""
FUNCTIONS: Registry[Callable[..., Any]] = Registry(
    "function",
    {
        "batch_dynamics": Row(
            "lwr_dyn.codegen.kernels.batch:batch_dynamics", "dynamics over rows of states", extra="batch"
        ),
        "passive_refit": Row("lwr_dyn.model.passive_refit:passive_refit", "nearest passive friction"),
        "dh_matrices_text": Row(
            "lwr_dyn.dynamics.symbolic.dh_matrices:dh_matrices_text", "DH matrices", extra="symbolic"
        ),
        "inertia_certificates": Row(
            "lwr_dyn.control.inertia.bounds.certificate:inertia_certificates", "proven largest inertias", extra="batch"
        ),
        "sampled_notes": Row("lwr_dyn.design.sampled_text:sampled_notes", "the sampled loop of a simulation"),
        "margins": Row("lwr_dyn.design.margins:margins", "margins of a sampled loop"),
        "loop_pictures": Row("lwr_dyn.pages.plotting.loop_pictures:LoopPictures", "pictures of a loop", extra="plots"),
        "compare": Row("lwr_dyn.studies.compare.comparison:compare", "runs side by side"),
        "plot": Row("lwr_dyn.pages.notebook.plot:plot", "pictures of runs", extra="plots"),
        "rollouts": Row(
            "lwr_dyn.codegen.rollouts.rollouts:rollouts", "many runs of a closed loop at once", extra="batch"
        ),
        "responses": Row("lwr_dyn.simulation.responses.text:responses_said", "what a loop made of a step or a chirp"),
        "show": Row("lwr_dyn.pages.explorer.shown:show", "an arm or a run in the browser"),
        "plot_writer": Row("lwr_dyn.pages.notebook.plot:plot_writer", "the option --plot", extra="plots"),
        "machine_arm": Row("lwr_dyn.krl.robot.machine_arm:load_machine_arm", "KUKA's machine data", extra="krl"),
        "kuka_units": Row("lwr_dyn.krl.robot.kuka_units:KukaUnits", "poses in mm and deg, Status, Turn", extra="krl"),
    },
)
"""Functions of optional packages that are offered by `import lwr_dyn` and by the commands."""


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
    elif ends_in(name, ".dat", ".kuka.toml"):
        arm, paper = FUNCTIONS.load("machine_arm")(name, reading, lock), None
    else:
        arm, paper = _of_paper(name, reading, lock or {})
    file = str(Path(name).resolve()) if ends_in(name, ".urdf", ".xacro", ".toml", ".dat") else ""
    arm = replace(arm, file=file, loaded_with=options)
    return (arm if mount is tool is None else PARTS.load("installation")(arm, mount, tool)), paper


def xacro_arguments(texts: Iterable[str]) -> dict[str, str]:
    """Arguments of a `.xacro` from texts NAME:=VALUE; raises `OptionError`."""
    parts = {text: text.partition(":=") for text in texts}
    for text in (text for text, (name, mark, _) in parts.items() if not (name and mark)):
        raise OptionError("--xacro-arg", repr(text), "NAME:=VALUE, such as ur_type:=ur10e")
    return {name: value for name, _, value in parts.values()}


def _of_paper(name: str, reading: str | None, lock: Mapping[str, float]) -> tuple[Arm, Paper]:
    from lwr_dyn.arms.papers import assembly, catalog

    paper = catalog.open_paper(name, reading)
    arm = assembly.arm_from_paper(paper)
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
