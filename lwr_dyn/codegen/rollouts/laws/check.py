"""Whether a controller acts as its kernel form: torques at a few states, with the memory of both."""

from collections.abc import Callable, Mapping
from math import isfinite
from typing import Any

import casadi
import numpy as np

from lwr_dyn.codegen.rollouts.laws.no_form import NoKernelFormError
from lwr_dyn.codegen.rollouts.laws.protocol import LawForm, LawInputs
from lwr_dyn.codegen.rollouts.symbolic_model import SymbolicModel
from lwr_dyn.control.protocol import Controller, label_of, reset
from lwr_dyn.foundation.arrays import Array
from lwr_dyn.model.arm import Arm

STEP = 1e-3
"""[s] Between the samples of the check."""
SAMPLES, SEED = 4, 0
ERRORS = (1e-4, 1e-2, 1.0)
"""[rad, rad/s or m] Size of the errors, of as many sequences of samples: inside and outside of layers and limits."""
CLOSE = 1e-9
"""Of the largest torque at a sample: what form and controller may differ by; rounding leaves 1e-14."""
JOINT = ("q", "dq", "q_ref", "dq_ref", "ddq_ref")
Step = Callable[..., tuple[Array, Array]]


def form_function(form: LawForm, arm: Arm) -> Step:
    """The form in NumPy: (q, dq, q_ref, dq_ref, ddq_ref, memory, values, h) -> torque (n,), next memory (m,)."""
    n, names = arm.n, list(form.parameters)
    joint = {name: casadi.SX.sym(name, n) for name in JOINT}
    memory, h = casadi.SX.sym("memory", form.memory), casadi.SX.sym("h")
    gains = {name: casadi.SX.sym(name, int(np.prod(form.parameters[name]))) for name in names}
    x = LawInputs(**joint, memory=memory, parameters=gains, h=h)
    out = form.torque(SymbolicModel.of(arm.chain), x)
    function = casadi.Function("law", [*joint.values(), memory, *gains.values(), h], [casadi.densify(y) for y in out])

    def step(*given: Any) -> tuple[Array, Array]:
        *state, values, time = given
        flat = [np.asarray(values[name], dtype=np.float64).ravel() for name in names]
        tau, after = function(*state, *flat, time)
        return np.array(tau).ravel(), np.array(after).ravel()

    return step


def states_of(arm: Arm) -> Array:
    """Random samples (sequences, samples, 5, n) of q, dq, q_ref, dq_ref, ddq_ref, inside the joint box."""
    rng = np.random.default_rng(SEED)
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    sequences = []
    for error in ERRORS:
        q_ref, dq_ref, ddq_ref = rng.uniform(-1.0, 1.0, (3, SAMPLES, arm.n))
        q_ref = lower + (0.5 + 0.4 * q_ref) * (upper - lower)
        q, dq = (r + error * rng.uniform(-1.0, 1.0, r.shape) for r in (q_ref, dq_ref))
        sequences.append([q, dq, q_ref, dq_ref, ddq_ref])
    return np.swapaxes(sequences, 1, 2)


def check_form(form: LawForm, controller: Controller, arm: Arm) -> None:
    """Compare the controller's torque with its form's; the controller is reset before and after.

    Raises
    ------
    NoKernelFormError
        They differ.
    """
    off, share = differences(form_function(form, arm), form.values(), form.start(), controller, states_of(arm))
    if not share <= CLOSE:
        raise NoKernelFormError(
            "controller",
            f"{label_of(controller)}: its torque is not that of its kernel form for {arm.name} ({arm.reading}), by up "
            f"to {off:.3g} N m",
            "a controller made for this arm, and not changed since",
        )


def differences(
    step: Step, values: Mapping[str, Array], start: Array, controller: Controller, sequences: Array
) -> tuple[float, float]:
    """The largest difference of the torques [N m], and the largest share of the largest torque of its sample."""
    off, share = 0.0, 0.0
    for sequence in sequences:
        reset(controller)
        memory = start
        for k, state in enumerate(sequence):
            own = np.asarray(controller(k * STEP, *np.array(state)), dtype=np.float64)
            tau, memory = step(*state, memory, values, STEP)
            apart, size = float(np.abs(tau - own).max()), max(1.0, float(np.abs(own).max()))
            if not isfinite(apart / size):
                return np.inf, np.inf
            off, share = max(off, apart), max(share, apart / size)
    reset(controller)
    return off, share
