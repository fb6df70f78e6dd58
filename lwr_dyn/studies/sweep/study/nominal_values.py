"""What a parameter of a study is as modelled, where its path alone does not say it: friction, gains, tasks."""

from dataclasses import replace

from lwr_dyn.control.controllers import CONTROLLERS
from lwr_dyn.foundation.registry import Option, options_of
from lwr_dyn.model.arm import Arm
from lwr_dyn.studies.sweep.study.distributions import VariedParameter
from lwr_dyn.studies.sweep.study.study_file import SweepStudy
from lwr_dyn.studies.sweep.study.study_setup import is_task, option_name, spec_of_study
from lwr_dyn.trajectory.references.tasks import REFERENCES


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
