"""A page without the packages that write its functions: it says so, and shows the rest."""

from dataclasses import replace

import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import kernel
from lwr_dyn.foundation.errors import MissingPackageError
from lwr_dyn.pages.explorer.page import explorer_html, function_sets, functions_script


@pytest.fixture
def without_casadi(monkeypatch):
    find = kernel.find_spec
    monkeypatch.setattr(kernel, "find_spec", lambda name: None if name == "casadi" else find(name))


def test_without_casadi_the_page_says_what_to_install(without_casadi):
    arm = lwr_dyn.load("kr30ha")
    script, why = functions_script(arm, "robot")
    assert script == ""
    assert why == f"this page does not compute: {MissingPackageError('casadi', 'batch')}"
    assert "pip install" in explorer_html(arm)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "places"), [("lwr4plus", (0, 0, 0)), ("wam7", (0, 0, 0)), ("kr30ha", (0, 1)), ("lwr4", (0,))]
)
def test_readings_with_the_same_kinematics_share_their_functions(robot, places):
    arms = [lwr_dyn.load(robot, reading) for reading in lwr_dyn.readings(robot)]
    sets = function_sets(arms)
    assert sets.places == places
    assert sets.script.count("function flange_pose(") == max(places) + 1
    assert ("function inverse_dynamics(" in sets.script) == (robot != "lwr4")


@pytest.mark.slow
def test_arms_of_other_limits_have_their_own_closed_form():
    arm = lwr_dyn.load("lwr4plus")
    limits = tuple(replace(each, upper=0.5) for each in arm.limits)
    assert function_sets([arm, replace(arm, limits=limits), arm]).places == (0, 1, 0)
