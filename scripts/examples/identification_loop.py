"""A motion that excites, its log of an arm that is not its table and has friction, a fitted arm, what it is worth."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.arms.papers.catalog import open_paper
from lwr_dyn.checks.arm.run_checks import check_arm
from lwr_dyn.foundation.files import make_folder
from lwr_dyn.identification.excitation.design import design_excitation
from lwr_dyn.identification.fitted_files import write_fitted
from lwr_dyn.identification.logs.joint_log import log_of_run, write_log
from lwr_dyn.identification.logs.simulated_logs import LogSensors
from lwr_dyn.identification.motion.motion_fit import identify_motion
from lwr_dyn.model.arm import Arm
from lwr_dyn.model.chain import Body, with_bodies
from lwr_dyn.model.friction import symmetric
from lwr_dyn.simulation.metrics import metrics


def true_arm(table: Arm, rng: np.random.Generator) -> Arm:
    bodies = []
    for link in table.chain.links:
        body, mass, size = link.body or Body.massless(), *np.exp(0.2 * rng.normal(size=2))
        bodies.append(Body(mass * body.mass, body.com * size, body.inertia_com * mass * size**2))
    friction = tuple(symmetric(*rng.uniform((2, 1), (8, 8))) for _ in range(table.n))
    return replace(table, chain=with_bodies(table.chain, bodies), friction=friction)


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/identification"))
    parser.add_argument("--starts", type=int, default=2, help="of the search for a motion")
    options = parser.parse_args(arguments)
    make_folder(options.out)
    table = lwr_dyn.load("lwr4plus", reading="physical")
    truth = true_arm(table, np.random.default_rng(0))
    motion = design_excitation(table, duration=10.0, starts=options.starts).motion
    run = lwr_dyn.simulate(truth, lwr_dyn.controller("inverse-dynamics", table), motion)
    log = LogSensors(torque_noise=0.1, position_noise=1e-5).through(log_of_run(run, rate=1000.0), seed=1)
    log = replace(log, source=str(options.out / "log.csv"))
    write_log(log.source, log)
    found = identify_motion([log], table)
    (file,) = write_fitted(options.out / "fitted.toml", found, open_paper("lwr4plus", "physical"))
    fitted = lwr_dyn.load(file)
    print(f"{found.identified} of {found.base.count} base parameters identified; {file}: {check_arm(fitted).summary()}")
    start, end = np.radians([0, 30, 0, -60, 0, 30, 0]), np.radians([60, 60, 40, 30, -60, -40, 80])
    task = lwr_dyn.reference("point-to-point", table, start=start, end=end, duration=3.0)
    for name, model in (("table", table), ("fitted", fitted), ("truth", truth)):
        law = lwr_dyn.controller("inverse-dynamics" + ("" if name == "table" else "+friction"), model)
        print(f"model {name:6s}: tip error {metrics(lwr_dyn.simulate(truth, law, task), table).tip_max_mm:.3f} mm")


if __name__ == "__main__":
    main()
