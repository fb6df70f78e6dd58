"""The full counts of what the tests only sample: prints a table; exit 1 when a line fails. Takes some minutes."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import lwr_dyn
from lwr_dyn.checks.run_checks import check_arm
from lwr_dyn.kinematics.inverse import inverse_kinematics
from lwr_dyn.papers.catalog import open_paper
from lwr_dyn.trajectory.references.ist import ist_reference
from lwr_dyn.trajectory.timings import MOTION_PROFILES

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))  # some counts are those of `tests`
EXACT, METRES = 1e-12, 1e-12
STATED_ELSEWHERE = ("the maker's", "as printed", "data sheet")
"""Ends of the names of checks against a second statement of the arm, which the reading `printed` may not meet."""

Line = Callable[[], tuple[str, bool]]


def properties() -> tuple[str, bool]:
    """Every hypothesis property, 2000 examples each."""
    environment = os.environ | {"LWR_DYN_HYPOTHESIS": "soak"}
    command = [sys.executable, "-m", "pytest", "-q", "-m", "hypothesis", "tests"]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    return done.stdout.strip().splitlines()[-1], done.returncode == 0


def checks() -> tuple[str, bool]:
    """Every robot and reading over 100 000 states; data-sheet checks count for default readings only."""
    failed, elsewhere, worst = [], 0, 0.0
    for robot in lwr_dyn.robots():
        for reading in lwr_dyn.readings(robot):
            report = check_arm(lwr_dyn.load(robot, reading), open_paper(robot, reading), states=100_000, seed=1)
            fails = [v.name for v in report.verdicts if not v.holds]
            counted = [x for x in fails if reading == lwr_dyn.readings(robot)[0] or not x.endswith(STATED_ELSEWHERE)]
            failed += [f"{robot} {reading}: {name}" for name in counted]
            elsewhere += len(fails) - len(counted)
            worst = max([worst, *(v.value for v in report.verdicts if "road A - road B" in v.name)])
    words = f"roads differ by {worst:.1e} relative at most; failed: {', '.join(failed) or 'none'}"
    return f"{words}; poses and envelope that other readings do not meet: {elsewhere}", not failed


def poses() -> tuple[str, bool]:
    """Closed-form inverse kinematics of the LWR over 20 000 random poses inside the limits."""
    arm, rng = lwr_dyn.load("lwr4plus"), np.random.default_rng(5)
    solved, residual = 0, 0.0
    for q in rng.uniform(arm.lower, arm.upper, (20_000, arm.n)):
        T = lwr_dyn.forward_kinematics(arm, q)
        result = inverse_kinematics(arm, T)
        solved += result.status == "solved"
        back = [np.abs(lwr_dyn.forward_kinematics(arm, s.q) - T).max() for s in result.solutions]
        residual = max([residual, *map(float, back)])
    return f"{solved} of 20000 solved, residual {residual:.1e}", solved == 20_000 and residual <= METRES


def runs() -> tuple[str, bool]:
    """The audit of energy and inverse dynamics of every controller, timing and reading on IST."""
    from lwr_dyn.control.controllers import CONTROLLERS, make_controller

    energy, torque, closed, count = 0.0, 0.0, 0, 0
    for reading in lwr_dyn.readings("lwr4plus"):
        arm = lwr_dyn.load("lwr4plus", reading)
        for timing in MOTION_PROFILES.rows:
            reference = ist_reference(arm, timing)
            for name in CONTROLLERS.rows:
                run = lwr_dyn.simulate(arm, make_controller(name, arm), reference)
                energy = max(energy, run.audit["residual"])
                torque = max(torque, run.audit["inverse_dynamics"]["residual"])
                closed, count = closed + run.audit["closed"], count + 1
    return f"{closed} of {count} runs of 14 s closed, to {energy:.1e} J and {torque:.1e} N m", closed == count


def ist_clear() -> tuple[str, bool]:
    """The shift of `ist-clear` is the best of its grid."""
    from ist_clear import line

    return line()


def coverage() -> tuple[str, bool]:
    """3-sigma intervals of the WAM's friction over 200 noise draws on one simulated set of logs."""
    from lwr_dyn.control.pd_gravity import PDGravity
    from lwr_dyn.identification.simulated_logs import LogSensors, cruise_logs
    from tests.identification.simulated import interval_coverage

    arm = lwr_dyn.load("wam7")
    Kd = np.array(arm.gains.Kd)
    Kd[3] = 8.0  # with the maker's 2 joint 4 has no net damping and no cruise
    controller = PDGravity(lwr_dyn.dynamics_of(arm), arm.gains.Kp, Kd, velocity_error=True)
    start, speeds = np.array([0.0, -1.5, 0.0, 1.6, 0.0, 0.0, 0.0]), (0.06, 0.1, 0.14, 0.19, 0.25)
    logs = list(cruise_logs(arm, controller, start, np.full(7, 0.5), speeds))
    result = interval_coverage(logs, arm, LogSensors(torque_noise=0.05, resolution=2e-5), range(200))
    return f"{result.share:.2%} of {result.intervals} cover the truth", 0.993 <= result.share <= 1.0


