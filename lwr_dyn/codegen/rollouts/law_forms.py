"""The kernel form of a controller: its torque on symbols, its memory, and its gains as values of a run.

A joint law is written over any scalar (`control.paper_laws`): its form is the controller itself with symbols in place
of its gains and model. The laws of Slotine and Li, whose regressor is not on symbols, have forms of their own; friction
compensation stands around any form. A form is compared with its controller at a few states before it is used: the
controller may be of another arm.
"""

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache
from math import prod
from typing import Any, Protocol

import casadi
import numpy as np
from numpy.typing import ArrayLike

from lwr_dyn.codegen.kernels.kernel_spec import FRICTION, friction_table
from lwr_dyn.codegen.rollouts.symbolic_arm import Column, SymbolicModel, friction_column, friction_models
from lwr_dyn.control.laws.friction_compensation import FrictionCompensation
from lwr_dyn.control.laws.motor_side import MotorSidePD
from lwr_dyn.control.paper_laws import PID, InverseDynamics, PDGravity
from lwr_dyn.control.protocol import Controller, Wrapped, label_of, reset
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics, ungated
from lwr_dyn.foundation.arrays import Array, read_only
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.spatial import ZERO


class NoKernelFormError(OptionError):
    """A controller without a form that kernels take, or one that does not act as its form."""


UNLIMITED = 1e300
"""[N m] Stands for a torque limit of infinity among the values of a law: 0 times it is 0, not NaN."""


def finite_limits(effort: ArrayLike) -> Array:
    """Torque limits (n,) [N m] with `UNLIMITED` for infinity."""
    return np.minimum(np.asarray(effort, dtype=np.float64), UNLIMITED)


@dataclass(frozen=True, slots=True, eq=False)
class LawInputs:
    """What a law is given at a sample, as columns; `parameters` by the names of `LawForm.parameters`, in C order.

    `memory` (m,) is that of this sample; `h` is the time between samples [s].
    """

    q: Column
    dq: Column
    q_ref: Column
    dq_ref: Column
    ddq_ref: Column
    memory: Column
    parameters: Mapping[str, Column]
    h: Any


class LawForm(Protocol):
    """A controller in the form that a kernel takes."""

    @property
    def name(self) -> str:
        """The controller's name, with its wrappers."""

    @property
    def parameters(self) -> Mapping[str, tuple[int, ...]]:
        """Its gains: name -> shape of one run's values; all of them may differ from run to run."""

    @property
    def memory(self) -> int:
        """Numbers kept from sample to sample."""

    @property
    def digest(self) -> str:
        """Text of all else on which `torque` depends: variants and switches, not the values of the parameters.

        A change of the code of `torque` raises `step.GENERATOR`, so that kernels on disk are made again.
        """

    def values(self) -> Mapping[str, Array]:
        """The parameters of this controller, in the shapes of `parameters`."""

    def start(self) -> Array:
        """The memory (m,) at the first sample."""

    def torque(self, model: SymbolicModel, x: LawInputs) -> tuple[Column, Column]:
        """The torque (n,) [N m], and the memory (m,) of the next sample; `model` is the arm as the law knows it."""

    def controller(self, arm: Arm, values: Mapping[str, Array]) -> Controller:
        """The controller that acts so on these values, with `arm` as the arm that it knows: for a run by `simulate`."""


@dataclass(frozen=True, slots=True)
class JointLaw:
    """A kind of joint law, `takes`: its gains, attributes (n,), and the parameters that switch its equations."""

    takes: Any
    gains: tuple[str, ...] = ("Kp", "Kd")
    switches: tuple[str, ...] = ()

    def of(self, law: Any, arm: Arm) -> "JointForm":
        """The form of a controller."""
        return JointForm(law, self)


