"""`lwr-dyn new`: commented files to start from, each kind a row of `KINDS`."""

import os
import re
from importlib.resources import files
from pathlib import Path

import click

from lwr_dyn.arms.loading import load
from lwr_dyn.arms.papers.catalog import template
from lwr_dyn.cli.main import RegistryGroup
from lwr_dyn.cli.options import OneOf, option, tip_option
from lwr_dyn.cli.vocabulary import shared
from lwr_dyn.foundation.errors import FileAccessError, OptionError
from lwr_dyn.foundation.files import ends_in, write_file
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.chain import Convention
from lwr_dyn.studies.sweep.study_template import study_template

KINDS: Registry[click.Command] = Registry(
    "new",
    {
        "arm": Row("lwr_dyn.cli.new:arm", "A data file for your own arm."),
        "paper": Row("lwr_dyn.cli.new:paper", "A data file with the results that a paper prints."),
        "controller": Row("lwr_dyn.cli.new:controller", "A Python file for your own controller."),
        "cell": Row("lwr_dyn.cli.krl.options:new_cell", "What stands around a KRL program.", extra="krl"),
        "study": Row("lwr_dyn.cli.new:study", "A study of many closed loops."),
    },
)
"""What `lwr-dyn new` can write."""


@click.group("new", cls=RegistryGroup, registry=KINDS)
def command() -> None:
    """Write a commented file to start from; it runs as it stands."""


JOINTS = option("--joints", "R (turning) or P (sliding) per joint, base outward.", str, "RRRRRR")
CONVENTION = shared("--convention", default="standard", kind=OneOf([c.value for c in Convention]))


@click.command("arm", params=[JOINTS, CONVENTION])
@click.argument("file")
def arm(file: str, joints: str, convention: str) -> None:
    """Write a data file for your own arm; every command takes it instead of a name."""
    path = new_file(file, ".toml")
    write_file(path, template(file, path.stem, joints.upper(), convention))
    click.echo(f"wrote {file}; next: fill it in, then  lwr-dyn check {file}")


@click.command("paper", params=[JOINTS, CONVENTION])
@click.argument("file")
def paper(file: str, joints: str, convention: str) -> None:
    """Write a data file for a paper's arm and the results that it prints; `reproduce` computes them again."""
    path = new_file(file, ".toml")
    write_file(path, paper_template(file, path.stem, joints.upper(), convention))
    click.echo(f"wrote {file}; next: fill it in, then  lwr-dyn reproduce {file}")


EXAMPLES = (
    ("mass", "Table 4, total", "total_mass", ("kg", "kg"), ".1f"),
    ("b{k}{k}", "Table 5, b{k}{k}", "mass_matrix[{k},{k}]", ("kg m^2", "kg"), ".4f"),
    ("g{k}", "Table 5, g{k}", "gravity[{k}]", ("N m", "N"), ".3f"),
    ("share", "conclusion: share of motor {k}", "abs(gravity[{k}]) / limits.effort[{k}]", ("%", "%"), ".2f"),
    ("height", "Figure 2, height of the flange", "pose[3]", ("m", "m"), ".3f"),
)
"""Id, place, what it is, unit where joint k turns or slides, and format of the results in a new paper."""


def paper_template(file: str, name: str, joints: str = "RRRRRR", convention: str = "standard") -> str:
    """The text of a commented paper: an arm as of `template`, and results that follow from it. Raises as `template`.

    >>> 'compute = "mass_matrix[2,2]"' in paper_template("x.toml", "x", "RP")
    True
    """
    from lwr_dyn.reproduction.named_results import QUANTITIES
    from lwr_dyn.reproduction.own_paper import FEW

    tables = template(file, name, joints, convention)
    text = (files("lwr_dyn.cli") / "new_paper.txt").read_text(encoding="utf-8")
    listed = (f"  {key:16} {quantity.about}" for key, quantity in QUANTITIES.items())
    texts = {"file": file, "quantities": "\n#              ".join(listed), "results": _example_results(tables, joints)}
    texts |= {
        "few": str(FEW),
        "zeros": str([0] * len(joints)),
        "ends": str([30 if letter == "R" else 0.1 for letter in joints]),
    }
    for key, value in texts.items():
        text = text.replace(f"@@{key}@@", value)
    return tables + text


