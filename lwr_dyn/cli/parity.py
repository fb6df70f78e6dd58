"""`lwr-dyn parity`: what Pinocchio, MuJoCo, Drake, PyBullet and yourdfpy make of a model file."""

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import click
import numpy as np

from lwr_dyn.arms.loading import load
from lwr_dyn.arms.papers.catalog import readings, robots
from lwr_dyn.arms.urdf.model_files import model_stem
from lwr_dyn.arms.urdf.writer import urdf_text
from lwr_dyn.checks.engines.engine import ENGINES, is_installed
from lwr_dyn.checks.engines.losses import as_urdf
from lwr_dyn.checks.engines.survey import ModelReport, document, markdown, matrix, survey
from lwr_dyn.cli.options import Loading, OneOf, robot_options, show, stands_on
from lwr_dyn.cli.vocabulary import with_shared
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.foundation.files import ends_in, write_file
from lwr_dyn.foundation.progress import Report, progress
from lwr_dyn.model.arm import Arm


@click.command("parity")
@robot_options
@click.option("--only", "engines", multiple=True, type=OneOf(ENGINES.names), help="Only this engine. Repeatable.")
@with_shared("--json as_json")
@with_shared("--markdown as_markdown", ", a row a feature and a column an engine")
def command(robot: str, loading: Loading, engines: tuple[str, ...], as_json: bool, as_markdown: bool) -> None:
    """What engines ignore or misread of ROBOT's URDF, measured by loading it, and which file or option restores it.

    ROBOT may be `all`: every robot and reading of this package. A .urdf is taken as it stands; with --mount or --tool,
    and of a robot by name, the file is the one that `lwr-dyn urdf` writes.
    """
    if as_json and as_markdown:
        raise OptionError("--json, --markdown", "both given", "one of them")
    for engine in engines:
        if not is_installed(engine):
            raise MissingPackageError(ENGINES[engine].facts["package"], ENGINES[engine].extra)
    chosen = engines or ENGINES.names
    with progress("loading models into the engines") as report:
        reports = list(_all(chosen, report)) if robot == "all" else [_one(robot, loading, chosen)]
    if as_markdown:
        click.echo(markdown(matrix(reports)))
    else:
        show(document(reports), as_json)


def _one(robot: str, loading: Loading, engines: Sequence[str]) -> ModelReport:
    arm = loading.arm(robot)
    given = arm.loaded_with
    if not ends_in(robot, ".urdf", ".xacro") or given.keys() & {"mount", "tool", "rotor"}:
        return _written(arm, engines)
    with as_urdf(Path(robot), given) as path:
        return survey(path, loading.tip, given.get("lock", {}), engines)


def _all(engines: Sequence[str], report: Report) -> Iterator[ModelReport]:
    for robot in robots():
        for reading in readings(robot):
            report(f"{robot}, reading {reading}")
            yield _written(stands_on(load(robot, reading)), engines)


def _written(arm: Arm, engines: Sequence[str]) -> ModelReport:
    """The file that `lwr-dyn urdf` writes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{model_stem(arm)}.urdf"
        write_file(path, urdf_text(arm))
        report = survey(path, engines=engines)
    if not arm.friction:
        return replace(report, unwritten="")
    largest = float(np.abs(report.reference.friction(arm)).max())
    text = f"friction that differs by direction is in none, up to {largest:.2g} N m; see .provenance.json"
    return replace(report, unwritten=text)
