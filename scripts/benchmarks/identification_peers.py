"""The same logs of the same arm fitted here, by figaroh and by FloBaRoID: torque residual, time, links that are bodies.

    python scripts/benchmarks/identification_peers.py --figaroh PYTHON --flobaroid PYTHON CHECKOUT [--plants 5]

figaroh 1.0.2: apt install coinor-libipopt-dev liblapack-dev libblas-dev gfortran; pip install cyipopt figaroh==1.0.2.
FloBaRoID: git clone github.com/kjyv/FloBaRoID; pip install idyntree cvxpy clarabel matplotlib colorama palettable
plotly sympy pyyaml. Each in an environment of its own; a peer that is not given is left out.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]

import lwr_dyn  # noqa: E402
from lwr_dyn.foundation.arrays import Array  # noqa: E402
from lwr_dyn.identification.bodies.body_prior import constraints_of  # noqa: E402
from lwr_dyn.identification.bodies.consistent import consistent_fit  # noqa: E402
from lwr_dyn.identification.bodies.possible_bodies import are_bodies  # noqa: E402
from lwr_dyn.identification.regression.information import information_of  # noqa: E402
from lwr_dyn.identification.regression.samples import exact_samples  # noqa: E402
from lwr_dyn.identification.regression.torque_columns import TorqueColumns  # noqa: E402
from lwr_dyn.model.arm import Arm  # noqa: E402
from tests.identification.consistency_study import table_of  # noqa: E402
from tests.identification.plants import Motion, Plant, perturbed_plant, random_motion  # noqa: E402

HERE = Path(__file__).resolve().parent / "peers"
SLOWEST = 0.1
"""Instants count at which every joint is faster [rad/s]: no two definitions of dry friction differ there."""
FRESH = 4
PERIOD = 10.0
"""Of the random series that logs are cut from, and that fits are judged on [s]."""


@dataclass(frozen=True, slots=True)
class Fit:
    """What a method made of a log: RMS torque errors [N m] on it and on fresh motions (no noise), processor time."""

    name: str
    log: float
    fresh: float
    seconds: float
    physical: float


def moving(motion: Motion, rows: int | None = None) -> Motion:
    """Its instants at which every joint moves."""
    fast = np.flatnonzero((np.abs(motion.dq) > SLOWEST).all(axis=1))[:rows]
    return Motion(motion.t[fast], motion.q[fast], motion.dq[fast], motion.ddq[fast])


class Case:
    """One plant, its noisy log and motions to judge by."""

    def __init__(self, arm: Arm, seed: int, seconds: float, noise: float, rotors: bool) -> None:
        rng = np.random.default_rng([seed, round(10 * seconds), 3])
        self.noise, self.rotors, self.columns = noise, rotors, TorqueColumns(arm.chain)
        self.table = table_of(arm, self.columns, friction=True)
        self.arm = arm
        drawn = perturbed_plant(self.columns, arm, rng).parameters
        if not rotors:
            drawn[self.columns.rotor_indices] = 0.0
        self.plant = Plant(self.columns, drawn)
        texts = [f"{self.columns.names[k]} = 0" for k in self.columns.rotor_indices]
        self.known = None if rotors else constraints_of(texts, self.columns.names)
        whole = random_motion(arm, PERIOD, rng)
        first = rng.integers(0, len(whole.t) - round(100 * seconds) + 1)
        part = slice(first, first + round(100 * seconds))
        self.log = moving(Motion(whole.t[part], whole.q[part], whole.dq[part], whole.ddq[part]))
        exact = self.plant.torque(self.log)
        self.tau = exact + noise * rng.normal(size=exact.shape)
        parts = [moving(random_motion(arm, PERIOD, rng, 20.0)) for _ in range(FRESH)]
        names = ("t", "q", "dq", "ddq")
        self.fresh = Motion(*(np.concatenate([getattr(p, name) for p in parts]) for name in names))
        self.fresh_tau = self.plant.torque(self.fresh)

    def judged(self, name: str, log: Array, fresh: Array, seconds: float, physical: float) -> Fit:
        """Torques (k, n) of a fit on the log and on fresh motions against the truth."""
        misses = (log - self.tau, fresh - self.fresh_tau)
        return Fit(name, *(float(np.sqrt(np.mean(np.square(miss)))) for miss in misses), seconds, physical)

    def ours(self) -> list[Fit]:
        """Least squares (with rotors always) and the consistent fit (which knows where there are none)."""
        samples = exact_samples(self.log.t, self.log.q, self.log.dq, self.log.ddq, self.tau, SLOWEST)
        self.columns.base()  # once per arm; as the peers' set-up, not counted
        start = time.process_time()
        information = information_of(samples, self.columns)
        least = time.process_time() - start
        start = time.process_time()
        fit = consistent_fit(information, self.table, constraints=self.known)
        whole = least + time.process_time() - start
        base = self.columns.base()
        plain = np.zeros(self.columns.count)
        plain[base.kept] = information.values
        found = []
        for name, parameters, seconds in (("least squares", plain, least), ("consistent", fit.parameters, whole)):
            bodies = are_bodies(parameters[: self.columns.bodies].reshape(-1, 10))
            torques = (self.columns(m.q, m.dq, m.ddq) @ parameters for m in (self.log, self.fresh))
            found.append(self.judged(f"lwr_dyn, {name}", *torques, seconds, float(bodies.mean())))
        return found

    def write(self, folder: Path) -> None:
        """What peers read: arm.urdf (with the table's friction) and case.npz."""
        rows = iter(self.table[self.columns.rotor_indices[:, None] + np.arange(1, 3)])
        with_friction = re.sub(
            r"<limit [^>]*/>",
            lambda limit: "{}<dynamics friction='{}' damping='{}'/>".format(limit[0], *next(rows)),
            lwr_dyn.urdf_text(self.arm),
        )
        (folder / "arm.urdf").write_text(with_friction)
        arrays = {
            f"{part}_{name}": getattr(motion, name)
            for part, motion in (("log", self.log), ("fresh", self.fresh))
            for name in ("t", "q", "dq", "ddq")
        }
        friction = {name: self.table[self.columns.rotor_indices + k] for k, name in enumerate(("Ia", "fs", "fv"))}
        links = [link.link for link in self.arm.chain.links]
        np.savez(
            folder / "case.npz", **arrays, log_tau=self.tau, fresh_tau=self.fresh_tau, noise=self.noise,
            rotors=self.rotors, **friction, links=links,
        )  # fmt: skip

    def of_a_peer(self, peer: str, python: str, *arguments: str) -> tuple[str, list[Fit]]:
        """A peer's version and its fits, by its own interpreter."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            self.write(folder)
            command = [python, str(HERE / f"{peer}_fit.py"), name, *arguments]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                raise SystemExit(f"{peer}: {done.stderr[-2000:]}")
            said = json.loads(done.stdout.splitlines()[-1])
            torques = np.load(folder / f"{peer}.npz")
            fits = [
                self.judged(
                    f"{peer}, {answer['name']}", torques[f"{answer['name']}_log"], torques[f"{answer['name']}_fresh"],
                    answer["seconds"], answer["physical"],
                )
                for answer in said["answers"]
            ]  # fmt: skip
        return said["version"], fits


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--figaroh", metavar="PYTHON")
    parser.add_argument("--flobaroid", nargs=2, metavar=("PYTHON", "CHECKOUT"))
    parser.add_argument("--plants", type=int, default=5)
    parser.add_argument("--rotors", action="store_true", help="plants have rotors (FloBaRoID has no column for them)")
    given = parser.parse_args()
    arm = lwr_dyn.load("lwr4plus", "physical")
    versions: dict[str, str] = {"lwr_dyn": lwr_dyn.__version__}
    print(f"(medians of {given.plants} plants {'with' if given.rotors else 'without'} rotors)")
    print("| log | method | on the log, N m | fresh, N m | median s | links that are bodies |")
    print("|---|---|---|---|---|---|")
    for seconds, noise in ((10.0, 0.1), (5.0, 0.5)):
        table: dict[str, list[Fit]] = {}
        for seed in range(given.plants):
            case = Case(arm, seed, seconds, noise, given.rotors)
            fits = case.ours()
            if given.figaroh:
                versions["figaroh"], more = case.of_a_peer("figaroh", given.figaroh)
                fits += more
            if given.flobaroid:
                versions["FloBaRoID"], more = case.of_a_peer("flobaroid", *given.flobaroid)
                fits += more
            for fit in fits:
                table.setdefault(fit.name, []).append(fit)
        for name, fits in table.items():
            middle = [float(np.median([getattr(fit, what) for fit in fits])) for what in ("log", "fresh", "seconds")]
            physical = np.mean([fit.physical for fit in fits])
            print(
                f"| {seconds:g} s, {noise:g} N m | {name} | {middle[0]:.4f} | {middle[1]:.4f} | {middle[2]:.3g} "
                f"| {physical:.0%} |{'' if len(fits) == given.plants else f' {len(fits)} of {given.plants} ended'}",
                flush=True,
            )
    print(versions)


if __name__ == "__main__":
    main()
