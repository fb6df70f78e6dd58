"""What a study is made of: its arm, its task's references, its controllers; each built when it is needed."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from inspect import signature
from itertools import product
from pathlib import Path
from typing import Any

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.control.controller_specs import ControllerSpec, controller_spec
from lwr_dyn.control.controllers import CONTROLLERS
from lwr_dyn.control.laws.assumed_friction import arm_with_friction
from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.errors import FaultError, LwrDynError, MissingPackageError, PaperError, UnknownNameError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.run import Reference
from lwr_dyn.studies.sweep.study.study_file import SweepStudy
from lwr_dyn.trajectory.references.tasks import REFERENCES

MOST_REFERENCES = 64
"""Of one study: values of the options of its task, in every combination."""


@contextmanager
def field_of(file: str, field: str) -> Iterator[None]:
    """Gives errors the file and the field that they come from; a missing package keeps its own words."""
    try:
        yield
    except (PaperError, MissingPackageError):
        raise
    except UnknownNameError as fault:
        found, _, known = str(fault).partition("; known: ")
        raise PaperError(file, field, found, known) from fault
    except FaultError as fault:
        raise PaperError(file, field, f"{fault.name}: {fault.found}", fault.allowed) from fault
    except LwrDynError as fault:
        raise PaperError(file, field, str(fault), "another value") from fault


def arm_of_study(study: SweepStudy, reading: str | None = None) -> Arm:
    """The arm as the controllers know it, or as another reading has it; raises as `lwr_dyn.load`."""
    content = study.sources.get(Path(study.robot).name, "")
    return _arm(study.robot, study.reading if reading is None else reading, study.assumed_friction, content)


@lru_cache(maxsize=8)
def _arm(robot: str, reading: str, share: float | None, content: str) -> Arm:
    """`content` makes a file that has changed another arm."""
    arm, _ = load_with_paper(robot, reading or None)
    return arm if share is None else arm_with_friction(arm, share)


def references_of_study(study: SweepStudy) -> tuple[Reference, ...]:
    """The task's reference; several where options of the task vary, in the order of `task_choices`.

    Raises as the task's factory.
    """
    options = [{**study.task_options, **choice} for choice in task_choices(study)]
    arm = arm_of_study(study)
    return tuple(REFERENCES.make(study.task, arm, **each) for each in options)


def task_choices(study: SweepStudy) -> list[dict[str, Any]]:
    """Values of the options of the task that the study gives, in every combination, the last fastest."""
    given = {option_name(one.path): one.values for one in study.parameters if is_task(one.path)}
    return [dict(zip(given, values, strict=True)) for values in product(*given.values())]


def is_task(path: str) -> bool:
    """Whether a path is an option of the task."""
    return path.startswith("task.")


def option_name(path: str) -> str:
    """The keyword of an option of the task or of the controllers.

    >>> option_name("controller.omega-n")
    'omega_n'
    """
    return path.partition(".")[2].replace("-", "_")


def spec_of_study(study: SweepStudy, text: str) -> ControllerSpec:
    """The controller of a text; a Python file is looked for beside the study's file. Raises as `controller_spec`."""
    spec = controller_spec(text)
    if not spec.is_file:
        return spec
    place = str((Path(study.file).parent / spec.base).resolve()) if study.file else spec.base
    return ControllerSpec(text, place, spec.options, spec.wrappers)


def try_controller(study: SweepStudy, text: str, options: Mapping[str, Any]) -> None:
    """Make a controller to see that it can be made; without the search for its gains. Raises as `make_controller`."""
    arm, spec = arm_of_study(study), spec_of_study(study, text)
    unit = {"inertia": [1.0] * arm.n} if takes_inertia(spec) else {}
    spec.make(arm, dynamics_of(arm), {**unit, **options})


def takes_inertia(spec: ControllerSpec) -> bool:
    """Whether a controller's gains are made from the largest inertia of each joint."""
    return not spec.is_file and "inertia" in signature(CONTROLLERS.load(spec.base)).parameters


def controller_of_study(study: SweepStudy, text: str, options: Mapping[str, Any] | None = None) -> Controller:
    """A new controller of the study; `options` are added to those of its text. Raises as `make_controller`."""
    arm = arm_of_study(study)
    return spec_of_study(study, text).make(arm, dynamics_of(arm), options)
