"""Controllers by name, from a Python file of one's own, or from the texts of a study.

Whatever fails in a user's file becomes one line that says where. The text `pid:omega-n=20:velocity-error` gives a row
its options, by the names that they have in `lwr-dyn simulate` (`omega_n` is read too); a switch has no value.
`pid:omega-n=20+friction` adds a wrapper, as `A+B` adds a change to a plant.
"""

import inspect
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from traceback import extract_tb
from types import ModuleType
from typing import Any, cast

import numpy as np

from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import arm_argument, number_of
from lwr_dyn.foundation.errors import FileAccessError, LwrDynError, OptionError, UnknownNameError, did_you_mean
from lwr_dyn.foundation.files import read_text
from lwr_dyn.foundation.registry import Option, Quantity, Registry, Row, check_options, options_of
from lwr_dyn.model.arm import Arm

NEEDED = "a Python file with controller(t, q, dq, q_ref, dq_ref, ddq_ref), or make(arm, dynamics) that returns one"


def controller_from_file(path: str, arm: Arm, dynamics: Dynamics, **options: Any) -> Controller:
    """The controller of a Python file: its function `controller`, or what its function `make` returns.

    The file holds `make(arm, dynamics)`, or else `controller(t, q, dq, q_ref, dq_ref, ddq_ref)` itself. A function
    without a `name` of its own is named as the file, such as "mine.py". Raises `FileAccessError`: the file cannot be
    read, an error is raised in it (says in which line), or it holds no controller; `OptionError`: an option that `make`
    does not know.
    """
    module = _run(path)
    controller, make = getattr(module, "controller", None), getattr(module, "make", None)
    if make is not None:
        if not _takes(make, 2):
            raise FileAccessError(path, "make does not take two arguments", NEEDED)
        check_options(f"make in {path}", make, 2, options)
        with faults_in(path):
            controller = make(arm, dynamics, **options)
    if controller is None or not _takes(controller, 6):
        raise FileAccessError(path, "no function of six arguments for a controller", NEEDED)
    if inspect.isfunction(controller) and not hasattr(controller, "name"):
        controller.name = Path(path).name  # type: ignore[attr-defined]
    return cast(Controller, controller)


@contextmanager
def faults_in(path: str) -> Iterator[None]:
    """Turns an error that the code of a file raises into a `FileAccessError` that says in which line."""
    try:
        yield
    except LwrDynError:
        raise
    except (Exception, SystemExit) as fault:
        lines = [frame.lineno for frame in extract_tb(fault.__traceback__) if frame.filename == path]
        if isinstance(fault, SyntaxError) and fault.filename == path:
            lines = [fault.lineno]
        if not lines:
            raise
        text = f"line {lines[-1]}: {type(fault).__name__}: {getattr(fault, 'msg', fault)}"
        raise FileAccessError(path, text, "a controller that runs") from fault


NO_CODE = "LWR_DYN_NO_CODE"
"""With this variable set no Python file of a user is run, in no process that inherits it."""


def code_files(texts: Iterable[str]) -> tuple[str, ...]:
    """The Python files among controllers as text, each once: what making the controllers would run.

    >>> code_files(["pid:omega-n=20+friction", "mine.py:stiff+friction", "mine.py"])
    ('mine.py',)
    """
    bases = (found["base"] for text in texts if (found := _FORM.match(text)))
    return tuple(dict.fromkeys(base for base in bases if base.endswith(".py")))


def refuse_code(path: str, by: str) -> None:
    """Raise `OptionError`: a file that would run, where `by` forbids it."""
    raise OptionError(path, f"Python that would run, against {by}", "controllers by name")


def _run(path: str) -> ModuleType:
    if os.environ.get(NO_CODE):
        refuse_code(path, NO_CODE)
    text = read_text(path, NEEDED)
    if "\0" in text:
        raise FileAccessError(path, "a null character", NEEDED)
    module = ModuleType(f"lwr_dyn_controller_{Path(path).stem}")
    module.__file__ = path
    sys.modules[module.__name__] = module  # dataclasses look their module up there
    with faults_in(path):
        exec(compile(text, path, "exec"), module.__dict__)
    return module


def _takes(function: Any, arguments: int) -> bool:
    try:
        inspect.signature(function).bind(*range(arguments))
    except (TypeError, ValueError):
        return False
    return True


