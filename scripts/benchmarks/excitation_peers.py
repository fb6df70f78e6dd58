"""Exciting motions of the LWR 4+ scored alike: ours, figaroh's, FloBaRoID's, and the best of random series.

    python scripts/benchmarks/excitation_peers.py [--figaroh PYTHON] [--flobaroid CHECKOUT] [--folder out/excitation]

Sigma is the geometric mean over all base parameters, for as many rows of each motion, whatever its own duration is; the
half-axis is that of their error ellipsoid, exp(d / 2). Clear is the least distance from floor, column and own links at
1 kHz, less what is to be kept.
figaroh's motions are kept in the folder and not made again; of FloBaRoID it is the one that comes with it for this arm,
whose joints are the same. Versions, and how to install them: scripts/benchmarks/identification_peers.py.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]

import lwr_dyn  # noqa: E402
from lwr_dyn.identification.excitation.design import design_excitation, rows_of  # noqa: E402
from lwr_dyn.identification.excitation.motion_limits import MotionLimits, clearance_of  # noqa: E402
from lwr_dyn.identification.excitation.objectives import MotionScore, fourier_basis, motion_score  # noqa: E402
from lwr_dyn.identification.regression.torque_columns import TorqueColumns  # noqa: E402
from lwr_dyn.model.arm import Arm  # noqa: E402
from lwr_dyn.model.run import Motion  # noqa: E402

HERE = Path(__file__).resolve().parent / "peers"
STORED = "model/kuka_lwr4.urdf.trajectory_opt_1.npz"
RUNS = ((0, 60), (2, 60), (0, 200))
"""Seeds and iterations of figaroh."""
DURATION, HARMONICS = 10.0, 5
ROWS = 1000
"""Of which sigma is said: 10 s at 100 Hz."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--figaroh", help="Python of figaroh's environment")
    parser.add_argument("--flobaroid", type=Path, help="its checkout")
    parser.add_argument("--folder", type=Path, default=Path("out/excitation"))
    parser.add_argument("--random", type=int, default=50)
    parser.add_argument("--starts", type=int, nargs="*", default=[1, 4, 8])
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    arm = lwr_dyn.load("lwr4plus", "physical")
    columns = TorqueColumns(arm.chain)
    rows = []
    for objective in ("d", "cond"):
        for starts in given.starts:
            begin = time.process_time()
            found = design_excitation(arm, DURATION, objective, starts, HARMONICS)
            seconds = time.process_time() - begin
            rows.append((f"ours, {objective}, {starts} starts", score(columns, rows_of(found.motion)), seconds))
            rows[-1] += (clear_of(arm, found.sampled(1000.0).q),)
    rows += best_random(arm, columns, given.random)
    rows += figaroh(arm, columns, given.figaroh, given.folder)
    if given.flobaroid is not None:
        rows.append(flobaroid(arm, columns, given.flobaroid))
    best = next(row for row in rows if row[0].startswith("ours, d, 8") or row[0].startswith("ours, d"))
    ours_d = min(row[1].d for row in rows if row[0].startswith("ours, d"))
    ours_sigma = min(row[1].mean_sigma for row in rows if row[0].startswith("ours, d"))
    ours_cond = min(row[1].condition for row in rows if row[0].startswith("ours, cond"))
    print(f"LWR 4+, {DURATION:g} s, {best[1].sigma.size} base parameters")
    print("\n| motion | sigma / ours | half-axis / ours | condition | / ours | -log det | clear [m] | CPU time [s] |")
    print("|---|---|---|---|---|---|---|---|")
    for name, found, seconds, clear in rows:
        axis, share = np.exp((found.d - ours_d) / 2.0), found.condition / ours_cond
        sigma = f"{found.mean_sigma / ours_sigma:.2f} | {axis:.2f}"
        cells = f"{sigma} | {found.condition:.2f} | {share:.2f} | {found.d:.3f} | {clear:+.3f}"
        print(f"| {name} | {cells} | {'' if seconds is None else f'{seconds:.1f}'} |")


