"""Your own controller: a function of (t, q, dq, q_ref, dq_ref, ddq_ref), here computed torque with a speed limit."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.foundation.files import make_folder
from lwr_dyn.simulation.audit import audit_words
from lwr_dyn.simulation.metrics import metrics


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stiffness", type=float, default=900.0, help="1/s^2")
    parser.add_argument("--out", type=Path, default=Path("out/own_controller.npz"))
    options = parser.parse_args(arguments)

    arm = lwr_dyn.load("lwr4plus")
    model = lwr_dyn.dynamics_of(arm)
    Kp, Kd = options.stiffness, 2 * np.sqrt(options.stiffness)

    def gentle(t, q, dq, q_ref, dq_ref, ddq_ref):  # type: ignore[no-untyped-def]
        """Inverse dynamics whose correction is never more than 5 rad/s^2."""
        correction = Kp * (q_ref - q) + Kd * (dq_ref - dq)
        return model.inverse_dynamics(q, dq, ddq_ref + np.clip(correction, -5.0, 5.0))

    run = lwr_dyn.simulate(arm, gentle, lwr_dyn.reference("ist", arm))
    make_folder(options.out.parent)
    run.save(options.out)
    errors = metrics(run, arm)
    tip = f"tip error ({errors.caveat}) at most {errors.tip_max_mm:.4f} mm"
    print(f"{tip}, audit {audit_words(run.audit)}")
    print(f"wrote {options.out}; see it:  lwr-dyn replay {options.out} --html {options.out.with_suffix('.html')}")


if __name__ == "__main__":
    main()
