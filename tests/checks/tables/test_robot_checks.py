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


@pytest.mark.parametrize("case", [*CHANGED, "a good file"])
def test_what_check_fails_is_found(tmp_path, case, lwr_dyn_command):
    old, new = CHANGED.get(case, ("", ""))
    path = tmp_path / "own.toml"
    assert old in OWN
    path.write_text(OWN.replace(old, new, 1))
    try:
        checked = check_arm(*load_with_paper(path)).holds
    except LwrDynError:
        checked = False
    findings = list(robot_findings(path))
    assert (checked, not findings) == (not old, not old)
    code, out, _ = lwr_dyn_command("lint", str(path))
    assert (code, bool(re.search(r"own\.toml:.*: error (check|refused): ", out))) == (bool(old), bool(old))
    if case == "a tensor that no body has":
        (found,) = [f for f in findings if "triangle" in f.place]
        assert (found.rule, found.severity, found.counts) == ("check", "error", True)
        assert found.numbers["value"] > found.numbers["tolerance"]


@pytest.mark.slow
def test_robots_of_the_package_hold():
    assert {robot: list(robot_findings(robot)) for robot in studied()} == {robot: [] for robot in studied()}


def test_other_tables_are_no_robots():
    texts = ("[gains]\nKp = [1.0, 2.0]", "dh = 3", "not TOML", "[joints]\nq = [1]")
    robots = [holds_a_robot(OWN, "own.toml"), holds_a_robot("", "a.kuka.toml")]
    assert robots + [holds_a_robot(text, "x.toml") for text in texts] == [True, True, False, False, False, False]
