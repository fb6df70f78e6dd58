"""Controllers of a study as texts: a name or a file, its options, and what is wrapped around it.

`pid:omega-n=20:velocity-error` gives a row its options, by the names that they have in `lwr-dyn simulate` (`omega_n` is
read too); a switch has no value. `pid:omega-n=20+friction` adds a wrapper, as `A+B` adds a change to a plant.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lwr_dyn.control.controllers import CONTROLLERS, WRAPPERS, make_controller
from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import number_of
from lwr_dyn.foundation.errors import OptionError, UnknownNameError, did_you_mean
from lwr_dyn.foundation.registry import Option, Quantity, Registry, options_of
from lwr_dyn.model.arm import Arm

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

    Raises
    ------
    UnknownNameError
        No controller or wrapper of that name.
    OptionError
        Another form, an option that the controller does not have, a value that is missing, not needed or not allowed.

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
    else:
        options = dict(_option(base, name, value) for name, value in given)
    _check(base, text)
    for wrapper in wrappers:
        WRAPPERS[wrapper]  # raises for an unknown one
    return ControllerSpec(text, base, options, wrappers)


def _check(base: str, text: str) -> None:
    if not base.endswith(".py") and base not in CONTROLLERS.names:
        raise UnknownNameError("controller", base or text, (*CONTROLLERS.names, "or a file that ends in .py"))


def _option(base: str, name: str, value: str) -> tuple[str, Any]:
    """The keyword and the value of one option of a row."""
    _check(base, base)
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