@dataclass(frozen=True, slots=True, eq=False)
class JointForm:
    """The form of a joint law: the controller itself, with other gains and another model."""

    law: Any
    kind: JointLaw

    @property
    def name(self) -> str:
        """The controller's name."""
        return str(self.law.name)

    @property
    def memory(self) -> int:
        """Numbers kept: an integral a joint, or none."""
        return int(getattr(self.law, "memory_size", 0))

    @property
    def parameters(self) -> Mapping[str, tuple[int, ...]]:
        """The gains by their names; "law_effort" are the torque limits that the law knows [N m]."""
        return {name: value.shape for name, value in self.values().items()}

    @property
    def digest(self) -> str:
        """The name, and the switches."""
        switches = (f"{name}={self.law.parameters[name]}" for name in self.kind.switches)
        return " ".join((self.name, *switches))

    def values(self) -> Mapping[str, Array]:
        """The controller's gains and limits."""
        values = {name: getattr(self.law, _ATTRIBUTES.get(name, name)) for name in self.kind.gains}
        return {name: finite_limits(value) if name in _ATTRIBUTES else value for name, value in values.items()}

    def start(self) -> Array:
        """An integral starts at zero."""
        return np.zeros(self.memory)

    def torque(self, model: SymbolicModel, x: LawInputs) -> tuple[Column, Column]:
        """See `LawForm`."""
        is_weightless = not getattr(self.law, "gravity", True)
        law = self._with(x.parameters, replace(model, pull=ZERO) if is_weightless else model)
        state = (x.q, x.dq, x.q_ref, x.dq_ref, x.ddq_ref)
        if not self.memory:
            return law(0.0, *state), casadi.SX.zeros(0)
        tau, rate = law.torque_and_rate(x.memory, *state)
        return tau, x.memory + x.h * rate

    def controller(self, arm: Arm, values: Mapping[str, Array]) -> Controller:
        """See `LawForm`."""
        dynamics = dynamics_of(arm)
        law: Controller = self._with(values, ungated(dynamics), dynamics)
        return law

    def _with(self, gains: Mapping[str, Any], model: Any, dynamics: Dynamics | None = None) -> Any:
        law = copy(self.law)
        reset(law)
        for name in self.kind.gains:
            setattr(law, _ATTRIBUTES.get(name, name), gains[name])
        if law._model is not None:
            law._model, law._dynamics = model, dynamics
        return law


_ATTRIBUTES = {"law_effort": "_effort"}  # where a law keeps a gain that has another name

PD_GRAVITY = JointLaw(PDGravity, switches=("velocity_error",))
PID_LAW = JointLaw(PID, ("Kp", "Ki", "Kd", "tracking_time", "law_effort"), ("velocity_error", "gravity"))
INVERSE_DYNAMICS = JointLaw(InverseDynamics, switches=("feedforward", "gravity"))
MOTOR_PD = JointLaw(MotorSidePD, switches=("feedforward",))
"""As it acts on rigid joints: no spring, no torque feedback."""


@dataclass(frozen=True, slots=True, eq=False)
class FrictionForm:
    """tau = inner's + tau_f(dq_ref), or tau_f(dq), `FrictionCompensation`; no Stribeck curve (`OptionError`)."""

    law: FrictionCompensation
    inner: LawForm

    def __post_init__(self) -> None:
        friction_table(self.law.models)  # refuses a Stribeck curve

    @property
    def name(self) -> str:
        """The controller's name."""
        return f"{self.inner.name}+{self.law.word}"

    @property
    def memory(self) -> int:
        """The inner law's."""
        return self.inner.memory

    @property
    def parameters(self) -> Mapping[str, tuple[int, ...]]:
        """The inner law's, the friction that the law knows (5, n), and the width of its tanh [rad/s or m/s]."""
        shape = (len(FRICTION), len(self.law.models))
        return {**self.inner.parameters, "law_friction": shape, "law_friction_width": ()}

    @property
    def digest(self) -> str:
        """The inner law's, and the variant."""
        return f"{self.inner.digest} + {self.law.word}"

    def values(self) -> Mapping[str, Array]:
        """The inner law's and the wrapper's own."""
        own = {"law_friction": friction_table(self.law.models), "law_friction_width": np.array(self.law.width)}
        return {**self.inner.values(), **own}

    def start(self) -> Array:
        """The inner law's."""
        return self.inner.start()

    def torque(self, model: SymbolicModel, x: LawInputs) -> tuple[Column, Column]:
        """See `LawForm`."""
        tau, memory = self.inner.torque(model, x)
        speed = x.dq if self.law.measured else x.dq_ref
        return tau + friction_column(speed, x.parameters["law_friction"], x.parameters["law_friction_width"]), memory

    def __getattr__(self, name: str) -> Any:
        if name != "signals":  # those of the inner law, where it has any
            raise AttributeError(name)
        return getattr(self.inner, name)

    def controller(self, arm: Arm, values: Mapping[str, Array]) -> Controller:
        """See `LawForm`."""
        models = friction_models(values["law_friction"])
        inner = self.inner.controller(arm, values)
        return FrictionCompensation(inner, models, float(values["law_friction_width"]), self.law.measured)


