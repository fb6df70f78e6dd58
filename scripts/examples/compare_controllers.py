"""Controllers on ist-clear, on the arm of their model and on two other arms: ranked by the RMS error of the tip.

The errors are those of an arm with rigid links and joints. With --task ist, the paper's path as it is printed, joint 6
starts 1.2 degrees from its limit: with the payload it comes to rest on its stop, and the table says so.
"""

from __future__ import annotations

import argparse

import numpy as np

import lwr_dyn
from lwr_dyn.control.controllers import CONTROLLERS
from lwr_dyn.control.protocol import label_of
from lwr_dyn.simulation.metrics import RIGID, metrics
from lwr_dyn.simulation.plant import arm_with_payload, arm_with_scaled_inertia


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", default="ist-clear", choices=["ist-clear", "ist"])
    parser.add_argument("--timing", default="smooth", help="constant, quintic, smooth or smooth-blended")
    parser.add_argument("--payload", type=float, default=3.0, help="kg at the flange, unknown to the controllers")
    parser.add_argument("--heavier", type=float, default=1.1, help="factor on all masses, unknown to the controllers")
    parser.add_argument("--no-stops", action="store_true", help="let joints pass their position limits")
    options = parser.parse_args(arguments)

    arm = lwr_dyn.load("lwr4plus")
    reference = lwr_dyn.reference(options.task, arm, timing=options.timing)
    controllers = [lwr_dyn.controller(name, arm) for name in CONTROLLERS.names]
    plants = {
        "as modelled": arm,
        f"{options.heavier:g} x heavier": arm_with_scaled_inertia(arm, options.heavier),
        f"{options.payload:g} kg payload": arm_with_payload(arm, options.payload),
    }
    margin = f"every joint at least {np.degrees(reference.margin):.1f} deg from its limits"
    print(f"{options.task}, {options.timing}: {margin}; errors of the tip: {RIGID}")
    for plant_name, plant in plants.items():
        results = []
        for controller in controllers:
            run = lwr_dyn.simulate(arm, controller, reference, plant=plant, position_limits=not options.no_stops)
            results.append((metrics(run, arm), label_of(controller), run.meta["audit"]["residual"]))
        for place, (m, name, audit) in enumerate(sorted(results, key=lambda x: x[0].tip_rms_mm), start=1):
            errors = f"tip RMS {m.tip_rms_mm:8.4f} mm, max {m.tip_max_mm:8.4f} mm"
            print(f"{plant_name:15s} {place}. {name:34s} {errors}, audit {audit:.0e} J; limits {m.limits}")


if __name__ == "__main__":
    main()
