"""Every worked example runs as a user runs it, prints what it promises, and writes to `out/` only."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.blocks import blocks

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"

EXAMPLES = {
    "generate_urdf.py": (["lwr4plus", "--reading", "computed"], "lwr4plus_computed.urdf"),
    "dynamics_two_roads.py": (["--states", "20"], "coriolis_matrix  largest difference"),
    "own_arm.py": ([], "torque that holds it"),
    "stick_slip.py": (["--out", "out/figures"], "99% of break-away for 1 s: moves by 0 m"),
    "own_controller.py": ([], "tip error (rigid links and joints) at most 0.00"),
    "compare_controllers.py": ([], "PID + gravity, damping on dq        3 kg at the flange  1.529 *"),
    "swing.py": (["--seconds", "0.5"], "upright at rest: an equilibrium to the printed digits"),
    "krl_two_points.py": ([], "check: no findings"),
    "replay_ist.py": ([], "wrote out/ist.html"),
    "kr30ha_envelope.py": ([], "reach 2032.72 mm, data sheet 2033"),
}
ON_PAGES = {
    "friction_wam.py": "friction_from_logs.md",
    "robot_logs.py": "logs_of_your_robot.md",
    "identification_loop.py": "identify_your_arm.md",
    "kr30ha_equations_of_motion.py": "equations_of_motion.md",
}
"""Examples that a page runs with what they print; what else holds of an example is asked there too."""
LONGEST = 60
"""Lines of an example."""


def run(script: Path, arguments: list[str], folder: Path) -> str:
    """Output of a script that succeeds without a word on stderr."""
    command = [sys.executable, "-W", "error", str(script), *arguments]
    process = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert process.returncode == 0, process.stderr
    assert process.stderr == ""
    return process.stdout


@pytest.mark.slow
@pytest.mark.parametrize("script", EXAMPLES)
def test_a_worked_example_runs(script, tmp_path):
    arguments, promise = EXAMPLES[script]
    assert promise in run(SCRIPTS / "examples" / script, arguments, tmp_path)
    assert [p.name for p in tmp_path.iterdir()] in ([], ["out"])


@pytest.mark.slow
def test_data_mutants(tmp_path):
    assert "lwr4: 24 mutants, " in run(SCRIPTS / "data_mutants.py", ["lwr4", "--share", "24"], tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("script", ["benchmark.py", "soak.py"])
def test_a_long_script_lists_its_parts(script, tmp_path):
    assert "usage: " in run(SCRIPTS / script, ["--help"], tmp_path)


@pytest.mark.slow
def test_every_line_of_soak_loads_and_says_what_it_counts(tmp_path):
    code = "import soak\nfor name in soak.LINES: assert soak.line_of(name).__doc__.endswith('.'), name\nprint('all')"
    path = os.pathsep.join([str(SCRIPTS), str(SCRIPTS.parent)])
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=tmp_path, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True)
    assert done.stdout == "all\n", done.stderr


@pytest.mark.parametrize("script", ON_PAGES)
def test_an_example_is_run_by_its_page(script):
    page = (SCRIPTS.parent / "docs" / "how_to" / ON_PAGES[script]).read_text(encoding="utf-8")
    commands = [each.text for block in blocks(page) if block.language == "console" for each in block.commands()]
    assert any(
        re.fullmatch(rf"python scripts/examples/{re.escape(script)}( --\w+ [\w,]+)*( \| grep .*)?", text)
        for text in commands
    )


def test_no_example_is_left_out_and_none_is_long():
    assert {p.name for p in (SCRIPTS / "examples").glob("*.py")} == EXAMPLES.keys() | ON_PAGES.keys()
    for name in EXAMPLES.keys() | ON_PAGES.keys():
        assert len((SCRIPTS / "examples" / name).read_text().splitlines()) <= LONGEST
