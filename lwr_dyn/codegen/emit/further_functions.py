"""Functions beside those of a batch: the regressor by its distinct numbers, friction, and control laws as one step.

Of the regressor's n x 10 n numbers about half are always 0, and many others are equal up to their sign. A law's step is
the torque at a sample and the memory of the next, by its kernel form: measured state, reference and gains are
arguments, the law's model is the arm with its own constants.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import exp
from typing import Any

import casadi
import numpy as np
from numpy.typing import NDArray

from lwr_dyn.codegen.emit import functions as emit
from lwr_dyn.codegen.kernels.elementary import sincos
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.codegen.kernels.straight_line import compact, straight_line_code
from lwr_dyn.codegen.kernels.symbolic_functions import symbolic_function
from lwr_dyn.codegen.rollouts.law_forms import law_form, traced
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.dynamics.regressor import chain_with_dynamics
from lwr_dyn.foundation.errors import MissingDataError, OptionError
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.friction import FRICTIONLESS, JointFriction

DENSE = "torque_regressor"

COMPACT, EXPANDED = f"{DENSE}_compact", f"{DENSE}_expanded"

_C = """\
static const short @NAME@_map[{wide}] = {{
    {numbers}}};

int @NAME@_index(int place)
{{
    return @NAME@_map[place];
}}