def score(columns: TorqueColumns, motion: Motion) -> MotionScore:
    """With torques that are equally noisy at all joints, 1 N m; sigma as of `ROWS` rows."""
    found = motion_score(columns, motion, np.ones(columns.n))
    return replace(found, sigma=found.sigma * np.sqrt(len(motion.t) / ROWS))


def clear_of(arm: Arm, q: np.ndarray) -> float:
    """Least distance less what is kept [m]."""
    return float(clearance_of(arm).of(q).min())


def best_random(arm: Arm, columns: TorqueColumns, count: int) -> list[tuple]:
    """Of as many random series that fill the limits and clear: the best at each objective, and the median."""
    rng, limits = np.random.default_rng(77), MotionLimits.of(arm)
    basis, space = fourier_basis(DURATION, HARMONICS, 10000), clearance_of(arm)
    found, tried, begin = [], 0, time.process_time()
    while len(found) < count:
        X, tried = rng.normal(size=(basis.count, arm.n)), tried + 1
        X[0] = rng.uniform(limits.lower, limits.upper)
        X = limits.fitted(X, basis, fill=True)
        clear = float(space.of(basis.position @ X).min())
        if clear > 0.0:
            found.append((score(columns, rows_of(basis.motion(X))), clear))
    seconds = time.process_time() - begin
    rows = []
    for name in ("d", "condition"):
        one, clear = min(found, key=lambda pair: getattr(pair[0], name))
        rows.append((f"random, best {name} of {count} that clear ({tried} tried)", one, seconds, clear))
    one, clear = sorted(found, key=lambda pair: pair[0].d)[count // 2]
    return [*rows, ("random, median d", one, seconds / tried, clear)]


def figaroh(arm: Arm, columns: TorqueColumns, python: str | None, folder: Path) -> list[tuple]:
    """Its motions, made where they are not in the folder and its Python is given."""
    (folder / "arm.urdf").write_text(limited_urdf(arm))
    rows = []
    for seed, iterations in RUNS:
        file = folder / f"figaroh_{seed}_{iterations}.npz"
        name = f"figaroh 1.0.2, seed {seed}, {iterations} iterations"
        if not file.is_file() and python is not None:
            command = [python, str(HERE / "figaroh_excitation.py"), str(folder), str(seed), str(iterations)]
            subprocess.run(command, check=True, capture_output=True)
        if not file.is_file() and python is not None:
            print(f"({name}: ends without a motion)")
        if file.is_file():
            kept = np.load(file)
            motion = Motion(kept["t"], kept["q"], kept["dq"], kept["ddq"])
            rows.append((name, score(columns, motion), float(kept["seconds"]), clear_of(arm, motion.q)))
    return rows


def flobaroid(arm: Arm, columns: TorqueColumns, checkout: Path) -> tuple:
    """Its stored motion for this arm: the period of it, without the ways from rest before and to rest after it."""
    kept = np.load(checkout / STORED, allow_pickle=True)
    count = round(2.0 * np.pi / float(kept["wf"]) * float(kept["frequency"]))
    first = (len(kept["times"]) - count) // 2
    names = ("times", "positions", "velocities", "accelerations")
    parts = (kept[name][first : first + count] for name in names)
    motion = Motion(*parts)
    name = f"FloBaRoID 0.9.8, stored ({motion.t[-1] - motion.t[0]:.2f} s)"
    return (name, score(columns, motion), None, clear_of(arm, motion.q))


def limited_urdf(arm: Arm) -> str:
    """The arm without shapes, its limits those that our motions keep."""
    limits, root = MotionLimits.of(arm), ET.fromstring(lwr_dyn.urdf_text(arm))
    for link in root.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    joints = {joint.get("name"): joint for joint in root.findall("joint")}
    for j, name in enumerate(arm.joint_names):
        values = {"lower": limits.lower, "upper": limits.upper, "velocity": limits.speed, "effort": limits.torque}
        for key, value in values.items():
            joints[name].find("limit").set(key, repr(float(value[j])))
    return ET.tostring(root, encoding="unicode")


if __name__ == "__main__":
    main()
