"""Runs in FloBaRoID's environment: its fits of a log, judged on motions that it does not see.

flobaroid_fit.py FOLDER CHECKOUT: arm.urdf and case.npz in, flobaroid.npz out; the variants' names are on stdout.
Its pull of friction to the URDF's and its second fit of friction are off: both made every answer here worse.
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
import yaml
from bodies import share_of_bodies
from idyntree import bindings

folder, checkout = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
sys.path.insert(0, str(checkout))
os.environ["MPLBACKEND"] = "Agg"
_EMPTY = bindings.Vector6


def _zeroed() -> object:
    """A vector of zeros: its own is left uninitialised for fixed bases, which puts NaN into the regressor."""
    vector = _EMPTY()
    vector.zero()
    return vector


bindings.Vector6 = _zeroed
from identification.data import Data  # noqa: E402
from identifier import Identification  # noqa: E402

KEYS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
VARIANTS = {
    "least squares": {"constrainToConsistent": 0},
    "LMI": {"identifyClosestToCAD": 0},
    "LMI, closest to the table": {"identifyClosestToCAD": 1, "cadRegularizationMode": "observability"},
    "LMI, log-det to the table": {"identifyClosestToCAD": 1, "cadRegularizationMode": "geometric"},
}
PLAIN = {
    "floatingBase": 0, "identifyFrictionSimultaneously": 1, "identifySymmetricVelFriction": 1, "useAPriori": 0,
    "simulateTorques": 0, "useStructuralRegressor": 1, "identifyGravityParamsOnly": 0, "startOffset": 0,
    "skipSamples": 0, "selectBlocksFromMeasurements": 0, "createPlots": 0, "verbose": 0, "showTiming": 0,
    "filterRegressor": 0, "estimateWith": "std", "restrictCOMtoHull": 0, "limitOverallMass": 0,
    "limitMassToApriori": 0, "constrainToConsistent": 1, "checkAPrioriFeasibility": 0, "postIdentifyFriction": 0,
    "frictionRegularization": 0,
}  # fmt: skip
case = np.load(folder / "case.npz")
with open(checkout / "configs" / "kuka_lwr4.yaml") as stream:
    config = {**yaml.safe_load(stream), **PLAIN}
for part in ("log", "fresh"):
    of = {"positions": "q", "velocities": "dq", "accelerations": "ddq", "torques": "tau", "times": "t"}
    np.savez(folder / f"{part}.npz", **{name: case[f"{part}_{key}"] for name, key in of.items()})


def fit(options: dict) -> tuple[Identification, float]:
    """A fit, and its time without reading the model and its structural regressor."""
    files = [[str(folder / "log.npz")]]
    made = Identification({**config, **options}, str(folder / "arm.urdf"), None, files, None, None)
    start = time.process_time()
    made.estimateParameters()
    return made, time.process_time() - start


answers, out = [], {}
for name, options in VARIANTS.items():
    with contextlib.redirect_stdout(io.StringIO()):
        made, seconds = fit(options)
        theta = np.array(made.model.xStd)
        torques = {"log": made.model.YStd @ theta[made.model.identified_params]}
        other = Data(made.opt)
        other.init_from_files([[str(folder / "fresh.npz")]])
        made.model.computeRegressors(other)
        torques["fresh"] = made.model.YStd @ theta[made.model.identified_params]
    moving = [i for i, link in enumerate(made.model.linkNames) if link in set(case["links"].tolist())]
    for part, tau in torques.items():
        out[f"{name}_{part}"] = tau.reshape(-1, made.model.num_dofs)
    physical = share_of_bodies(theta[: 10 * made.model.num_links].reshape(-1, 10)[moving], KEYS)
    answers.append({"name": name, "seconds": seconds, "physical": physical})
np.savez(folder / "flobaroid.npz", **out)
said = subprocess.run(["git", "-C", str(checkout), "log", "-1", "--format=%h, %cs"], capture_output=True, text=True)
print(json.dumps({"version": said.stdout.strip(), "answers": answers}))