void @NAME@(const @NUMBER@ values[{narrow}], @NUMBER@ out[{wide}])
{{
    int i;
    for (i = 0; i < {wide}; i++) {{
        const int k = @NAME@_map[i];
        out[i] = 0;
        if (k > 0) {{
            out[i] = values[k - 1];
        }} else if (k < 0) {{
            out[i] = -values[-k - 1];
        }}
    }}
}}
"""

_JS = """\
const map = new Int16Array([{numbers}]);
function @NAME@_index(place) {{
    return map[place];
}}
function @NAME@(values, out = new Float64Array({wide})) {{
    for (let i = 0; i < {wide}; i++) {{
        const k = map[i];
        out[i] = k > 0 ? values[k - 1] : k < 0 ? -values[-k - 1] : 0;
    }}
    return out;
}}
"""


@dataclass(frozen=True, slots=True, eq=False)
class CompactResult:
    """The distinct numbers of a result, those that are not always 0, each once up to its sign."""

    function: Any
    """casadi.Function of the same arguments, which gives them."""
    index: NDArray[np.int64]
    """For each place of the whole result: 0 where it is 0, k for number k - 1, -k for that number negated."""


@lru_cache(maxsize=16)
def compact_regressor(spec: KernelSpec) -> CompactResult:
    """Of the torque regressor."""
    return compact_result(symbolic_function(spec, DENSE))


def compact_result(function: Any) -> CompactResult:
    """Of a casadi.Function with one output vector; raises `OptionError` where one is a constant other than 0."""
    _, entries, constants = compact(straight_line_code(function, sincos("float64"), is_flagged=False))
    if any(constants):
        raise OptionError(COMPACT, "a number that is always the same, but not 0", "numbers that are 0 or change")
    index = np.array(entries)
    symbols = [casadi.SX.sym(f"x{i}", function.size1_in(i)) for i in range(function.n_in())]
    out = casadi.SX(function(*symbols))
    places = [int(np.argmax(np.abs(index) == k)) for k in range(1, int(np.abs(index).max()) + 1)]
    values = [float(np.sign(index[place])) * out[place] for place in places]
    return CompactResult(casadi.Function(function.name(), symbols, [casadi.densify(casadi.vertcat(*values))]), index)


def compact_function(spec: KernelSpec, name: str, arm: Arm) -> emit.EmittedFunction:
    """The row "torque_regressor_compact" of `EMITTED`; raises as that of the regressor."""
    dense, function = emit.of_batch(spec, DENSE, arm), compact_regressor(spec).function
    width = int(function.size1_out(0))
    text = f"the {width} distinct numbers of {DENSE}, to be placed by {EXPANDED}"
    return emit.EmittedFunction(
        name, text, dense.arguments, (width,), emit.RESULT_UNITS[DENSE].partition(";")[0], function
    )


def expanding_function(spec: KernelSpec, name: str, arm: Arm) -> emit.TemplateFunction:
    """The row "torque_regressor_expanded" of `EMITTED`; raises as that of the regressor."""
    emit.of_batch(spec, DENSE, arm)
    made, n = compact_regressor(spec), arm.n
    width, places = int(made.function.size1_out(0)), made.index.size
    words = {"wide": places, "narrow": width}
    rows = [", ".join(map(str, row)) for row in made.index.reshape(-1, 10).tolist()]
    text = "\n".join([
        f"{DENSE} ({n} x {10 * n}, row by row) from the {width} numbers of {COMPACT}",
        "_index: which number stands at a place: 0 for none (it is 0), k for values[k - 1], -k for -values[k - 1]",
    ])  # fmt: skip
    c = _C.format(**words, numbers=",\n    ".join(rows))
    head = f"void @NAME@(const @NUMBER@ values[{width}], @NUMBER@ out[{places}]);\nint @NAME@_index(int place)"
    js = _JS.format(**words, numbers=",\n".join(rows))
    names = {"c": head, "js": f"{name}, {name}_index"}
    return emit.TemplateFunction(
        name, text, names, {"c": c, "js": js}, cases=lambda: (_placed(name, made.index, width),)
    )


def _placed(name: str, index: NDArray[np.int64], width: int) -> emit.TemplateCase:
    """Its test vector: 1, 2, 3 ... in their places."""
    values = [[float(k + 1) for k in range(width)]]
    argument = emit.Argument("values", width, emit.RESULT_UNITS[DENSE].partition(";")[0])
    return emit.TemplateCase(name, ((argument, values),), argument.unit, [index.astype(float).tolist()], None, 0.0)


TEXT = {
    "friction_torque": "tau_f(dq), Coulomb, viscous and Stribeck friction per direction; at rest the offset alone",
    "smooth_friction_torque": "tau_f(dq) with tanh(dq / width) in place of the sign; at rest the offset alone",
}


def friction_function(spec: KernelSpec, name: str, arm: Arm) -> emit.EmittedFunction:
    """The rows of `EMITTED`.

    Raises `MissingDataError` for an arm without friction, `OptionError` for friction that grows with the load.
    """
    models = [model or FRICTIONLESS for model in arm.friction_models()]
    for joint, model in zip(arm.joint_names, models, strict=True):
        if model.load:
            allowed = "none: the functions have speeds and no torques"
            raise OptionError(f"friction of {joint}", f"{model.load:.2g} of the load", allowed)
    if all(model is FRICTIONLESS for model in models):
        raise MissingDataError(arm.name, "friction", name)
    is_smooth = name != "friction_torque"
    dq, width = casadi.SX.sym("dq", arm.n), casadi.SX.sym("width")
    speeds = casadi.vertsplit(dq)
    if is_smooth:
        rows = [_smooth(model, x, width) for model, x in zip(models, speeds, strict=True)]
    else:
        rows = [_jumping(model, x) for model, x in zip(models, speeds, strict=True)]
    arguments = [emit.Argument("dq", arm.n, emit.UNITS["dq"]), emit.Argument("width", 1, "rad/s or m/s, above 0")]
    given = [dq, width] if is_smooth else [dq]
    function = casadi.Function(name, given, [casadi.densify(casadi.SX(casadi.vertcat(*rows)))])
    return emit.EmittedFunction(name, TEXT[name], tuple(arguments[: len(given)]), (arm.n,), emit.UNITS["tau"], function)


def _jumping(model: JointFriction, dq: Any) -> Any:
    """`JointFriction.torque`."""
    return model.offset + (dq > 0) * _level(model, 0, dq) - (dq < 0) * _level(model, 1, dq) + _rest(model, dq)


def _smooth(model: JointFriction, dq: Any, width: Any) -> Any:
    """`model.friction.smooth_friction`."""
    level = casadi.if_else(dq > 0, _level(model, 0, dq), _level(model, 1, dq))
    return model.offset + level * casadi.tanh(dq / width) + _rest(model, dq)


def _rest(model: JointFriction, dq: Any) -> Any:
    """Viscous friction and the sigmoid, which need no sign."""
    up, down = model.positive.viscous, model.negative.viscous
    viscous = down * dq + (up - down) * (dq > 0) * dq
    if (s := model.sigmoid) is None:
        return viscous
    at_rest = 1.0 / (1.0 + exp(-s.slope * s.shift))
    return viscous + s.level * ((1.0 + casadi.tanh(s.slope * (dq + s.shift) / 2)) / 2 - at_rest)


def _level(model: JointFriction, side: int, dq: Any) -> Any:
    """Coulomb's level with Stribeck's curve, of one direction."""
    direction = (model.positive, model.negative)[side]
    drop, scale = direction.holding - direction.coulomb, direction.stribeck_velocity
    if scale is None or drop <= 0.0:
        return direction.coulomb
    return direction.coulomb + drop * casadi.exp(-((dq / scale) ** 2))


STEP = "step_"
"""What the names of the functions of registered laws begin with."""

JOINT = {"q": "q", "dq": "dq", "q_ref": "q", "dq_ref": "dq", "ddq_ref": "ddq"}
"""Arguments of every law, and whose units they have."""

GAIN_UNITS = {
    "Kp": "of the law: N m/rad, or 1/s^2 with inverse dynamics", "Kd": "of the law: N m s/rad, or 1/s",
    "Ki": "N m/(rad s)", "tracking_time": "s", "law_effort": "N m or N, the torque limits that the law knows",
    "omega_n": "1/s", "layer": "W", "rho": "1", "law_friction_width": "rad/s or m/s",
    "law_friction": "rows Coulomb and viscous towards +, towards -, offset: N m, N m s/rad",
}  # fmt: skip

TUNED = "; gains as tuned: "
"""In a law's text, what comes before its gains."""

