"""Every worked example runs as a user runs it and prints what it promises."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"

EXAMPLES = {
    "generate_urdf.py": (["lwr4plus", "--reading", "physical", "--out", "models"], "lwr4plus_physical.urdf"),
    "dynamics_two_roads.py": (["--states", "20"], "coriolis_matrix  largest difference"),
    "own_arm.py": (["--out", "my.toml"], "torque that holds it"),
    "friction_wam.py": (["--out", "maps", "--speeds", "0.1", "0.18", "0.25"], "wrote 3 logs and maps"),
    "stick_slip.py": (["--out", "figures"], "99% of break-away for 1 s: moves by 0 m"),
    "build_models.py": (["--check"], "fresh: "),
    "own_controller.py": ([], "tip error at most 0.00"),
    "compare_controllers.py": ([], "3 kg payload    1. pid"),
    "data_mutants.py": (["lwr4", "--share", "24"], "lwr4: 24 mutants, "),
    "swing.py": (["--seconds", "0.5"], "upright at rest: an equilibrium to the printed digits"),
    "krl_two_points.py": ([], "check: nothing to say"),
    "replay_ist.py": (["--out", "ist.html"], "wrote ist.html"),
    "kr30ha_envelope.py": (["--out", "envelope"], "reach 2032.72 mm, data sheet 2033"),
    "kr30ha_equations_of_motion.py": (["--latex", "equations.tex"], "tau is Pinocchio's to "),
}
NOT_EXAMPLES = {
    "benchmark.py", "benchmark_friction.py", "benchmark_kernels.py", "dynamics_peers.py", "kernel_limit.py",
    "kernel_peers.py", "kernel_processes.py", "recursion_peers.py", "soak.py", "timing.py",
}  # fmt: skip
"""Run by hand; their parts are tested where they live."""


@pytest.mark.parametrize("script", EXAMPLES)
def test_a_worked_example_runs(script, tmp_path):
    arguments, promise = EXAMPLES[script]
    command = [sys.executable, "-W", "error", str(SCRIPTS / script), *arguments]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert promise in done.stdout
    assert done.stderr == ""


def test_no_script_is_left_out_and_none_is_long():
    here = {p.name for p in SCRIPTS.glob("*.py")}
    assert here == set(EXAMPLES) | (NOT_EXAMPLES & here)
    for name in EXAMPLES:
        assert len((SCRIPTS / name).read_text().splitlines()) <= 60
