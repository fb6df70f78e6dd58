"""The arms whose emitted code is run."""

from functools import cache

import lwr_dyn
from lwr_dyn.codegen.emit.functions import emitted_function
from lwr_dyn.codegen.kernels.kernel_spec import kernel_spec
from tests.codegen.emit.digests import EmittedRobot

ARMS = ("lwr4plus", "wam7", "kr30ha")
DYNAMICS = ("inverse_dynamics", "forward_dynamics", "mass_matrix", "coriolis_matrix", "gravity_vector")


@cache
def emitted_robot(name: str, functions: tuple[str, ...] = DYNAMICS) -> EmittedRobot:
    """An arm with some functions."""
    arm = lwr_dyn.load(name)
    spec = kernel_spec(arm)
    return EmittedRobot(name, [emitted_function(spec, function, arm) for function in functions])
