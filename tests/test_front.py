"""Functions of `import lwr_dyn` answer bad input with one clear line."""

import inspect
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn import front
from lwr_dyn.codegen.batch import batch_dynamics
from lwr_dyn.errors import LwrDynError
from lwr_dyn.loading import FUNCTIONS
from lwr_dyn.registry import Registry
from lwr_dyn.simulation.setup import prepare
from lwr_dyn.trajectory.references.joint_moves import hold
from lwr_dyn.viewer.replay_page import replay_html

ROOT = Path(__file__).resolve().parents[1]
ARM = lwr_dyn.load("lwr4plus")
BAD = {
    "a name for an arm, text": (lambda: lwr_dyn.urdf_text("lwr4plus"), "arm: 'lwr4plus'; allowed: an arm"),
    "a name for an arm, engine": (lambda: lwr_dyn.dynamics_of("lwr4plus"), "arm: 'lwr4plus'"),
    "a name for an arm, pose": (lambda: lwr_dyn.forward_kinematics("lwr4plus", np.zeros(7)), "arm: 'lwr4plus'"),
    "a name for an arm, inverse": (lambda: lwr_dyn.inverse_kinematics("lwr4plus", np.eye(4)), "arm: 'lwr4plus'"),
    "a name for an arm, run": (lambda: lwr_dyn.simulate("lwr4plus", None, None), "arm: 'lwr4plus'"),
    "no controller": (lambda: lwr_dyn.simulate(ARM, None, hold(ARM, np.zeros(7), 0.1)), "controller: None; allowed:"),
    "no reference": (lambda: lwr_dyn.simulate(ARM, lambda *x: np.zeros(7), None), "reference: None; allowed:"),
    "no engine": (lambda: lwr_dyn.dynamics_of(ARM, None), "no engine named 'None'"),
    "a number for a reading": (lambda: lwr_dyn.load("lwr4plus", 3), "no reading of lwr4plus named '3'"),
    "a null in a path": (lambda: lwr_dyn.load("a\0b.toml"), "a null character"),
    "no runs": (lambda: lwr_dyn.replay(None, "x.html"), "runs: None; allowed: a run or a list of runs"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case):
    call, message = BAD[case]
    with pytest.raises(LwrDynError) as fault:
        call()
    assert message in str(fault.value)
    assert "\n" not in str(fault.value)


def test_every_name_of_the_package_is_a_function_of_the_front_door():
    offered = set(lwr_dyn.__all__) - {"Run"}
    assert {name for name in offered if getattr(lwr_dyn, name) is not getattr(front, name)} == set()
    with pytest.raises(AttributeError, match="no attribute 'loads'"):
        front.loads  # noqa: B018
    with pytest.raises(AttributeError, match="no attribute 'loads'"):
        lwr_dyn.loads  # noqa: B018


def test_functions_of_optional_packages_are_rows_that_are_loaded_when_they_are_used(monkeypatch):
    called = []
    monkeypatch.setattr(Registry, "load", lambda self, name: lambda arm, *options: called.append((name, options)))
    front.batch_dynamics(ARM, rotors="none")
    assert called == [("batch_dynamics", ("float64", 1, (), "none", "none"))]


def test_each_function_that_is_installed_can_be_called():
    installed = [name for name in FUNCTIONS.names if FUNCTIONS[name].is_installed]
    assert [name for name in installed if not callable(FUNCTIONS.load(name))] == []


OF_FACTORIES = {"controller", "reference"}
"""Their options are those of the row or the page that is chosen, so they cannot be listed."""


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

    assert options(front.batch_dynamics) == options(batch_dynamics)
    assert options(front.replay, ("path",)) == options(replay_html, ("arms", "live"))
    assert options(front.simulate, ("progress",)) == options(prepare)


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


def test_a_run_of_an_arm_that_was_changed_is_replayed_with_that_arm(arm, tmp_path):
    locked = arm.with_locked_joint("joint_3", 0.0)
    hold = lwr_dyn.reference("hold", locked, q=[0.1] * 6, duration=0.01)
    run = lwr_dyn.simulate(locked, lwr_dyn.controller("pid", locked), hold)
    lwr_dyn.replay(run, tmp_path / "x.html")
    assert (tmp_path / "x.html").is_file()
