"""What a parameter of a study is as modelled, where its path alone does not say it: friction, gains, tasks.

The `[task]` table of a study's file: a task and its options, by the names that they have in `lwr-dyn simulate`.

Reads a study's file: TOML, strict; what is wrong is one line with the file and the field.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lwr_dyn.control.controllers import CONTROLLERS, controller_spec
from lwr_dyn.foundation.errors import FileAccessError, PaperError, did_you_mean
from lwr_dyn.foundation.fields import Fields, parse_toml
from lwr_dyn.foundation.files import ends_in, read_text
from lwr_dyn.foundation.registry import REQUIRED, Option, Quantity, Registry, options_of
from lwr_dyn.model.arm import Arm, si_value
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.simulation.setup import SimulationOptions
from lwr_dyn.studies.sweep.read_parameters import (
    check_parameters,
    number_at,
    read_parameter,
    refuse_overlaps,
    take_number,
    take_numbers,
    take_texts,
)
from lwr_dyn.studies.sweep.sampling import METHODS, VariedParameter, grid_runs, usual_method
from lwr_dyn.studies.sweep.sweep_study import (
    SweepStudy,
    arm_of_study,
    digest_of,
    field_of,
    is_task,
    option_name,
    references_of_study,
    spec_of_study,
    try_controller,
)
from lwr_dyn.studies.sweep.vocabulary import metric_row
from lwr_dyn.trajectory.references.references import REFERENCES


def with_nominal_values(study: SweepStudy, arm: Arm) -> SweepStudy:
    """The study with the nominal value of each parameter; None where there is none, or one for each controller."""
    return replace(study, parameters=tuple(replace(one, nominal=_nominal(study, arm, one)) for one in study.parameters))


def _nominal(study: SweepStudy, arm: Arm, one: VariedParameter) -> float | None:
    if is_task(one.path):
        return _number(options_of(REFERENCES.load(study.task)).get(option_name(one.path)))
    if one.path.startswith("controller."):
        specs = [spec_of_study(study, text) for text in study.controllers]
        rows = [{} if spec.is_file else options_of(CONTROLLERS.load(spec.base)) for spec in specs]
        found = {_number(row.get(option_name(one.path))) for row in rows}
        return found.pop() if len(found) == 1 else None
    if one.path.startswith("friction.") and any(arm.friction_models()):
        assumed = study.assumed_friction
        return None if assumed is None else assumed if one.path.startswith("friction.coulomb") else 0.0
    return one.nominal


def _number(option: Option | None) -> float | None:
    """The default of an option that is a number."""
    is_number = option is not None and isinstance(option.default, int | float) and not isinstance(option.default, bool)
    return float(option.default) if option is not None and is_number else None


LISTS = {Quantity.ANGLES: 3, Quantity.POINT: 3}
"""Options that are lists, and how many numbers they have; joint positions have one a joint."""


@dataclass(frozen=True, slots=True)
class TaskFields:
    """A task, its options by keyword in rad and m, and the files that they name."""

    name: str
    options: Mapping[str, Any]
    files: tuple[Path, ...]


def read_task(table: Any, file: str, folder: Path, arm: Arm) -> TaskFields:
    """The task of a study's file; raises `PaperError`."""
    fields = Fields(table, file, "task")
    name = fields.take("name", str)
    with field_of(file, "task.name"):
        known = {option.flag_name: option for option in options_of(REFERENCES.load(name)).values()}
    options, files = {}, []
    for key in (key for key in table if key != "name"):
        written = key.replace("_", "-")
        if written not in known:
            found = f"unknown field{did_you_mean(written, known)}"
            raise PaperError(file, f"task.{key}", found, ", ".join(["name", *known]))
        option = known[written]
        value = _value(table[key], option, file, f"task.{key}", arm, name)
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


def _value(value: Any, option: Option, file: str, field: str, arm: Arm, task: str) -> Any:
    """A value as the task's factory takes it."""
    kind, words = option.kind, option.help.rstrip(".")
    if kind is bool:
        if not isinstance(value, bool):
            raise PaperError(file, field, repr(value), "true or false")
        return (not option.default) if value else option.default
    if kind in (int, float, Quantity.ANGLE):
        number = number_at(value, file, field, f"a number ({words})")
        if kind is int and number % 1.0:
            raise PaperError(file, field, repr(value), f"a whole number ({words})")
        return float(np.radians(number)) if kind is Quantity.ANGLE else kind(number)
    if isinstance(kind, Quantity):
        return _list(value, option, file, field, arm, task)
    return _text(value, option, file, field)


