"""Controllers by name, or from a Python file of one's own."""

from collections.abc import Callable
from inspect import signature
from typing import Any

from lwr_dyn.control.controller_file import controller_from_file
from lwr_dyn.control.protocol import Controller
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import Dynamics
from lwr_dyn.foundation.arrays import arm_argument
from lwr_dyn.foundation.registry import Registry, Row
from lwr_dyn.model.arm import Arm

CONTROLLERS: Registry[Callable[..., Controller]] = Registry(
    "controller",
    {
        "pd-gravity": Row("lwr_dyn.control.pd_gravity:tuned_pd_gravity", "PD with gravity compensation"),
        "pid": Row("lwr_dyn.control.pid:tuned_pid", "PID with back-calculation against wind-up"),
        "inverse-dynamics": Row(
            "lwr_dyn.control.inverse_dynamics:tuned_inverse_dynamics", "inverse dynamics: the model linearises the arm"
        ),
        "motor-pd": Row(
            "lwr_dyn.control.laws.motor_side_pd:tuned_motor_side_pd", "PD on the motor side of elastic joints"
        ),
        "joint-impedance": Row(
            "lwr_dyn.control.laws.joint_impedance:tuned_joint_impedance",
            "joints as springs; the damping fits every pose",
        ),
        "cartesian-impedance": Row(
            "lwr_dyn.control.laws.cartesian_impedance:tuned_cartesian_impedance", "the tip as a spring in space"
        ),
        "hand-guiding": Row(
            "lwr_dyn.control.laws.hand_guiding:tuned_hand_guiding", "weight and friction carried; a hand moves the arm"
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
            "lwr_dyn.control.laws.observed:observed", "external torque and collisions by a momentum observer"
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
    own = {w: {k: options[k] for k in signature(WRAPPERS.load(w)).parameters if k in options} for w in wrappers}
    rest = {k: value for k, value in options.items() if not any(k in keys for keys in own.values())}
    make = controller_from_file if law.endswith(".py") else CONTROLLERS.make
    controller: Controller = make(law, arm, dynamics, **rest)
    for wrapper in wrappers:
        controller = WRAPPERS.make(wrapper, controller, arm, dynamics, **own[wrapper])
    return controller
