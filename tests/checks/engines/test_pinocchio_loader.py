"""Pinocchio on the file itself against our reading: it holds on foreign arms, and a misreading fails."""

import re
from dataclasses import replace

import pytest

import lwr_dyn
from lwr_dyn.checks.arm.model_laws import SLIDE
from lwr_dyn.checks.arm.run_checks import check_arm
from lwr_dyn.checks.engines import pinocchio_loader
from lwr_dyn.checks.engines.engine import EXACT
from lwr_dyn.checks.engines.pinocchio_loader import file_verdicts
from tests.arms.export.test_data_file import FOREIGN, arm_named
from tests.checks.engines.small_files import TWO

OWN = "Pinocchio on the file itself against our reading"


@pytest.mark.parametrize("name", FOREIGN)
def test_foreign_arms_hold(name):
    """panda: locked fingers; z1: a link and a joint of one name; kinova: continuous joints."""
    verdicts, unjudged = file_verdicts(arm_named(name))
    assert [(v.name, v.holds) for v in verdicts] == [
        (f"{x}: {OWN}", True) for x in ("FK", "B", "g", "inverse dynamics")
    ]
    assert unjudged == []


@pytest.mark.parametrize(
    ("before", "after", "fails"),
    [
        ('<origin xyz="0 0 0.4"/>', '<origin xyz="0 0 0.4000001"/>', "FK"),
        ('rpy="0.3 0.5 0"', 'rpy="0.3 0.5 1e-9"', "B"),
        ('<mass value="1"/>', '<mass value="1.000000001"/>', "g"),
    ],
)
def test_a_misreading_is_seen(two, tmp_path, monkeypatch, before, after, fails):
    """Our reader is given another file than Pinocchio."""
    other = tmp_path / "other.urdf"
    other.write_text(TWO.replace(before, after), encoding="utf-8")
    real = pinocchio_loader.reference_of
    monkeypatch.setattr(pinocchio_loader, "reference_of", lambda path, *rest: real(other, *rest))
    verdicts, _ = file_verdicts(lwr_dyn.load(two))
    assert f"{fails}: {OWN}" in [v.name for v in verdicts if not v.holds]


def test_a_file_that_pinocchio_refuses_is_not_judged(two, capfd):
    two.write_text(TWO.replace('effort="20" velocity="4"', 'effort="20"'), encoding="utf-8")
    verdicts, unjudged = file_verdicts(lwr_dyn.load(two))
    assert (verdicts, unjudged[0].startswith(f"{OWN}: ")) == ([], True)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("shift", "size"), [("0.4", 1.0), ("40", 40.5)])
def test_poses_may_differ_by_rounding_of_the_arm_s_reach_of_a_metre_at_least(two, shift, size):
    two.write_text(TWO.replace("0 0 0.4", f"0 0 {shift}"), encoding="utf-8")
    kinematics = file_verdicts(lwr_dyn.load(two))[0][0]
    assert (kinematics.tolerance / EXACT, kinematics.unit) == (pytest.approx(size, rel=0.01), "m")


@pytest.mark.parametrize("shift", [0.4, 40.0])
def test_gravity_s_torque_is_judged_by_a_share_of_the_weight_at_the_reach(two, monkeypatch, shift):
    floors = {}
    monkeypatch.setattr(pinocchio_loader, "equality", lambda name, a, b, floor=0.0: floors.setdefault(name, floor))
    text = TWO.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 0 1"/>').replace("0 0 0.4", f"0 0 {shift}")
    two.write_text(re.sub(r'mass value="\d"', 'mass value="1e3"', text), encoding="utf-8")
    file_verdicts(lwr_dyn.load(two))
    reach = min(max(1.0, shift + 0.5), SLIDE)
    assert floors[f"g: {OWN}"] == pytest.approx(20.0 * 9.81 * reach, rel=0.01)


@pytest.mark.parametrize("axis", ["1e200 0 0", "1e-170 0 0"])
def test_an_axis_without_a_square_is_not_judged(two, axis):
    two.write_text(TWO.replace('<axis xyz="1 0 0"/>', f'<axis xyz="{axis}"/>'), encoding="utf-8")
    why = "its parser squares an axis, and that of j2 has no square as a float"
    assert file_verdicts(lwr_dyn.load(two)) == ([], [f"{OWN}: {why}"])


def test_a_xacro_is_judged_as_what_it_expands_to(tmp_path):
    path = tmp_path / "two.urdf.xacro"
    text = TWO.replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ')
    text = text.replace('value="2"', 'value="${1 + 1}"')
    path.write_text(text, encoding="utf-8")
    verdicts, unjudged = file_verdicts(lwr_dyn.load(path))
    assert ([v.holds for v in verdicts], unjudged) == ([True] * 4, [])


def test_check_has_the_verdicts_of_a_file_and_none_of_a_robot_and_a_payload_in_code_is_not_the_file_s(two):
    arm = lwr_dyn.load(two)
    found = [
        [v.name for v in check_arm(x, states=5).verdicts if OWN in v.name] for x in (arm, lwr_dyn.load("lwr4plus"))
    ]
    assert (f"B: {OWN}" in found[0], found[1]) == (True, [])
    first, second = arm.chain.links
    body = replace(second.body, mass=9.0)
    heavier = arm.with_chain(replace(arm.chain, links=(first, replace(second, body=body))))
    assert all(v.holds for v in file_verdicts(heavier)[0])