def _text(value: Any, option: Option, file: str, field: str) -> str:
    if not isinstance(value, str):
        raise PaperError(file, field, repr(value), f"a text ({option.help.rstrip('.')})")
    if isinstance(option.kind, Registry):
        with field_of(file, field):
            option.kind[value]
    return value


def _list(value: Any, option: Option, file: str, field: str, arm: Arm, task: str) -> Any:
    count = LISTS.get(option.kind, arm.n)
    allowed = f"{count} numbers" + ("" if option.kind in LISTS else f", one a joint of {arm.name}")
    if not isinstance(value, list) or len(value) != count:
        found = f"{len(value)} numbers" if isinstance(value, list) else repr(value)
        raise PaperError(file, field, found, f"a list of {allowed} ({option.help.rstrip('.')})")
    numbers = np.array([number_at(x, file, f"{field}[{i}]") for i, x in enumerate(value)])
    if option.kind is Quantity.POINT:
        return numbers
    key = field.partition(".")[2]
    return si_value(option, tuple(numbers.tolist()), arm, f"--{key}")


NEEDED = "a study, as `lwr-dyn new study` writes it"

FRICTIONS = ("none", "smooth")

CUTOFF_HZ = 100.0

ON_LEVELS = "values, levels (low, high, count) or a fixed value"


def read_study(path: str | Path) -> SweepStudy:
    """The study of a `.toml` file, checked against its arm, task and controllers; nothing is simulated.

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
    text = read_text(path, NEEDED)
    return study_of_text(text, Path(path))


def study_of_text(text: str, path: Path) -> SweepStudy:
    """The study of a file's text; files that it names are looked for beside `path`. Raises as `read_study`."""
    file = path.name
    fields = Fields(parse_toml(text, file), file, "")
    study = _base(fields, file, path, text)
    tables = {name: Fields(fields.take(name, dict, {}), file, name) for name in ("loop", "sampling", "metrics")}
    limits, listed = fields.take("limits", dict, {}), fields.take("parameter", list, [])
    given = fields.take("task", dict)
    fields.refuse_unknown()
    with field_of(file, "robot"):
        arm = arm_of_study(study)
        arm.require_dynamics()
    task = read_task(given, file, path.parent, arm)
    parameters = tuple(read_parameter(table, file, i, arm.n) for i, table in enumerate(listed))
    refuse_overlaps(parameters, file)
    study = replace(study, task=task.name, task_options=task.options, parameters=parameters)
    study = _with_loop(tables["loop"], study, arm, file)
    study = _with_files(study, task.files)
    study = _with_controller_files(study, path.parent, file)
    _try_controllers(study, file)
    check_parameters(study, arm, file)
    study = with_nominal_values(study, arm)
    lacking = missing_option(task, {option_name(one.path) for one in parameters if is_task(one.path)})
    if lacking is not None:
        raise PaperError(file, f"task.{lacking}", "missing", f"a value, which the task {task.name} needs")
    study = _sampled(tables["sampling"], study, file)
    study = _measured(tables["metrics"], limits, study, file)
    with field_of(file, "task"):
        for reference in references_of_study(study):
            _options(study).times(study.loop.get("duration", reference.duration))
    return study


def _base(fields: Fields, file: str, path: Path, text: str) -> SweepStudy:
    """Robot, controllers and friction that is assumed."""
    robot, name = fields.take("robot", str), fields.take("name", str, path.stem)
    files: tuple[Path, ...] = ()
    if ends_in(robot, ".toml", ".urdf", ".xacro"):
        files = (path.parent / robot,)
        robot = str(files[0].resolve())
    share = take_number(fields, "assumed_friction", file, above=0.0)
    reading, texts = fields.take("reading", str, ""), take_texts(fields, "controllers", file)
    study = SweepStudy(name, robot, reading, texts, "", runs=1, assumed_friction=share, file=str(path), text=text)
    with field_of(file, "robot"):
        return _with_files(study, files)


def _with_files(study: SweepStudy, files: Iterable[Path], name: str = "") -> SweepStudy:
    """With the SHA-256 of files, by `name`, or their own ones; raises `FileAccessError`."""
    sources, places = dict(study.sources), dict(study.places)
    for each in files:
        sources[name or each.name] = places[str(each.resolve())] = digest_of(str(each))
    return replace(study, sources=sources, places=places)


