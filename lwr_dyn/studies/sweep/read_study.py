"""Reads a study's file: TOML, strict; what is wrong is one line with the file and the field."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import compress
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.arms.loading import ONE_READING
from lwr_dyn.control.controllers import code_files, controller_spec
from lwr_dyn.foundation.errors import FileAccessError, did_you_mean
from lwr_dyn.foundation.fields import Fields, parse_toml
from lwr_dyn.foundation.files import ends_in, read_text
from lwr_dyn.foundation.registry import REQUIRED, Option, Quantity, Registry, options_of
from lwr_dyn.model.arm import Arm, si_value
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import Loop
from lwr_dyn.studies.sweep import sweep_study
from lwr_dyn.studies.sweep.read_parameters import blamed, checked_parameters, read_parameters
from lwr_dyn.studies.sweep.sampling import FEW, METHODS
from lwr_dyn.studies.sweep.sweep_study import SweepStudy
from lwr_dyn.studies.sweep.vocabulary import metric_row
from lwr_dyn.trajectory.references.references import REFERENCES

NEEDED = "a study, as `lwr-dyn new study` writes it"
CUTOFF_HZ = 100.0
ON_LEVELS = "values, levels (low, high, count) or a fixed value"
LISTS = {Quantity.ANGLES: 3, Quantity.POINT: 3}
"""Options that are lists, and how many numbers they have; joint positions have one a joint."""


def read_study(path: str | Path, before_code: Callable[[str], None] = lambda _: None) -> SweepStudy:
    """The study of a `.toml` file, checked against its arm, task and controllers; nothing is simulated.

    A controller in a Python file is made once, which runs the file: `before_code(path)` may say so, or raise.

    Raises
    ------
    FileAccessError
        A file that cannot be read, or does not end in .toml.
    PaperError
        What is wrong in which field.
    MissingPackageError
        A task or a controller of an optional package whose dependency is not installed.
    """
    if not ends_in(path, ".toml"):
        raise FileAccessError(str(path), "does not end in .toml", NEEDED)
    return study_of_text(read_text(path, NEEDED), Path(path), before_code)


def study_of_text(text: str, path: Path, before_code: Callable[[str], None] = lambda _: None) -> SweepStudy:
    """The study of a file's text; files that it names are looked for beside `path`. Raises as `read_study`."""
    fields = Fields(parse_toml(text, path.name), path.name)
    if "joints" in fields.unread():
        raise fields.refuse("joints", "a robot's tables", "a study (lwr-dyn new study FILE ROBOT writes one)")
    study = _base(fields, path, text)
    loop, sampling, metrics, limits = (fields.table(name, {}) for name in ("loop", "sampling", "metrics", "limits"))
    tables, given = fields.tables("parameter", []), fields.table("task")
    fields.refuse_unknown()
    with blamed(fields, "robot"):
        arm = sweep_study.arm_of_study(study)
        arm.require_dynamics()
    task = read_task(given, path.parent, arm)
    parameters = read_parameters(tables, arm.n)
    study = replace(study, task=task.name, task_options=task.options, parameters=parameters)
    study = _with_loop(loop, study, arm)
    study = _with_files(study, task.files)
    study = _with_controllers(fields, study, path.parent, before_code)
    study = checked_parameters(study, arm, fields, tables)
    lacking = missing_option(task, set(sweep_study.task_choices(study)[0]))
    if lacking is not None:
        raise fields.refuse(f"task.{lacking}", "missing", f"a value, which the task {task.name} needs")
    study = _sampled(fields, sampling, study)
    study = _measured(metrics, limits, study, arm)
    with blamed(fields, "task"):
        for reference in sweep_study.references_of_study(study):
            _options(study).times(study.loop.get("duration", reference.duration))
    return study


def _base(fields: Fields, path: Path, text: str) -> SweepStudy:
    """Robot, controllers and friction that is assumed."""
    robot, name = fields.take("robot", str), fields.take("name", str, path.stem)
    files: tuple[Path, ...] = ()
    if ends_in(robot, ".toml", *ONE_READING):
        files = (path.parent / robot,)
        robot = str(files[0].resolve())
    share = fields.number("assumed_friction", None, above=0.0)
    reading, texts = fields.take("reading", str, ""), fields.texts("controllers")
    study = SweepStudy(
        name, robot, reading, texts, "", tip=fields.take("tip", str, None), runs=1, assumed_friction=share,
        file=str(path), text=text,
    )  # fmt: skip
    with blamed(fields, "robot"):
        return _with_files(study, files)