STEP = 1e-3
"""[s] Between the samples of the check."""
SAMPLES, SEED = 4, 0
ERRORS = (1e-4, 1e-2, 1.0)
"""[rad, rad/s or m] Size of the errors, of as many sequences of samples: inside and outside of layers and limits."""
CLOSE = 1e-9
"""Of the largest torque at a sample: what form and controller may differ by; rounding leaves 1e-14."""

JOINT = ("q", "dq", "q_ref", "dq_ref", "ddq_ref")
Step = Callable[..., tuple[Array, Array]]


def traced(form: LawForm, arm: Arm) -> tuple[dict[str, Column], tuple[Column, Column]]:
    """Symbols by their names, those of `JOINT`, memory, h and the parameters; the torque (n,) and the next memory."""
    widths = {**dict.fromkeys(JOINT, arm.n), "memory": form.memory, "h": 1}
    gains = {name: casadi.SX.sym(name, prod(shape)) for name, shape in form.parameters.items()}
    x = {name: casadi.SX.sym(name, width) for name, width in widths.items()}
    return x | gains, form.torque(SymbolicModel.of(arm.chain), LawInputs(**x, parameters=gains))


_KEPT, _functions = 32, dict[tuple[Any, ...], Any]()  # of forms: to trace one takes longer than a run of its loop


def _function_of(form: LawForm, arm: Arm) -> Any:
    """The form as a casadi.Function from one column to one; kept by all that it depends on (`LawForm.digest`)."""
    key = type(form), form.name, form.digest, repr(dict(form.parameters)), form.memory, arm.chain
    if key not in _functions:
        x, out = traced(form, arm)
        if len(_functions) >= _KEPT:
            _functions.clear()
        _functions[key] = casadi.Function("law", [casadi.vertcat(*x.values())], [casadi.densify(casadi.vertcat(*out))])
    return _functions[key]


def form_function(form: LawForm, arm: Arm) -> Step:
    """The form in NumPy: (q, dq, q_ref, dq_ref, ddq_ref, memory, values, h) -> torque (n,), next memory (m,)."""
    function = _function_of(form, arm)
    buffer, run = function.buffer()  # a call with arrays takes a hundred times as long
    x, y = np.zeros(function.numel_in(0)), np.zeros(function.numel_out(0))
    buffer.set_arg(0, x.data)
    buffer.set_res(0, y.data)
    shapes = [(arm.n,)] * len(JOINT) + [(form.memory,), (), *form.parameters.values()]
    parts = np.split(x, np.cumsum([prod(shape) for shape in shapes[:-1]]))
    places, names = [part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)], tuple(form.parameters)

    def step(*given: Any) -> tuple[Array, Array]:
        *state, values, time = given
        for place, value in zip(places, (*state, time, *(values[name] for name in names)), strict=True):
            place[...] = value
        run()
        failed = buffer.ret() != 0  # it also keeps the buffer alive, which `run` alone does not
        return np.where(failed, np.nan, y[: arm.n]), y[arm.n :].copy()

    return step


@lru_cache(maxsize=32)
def states_of(arm: Arm) -> Array:
    """Random samples (sequences, samples, 5, n) of q, dq, q_ref, dq_ref, ddq_ref, inside the joint box; read-only."""
    rng = np.random.default_rng(SEED)
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    sequences = []
    for error in ERRORS:
        q_ref, dq_ref, ddq_ref = rng.uniform(-1.0, 1.0, (3, SAMPLES, arm.n))
        q_ref = lower + (0.5 + 0.4 * q_ref) * (upper - lower)
        q, dq = (r + error * rng.uniform(-1.0, 1.0, r.shape) for r in (q_ref, dq_ref))
        sequences.append([q, dq, q_ref, dq_ref, ddq_ref])
    return read_only(np.swapaxes(sequences, 1, 2))