CONTROLLERS: Registry[Callable[..., Controller]] = Registry(
    "controller",
    {
        "pd-gravity": Row("lwr_dyn.control.paper_laws:tuned_pd_gravity", "PD with gravity compensation"),
        "pid": Row("lwr_dyn.control.paper_laws:tuned_pid", "PID with back-calculation against wind-up"),
        "inverse-dynamics": Row(
            "lwr_dyn.control.paper_laws:tuned_inverse_dynamics", "inverse dynamics: the model linearises the arm"
        ),
        "motor-pd": Row(
            "lwr_dyn.control.laws.motor_side:tuned_motor_side_pd", "PD on the motor side of elastic joints"
        ),
        "joint-impedance": Row(
            "lwr_dyn.control.laws.impedance:tuned_joint_impedance", "joints as springs; the damping fits every pose"
        ),
        "cartesian-impedance": Row(
            "lwr_dyn.control.laws.impedance:tuned_cartesian_impedance", "the tip as a spring in space"
        ),
        "hand-guiding": Row(
            "lwr_dyn.control.laws.friction_compensation:tuned_hand_guiding",
            "weight and friction carried; a hand moves the arm",
        ),
        "adaptive": Row("lwr_dyn.control.laws.adaptive:tuned_adaptive", "Slotine and Li: learns load, and friction"),
        "robust": Row("lwr_dyn.control.laws.robust:tuned_robust", "passivity-based, for a load out of a set"),
    },
)
"""Each row makes a controller: `factory(arm, dynamics, **options)`."""

WRAPPERS: Registry[Callable[..., Controller]] = Registry(
    "controller wrapper",
    {
        "friction": Row("lwr_dyn.control.laws.friction_compensation:with_friction", "friction of dq_ref"),
        "friction-measured": Row("lwr_dyn.control.laws.friction_compensation:with_measured_friction", "friction of dq"),
        "motor-side": Row("lwr_dyn.control.laws.motor_side:on_motor_side", "reads the motor side of elastic joints"),
        "observer": Row(
            "lwr_dyn.control.laws.observer:observed", "external torque and collisions by a momentum observer"
        ),
    },
)
"""What can be put around any controller, as "pid+friction": `factory(controller, arm, dynamics, **options)`."""


def split_name(name: str) -> tuple[str, tuple[str, ...]]:
    """The controller and its wrappers, innermost first.

    >>> split_name("pid+friction")
    ('pid', ('friction',))
    """
    inner, plus, last = name.rpartition("+")
    if not plus or name.endswith(".py"):
        return name, ()
    law, wrappers = split_name(inner)
    return law, (*wrappers, last)


def controller(name: str, arm: Arm, *, engine: str | Dynamics = "pinocchio", **options: Any) -> Controller:
    """A controller by name ("pd-gravity", "pid", "inverse-dynamics", or one that a package adds), or from a .py file.

    Options are those of its factory, such as omega_n [rad/s]; errors as of `make_controller`. The
    engine computes the model of the arm.

    >>> import lwr_dyn
    >>> controller("inverse-dynamics", lwr_dyn.load("lwr4plus"), omega_n=20.0).Kp[0]
    np.float64(400.0)
    """
    return make_controller(name, arm_argument(arm), engine, **options)


def make_controller(name: str, arm: Arm, engine: str | Dynamics = "pinocchio", **options: Any) -> Controller:
    """A controller by name, or from a file.

    Parameters
    ----------
    name : str
        A name of `CONTROLLERS`, or a path that ends in .py (`controller_from_file`); then wrappers, as "pid+friction".
    arm : Arm
        The arm as the controller knows it.
    engine : str or Dynamics
        Computes the controller's model: a name, or dynamics that are already built for this arm.
    options
        Of the row's factory, such as omega_n [rad/s], xi, velocity_error; those of a wrapper go to the wrapper.

    Raises
    ------
    UnknownNameError
        No controller, wrapper or engine of that name.
    OptionError, ShapeError
        An option that this controller does not know, gains that are not positive, inertias of the wrong shape.
    MissingDataError
        The arm has no inertias, no gains of its own, or no limits to search its worst case in.
    FileAccessError
        A file that cannot be read, does not run, or holds no controller.
    """
    dynamics = dynamics_of(arm, engine) if isinstance(engine, str) else engine
    law, wrappers = split_name(str(name))
    own = {w: {k: options[k] for k in inspect.signature(WRAPPERS.load(w)).parameters if k in options} for w in wrappers}
    rest = {k: value for k, value in options.items() if not any(k in keys for keys in own.values())}
    make = controller_from_file if law.endswith(".py") else CONTROLLERS.make
    controller: Controller = make(law, arm, dynamics, **rest)
    for wrapper in wrappers:
        controller = WRAPPERS.make(wrapper, controller, arm, dynamics, **own[wrapper])
    return controller


