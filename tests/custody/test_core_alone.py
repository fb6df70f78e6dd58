"""Without the optional packages and their dependencies the core installs, imports, checks, simulates and replays.

Some of its tests run here; `scripts/soak.py core` runs them all.
"""

import os

import pytest

from tests.custody.core_alone import installed_core, run, run_tests

SHARE = ("papers", "control", "laws", "test_front.py")
"""Folders of tests that need nothing but pytest and hypothesis, and little time."""
COMMANDS = (
    (("list",), 0, "lwr4plus"),
    (("check", "wam7"), 0, "checks hold. Next: lwr-dyn urdf wam7 --out arm.urdf"),
    (("check", "kr30ha"), 0, "data-sheet not checked: lwr_dyn.checks.datasheet.datasheet is not installed"),
    (("gains", "lwr4plus"), 2, "lwr_dyn.design is not installed"),
    (("urdf", "kr30ha", "--out", "x.urdf"), 0, "x.urdf"),
    (("check", "x.urdf"), 0, "not judged as written: lwr_dyn.checks.urdf.report_text is not installed"),
    (("fk", "lwr4", "--q-deg", "0,90,90,-90,0,90,0"), 0, "position"),
    (("ik", "lwr4plus", "--xyz", "-0.05,-0.45,0.55"), 2, "lwr_dyn.kinematics.six_joints is not installed"),
    (("fk", "kr30ha", "--axes-deg", "A2=-90,A3=90"), 0, "position  1.34"),
    (("simulate", "lwr4plus", "--controller", "inverse-dynamics", "--out", "x.npz"), 0, "wrote x.npz"),
    (("replay", "x.npz", "--html", "x.html"), 0, "x.html"),
    (("compare", "x.npz", "x.npz"), 2, "lwr_dyn.studies.compare is not installed"),
    (("simulate", "lwr4plus", "--csv", "x.csv"), 2, "lwr_dyn.pages.notebook is not installed"),
    (("reproduce", "lwr4"), 2, "lwr_dyn.reproduction is not installed; install it with: pip install 'lwr_dyn[all]'"),
    (("fk", "lwr4", "--symbolic"), 2, "pip install 'lwr_dyn[symbolic]'"),
    (("lint", "wam7"), 2, "lwr_dyn.checks is not installed"),
    (("show", "wam7"), 2, "lwr_dyn.pages.explorer is not installed"),
    (("simulate", "lwr4plus", "--engine", "kernels"), 2, "pip install 'lwr_dyn[batch]'"),
)
"""In this order: a command, its exit code, a part of its output."""


@pytest.fixture(scope="module")
def core(tmp_path_factory):
    folder = tmp_path_factory.mktemp("core")
    try:
        return installed_core(folder), folder
    except RuntimeError as fault:
        if os.environ.get("CI"):
            raise
        pytest.skip(f"no environment could be made: {fault}")


def test_the_commands_of_the_core(core):
    python, folder = core
    for arguments, code, words in COMMANDS:
        process = run([str(python), "-m", "lwr_dyn", *arguments], folder)
        assert process.returncode == code, process.stderr
        assert words in process.stdout + process.stderr, arguments
        assert code == 0 or process.stderr.count("\n") == 1


def test_help_hides_commands_that_are_not_installed(core):
    python, folder = core
    text = run([str(python), "-m", "lwr_dyn", "--help"], folder).stdout
    assert "  simulate " in text
    assert not any(f"  {name} " in text for name in ("reproduce", "lint", "krl", "identify", "kernels"))


def test_functions_of_optional_packages_name_their_extra(core):
    python, folder = core
    code = "import lwr_dyn; lwr_dyn.batch_dynamics(lwr_dyn.load('lwr4plus'))"
    words = (
        "MissingPackageError: lwr_dyn.codegen.kernels is not installed; install it with: pip install 'lwr_dyn[batch]'"
    )
    assert words in run([str(python), "-c", code], folder).stderr


def test_its_tests_pass(core):
    python, folder = core
    process = run_tests(python, folder, SHARE)
    assert process.returncode == 0, process.stdout[-3000:]
