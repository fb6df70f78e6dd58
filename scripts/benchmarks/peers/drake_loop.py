"""Drake: one run of the case, InverseDynamicsController and ZeroOrderHold in a Diagram, Runge-Kutta of order 3.

python drake_loop.py FOLDER 1
"""

import sys
from pathlib import Path

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.controllers import InverseDynamicsController
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource, ZeroOrderHold
from pydrake.trajectories import PiecewisePolynomial
from turns import serve

folder = Path(sys.argv[1])
case = np.load(folder / "case.npz")
(kp, kd), h = case["gains"], 1.0 / float(case["rate"])
count = len(case["q"])
times = np.arange(count) * h


def plant(name: str) -> MultibodyPlant:
    """The arm of a file, with gravity and without contacts."""
    made = MultibodyPlant(time_step=0.0)
    Parser(made).AddModels(str(folder / f"{name}.urdf"))
    made.WeldFrames(made.world_frame(), made.GetFrameByName("base"))
    made.Finalize()
    return made


def diagram() -> tuple[Simulator, MultibodyPlant]:
    """The closed loop."""
    builder, law = DiagramBuilder(), plant("law")
    body = builder.AddSystem(plant("plant"))
    n = body.num_positions()
    controller = builder.AddSystem(InverseDynamicsController(law, [kp] * n, [0.0] * n, [kd] * n, True))
    hold = builder.AddSystem(ZeroOrderHold(h, n))
    state = np.hstack([case["q"], case["dq"]]).T
    wanted = builder.AddSystem(TrajectorySource(PiecewisePolynomial.FirstOrderHold(times, state)))
    rate = builder.AddSystem(TrajectorySource(PiecewisePolynomial.FirstOrderHold(times, case["ddq"].T)))
    builder.Connect(body.get_state_output_port(), controller.get_input_port_estimated_state())
    builder.Connect(wanted.get_output_port(), controller.get_input_port_desired_state())
    builder.Connect(rate.get_output_port(), controller.get_input_port_desired_acceleration())
    builder.Connect(controller.get_output_port_control(), hold.get_input_port())
    builder.Connect(hold.get_output_port(), body.get_actuation_input_port())
    return Simulator(builder.Build()), body


simulator, body = diagram()
integrator = ResetIntegratorFromFlags(simulator, "runge_kutta3", h)
integrator.set_fixed_step_mode(True)
integrator.set_maximum_step_size(h)


def loop() -> np.ndarray:
    """The whole motion; the final positions (1, n)."""
    context = simulator.get_mutable_context()
    context.SetTime(0.0)
    inside = body.GetMyMutableContextFromRoot(context)
    body.SetPositions(inside, case["q"][0])
    body.SetVelocities(inside, case["dq"][0])
    simulator.Initialize()
    simulator.AdvanceTo(times[-1])
    return np.array(body.GetPositions(inside))[None]


if __name__ == "__main__":
    serve(("drake", "numpy"), loop, folder)
