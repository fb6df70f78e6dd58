"""Runs in FloBaRoID's environment: its fits of a log, judged on motions that it does not see.

flobaroid_fit.py FOLDER CHECKOUT: arm.urdf and case.npz in, flobaroid.npz out; the variants' names are on stdout.
"""

import contextlib
import io
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

folder, checkout = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
sys.path.insert(0, str(checkout))
os.environ["MPLBACKEND"] = "Agg"
case = np.load(folder / "case.npz")
GEOMETRIC = {"cadRegularizationMode": "geometric"}
VARIANTS = {
    "least squares": {"constrainToConsistent": 0},
    "LMI": {"identifyClosestToCAD": 0},
    "LMI, closest to the table": {"identifyClosestToCAD": 1, "cadRegularizationMode": "observability"},
    "LMI, log-det to the table": {"identifyClosestToCAD": 1, **GEOMETRIC},
}
PLAIN = {
    "floatingBase": 0, "identifyFrictionSimultaneously": 1, "identifySymmetricVelFriction": 1, "useAPriori": 0,
    "simulateTorques": 0, "useStructuralRegressor": 1, "identifyGravityParamsOnly": 0, "startOffset": 0,
    "skipSamples": 0, "selectBlocksFromMeasurements": 0, "createPlots": 0, "verbose": 0, "showTiming": 0,
    "filterRegressor": 0, "estimateWith": "std", "restrictCOMtoHull": 0, "limitOverallMass": 0,
    "limitMassToApriori": 0, "constrainToConsistent": 1, "checkAPrioriFeasibility": 0, "postIdentifyFriction": 0,
}  # fmt: skip


def main() -> None:
    import yaml
    from idyntree import bindings

    empty = bindings.Vector6

    def zeroed() -> object:
        vector = empty()  # left uninitialised for fixed bases: NaN in the regressor
        vector.zero()
        return vector

    bindings.Vector6 = zeroed
    from identification.data import Data
    from identifier import Identification

    with open(checkout / "configs" / "kuka_lwr4.yaml") as stream:
        config = {**yaml.safe_load(stream), **PLAIN}
    for part in ("log", "fresh"):
        names = {"positions": "q", "velocities": "dq", "accelerations": "ddq", "torques": "tau", "times": "t"}
        np.savez(folder / f"{part}.npz", **{name: case[f"{part}_{key}"] for name, key in names.items()})
    answers, out, silent = [], {}, io.StringIO()
    for name, options in VARIANTS.items():
        with contextlib.redirect_stdout(silent):
            start = time.process_time()
            fit = Identification({**config, **options}, str(folder / "arm.urdf"), None, [[str(folder / "log.npz")]], None, None)
            setup = time.process_time() - start
            start = time.process_time()
            fit.estimateParameters()
            seconds = time.process_time() - start
            theta = np.array(fit.model.xStd)
            torques = {"log": fit.model.YStd @ theta[fit.model.identified_params]}
            other = Data(fit.opt)
            other.init_from_files([[str(folder / "fresh.npz")]])
            fit.model.computeRegressors(other)
            torques["fresh"] = fit.model.YStd @ theta[fit.model.identified_params]
        moving = [i for i, link in enumerate(fit.model.linkNames) if link in set(case["links"].tolist())]
        physical = [bool(np.linalg.eigvalsh(pseudo_inertia(theta[10 * i : 10 * i + 10]))[0] > 0.0) for i in moving]
        for part, tau in torques.items():
            out[f"{name}_{part}"] = tau.reshape(-1, fit.model.num_dofs)
        answers.append({"name": name, "seconds": seconds, "setup": setup, "physical": float(np.mean(physical))})
    np.savez(folder / "flobaroid.npz", **out)
    said = subprocess.run(["git", "-C", str(checkout), "log", "-1", "--format=%h, %cs"], capture_output=True, text=True)
    print(json.dumps({"version": said.stdout.strip(), "answers": answers}))


def pseudo_inertia(p: np.ndarray) -> np.ndarray:
    m, mx, my, mz, xx, xy, xz, yy, yz, zz = p
    half = (xx + yy + zz) / 2
    return np.array([[half - xx, -xy, -xz, mx], [-xy, half - yy, -yz, my], [-xz, -yz, half - zz, mz], [mx, my, mz, m]])


main()
