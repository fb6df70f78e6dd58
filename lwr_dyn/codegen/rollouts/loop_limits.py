"""What the loop "compiled" lacks, refused by name before a run, and where a run comes to it."""

import numpy as np

from lwr_dyn.codegen.kernels.sincos import sincos
from lwr_dyn.codegen.rollouts.small_turn import LARGEST
from lwr_dyn.codegen.rollouts.step import MOST_DELAY
from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.dynamics.protocol import ungated
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.simulation.record import Log
from lwr_dyn.simulation.sensors import Encoder
from lwr_dyn.simulation.setup import Setup

USUAL, STICK = "the usual loop (the default)", "true stick (friction set-valued)"
SAME = 1e-9
"""Share of the largest torque by which the plant's engine may differ from the plant with rotors as armature."""


def check_setup(setup: Setup) -> None:
    """Raise `OptionError` for what the loop does not have, and name it."""
    options, friction, encoder = setup.options, setup.plant.friction.form, setup.encoder
    own_encoder = encoder is not None and type(encoder).sensor is not Encoder.sensor
    lacking = {
        "elastic joints": setup.elasticity is not None, "external torques": setup.external is not None,
        "a controller at every moment": options.continuous, f"method {options.method}": options.method != "rk4",
        STICK: friction == "set-valued", "friction by a function": friction == "given",
        f"a delay of {options.delay} samples (at most {MOST_DELAY})": options.delay > MOST_DELAY,
        "an encoder with a sensor of its own": own_encoder,
    }  # fmt: skip
    for what in (name for name, is_asked in lacking.items() if is_asked):
        smooth = "friction smooth or none, or " if what == STICK else ""
        raise OptionError("loop", f"compiled, which does not have {what}", smooth + USUAL)
    _check_engine(setup)


def _check_engine(setup: Setup) -> None:
    """Raise `OptionError` where the plant's engine is not of the plant with rotors as armature."""
    plant, state = setup.plant, (*setup.start, np.ones(setup.plant.n))
    own = plant.ungated.inverse_dynamics(*state)
    other = ungated(dynamics_of(plant.arm)).inverse_dynamics(*state)
    if not np.abs(own - other).max() <= SAME * max(1.0, float(np.abs(other).max())):
        fault = "compiled, which does not have an engine other than that of the plant with rotors as armature"
        raise OptionError("loop", fault, USUAL)


def refuse_ends(setup: Setup, log: Log) -> None:
    """Raise `OptionError` where a joint came to its stop, or the kernel could not follow the motion; with the time."""
    step = 1.0 / (setup.options.rate * setup.options.substeps)
    most = (sincos("float64").most_half_turns - 1) * np.pi
    q, dq = np.moveaxis(log.states, 1, 0)
    with np.errstate(invalid="ignore"):
        lost = ~((np.abs(dq) * step <= LARGEST) & (np.abs(q) <= most) & np.isfinite(log.command))
    beyond = setup.plant.beyond(q)
    rows = np.flatnonzero((lost | beyond).any(axis=1))
    if not rows.size:
        return
    k = int(rows[0])
    joint = setup.plant.arm.joint_names[int(np.flatnonzero((lost | beyond)[k])[0])]
    if lost[k].any():
        fault = f"compiled, which cannot follow {joint} at {log.t[k]:.6g} s: above {LARGEST:g} rad a step, or no number"
        raise OptionError("loop", fault, f"a higher rate or more substeps, or {USUAL}")
    fault = f"compiled, which has no stops, and {joint} reaches its own before {log.t[k]:.6g} s"
    raise OptionError("loop", fault, f"position_limits=False, or {USUAL}")