def _with_controller_files(study: SweepStudy, folder: Path, file: str) -> SweepStudy:
    """With the files of controllers by path as given; raises `PaperError` for one that does not exist."""
    for i, text in enumerate(study.controllers):
        with field_of(file, f"controllers[{i}]"):
            spec = controller_spec(text)
            if spec.is_file:
                study = _with_files(study, [folder / spec.base], spec.base)
    return study


def _try_controllers(study: SweepStudy, file: str) -> None:
    """Raise `PaperError` for a controller that cannot be made; a file may need options that are varied."""
    varied = any(one.path.startswith("controller.") for one in study.parameters)
    for i, text in enumerate(study.controllers):
        with field_of(file, f"controllers[{i}]"):
            if not (varied and controller_spec(text).is_file):
                try_controller(study, text, {})


def _with_loop(table: Fields, study: SweepStudy, arm: Arm, file: str) -> SweepStudy:
    """`[loop]`: how every loop is closed and computed."""
    varied = any(one.path.startswith("friction.") for one in study.parameters)
    default = "smooth" if varied or any(arm.friction_models()) else "none"
    loop: dict[str, Any] = {
        "rate": take_number(table, "rate", file, 1000.0, above=0.0),
        "substeps": table.take("substeps", int, 1),
        "friction": table.choice("friction", FRICTIONS, default),
    }
    for key in ("duration", "friction_width"):
        loop[key] = take_number(table, key, file, above=0.0)
    for key in ("saturate", "position_limits", "hand_over"):
        loop[key] = table.take(key, bool, None)
    given = take_number(table, "cutoff_hz", file, above=0.0)
    table.refuse_unknown()
    loop = {key: value for key, value in loop.items() if value is not None}
    study = replace(study, loop=loop, cutoff_hz=given or CUTOFF_HZ)
    has_encoders = any(one.path.startswith("sensor.") for one in study.parameters)
    with field_of(file, "loop"):
        _options(study)
        if has_encoders or given is not None:
            Encoder(cutoff_hz=study.cutoff_hz).velocity_filter(loop["rate"])
    return study


def _options(study: SweepStudy) -> SimulationOptions:
    return SimulationOptions(rate=study.loop["rate"], substeps=study.loop["substeps"])


def _sampled(table: Fields, study: SweepStudy, file: str) -> SweepStudy:
    """`[sampling]`: how the runs are drawn, how many, in which chunks."""
    method = table.choice("method", METHODS, usual_method(len(study.levels)))
    facts = {key: table.take(key, int, default) for key, default in (("seed", 0), ("chunk", 500), ("keep", 3))}
    if method == "grid":
        for i, one in enumerate(study.parameters):
            if not one.values:
                raise PaperError(file, f"parameter[{i}].distribution", f"{one.distribution} in a grid", ON_LEVELS)
    runs = table.take("runs", int, grid_runs(study.levels) if method == "grid" else 256)
    table.refuse_unknown()
    with field_of(file, "sampling"):
        return replace(study, method=method, runs=runs, **facts)


def _measured(table: Fields, given: Mapping[str, Any], study: SweepStudy, file: str) -> SweepStudy:
    """`[metrics]` and `[limits]`: what is measured of a run beside the usual, and what is asked of it."""
    tolerance = take_number(table, "tolerance", file, above=0.0)
    shares = take_numbers(table, "quantiles", file, ())
    table.refuse_unknown()
    for i, share in enumerate(shares):
        if not 0.0 < share < 1.0:
            raise PaperError(file, f"metrics.quantiles[{i}]", repr(share), "a share between 0 and 1, as 0.95")
    limits = {}
    for name, bound in given.items():
        with field_of(file, f"limits.{name}"):
            row = metric_row(name, shares)
        allowed = f"a number{'' if row.signed else ' from 0 on'}, in {row.unit}"
        limits[name] = number_at(bound, file, f"limits.{name}", allowed)
        if limits[name] < 0.0 and not row.signed:
            raise PaperError(file, f"limits.{name}", repr(bound), allowed)
    if "first_violation" in limits and tolerance is None:
        raise PaperError(file, "limits.first_violation", "without a tolerance", "metrics.tolerance beside it, in m")
    return replace(study, tolerance=tolerance, quantiles=shares, limits=limits)
