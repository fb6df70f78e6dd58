"""Control laws as one function: the torque at a sample, and the memory of the next, by the kernel form of a controller.

The measured state, the reference and the gains are arguments; the law's model is the arm with its own constants.
"""

import math
from functools import lru_cache

import casadi
import numpy as np

from lwr_dyn.codegen.emit.functions import UNITS, Argument, EmittedFunction
from lwr_dyn.codegen.kernels.kernel_spec import KernelSpec
from lwr_dyn.codegen.rollouts.laws.forms import law_form
from lwr_dyn.codegen.rollouts.laws.protocol import LawInputs
from lwr_dyn.codegen.rollouts.symbolic_model import SymbolicModel
from lwr_dyn.control.controllers import make_controller
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.dynamics.unknown_inertia import chain_with_dynamics
from lwr_dyn.model.arm import Arm

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


def registered_step(spec: KernelSpec, name: str, arm: Arm) -> EmittedFunction:
    """The row of `EMITTED` "step_LAW": the law with its default options; raises as `law_form`."""
    chain_with_dynamics(arm)
    return step_function(_registered(arm, name.removeprefix(STEP).replace("_", "-")), arm, name)


def step_function(controller: Controller, arm: Arm, name: str = "step") -> EmittedFunction:
    """The torque of a controller at a sample, and its memory at the next one, ready to be written.

    Parameters
    ----------
    controller : Controller
        One of `rollout.laws.forms.LAW_FORMS`, plain or with friction compensation around it.
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
        As `rollout.laws.forms.law_form`.
    """
    form, n = law_form(controller, arm), arm.n
    widths = {x: n for x in JOINT}
    widths |= {"memory": form.memory, "h": 1} if form.memory else {}
    widths |= {x: math.prod(shape) for x, shape in form.parameters.items()}
    x = {argument: casadi.SX.sym(argument, width) for argument, width in widths.items()}
    gains = {gain: x[gain] for gain in form.parameters}
    memory, h = x.get("memory", casadi.SX.zeros(0)), x.get("h", casadi.SX.zeros(1))
    given = LawInputs(**{joint: x[joint] for joint in JOINT}, memory=memory, parameters=gains, h=h)
    out = casadi.densify(casadi.vertcat(*form.torque(SymbolicModel.of(arm.chain), given)))
    arguments = tuple(Argument(argument, width, _unit(argument)) for argument, width in widths.items())
    after = (
        f"; out[{n}] on: the memory of the next sample, which starts at {_numbers(form.start())}" if form.memory else ""
    )
    values = [f"{gain} = {_numbers(value)}" for gain, value in form.values().items()]
    text = f"torque of {label_of(controller)}{after}{TUNED}{'; '.join(values)}"
    unit = "N m or N" + (", then of the memory" if form.memory else "")
    return EmittedFunction(
        name, text, arguments, (n + form.memory,), unit, casadi.Function(name, list(x.values()), [out])
    )


def _unit(argument: str) -> str:
    if argument in JOINT:
        return UNITS[JOINT[argument]]
    return {"h": "s, between samples", "memory": "the law's own"}.get(argument) or GAIN_UNITS.get(argument, "SI")


def _numbers(values: object) -> str:
    """Numbers in short; one for all of them where they are equal."""
    flat = np.ravel(np.asarray(values, dtype=np.float64))
    if np.ptp(flat) <= 1e-12 * np.abs(flat).max():
        return f"{flat[0]:.12g}"
    return ", ".join(f"{x:.12g}" for x in flat) if flat.size <= _SHOWN else f"{flat.size} numbers"