_FORM = re.compile(r"(?P<base>.*\.py|[^:+]*)(?P<options>(?::[^:+]*)*)(?P<wrappers>(?:\+[^:+]*)*)")

FORM = "NAME:OPTION=VALUE:SWITCH+WRAPPER"


@dataclass(frozen=True, slots=True)
class ControllerSpec:
    """A controller by text: `base` is a name of `CONTROLLERS` or a file; `options` by keyword of its factory."""

    text: str
    base: str
    options: Mapping[str, Any] = field(default_factory=dict)
    wrappers: tuple[str, ...] = ()

    @property
    def is_file(self) -> bool:
        """Whether it stands in a file of a user's own."""
        return self.base.endswith(".py")

    @property
    def name(self) -> str:
        """The name or file with its wrappers, as `make_controller` takes it."""
        return "+".join((self.base, *self.wrappers))

    def make(self, arm: Arm, dynamics: Dynamics, tuned: Mapping[str, Any] | None = None) -> Controller:
        """A new controller; `tuned` are further options. Raises as `make_controller`."""
        return make_controller(self.name, arm, dynamics, **{**self.options, **(tuned or {})})


def controller_spec(text: str) -> ControllerSpec:
    """The controller of a text such as "pid:omega-n=20:velocity-error+friction".

    Raises `UnknownNameError`: no controller or wrapper of that name; `OptionError`: another form, an option that the
    controller does not have, a value that is missing, not needed or not allowed.

    >>> spec = controller_spec("pid:omega-n=20:velocity-error")
    >>> spec.base, dict(spec.options)
    ('pid', {'omega_n': 20.0, 'velocity_error': True})
    """
    parts = _FORM.fullmatch(text.strip())
    if parts is None:
        raise OptionError("controller", repr(text), FORM)
    base, wrappers = parts["base"].strip(), tuple(name.strip() for name in parts["wrappers"].split("+")[1:])
    pairs = [option.partition("=") for option in parts["options"].split(":")[1:]]
    given = [(name.strip().replace("_", "-"), value.strip()) for name, _, value in pairs]
    for name, _ in given:
        if [other for other, _ in given].count(name) > 1:
            raise OptionError(f"controller {text!r}", f"{name} twice", "each option once")
    if base.endswith(".py"):
        options = {name.replace("-", "_"): _free(value) for name, value in given}
    elif base in CONTROLLERS.names:
        options = dict(_option(base, name, value) for name, value in given)
    else:
        raise UnknownNameError("controller", base or text, (*CONTROLLERS.names, "or a file that ends in .py"))
    for wrapper in wrappers:
        WRAPPERS[wrapper]  # raises for an unknown one
    return ControllerSpec(text, base, options, wrappers)


def _option(base: str, name: str, value: str) -> tuple[str, Any]:
    """The keyword and the value of one option of a row."""
    known = {option.flag_name: option for option in options_of(CONTROLLERS.load(base)).values()}
    if name not in known:
        found = f"option {name!r}{did_you_mean(name, known)}"
        raise OptionError(f"controller {base}", found, ", ".join(known) or "no options")
    option = known[name]
    return option.keyword, _value(f"controller {base}: {name}", option, name, value)


def _value(subject: str, option: Option, name: str, text: str) -> Any:
    kind = option.kind
    if kind is bool:
        if text:
            raise OptionError(subject, f"with the value {text!r}", f"{name}, without a value")
        return not option.default
    if not text:
        raise OptionError(subject, "no value", f"{name}=VALUE ({option.help.rstrip('.')})")
    if kind in (int, float, Quantity.ANGLE):
        number = _number(subject, text, f"a number ({option.help.rstrip('.')})")
        if kind is int and number != int(number):
            raise OptionError(subject, repr(text), "a whole number")
        return float(np.radians(number)) if kind is Quantity.ANGLE else kind(number)
    if isinstance(kind, Registry) and text not in kind.names:
        raise UnknownNameError(kind.kind, text, kind.names)
    if isinstance(kind, Quantity):
        raise OptionError(subject, repr(text), "a controller in a file, for values that are lists")
    return text


def _number(subject: str, text: str, allowed: str) -> float:
    try:
        return number_of(text)
    except ValueError:
        raise OptionError(subject, repr(text), allowed) from None


def _free(text: str) -> Any:
    """A value for the file's own `make`: True without one, a number where it is one, else text."""
    try:
        return number_of(text) if text else True
    except ValueError:
        return text
