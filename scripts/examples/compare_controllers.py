"""Controllers on IST, on the arm of their model and on two other arms: ranked by the RMS error of the tip."""

from __future__ import annotations

import argparse

import lwr_dyn
from lwr_dyn.control.controllers import CONTROLLERS
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.simulation.plant import arm_with_payload, arm_with_scaled_inertia


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--timing", default="smooth", help="constant, quintic, smooth or smooth-blended")
    parser.add_argument("--payload", type=float, default=3.0, help="kg at the flange, unknown to the controllers")
    parser.add_argument("--heavier", type=float, default=1.1, help="factor on all masses, unknown to the controllers")
    options = parser.parse_args(arguments)

    arm = lwr_dyn.load("lwr4plus")
    reference = lwr_dyn.reference("ist", arm, timing=options.timing)
    controllers = {name: lwr_dyn.controller(name, arm) for name in CONTROLLERS.names}
    plants = {
        "as modelled": arm,
        f"{options.heavier:g} x heavier": arm_with_scaled_inertia(arm, options.heavier),
        f"{options.payload:g} kg payload": arm_with_payload(arm, options.payload),
    }
    for plant_name, plant in plants.items():
        results = []
        for name, controller in controllers.items():
            run = lwr_dyn.simulate(arm, controller, reference, plant=plant)
            results.append((metrics(run, arm), name, run.meta["audit"]["residual"]))
        for place, (m, name, audit) in enumerate(sorted(results, key=lambda x: x[0].tip_rms_mm), start=1):
            kept = "limits kept" if m.within_limits else "LIMITS NOT KEPT"
            errors = f"tip RMS {m.tip_rms_mm:8.4f} mm, max {m.tip_max_mm:8.4f} mm"
            print(f"{plant_name:15s} {place}. {name:17s} {errors}, {kept}, audit {audit:.0e} J")


if __name__ == "__main__":
    main()
