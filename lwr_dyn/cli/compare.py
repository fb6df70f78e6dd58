"""`lwr-dyn compare`: run files side by side, or controllers x plants simulated on one task."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from lwr_dyn.cli.options import (
    NO_CODE,
    TASK_HELP,
    Flag,
    Loading,
    OneOf,
    check_code,
    option,
    robot_options,
    row_options,
    show,
    stands_on,
)  # fmt: skip
from lwr_dyn.cli.simulate import task_of
from lwr_dyn.cli.vocabulary import FOLDER, shared
from lwr_dyn.control.controllers import CONTROLLERS, controller_spec
from lwr_dyn.control.laws.friction_compensation import arm_with_friction
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.files import check_writable, ends_in, make_folder, write_files
from lwr_dyn.foundation.progress import progress
from lwr_dyn.model.caveats import ABSENT_ROTORS, ALL, DYNAMICS, ROTOR_RUN
from lwr_dyn.model.run import Run, run_used
from lwr_dyn.studies.compare.comparison import RunComparison, comparison_html, comparison_of, cross_table, pair_html
from lwr_dyn.studies.compare.plants import PLANTS, plant_case
from lwr_dyn.studies.compare.study import ControllerStudy
from lwr_dyn.trajectory.references.ist import Twice
from lwr_dyn.trajectory.references.references import REFERENCES

RUNS = ".npz"
PLANTS_HELP = "What the controllers do not know of; A+B for both. " + "; ".join(
    f"{name}: {PLANTS[name].about}" for name in PLANTS.names
)
CONTROLLERS_HELP = (
    "Names or files of your own; if not given, all that follow the task, with a loop that is stable at this rate. "
    "Options of simulate follow a colon: pid:omega-n=20:velocity-error; wrappers a plus: pid+friction."
)
TUNED_HELP = (
    "Give each controller its largest omega-n with |S_ii| <= PEAK at poses of the task, rigid with a delay of 1 to 4 "
    "samples, and with elastic gears if the arm has them."
)
FRICTION_HELP = (
    "Coulomb friction of an arm that gives none, a share of its torque limits: of the plant `friction`, and known to "
    "wrappers such as pid+friction."
)
OWN = [
    option("--controllers", CONTROLLERS_HELP, str, metavar="A,B:OPTION=VALUE,FILE.py"),
    NO_CODE,
    option("--plants", PLANTS_HELP, str, "nominal", metavar="A,B=VALUE,A+B"),
    option("--task", TASK_HELP, OneOf(REFERENCES.names)),
    option("--tuned", TUNED_HELP, float, metavar="PEAK"),
    option("--friction-share", FRICTION_HELP, float, metavar="SHARE"),
    option("--rate", "Samples a second.", float, 1000.0),
    option("--no-stops", "Let joints pass their position limits."),
    option("--twice", "Follow the task twice, 3 s back between; the second pass is compared."),
    shared("--jobs", default=1),
    shared("--out", " the runs there, as .npz", form=FOLDER),
    option("--label labels", "Name of a run file; once per file.", str, metavar="TEXT", multiple=True),
    shared("--html"),
    option("--replay", "Write a page that replays any two of the runs side by side.", str, metavar="FILE"),
    option("--markdown", "One table in Markdown, plants down and controllers across: RMS, mm."),
    shared("--json"),
]
OF_FILES = ("targets", "labels", "html", "replay", "markdown", "json")
"""What run files can be compared with; the rest is for a robot."""


PAGES: dict[str, Callable[[RunComparison], str]] = {"html": comparison_html, "replay": pair_html}
"""Option -> what makes its page."""


@click.command("compare")
@robot_options
def command(robot: tuple[str, ...], loading: Loading, **given: Any) -> None:
    """Compare run files, or simulate ROBOT under controllers x plants: the error of the tip, torques, the audit.

    Each plant is the arm of the controllers' model, changed in one thing that they do not know of.
    """
    pages = {given[name]: make for name, make in PAGES.items() if given[name] is not None}
    for page in pages:
        check_writable(page, ".html")
    files = [target for target in robot if ends_in(target, RUNS)]
    if files and len(files) < len(robot):
        raise OptionError("compare", "run files and a robot", "run files alone, or one robot")
    compared = _of_files(files, given) if files else _of_robot(robot, loading, given)
    write_files({Path(page): make(compared) for page, make in pages.items()})
    if given["markdown"] and not given["json"]:
        click.echo("\n".join([_markdown(compared), *(f"wrote {page}" for page in pages)]))
    else:
        show(compared.document, given["json"], pages)


command.params = [p for p in command.params if p.name != "robot"]
TASKS = row_options(REFERENCES, "task", [*command.params, *OWN])
command.params = [
    click.Argument(["robot"], nargs=-1, required=True, metavar="RUN.npz OTHER.npz ... | ROBOT"),
    *command.params, *OWN[:4], *TASKS.click_options(), *OWN[4:],
]  # fmt: skip


def _markdown(compared: RunComparison) -> str:
    """The table and, below it, why a pair has no run or is not ranked."""
    below = "".join(f"\n- {one}" for one in compared.failures)
    return cross_table(compared.record()["runs"]) + (f"\n{below}" if below else "")


def _of_files(files: list[str], given: dict[str, Any]) -> RunComparison:
    for name in (param.name or "" for param in click.get_current_context().command.params):
        if Flag(name, None).is_typed and name not in ("robot", *OF_FILES):
            flag = f"--{name.replace('_', '-')}"
            raise OptionError(flag, "would do nothing here", "with a robot, not with run files")
    runs = [Run.load(path) for path in files]
    compared = comparison_of(runs, [Path(path).name for path in files], given["labels"] or None)
    for one in compared.runs:
        stands_on(one.shown.arm, (*run_used(one.shown.run), ABSENT_ROTORS), ROTOR_RUN)
    return compared


def _of_robot(robots: tuple[str, ...], loading: Loading, given: dict[str, Any]) -> RunComparison:
    if len(robots) != 1:
        raise OptionError("compare", f"{len(robots)} robots", "one robot, or run files that end in .npz")
    if given["labels"]:
        raise OptionError("--label", "would do nothing here", "with run files")
    if given["task"] is not None:
        TASKS.refuse_unused(given["task"])
    arm = loading.arm(robots[0], (*(DYNAMICS if given["tuned"] is None else ALL), ABSENT_ROTORS))
    if given["friction_share"] is not None:
        arm = arm_with_friction(arm, given["friction_share"])
    controllers = _listed("--controllers", given["controllers"], CONTROLLERS.names)
    for text in controllers:
        controller_spec(text)
    check_code(controllers, given["no_code"])
    cases = [plant_case(arm, text) for text in _listed("--plants", given["plants"], ())]
    usual = task_of(TASKS, given, arm)
    if usual.words and not given["json"]:
        click.echo(usual.words, err=True)
    twice = Twice(usual.reference) if given["twice"] else None
    reference = usual.reference if twice is None else twice
    folder = None if given["out"] is None else make_folder(given["out"])
    fixed = (("rate", given["rate"]), ("position_limits", not given["no_stops"]))
    since = 0.0 if twice is None else twice.second
    task = usual.name + (" twice" if given["twice"] else "")
    study = ControllerStudy(
        arm, reference, controllers, cases, task, fixed, since, given["tuned"], folder=folder,
        lenient=given["controllers"] is None,
    )  # fmt: skip
    with progress("comparing") as report:
        return study.run(report, given["jobs"])[0]


def _listed(option: str, text: str | None, default: tuple[str, ...]) -> list[str]:
    """Texts separated by commas; raises `OptionError` for an empty list or one that stands twice."""
    parts = list(default) if text is None else [part.strip() for part in text.split(",")]
    if not parts or not all(parts):
        raise OptionError(option, repr(text), "names separated by commas")
    for part in parts:
        if parts.count(part) > 1:
            raise OptionError(option, f"{part} twice", "each once")
    return parts