def _with_files(study: SweepStudy, files: Iterable[Path], name: str = "") -> SweepStudy:
    """With the SHA-256 of files, by `name`, or their own ones; raises `FileAccessError`."""
    sources, places = dict(study.sources), dict(study.places)
    for each in files:
        sources[name or each.name] = places[str(each.resolve())] = sweep_study.digest_of(str(each))
    return replace(study, sources=sources, places=places)


def _with_controllers(
    fields: Fields, study: SweepStudy, folder: Path, before_code: Callable[[str], None]
) -> SweepStudy:
    """With the files of controllers by path as given; each is made once, but a file may need options that vary."""
    for i, text in enumerate(study.controllers):
        with blamed(fields, f"controllers[{i}]"):
            spec = controller_spec(text)
            if spec.is_file:
                study = _with_files(study, [folder / spec.base], spec.base)
    for path in code_files(sweep_study.spec_of_study(study, text).base for text in study.controllers):
        before_code(path)
    varied = any(one.path.startswith("controller.") for one in study.parameters)
    for i, text in enumerate(study.controllers):
        with blamed(fields, f"controllers[{i}]"):
            if not (varied and controller_spec(text).is_file):
                sweep_study.try_controller(study, text, {})
    return study


def _with_loop(table: Fields, study: SweepStudy, arm: Arm) -> SweepStudy:
    """`[loop]`: how every loop is closed and computed."""
    varied = {one.path.partition(".")[0] for one in study.parameters}
    friction = "smooth" if "friction" in varied or arm.has_friction else "none"
    loop: dict[str, Any] = {
        "rate": table.number("rate", 1000.0, above=0.0),
        "substeps": table.take("substeps", int, 1),
        "friction": table.choice("friction", ("none", "smooth"), friction),
        **{key: table.number(key, None, above=0.0) for key in ("duration", "friction_width")},
        **{key: table.take(key, bool, None) for key in ("saturate", "position_limits", "hand_over")},
    }
    cutoff = table.number("cutoff_hz", None, above=0.0)
    table.refuse_unknown()
    given = {key: value for key, value in loop.items() if value is not None}
    study = replace(study, loop=given, cutoff_hz=cutoff or CUTOFF_HZ)
    with blamed(table):
        _options(study)
        if "sensor" in varied or cutoff is not None:
            Encoder(cutoff_hz=study.cutoff_hz).velocity_filter(loop["rate"])
    return study


def _options(study: SweepStudy) -> Loop:
    return Loop(rate=study.loop["rate"], substeps=study.loop["substeps"])


def _sampled(whole: Fields, table: Fields, study: SweepStudy) -> SweepStudy:
    """`[sampling]`: how the runs are drawn, how many, in which chunks."""
    method = table.choice("method", METHODS, "sobol" if len(study.levels) <= FEW else "latin-hypercube")
    facts = {key: table.take(key, int, default) for key, default in (("seed", 0), ("chunk", 500), ("keep", 3))}
    if method == "grid":
        for i, one in enumerate(study.parameters):
            if not one.values:
                found = f"{one.distribution} in a grid"
                raise whole.refuse(f"parameter[{i}].distribution", found, ON_LEVELS)
    runs = table.take("runs", int, prod(study.levels) if method == "grid" else 256)
    table.refuse_unknown()
    with blamed(table):
        return replace(study, method=method, runs=runs, **facts)


