"""From values of a study's paths to the keywords of `lwr_dyn.rollouts`: plants, and one of its controllers."""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from lwr_dyn.codegen.kernels.kernel_spec import FRICTION, TENSOR, friction_parameters
from lwr_dyn.codegen.rollouts.law_forms import LawForm, law_form, unchecked_form
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, with_payload
from lwr_dyn.simulation.plant import Encoder
from lwr_dyn.studies.sweep import sweep_study
from lwr_dyn.studies.sweep.sampling import Values
from lwr_dyn.studies.sweep.sweep_study import SweepStudy
from lwr_dyn.studies.sweep.vocabulary import ALL, AXES, parameter_path

PLAIN = {
    "payload.mass": "payload", "sensor.resolution": "resolution", "sensor.noise": "noise", "loop.delay": "delay",
}  # fmt: skip
"""Paths whose values are parameters of `rollouts` as they are."""
NO_LIMIT = 1e9
"""[N m] or [N] In place of an unknown torque limit, as in a URDF."""


Quantity = Callable[[Arm], Any]
SCALED: dict[str, tuple[str, Quantity]] = {
    "armature": ("arm.armature", lambda arm: arm.armature),
    "effort": ("limits.torque", lambda arm: np.minimum(arm.effort, NO_LIMIT)),
}
"""Parameter of `rollouts` -> the path that is its factor, and what it is in the arm."""


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
    index: dict[str, Any] = {str(i + 1): i for i in range(n)} | {axis: i for i, axis in enumerate(AXES)}
    index[ALL] = slice(None)
    out = np.full((len(values[paths[0]]), *shape), start)
    for path in paths:
        columns = parameter_path(path, n).columns(n)
        numbers = np.asarray(values[path], dtype=np.float64).reshape(len(out), len(columns))
        for column, drawn in zip(columns, numbers.T, strict=True):
            place = (slice(None), *(index[part] for part in column.removeprefix(name).split(".")[1:]))
            out[place] = drawn.reshape(-1, *[1] * (out[place].ndim - 1))
    return out


def plant_parameters(study: SweepStudy, values: Mapping[str, Values]) -> dict[str, Array]:
    """The plant's parameters by the names of `lwr_dyn.rollouts`: inertia, payload, friction, effort, delay, ...

    Raises `OptionError` for friction with a Stribeck curve, and as `lwr_dyn.load` for a reading that does not exist.
    """
    if not values:  # what varies is the law's alone
        return {}
    names, which = np.unique(values.get("reading", [""] * len(next(iter(values.values())))), return_inverse=True)
    arms = [sweep_study.arm_of_study(study, str(name) or None) for name in names]

    def each(quantity: Quantity) -> Array:
        """A quantity of each run's arm, (runs, ...)."""
        return np.stack([np.asarray(quantity(arm), dtype=np.float64) for arm in arms])[which]

    found = {name: np.asarray(values[path], np.float64) for path, name in PLAIN.items() if path in values}
    if _varies(values, "payload.com"):
        found["payload_com"] = _given(values, "payload.com", (len(AXES),), 0.0)
    if _varies(values, "reading", "arm.mass", "arm.inertia", "arm.com"):
        found["inertia"] = _inertia(values, each, arms[0].n)
    for name, (path, quantity) in SCALED.items():
        if _varies(values, "reading", path):
            found[name] = each(quantity) * _given(values, path, (arms[0].n,), 1.0)
    if study.loop["friction"] == "smooth" and _varies(values, "reading", "friction."):
        found["friction"] = _friction(values, each, arms[0].n)
    return found


def _varies(values: Mapping[str, Values], *groups: str) -> bool:
    return any(path.startswith(groups) for path in values)


def _given(values: Mapping[str, Values], name: str, shape: tuple[int, ...], start: float) -> Array:
    found = rows_of(values, name, shape, start)
    return np.full(shape, start) if found is None else found


def _bodies(arm: Arm) -> tuple[Body, ...]:
    return arm.require_dynamics().bodies or ()


