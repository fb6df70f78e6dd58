"""From values of a study's paths to the keywords of `lwr_dyn.rollouts`, for one of its controllers."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from lwr_dyn.codegen.rollouts.laws.protocol import LawForm
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import with_payload
from lwr_dyn.simulation.sensors import Encoder
from lwr_dyn.studies.sweep.study.distributions import Values
from lwr_dyn.studies.sweep.study.parameter_paths import AXES
from lwr_dyn.studies.sweep.study.plant_rows import plant_parameters, rows_of
from lwr_dyn.studies.sweep.study.study_file import SweepStudy
from lwr_dyn.studies.sweep.study.study_setup import (
    arm_of_study,
    is_task,
    option_name,
    spec_of_study,
    takes_inertia,
)

OWN_LOAD = ("robust",)
"""Controllers whose model holds a load of its own, the middle of their set: a known payload is not added to it."""


def rollout_arguments(study: SweepStudy, text: str, values: Mapping[str, Values]) -> dict[str, Any]:
    """Keywords of `lwr_dyn.rollouts`, all but arm, controller, reference, runs, threads, first_run and record.

    Parameters
    ----------
    study : SweepStudy
    text : str
        The controller, as the study has it. One in a Python file has no gains and no model among the parameters: they
        come with `controller_of_run`.
    values : mapping
        By path, any runs: (runs,) or (runs, k), as `SweepStudy.values` gives them.

    Raises
    ------
    OptionError
        An option of the controller that its factory refuses, or that changes more than its gains.
    NoKernelFormError
        A controller without a kernel form whose options vary.
    """
    spec = spec_of_study(study, text)
    parameters = plant_parameters(study, values)
    if not spec.is_file:
        parameters |= _known_payload(values, spec.base) | _gains(study, text, values)
    if any(is_task(path) for path in values):
        parameters["reference"] = _references(study, values)
    sensed = any(path.startswith("sensor.") for path in values)
    return {
        **study.loop,
        "parameters": parameters,
        "encoder": Encoder(cutoff_hz=study.cutoff_hz) if sensed else None,
        "seed": study.seed,
        "tolerance": study.tolerance,
        "quantiles": study.quantiles,
    }


def controller_of_run(study: SweepStudy, text: str, values: Mapping[str, Values], index: int = 0) -> Controller:
    """The controller of run `index` of these values, with its options and its payload; for one in a Python file.

    Raises as `make_controller`.
    """
    arm, spec = arm_of_study(study), spec_of_study(study, text)
    known = {} if spec.base in OWN_LOAD else _known_payload(values, spec.base)
    if known:
        com = known.get("model_payload_com", np.zeros((index + 1, len(AXES))))
        arm = arm.with_chain(with_payload(arm.chain, float(known["model_payload"][index]), com[index]))
    options = {option_name(path): float(values[path][index]) for path in _options(values)}
    return spec.make(arm, dynamics_of(arm), options)


def _options(values: Mapping[str, Values]) -> list[str]:
    return [path for path in values if path.startswith("controller.")]


def _known_payload(values: Mapping[str, Values], base: str) -> dict[str, Array]:
    """What the controller's model has of the payload."""
    if "payload.known" not in values or base in OWN_LOAD:
        return {}
    known = {"model_payload": np.asarray(values["payload.known"], float) * np.asarray(values["payload.mass"], float)}
    com = rows_of(values, "payload.com", (len(AXES),), 0.0)
    return known if com is None else {**known, "model_payload_com": com}


def _references(study: SweepStudy, values: Mapping[str, Values]) -> Array:
    """Number of each run's reference in `references_of_study`."""
    index = 0
    for one in (one for one in study.parameters if is_task(one.path)):
        drawn = np.asarray(values[one.path], float)[:, None]
        index = index * len(one.values) + np.abs(drawn - np.asarray(one.values, float)).argmin(axis=1)
    return np.asarray(index, dtype=np.float64)


@lru_cache(maxsize=4)
def _largest_inertias(arm: Arm) -> tuple[float, ...]:
    """The largest inertias of the joints, for gains that are made many times."""
    return tuple(one.value for one in worst_case_inertias(arm))


def _gains(study: SweepStudy, text: str, values: Mapping[str, Values]) -> dict[str, Array]:
    """The gains of every run by the names of the controller's kernel form: each set of options is made once."""
    paths = _options(values)
    if not paths:
        return {}
    from lwr_dyn.codegen.rollouts.laws.forms import law_form, unchecked_form

    arm, spec = arm_of_study(study), spec_of_study(study, text)
    dynamics, fixed = dynamics_of(arm), {"inertia": _largest_inertias(arm)} if takes_inertia(spec) else {}
    rows, which = np.unique(
        np.stack([np.asarray(values[p], float) for p in paths], axis=1), axis=0, return_inverse=True
    )
    forms: list[LawForm] = []
    for row in rows:
        options = dict(zip(map(option_name, paths), row.tolist(), strict=True))
        form = unchecked_form if forms else law_form  # the first is compared with its controller
        forms.append(form(spec.make(arm, dynamics, {**fixed, **options}), arm))
    if len({form.digest for form in forms}) > 1:
        raise OptionError(", ".join(paths), f"changes more than the gains of {text}", "options that are gains")
    each = [form.values() for form in forms]
    return {name: np.stack([one[name] for one in each])[which.ravel()] for name in each[0]}
