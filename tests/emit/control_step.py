"""One step of computed torque: tau = B (ddq_ref + Kd (dq_ref - dq) + Kp (q_ref - q)) + C dq + g, as one function."""

import casadi

import lwr_dyn
from lwr_dyn.codegen.kernel_spec import kernel_spec
from lwr_dyn.codegen.symbolic_dynamics import SymbolicDynamics, column, scalars
from lwr_dyn.emit.functions import UNITS, Argument, EmittedFunction

STATES = ("q", "dq", "q_ref", "dq_ref", "ddq_ref")


def control_step(arm: str) -> EmittedFunction:
    """Of an arm, with a gain a joint as arguments."""
    spec = kernel_spec(lwr_dyn.load(arm))
    names = (*STATES, "Kp", "Kd")
    symbols = {name: scalars(casadi.SX.sym(name, spec.n)) for name in names}
    q, dq, q_ref, dq_ref, ddq_ref, Kp, Kd = symbols.values()
    wanted = ddq_ref + Kd * (dq_ref - dq) + Kp * (q_ref - q)
    torque = SymbolicDynamics.of(spec, q, dq, wanted, {}).applied(wanted)
    function = casadi.Function("control_step", [column(x) for x in symbols.values()], [casadi.SX(torque)])
    units = {**UNITS, "q_ref": UNITS["q"], "dq_ref": UNITS["dq"], "ddq_ref": UNITS["ddq"], "Kp": "1/s^2", "Kd": "1/s"}
    arguments = tuple(Argument(name, spec.n, units[name]) for name in names)
    return EmittedFunction("control_step", "tau", arguments, (spec.n,), UNITS["tau"], function)
