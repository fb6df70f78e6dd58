"""A page without the packages that write its functions: it says so, and shows the rest."""

import pytest

import lwr_dyn
from lwr_dyn.codegen import kernel
from lwr_dyn.errors import MissingPackageError
from lwr_dyn.explorer.computing import robot_script
from lwr_dyn.explorer.page import explorer_html
from lwr_dyn.explorer.readings import further_script


@pytest.fixture
def without_casadi(monkeypatch):
    find = kernel.find_spec
    monkeypatch.setattr(kernel, "find_spec", lambda name: None if name == "casadi" else find(name))


def test_without_casadi_the_page_says_what_to_install(without_casadi):
    arm = lwr_dyn.load("kr30ha")
    script, why = robot_script(arm)
    assert script == ""
    assert why == f"this page does not compute: {MissingPackageError('casadi', 'batch')}"
    assert "inverse_dynamics" not in further_script(arm)
    assert "pip install" in explorer_html(arm)


def test_with_it_the_page_has_its_functions():
    script, _ = robot_script(lwr_dyn.load("kr30ha"))
    assert "inverse_dynamics" in script