def check_form(form: LawForm, controller: Controller, arm: Arm) -> None:
    """Raise `NoKernelFormError` where the controller's torque is not its form's; it is reset before and after."""
    off, share = differences(form_function(form, arm), form.values(), form.start(), controller, states_of(arm))
    if not share <= CLOSE:
        raise NoKernelFormError(
            "controller",
            f"{label_of(controller)}: its torque is not that of its kernel form for {arm.name} ({arm.reading}), by up "
            f"to {off:.3g} N m", "a controller made for this arm, and not changed since",
        )  # fmt: skip


def differences(
    step: Step, values: Mapping[str, Array], start: Array, controller: Controller, sequences: Array
) -> tuple[float, float]:
    """The largest difference of the torques [N m], and the largest share of the largest torque of its sample."""
    torque = np.empty((2, *sequences.shape[:2], sequences.shape[-1]))  # the controller's and the form's
    for i, sequence in enumerate(sequences):
        reset(controller)
        memory = start
        for k, state in enumerate(sequence):
            torque[0, i, k] = controller(k * STEP, *np.array(state))
            torque[1, i, k], memory = step(*state, memory, values, STEP)
    reset(controller)
    with np.errstate(invalid="ignore"):
        off = np.abs(torque[1] - torque[0]).max(axis=-1)
        share = off / np.maximum(1.0, np.abs(torque[0]).max(axis=-1))
    return (float(off.max()), float(share.max())) if np.isfinite(share).all() else (np.inf, np.inf)


_JOINT, _PASSIVE = "lwr_dyn.codegen.rollouts.law_forms", "lwr_dyn.codegen.rollouts.passivity_law_forms"

LAW_FORMS: Registry[Any] = Registry(
    "kernel_form",
    {
        "pd-gravity": Row(f"{_JOINT}:PD_GRAVITY", "both forms of damping", extra="batch"),
        "pid": Row(f"{_JOINT}:PID_LAW", "with its integral as memory", extra="batch"),
        "inverse-dynamics": Row(f"{_JOINT}:INVERSE_DYNAMICS", "with every switch", extra="batch"),
        "motor-pd": Row(f"{_JOINT}:MOTOR_PD", "as it acts on rigid joints", extra="batch"),
        "adaptive": Row(f"{_PASSIVE}:AdaptiveForm", "of a load or all links, with friction if adapted", extra="batch"),
        "robust": Row(f"{_PASSIVE}:RobustForm", "the robust term as a load", extra="batch"),
    },
)
"""By the controller's name: what has `takes`, the controllers' class, and `of(controller, arm) -> LawForm`."""

WORDS = ("friction", "friction-measured")  # of wrappers around a law that have a form too


def law_form(controller: Controller, arm: Arm) -> LawForm:
    """The kernel form of a controller.

    The controller is called at a few states, after `reset`, and must give its form's torque at each.

    Parameters
    ----------
    controller : Controller
        One of `LAW_FORMS`, plain or with friction compensation around it.
    arm : Arm
        The arm as the controller knows it.

    Raises
    ------
    NoKernelFormError
        A controller without a form; one whose torque is not its form's: it was made for another arm, or changed.
    OptionError
        Friction with a Stribeck curve.
    MissingDataError
        The arm has no inertias.
    """
    form = unchecked_form(controller, arm)
    check_form(form, controller, arm)
    return form


def unchecked_form(controller: Controller, arm: Arm) -> LawForm:
    """`law_form` without a look at the torque: for more controllers of a kind whose first was checked."""
    if type(controller) is FrictionCompensation:
        return FrictionForm(controller, unchecked_form(controller.inner, arm))
    name = str(getattr(controller, "name", ""))
    is_known = name in LAW_FORMS.names and not isinstance(controller, Wrapped)
    kind = LAW_FORMS.load(name) if is_known else None
    if kind is None or type(controller) is not kind.takes:
        own = "" if type(controller).__module__.startswith("lwr_dyn.") else f" ({type(controller).__qualname__})"
        raise NoKernelFormError(
            "controller", f"{label_of(controller)}{own} has no form that kernels take",
            f"{', '.join(LAW_FORMS.names)}, plain or with +{' or +'.join(WORDS)}",
        )  # fmt: skip
    form: LawForm = kind.of(controller, arm)
    return form
