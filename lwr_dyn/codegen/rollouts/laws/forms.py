"""The kernel form of a controller, checked against the controller; which controllers have one."""

from typing import Any

from lwr_dyn.codegen.rollouts.laws.check import check_form
from lwr_dyn.codegen.rollouts.laws.friction_forms import FrictionForm
from lwr_dyn.codegen.rollouts.laws.no_form import NoKernelFormError
from lwr_dyn.codegen.rollouts.laws.protocol import LawForm
from lwr_dyn.control.laws.friction_compensation import FrictionCompensation
from lwr_dyn.control.laws.wrapped import Wrapped
from lwr_dyn.control.protocol import Controller, label_of
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm

_JOINT, _PASSIVE = "lwr_dyn.codegen.rollouts.laws.joint_forms", "lwr_dyn.codegen.rollouts.laws.passivity_forms"
LAW_FORMS: Registry[Any] = Registry(
    "kernel_form",
    {
        "pd-gravity": Row(f"{_JOINT}:PDGravityForm", "both forms of damping", extra="batch"),
        "pid": Row(f"{_JOINT}:PIDForm", "with its integral as memory", extra="batch"),
        "inverse-dynamics": Row(f"{_JOINT}:InverseDynamicsForm", "with every switch", extra="batch"),
        "motor-pd": Row(f"{_JOINT}:MotorSidePDForm", "as it acts on rigid joints", extra="batch"),
        "adaptive": Row(f"{_PASSIVE}:AdaptiveForm", "of a load or all links, with friction if adapted", extra="batch"),
        "robust": Row(f"{_PASSIVE}:RobustForm", "the robust term as a load", extra="batch"),
    },
)
"""By the controller's name: a class with `takes`, the controllers' class, and `of(controller, arm) -> LawForm`."""
WORDS = ("friction", "friction-measured")
"""Of wrappers around a law that have a form too."""


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
        return FrictionForm.of(controller, unchecked_form(controller.inner, arm))
    name = str(getattr(controller, "name", ""))
    if isinstance(controller, Wrapped) or name not in LAW_FORMS.names:
        raise _without(controller)
    kind = LAW_FORMS.load(name)
    if type(controller) is not kind.takes:
        raise _without(controller)
    form: LawForm = kind.of(controller, arm)
    return form


def _without(controller: Controller) -> NoKernelFormError:
    kind = "" if type(controller).__module__.startswith("lwr_dyn.") else f" ({type(controller).__qualname__})"
    return NoKernelFormError(
        "controller", f"{label_of(controller)}{kind} has no form that kernels take",
        f"{', '.join(LAW_FORMS.names)}, plain or with +{' or +'.join(WORDS)}",
    )  # fmt: skip