def _inertia(values: Mapping[str, Values], each: Callable[[Quantity], Array], n: int) -> Array:
    """Inertial parameters (runs, 10 n): mass fm m, centre c + dc, tensor about the centre fi I, moved to the origin.

    I_origin = fi I + fm m (|c'|^2 E - c' c'^T), c' = c + dc (Siciliano et al., Robotics, section 7.2.2).
    """
    m = each(lambda arm: [body.mass for body in _bodies(arm)]) * _given(values, "arm.mass", (n,), 1.0)
    c = each(lambda arm: [body.com for body in _bodies(arm)]) + _given(values, "arm.com", (n, len(AXES)), 0.0)
    factor = _given(values, "arm.inertia", (n,), 1.0)[..., None, None]
    about = each(lambda arm: [body.inertia_com for body in _bodies(arm)]) * factor
    square = (c * c).sum(axis=-1)[..., None, None] * np.eye(3)
    origin = about + m[..., None, None] * (square - c[..., :, None] * c[..., None, :])
    entries = np.stack([origin[..., i, j] for i, j in TENSOR], axis=-1)
    return np.concatenate([m[..., None], m[..., None] * c, entries], axis=-1).reshape(len(m), -1)


def _friction(values: Mapping[str, Values], each: Callable[[Quantity], Array], n: int) -> Array:
    """Friction (runs, 5, n): that of the arm, with the numbers that the study gives in its place."""
    table = each(friction_parameters)
    unit = {"coulomb": each(lambda arm: arm.effort), "viscous": np.ones(n)}
    for name, one in unit.items():
        given = _given(values, f"friction.{name}", (n,), np.nan) * one
        for row in (FRICTION.index(f"{side}_{name}") for side in ("positive", "negative")):
            table[:, row] = np.where(np.isnan(given), table[:, row], given)
    return table


OPTIONS = "controller."
OWN_LOAD = ("robust",)
"""Controllers whose model holds a load of its own, the middle of their set: a known payload is not added to it."""


def rollout_arguments(study: SweepStudy, text: str, values: Mapping[str, Values]) -> dict[str, Any]:
    """Keywords of `lwr_dyn.rollouts`, all but arm, controller, reference, runs, threads, first_run and record.

    Parameters
    ----------
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
    spec = sweep_study.spec_of_study(study, text)
    parameters = plant_parameters(study, values)
    if not spec.is_file:
        parameters |= _known_payload(values, spec.base) | _gains(study, text, values)
    if any(sweep_study.is_task(path) for path in values):
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
    arm, spec = sweep_study.arm_of_study(study), sweep_study.spec_of_study(study, text)
    known = _known_payload(values, spec.base)
    if known:
        com = known.get("model_payload_com", np.zeros((index + 1, len(AXES))))
        arm = arm.with_chain(with_payload(arm.chain, float(known["model_payload"][index]), com[index]))
    options = {sweep_study.option_name(path): float(values[path][index]) for path in values if path.startswith(OPTIONS)}
    return spec.make(arm, dynamics_of(arm), options)


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
    for one in (one for one in study.parameters if sweep_study.is_task(one.path)):
        drawn = np.asarray(values[one.path], float)[:, None]
        index = index * len(one.values) + np.abs(drawn - np.asarray(one.values, float)).argmin(axis=1)
    return np.asarray(index, dtype=np.float64)


@lru_cache(maxsize=4)
def _largest_inertias(arm: Arm) -> tuple[float, ...]:
    """The largest inertias of the joints, for gains that are made many times."""
    return tuple(one.value for one in worst_case_inertias(arm))


def _gains(study: SweepStudy, text: str, values: Mapping[str, Values]) -> dict[str, Array]:
    """The gains of every run by the names of the controller's kernel form: each set of options is made once."""
    paths = [path for path in values if path.startswith(OPTIONS)]
    if not paths:
        return {}
    arm, spec = sweep_study.arm_of_study(study), sweep_study.spec_of_study(study, text)
    dynamics, fixed = dynamics_of(arm), {"inertia": _largest_inertias(arm)} if sweep_study.takes_inertia(spec) else {}
    rows, which = np.unique(
        np.stack([np.asarray(values[p], float) for p in paths], axis=1), axis=0, return_inverse=True
    )
    forms: list[LawForm] = []
    for row in rows:
        options = dict(zip(map(sweep_study.option_name, paths), row.tolist(), strict=True))
        form = unchecked_form if forms else law_form  # the first is compared with its controller
        forms.append(form(spec.make(arm, dynamics, {**fixed, **options}), arm))
    if len({form.digest for form in forms}) > 1:
        raise OptionError(", ".join(paths), f"changes more than the gains of {text}", "options that are gains")
    each = [form.values() for form in forms]
    return {name: np.stack([one[name] for one in each])[which.ravel()] for name in each[0]}
