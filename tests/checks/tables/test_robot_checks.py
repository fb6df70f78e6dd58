"""What `check` of a robot's data file refuses or fails, `lint` of it says."""

import re

import pytest

from lwr_dyn.arms.loading import load_with_paper
from lwr_dyn.arms.papers.catalog import studied, template
from lwr_dyn.checks.arm.run_checks import check_arm
from lwr_dyn.checks.tables.robot_checks import holds_a_robot, robot_findings
from lwr_dyn.foundation.errors import LwrDynError

OWN = template("own.toml", "own", "RPR")
_TENSOR = "[[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.004]]"
CHANGED = {
    "a tensor that no body has": (_TENSOR, "[[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.4]]"),
    "a tensor with a moment below 0": (_TENSOR, "[[0.01, 0, 0], [0, -0.01, 0], [0, 0, 0.004]]"),
    "a tensor 1000 times too large": (_TENSOR, "[[10, 0, 0], [0, 10, 0], [0, 0, 4]]"),
    "a mass below 0": ("values = [2.0, 2.0, 2.0]", "values = [-2.0, 2.0, 2.0]"),
    "a tensor that is not symmetric": (_TENSOR, "[[0.01, 0.001, 0], [0, 0.01, 0], [0, 0, 0.004]]"),
    "exchanged limits": ("values = [-170, 0, -170]", "values = [190, 0, -170]"),
    "an unknown unit": ('unit = "kg"', 'unit = "st"'),
    "a row too few": ("values = [90, -90, 0]", "values = [90, -90]"),
    "an unknown table": ("[drawing]", "[drowing]"),
}


def checked(path):
    """Whether `check` holds."""
    try:
        return check_arm(*load_with_paper(path)).holds
    except LwrDynError:
        return False


@pytest.mark.parametrize("case", CHANGED)
def test_what_check_fails_is_found(tmp_path, case, lwr_dyn_command):
    old, new = CHANGED[case]
    path = tmp_path / "own.toml"
    path.write_text(OWN.replace(old, new, 1))
    assert old in OWN
    assert not checked(path)
    code, out, _ = lwr_dyn_command("lint", str(path))
    assert code == 1
    assert re.search(r"own\.toml:.*: error (check|refused): ", out)


def test_a_file_that_check_passes_gives_no_finding(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(OWN)
    assert checked(path)
    assert list(robot_findings(path)) == []


@pytest.mark.slow
def test_robots_of_the_package_hold():
    assert {robot: list(robot_findings(robot)) for robot in studied()} == {robot: [] for robot in studied()}


def test_a_finding_has_the_number_and_its_bound(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(OWN.replace(_TENSOR, "[[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.4]]", 1))
    (found,) = [f for f in robot_findings(path) if "triangle" in f.place]
    assert (found.rule, found.severity, found.counts) == ("check", "error", True)
    assert found.numbers["value"] > found.numbers["tolerance"] or "above" in found.suspected


def test_other_tables_are_no_robots():
    assert holds_a_robot(OWN, "own.toml")
    assert holds_a_robot("", "a.kuka.toml")
    for text in ("[gains]\nKp = [1.0, 2.0]", "dh = 3", "not TOML", "[joints]\nq = [1]"):
        assert not holds_a_robot(text, "x.toml")