_SHOWN = 14
"""Gains with more numbers than this are not listed."""


@lru_cache(maxsize=32)
def _registered(arm: Arm, law: str) -> Controller:
    """A controller with its tuned gains."""
    return make_controller(law, arm)


def registered_step(spec: KernelSpec, name: str, arm: Arm) -> emit.EmittedFunction:
    """The row of `EMITTED` "step_LAW": the law with its default options; raises as `law_form`."""
    chain_with_dynamics(arm)
    return step_function(_registered(arm, name.removeprefix(STEP).replace("_", "-")), arm, name)


def step_function(controller: Controller, arm: Arm, name: str = "step") -> emit.EmittedFunction:
    """The torque of a controller at a sample, and its memory at the next one, ready to be written.

    Parameters
    ----------
    controller : Controller
        One of `law_forms.LAW_FORMS`, plain or with friction compensation around it.
    arm : Arm
        The arm as the controller knows it.
    name : str
        Of the function.

    Returns
    -------
    EmittedFunction
        Of q, dq, q_ref, dq_ref, ddq_ref, with a memory of it and of h, and of the gains; the controller's own gains
        stand in its text.

    Raises
    ------
    NoKernelFormError, OptionError, MissingDataError
        As `law_forms.law_form`.
    """
    form, n = law_form(controller, arm), arm.n
    symbols, results = traced(form, arm)
    x = {name: symbol for name, symbol in symbols.items() if form.memory or name not in ("memory", "h")}
    out = casadi.densify(casadi.vertcat(*results))
    arguments = tuple(emit.Argument(name, symbol.numel(), _unit(name)) for name, symbol in x.items())
    after = (
        f"; out[{n}] on: the memory of the next sample, which starts at {_numbers(form.start())}" if form.memory else ""
    )
    values = [f"{gain} = {_numbers(value)}" for gain, value in form.values().items()]
    text = f"torque of {label_of(controller)}{after}{TUNED}{'; '.join(values)}"
    unit = "N m or N" + (", then of the memory" if form.memory else "")
    return emit.EmittedFunction(
        name, text, arguments, (n + form.memory,), unit, casadi.Function(name, list(x.values()), [out])
    )


def _unit(argument: str) -> str:
    if argument in JOINT:
        return emit.UNITS[JOINT[argument]]
    return {"h": "s, between samples", "memory": "the law's own"}.get(argument) or GAIN_UNITS.get(argument, "SI")


def _numbers(values: object) -> str:
    """Numbers in short; one for all of them where they are equal."""
    flat = np.ravel(np.asarray(values, dtype=np.float64))
    if np.ptp(flat) <= 1e-12 * np.abs(flat).max():
        return f"{flat[0]:.12g}"
    return ", ".join(f"{x:.12g}" for x in flat) if flat.size <= _SHOWN else f"{flat.size} numbers"
