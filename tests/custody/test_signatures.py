"""The functions of `import lwr_dyn` have real signatures: a user's editor, `help()` and mypy see them."""

import inspect
import re
import subprocess
import sys
from dataclasses import fields
from importlib import import_module
from pathlib import Path

import pytest

import lwr_dyn
from lwr_dyn.pages.replay.replay_page import replay_html
from lwr_dyn.simulation.setup import Loop

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "lwr_dyn"
OF_FACTORIES = {"controller", "margins", "reference"}
"""Their options are those of the row or the page that is chosen, so they cannot be listed."""
LOOP_OF_ROLLOUTS = {"rate", "plant", "saturate", "position_limits", "delay", "encoder", "seed", "duration"}
"""What rollouts take as `simulate` does; `substeps` they choose themselves for smooth friction."""


@pytest.mark.parametrize("name", sorted(set(lwr_dyn.__all__) - {"Run"}))
def test_every_function_has_a_signature_and_a_docstring(name):
    function = getattr(lwr_dyn, name)
    parameters = inspect.signature(function).parameters.values()
    assert all(p.annotation is not p.empty for p in parameters)
    assert inspect.signature(function).return_annotation is not inspect.Signature.empty
    assert any(p.kind is p.VAR_KEYWORD for p in parameters) is (name in OF_FACTORIES)
    words = inspect.getdoc(function)
    assert all(p.name in words for p in parameters if len(parameters) > 3 and p.kind is not p.VAR_KEYWORD)


def test_wrapped_functions_have_the_options_of_what_they_call():
    def options(function, left_out=()):
        return {p.name: p.default for p in inspect.signature(function).parameters.values() if p.name not in left_out}

    assert options(lwr_dyn.replay, ("path",)) == options(replay_html, ("arms", "live"))
    own = ("arm", "controller", "reference", "progress")
    assert options(lwr_dyn.simulate, own) == {field.name: field.default for field in fields(Loop)}
    many, one = options(lwr_dyn.rollouts), options(lwr_dyn.simulate)
    assert {name for name in many.keys() & one.keys() if many[name] == one[name]} >= LOOP_OF_ROLLOUTS


USER_SCRIPT = """
import numpy as np
import lwr_dyn

arm = lwr_dyn.load("lwr4plus", mount="ceiling")
dynamics = lwr_dyn.dynamics_of(arm)
controller = lwr_dyn.controller("pd-gravity", arm, omega_n=20.0)
hold = lwr_dyn.reference("hold", arm, q=np.zeros(arm.n), duration=0.1)
run: lwr_dyn.Run = lwr_dyn.simulate(arm, controller, hold, payload=1.0, rate=500.0)
lwr_dyn.replay([run], "x.html", title="x")
solution = lwr_dyn.inverse_kinematics(arm, lwr_dyn.forward_kinematics(arm, np.zeros(arm.n)))
print(solution.status, dynamics.gravity_vector(np.zeros(arm.n)).shape, lwr_dyn.ik_solver(arm, starts=10).near)
"""


@pytest.mark.slow
def test_a_users_script_is_checked_by_mypy(tmp_path):
    paths = [tmp_path / "right.py", tmp_path / "wrong.py"]
    for path, text in zip(paths, (USER_SCRIPT, USER_SCRIPT.replace("rate=500.0", "rates=500.0")), strict=True):
        path.write_text(text)
    done = subprocess.run(  # the cache is that of the step `mypy`
        [sys.executable, "-m", "mypy", "--strict", *map(str, paths)], capture_output=True, text=True, cwd=ROOT
    )
    faults = [line for line in done.stdout.splitlines() if "error:" in line]
    assert len(faults) == 1
    assert "wrong.py" in faults[0]
    assert 'Unexpected keyword argument "rates" for "simulate"' in faults[0]


def test_types_and_functions_are_those_of_the_same_modules():
    typed = re.findall(r"^from (\S+) import (\w+) as \2$", (PACKAGE / "__init__.pyi").read_text("utf-8"), re.MULTILINE)
    assert sorted(name for _, name in typed) == lwr_dyn.__all__
    for module, name in typed:
        assert getattr(lwr_dyn, name) is getattr(import_module(module), name)


def test_no_first_level_package_has_the_name_of_a_function():
    packages = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert packages & {*lwr_dyn.__all__} == set()


def test_another_name_is_no_attribute():
    with pytest.raises(AttributeError, match="no attribute 'loads'"):
        lwr_dyn.loads  # noqa: B018