def _measured(table: Fields, fields: Fields, study: SweepStudy, arm: Arm) -> SweepStudy:
    """`[metrics]` and `[limits]`: what is measured of a run beside the usual, and what is asked of it."""
    tolerance, shares = table.number("tolerance", None, above=0.0), table.numbers("quantiles", ())
    table.refuse_unknown()
    for i, share in enumerate(shares):
        if not 0.0 < share < 1.0:
            raise table.refuse(f"quantiles[{i}]", repr(share), "a share between 0 and 1, as 0.95")
    limits = {}
    for name in fields.unread():
        bound = fields.take(name, object)
        with blamed(fields, name):
            row = metric_row(name, shares)
        allowed = f"a number{'' if row.signed else ' from 0 on'}, in {row.unit}"
        limits[name] = fields.number_at(name, bound, allowed)
        if limits[name] < 0.0 and not row.signed:
            raise fields.refuse(name, repr(bound), allowed)
        if row.needs_effort and not np.isfinite(arm.effort).all():
            of = ", ".join(compress(arm.joint_names, ~np.isfinite(arm.effort)))
            raise fields.refuse(name, f"torque limits of {of} are unknown", "peak_torque, in N m or N, in its place")
    if "first_violation" in limits and tolerance is None:
        raise fields.refuse("first_violation", "without a tolerance", "metrics.tolerance beside it, in m")
    return replace(study, tolerance=tolerance, quantiles=shares, limits=limits)


@dataclass(frozen=True, slots=True)
class TaskFields:
    """A task, its options by keyword in rad and m, and the files that they name."""

    name: str
    options: Mapping[str, Any]
    files: tuple[Path, ...]


def read_task(fields: Fields, folder: Path, arm: Arm) -> TaskFields:
    """The `[task]` table, its options by the names that they have in `lwr-dyn simulate`; raises `PaperError`."""
    name = fields.text("name")
    with blamed(fields, "name"):
        known = {option.flag_name: option for option in options_of(REFERENCES.load(name)).values()}
    options, files = {}, []
    for key in fields.unread():
        written = key.replace("_", "-")
        if written not in known:
            raise fields.refuse(key, f"unknown field{did_you_mean(written, known)}", ", ".join(["name", *known]))
        option = known[written]
        value = _option_value(fields, key, fields.take(key, object), option, arm)
        if isinstance(value, str) and (folder / value).is_file():
            value = str((folder / value).resolve())
            files.append(Path(value))
        options[option.keyword] = value
    return TaskFields(name, options, tuple(files))


def missing_option(task: TaskFields, varied: set[str]) -> str | None:
    """An option that the task needs, and that is neither given nor varied, by its name in the file."""
    for option in options_of(REFERENCES.load(task.name)).values():
        if option.default is REQUIRED and option.keyword not in {*task.options, *varied}:
            return option.flag_name
    return None


def _option_value(fields: Fields, key: str, value: Any, option: Option, arm: Arm) -> Any:
    """A value as the task's factory takes it."""
    kind, words = option.kind, option.help.rstrip(".")
    if kind is bool:
        if not isinstance(value, bool):
            raise fields.refuse(key, repr(value), "true or false")
        return (not option.default) if value else option.default
    if kind in (int, float, Quantity.ANGLE):
        number = fields.number_at(key, value, f"a number ({words})")
        if kind is int and number % 1.0:
            raise fields.refuse(key, repr(value), f"a whole number ({words})")
        return float(np.radians(number)) if kind is Quantity.ANGLE else kind(number)
    if isinstance(kind, Quantity):
        return _list_value(fields, key, value, option, arm)
    if not isinstance(value, str):
        raise fields.refuse(key, repr(value), f"a text ({words})")
    if isinstance(kind, Registry):
        with blamed(fields, key):
            kind[value]
    return value


def _list_value(fields: Fields, key: str, value: Any, option: Option, arm: Arm) -> Any:
    count = LISTS.get(option.kind, arm.n)
    allowed = f"{count} numbers" + ("" if option.kind in LISTS else f", one a joint of {arm.name}")
    if not isinstance(value, list) or len(value) != count:
        found = f"{len(value)} numbers" if isinstance(value, list) else repr(value)
        raise fields.refuse(key, found, f"a list of {allowed} ({option.help.rstrip('.')})")
    numbers = np.array([fields.number_at(f"{key}[{i}]", x) for i, x in enumerate(value)])
    if option.kind is Quantity.POINT:
        return numbers
    return si_value(option, tuple(numbers.tolist()), arm, f"--{key}")