def _example_results(tables: str, joints: str) -> str:
    """The `[[result]]` tables of `EXAMPLES`, as they follow from a data file's text."""
    import numpy as np

    from lwr_dyn.arms.papers.assembly import arm_from_paper
    from lwr_dyn.arms.papers.reader import parse_paper
    from lwr_dyn.checks.tables.arithmetic import unit_of
    from lwr_dyn.reproduction.named_results import formula_of

    read, k = parse_paper(tables, "template"), min(2, len(joints))
    arm, q = arm_from_paper(read), [30 if letter == "R" else 0 for letter in joints]
    state = np.radians(q)
    out = []
    for name, where, what, units, form in EXAMPLES:
        formula, unit = formula_of(what.format(k=k), read), units["RP".index(joints[k - 1])]
        x = formula.value(read, lambda: arm, {"q": state}) / getattr(unit_of(unit), "factor", 1.0)
        printed = f"{float(f'{x:{form}}') + 0.0:{form}}"  # no -0.000
        lines = [f'id = "{name.format(k=k)}"', f'where = "{where.format(k=k)}"', f'printed = "{printed}"']
        lines += [f'unit = "{unit}"', f'compute = "{formula.text}"', *([f"q_deg = {q}"] if formula.takes else [])]
        out.append("\n".join(["[[result]]", *lines]))
    return "\n\n".join(out) + "\n"


@click.command("controller")
@click.argument("file")
def controller(file: str) -> None:
    """Write a Python file with a controller of your own; `simulate --controller` takes it instead of a name."""
    path = new_file(file, ".py")
    text = (files("lwr_dyn.cli") / "new_controller.txt").read_text(encoding="utf-8")
    write_file(path, text.replace("@@file@@", file))
    click.echo(f"wrote {file}; next: edit it, then  lwr-dyn simulate lwr4plus --controller {file}")


def new_file(file: str, ending: str) -> Path:
    """The path of a file to write; raises `FileAccessError` for another ending, an odd name, or a file that exists."""
    path = Path(file)
    if path.suffix != ending:
        raise FileAccessError(file, f"ends in {path.suffix or 'nothing'!r}", f"a path that ends in {ending}")
    if not re.fullmatch(r"[\w.-]+", path.stem):
        raise FileAccessError(file, "a name with other characters", "letters, digits, '.', '_' and '-'")
    if path.exists():
        raise FileAccessError(file, "exists already", "a new file")
    return path


@click.command("study")
@click.argument("file")
@click.argument("robot", required=False)
@click.option("--reading", help="How to read the tables of ROBOT; the paper's default if not given.")
@tip_option
def study(file: str, robot: str | None, reading: str | None, tip: str | None) -> None:
    """Write a study: which loops, what varies, how many runs; `lwr-dyn sweep` runs it.

    For ROBOT: its task, its laws, its load and the steps of its friction fit it. For the LWR 4+ if none is given.
    """
    path = new_file(file, ".toml")
    for option_name, given in (("--reading", reading), ("--tip", tip)):
        if robot is None and given is not None:
            raise OptionError(option_name, "would do nothing here", "with a robot behind FILE")
    arm = None if robot is None else load(robot, reading, tip=tip)
    write_file(path, study_template(file, path.stem, _named(robot, path), arm))
    click.echo(f"wrote {file}; next: edit it, then  lwr-dyn sweep {file} --out {path.stem}")


def _named(robot: str | None, study: Path) -> str | None:
    """How a study names its robot: a file by its path from the study's folder."""
    if robot is None or not Path(robot).is_file():
        return robot
    if not ends_in(robot, ".toml", ".urdf", ".xacro"):
        raise FileAccessError(robot, "no file that a study reads", "a .toml, .urdf or .xacro, or a robot's name")
    return os.path.relpath(robot, study.parent).replace(os.sep, "/")