def long_log() -> tuple[str, bool]:
    """A log of 1 000 000 rows and 15 columns identified, in a process of its own (10 s, 1 GB)."""

    from tests.identification.simulated import ideal_cruise

    arm, rows = lwr_dyn.load("wam7"), 1_000_000
    once = [ideal_cruise(arm.friction, np.full(7, v), arm) for v in (0.1, -0.1, 0.2, -0.2)]
    turn = np.vstack([np.hstack([log.q, log.tau]) for log in once])
    table = np.tile(turn, (-(-rows // len(turn)), 1))[:rows]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.csv"
        head = ",".join(["time", *(f"{x}{j}" for x in ("q", "tau") for j in range(1, 8))])
        np.savetxt(path, np.column_stack([np.arange(rows) / 100, table]), "%.9g", ",", header=head, comments="")
        code, seconds, gigabytes, _ = command("identify", "friction", str(path), "--robot", "wam7")
    return f"{seconds:.1f} s, {gigabytes:.2f} GB", code == 0 and seconds < 10.0 and gigabytes < 1.0


_COMMAND = """
import sys, time
from pathlib import Path
from lwr_dyn.cli.main import main
start, code = time.perf_counter(), 0
try:
    main(sys.argv[1:])
except SystemExit as end:
    code = end.code
peak = int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0])
print(f"{code} {time.perf_counter() - start} {peak / 1e6}", file=sys.stderr)
"""


def command(*arguments: str) -> tuple[int, float, float, str]:
    """`lwr-dyn` in a process of its own: exit code, seconds, peak memory [GB], what it printed."""
    done = subprocess.run([sys.executable, "-c", _COMMAND, *arguments], capture_output=True, text=True)
    code, seconds, gigabytes = done.stderr.strip().splitlines()[-1].split()
    return int(code), float(seconds), float(gigabytes), done.stdout


def krl() -> tuple[str, bool]:
    """100 000 mutated KRL programs end in a diagnosis or a program."""
    environment = os.environ | {"LWR_DYN_KRL_FUZZ": "100000"}
    command = [sys.executable, "-m", "pytest", "-q", "tests/krl/test_fuzz.py"]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    return done.stdout.strip().splitlines()[-1], done.returncode == 0


def krl_large() -> tuple[str, bool]:
    """A KRL program of 100 000 lines, read and checked."""
    rows = ["DEF big( )", "REAL x", "BAS(#VEL_PTP, 100)", "$VEL.CP = 0.3", "x = 0"]
    rows += ["PTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}", "PTP {X 1200, Y 0, Z 1300, A 0, B 90, C 0, S 2, T 2}"]
    while len(rows) < 99_999:
        i = len(rows)
        place = f"X {1200 + i % 97}.{i % 89}, Y {i % 83}, Z {1300 + i % 79}, A 0.0, B 90.0, C 0.0"
        rows += [f"IF x < {i} THEN", f"  x = x + {i}.5 ; {i}", "ENDIF", f"LIN {{{place}}} C_DIS"]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "big.src"
        path.write_text("\r\n".join([*rows[:99_999], "END"]))
        code, seconds, gigabytes, output = command("krl", "check", str(path))
    good = code == 0 and seconds < 20.0 and gigabytes < 1.0
    return f"{seconds:.1f} s, {1e3 * gigabytes:.0f} MB; {output.strip().splitlines()[-1].rpartition(': ')[2]}", good


def lint() -> tuple[str, bool]:
    """Lint: false alarms on 1000 random correct tables, and the share it finds of 1000 faults of each kind."""
    from tests.audit.lint.faulty_sheets import FAULTS, detection, false_alarms

    alarms = false_alarms(1000, seed=1)
    detected = {fault: detection(fault, 1000, seed=2) for fault in FAULTS}
    shares = ", ".join(f"{fault} {share:.0%}" for fault, share in detected.items())
    return f"{len(alarms)} false alarms; found: {shares}", not alarms and min(detected.values()) >= 0.6


def recovery() -> tuple[str, bool]:
    """Conventions of 1000 scrambled tables that their evidence decides, recovered."""
    from tests.audit.conventions.recovery import recovery as recovered

    result = recovered(1000)
    return result.statement(), result.rate >= 0.99 and result.kept_or_recovered == 1.0


def kernels() -> tuple[str, bool]:
    """Every generated function of every robot against Pinocchio over 100 000 states."""
    from benchmarks.kernel_peers import agreement

    arms = [lwr_dyn.load(robot) for robot in lwr_dyn.robots()]
    worst = {arm.name: agreement(arm, 100_000) for arm in arms if arm.chain.bodies is not None}
    words = "; ".join(
        f"{name} {max(differences.values()):.1e} ({max(differences, key=differences.get)})"
        for name, differences in worst.items()
    )
    return words, max(max(differences.values()) for differences in worst.values()) <= EXACT


def foreign_arms() -> tuple[str, bool]:
    """`check` on every URDF of the installed packages: no traceback, none over 30 s (a line each: foreign_arms.py)."""
    from collections import Counter

    from foreign_arms import BAD_KINDS, has_moving_joint, installed_urdfs, survey

    outcomes = survey([path for path in installed_urdfs(sys.path[1:]) if has_moving_joint(path)], processes=2)
    kinds = Counter(outcome.kind for outcome in outcomes)
    words = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    return f"{words}; longest {max(x.seconds for x in outcomes):.1f} s", not BAD_KINDS & set(kinds)


def data_mutants() -> tuple[str, bool]:
    """Every numeric cell of every data file changed in four ways, one at a time; survivors: scripts/data_mutants.py."""
    from data_mutants import surveyed

    from lwr_dyn.reproduction.study import studies
    from tests.reproduction.mutants import mutants

    surveys = {paper: surveyed(paper, list(mutants(paper)), 2) for paper in studies()}
    missed = sum(len(one.missed) for one in surveys.values())
    words = ", ".join(f"{paper} {one.share:.1%} of {len(one.fates)} seen" for paper, one in surveys.items())
    return f"{words}; moved a number by more than its last digit unseen: {missed}", missed == 0


def core() -> tuple[str, bool]:
    """All tests of the core in an environment of its own, from a built wheel, the optional packages deleted."""
    from tests.custody.core_alone import EVERYTHING, FOLDERS, installed_core, run_tests

    with tempfile.TemporaryDirectory() as folder:
        process = run_tests(installed_core(Path(folder), EVERYTHING), Path(folder), FOLDERS)
    return process.stdout.strip().splitlines()[-1], process.returncode == 0


def parity() -> tuple[str, bool]:
    """Every committed model in Pinocchio, MuJoCo, Drake and PyBullet against ours (pip install '.[parity]')."""
    from tests.parity.comparison import summary

    return summary(states=1000)


LINES: dict[str, Line] = {
    "properties": properties,
    "checks": checks,
    "poses": poses,
    "runs": runs,
    "ist_clear": ist_clear,
    "coverage": coverage,
    "long_log": long_log,
    "lint": lint,
    "krl": krl,
    "krl_large": krl_large,
    "recovery": recovery,
    "kernels": kernels,
    "foreign_arms": foreign_arms,
    "data_mutants": data_mutants,
    "parity": parity,
    "core": core,
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("lines", nargs="*", help=f"which to run: {', '.join(LINES)} (all if not given)")
    options = parser.parse_args()
    good = True
    print("| what | result | verdict | s |\n|---|---|---|---|")
    for name in options.lines or LINES:
        start = time.perf_counter()
        result, holds = LINES[name]()
        good = good and holds
        seconds = time.perf_counter() - start
        print(f"| {LINES[name].__doc__} | {result} | {'holds' if holds else 'FAILS'} | {seconds:.0f} |", flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
