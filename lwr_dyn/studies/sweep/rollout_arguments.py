"""Values of a study's paths as the parameters of the plant that `lwr_dyn.rollouts` takes, a row a run.

From values of a study's paths to the keywords of `lwr_dyn.rollouts`, for one of its controllers.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.kernels.kernel_spec import FRICTION, TENSOR, friction_parameters
from lwr_dyn.codegen.rollouts.law_forms import LawForm
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, with_payload
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.studies.sweep.sampling import Values
from lwr_dyn.studies.sweep.sweep_study import (
    SweepStudy,
    arm_of_study,
    is_task,
    option_name,
    spec_of_study,
    takes_inertia,
)
from lwr_dyn.studies.sweep.vocabulary import ALL, AXES, parameter_path

PLAIN = {
    "payload.mass": "payload", "sensor.resolution": "resolution", "sensor.noise": "noise", "loop.delay": "delay",
}  # fmt: skip
"""Paths whose values are parameters of `rollouts` as they are."""

NO_LIMIT = 1e9
"""[N m] or [N] In place of an unknown torque limit, as in a URDF."""


def rows_of(values: Mapping[str, Values], name: str, shape: tuple[int, ...], start: float) -> Array | None:
    """Numbers of one path (runs, *shape), each `start` where the study gives none; None where it gives none at all.

    Parameters
    ----------
    values : mapping
        By path, as `SweepStudy.values` gives them.
    name : str
        Without the numbers of links: "arm.com".
    shape : tuple
        (n,) a link or joint, (n, 3) with axes, (3,) with axes alone.
    """
    n = shape[0]
    paths = [path for path in values if path == name or path.startswith(f"{name}.")]
    if not paths:
        return None
    out = np.full((len(values[paths[0]]), *shape), start)
    for path in paths:
        columns = parameter_path(path, n).columns(n)
        numbers = np.asarray(values[path], dtype=np.float64).reshape(len(out), len(columns))
        for column, drawn in zip(columns, numbers.T, strict=True):
            rest = column.removeprefix(name).split(".")[1:]
            place = tuple(slice(None) if part == ALL else _index(part) for part in rest)
            cells = out[(slice(None), *place)]
            out[(slice(None), *place)] = drawn.reshape(-1, *[1] * (cells.ndim - 1))
    return out


def _index(part: str) -> int:
    return AXES.index(part) if part in AXES else int(part) - 1


@dataclass(frozen=True, slots=True, eq=False)
class PlantArms:
    """The arms that plants are made from, one a reading, and which of them each run has (runs,)."""

    arms: tuple[Arm, ...]
    which: NDArray[np.intp]
    by_reading: bool

    @classmethod
    def of(cls, study: SweepStudy, values: Mapping[str, Values]) -> Self:
        """Those of a study's values; raises as `lwr_dyn.load`."""
        if "reading" not in values:
            runs = len(next(iter(values.values())))
            return cls((arm_of_study(study),), np.zeros(runs, dtype=np.intp), False)
        names, which = np.unique(values["reading"], return_inverse=True)
        return cls(tuple(arm_of_study(study, str(name)) for name in names), which, True)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.arms[0].n

    def each(self, quantity: Callable[[Arm], Any]) -> Array:
        """A quantity of each run's arm, (runs, ...)."""
        return np.stack([np.asarray(quantity(arm), dtype=np.float64) for arm in self.arms])[self.which]

    def scaled(self, quantity: Callable[[Arm], Any], factor: Array | None) -> Array | None:
        """A quantity times a factor (runs, n); None where it is the same in all runs."""
        if factor is None:
            return self.each(quantity) if self.by_reading else None
        return np.asarray(self.each(quantity) * factor)


def plant_parameters(study: SweepStudy, values: Mapping[str, Values]) -> dict[str, Array]:
    """The plant's parameters by the names of `lwr_dyn.rollouts`: inertia, payload, friction, effort, delay, ...

    Raises `OptionError` for friction with a Stribeck curve, and as `lwr_dyn.load` for a reading that does not exist.
    """
    if not values:  # what varies is the law's alone
        return {}
    plants = PlantArms.of(study, values)
    n = plants.n
    found = {
        "inertia": _inertia(plants, values),
        "armature": plants.scaled(lambda arm: arm.armature, rows_of(values, "arm.armature", (n,), 1.0)),
        "effort": plants.scaled(_finite_effort, rows_of(values, "limits.torque", (n,), 1.0)),
        "friction": _friction(plants, values) if study.loop["friction"] == "smooth" else None,
        "payload_com": rows_of(values, "payload.com", (len(AXES),), 0.0),
    }
    found |= {name: np.asarray(values[path], np.float64) for path, name in PLAIN.items() if path in values}
    return {name: array for name, array in found.items() if array is not None}


def _finite_effort(arm: Arm) -> Array:
    """Torque limits; a very large number stands for an unknown one."""
    return np.minimum(arm.effort, NO_LIMIT)


def _inertia(plants: PlantArms, values: Mapping[str, Values]) -> Array | None:
    """Inertial parameters (runs, 10 n): mass fm m, centre c + dc, tensor about the centre fi I, moved to the origin.

    I_origin = fi I + fm m (|c'|^2 E - c' c'^T), c' = c + dc (Siciliano et al., Robotics, section 7.2.2).
    """
    n = plants.n
    mass, tensor = (rows_of(values, name, (n,), 1.0) for name in ("arm.mass", "arm.inertia"))
    shift = rows_of(values, "arm.com", (n, len(AXES)), 0.0)
    if mass is tensor is shift is None and not plants.by_reading:
        return None
    m, c = (
        plants.each(lambda arm: [b.mass for b in _bodies(arm)]),
        plants.each(lambda arm: [b.com for b in _bodies(arm)]),
    )
    about = plants.each(lambda arm: [b.inertia_com for b in _bodies(arm)])
    m = m if mass is None else m * mass
    c = c if shift is None else c + shift
    about = about if tensor is None else about * tensor[..., None, None]
    square = (c * c).sum(axis=-1)[..., None, None] * np.eye(3)
    origin = about + m[..., None, None] * (square - c[..., :, None] * c[..., None, :])
    entries = np.stack([origin[..., i, j] for i, j in TENSOR], axis=-1)
    return np.concatenate([m[..., None], m[..., None] * c, entries], axis=-1).reshape(len(m), 10 * n)


def _bodies(arm: Arm) -> tuple[Body, ...]:
    return arm.require_dynamics().bodies or ()


def _friction(plants: PlantArms, values: Mapping[str, Values]) -> Array | None:
    """Friction (runs, 5, n): that of the arm, with the rows that the study gives in its place."""
    n = plants.n
    coulomb, viscous = (rows_of(values, f"friction.{name}", (n,), np.nan) for name in ("coulomb", "viscous"))
    if coulomb is viscous is None and not plants.by_reading:
        return None
    table = plants.each(friction_parameters)
    limit = plants.each(lambda arm: arm.effort)
    for name, given in (("coulomb", None if coulomb is None else coulomb * limit), ("viscous", viscous)):
        for row in (FRICTION.index(f"{side}_{name}") for side in ("positive", "negative")):
            table[:, row] = table[:, row] if given is None else np.where(np.isnan(given), table[:, row], given)
    return table


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
    from lwr_dyn.codegen.rollouts.law_forms import law_form, unchecked_form

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
