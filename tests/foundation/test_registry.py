"""Registries: each row loads, options come from the factory's signature, other packages add rows."""

import importlib.metadata
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.controllers import CONTROLLERS
from lwr_dyn.foundation.errors import LwrDynError, MissingPackageError, OptionError, UnknownNameError
from lwr_dyn.foundation.registry import REQUIRED, Option, Quantity, Registry, Row, check_options, options_of
from lwr_dyn.kinematics.inverse import IK_SOLVERS
from lwr_dyn.trajectory.references.references import REFERENCES

if TYPE_CHECKING:
    from decimal import Decimal

ARM, WAM = lwr_dyn.load("lwr4plus"), lwr_dyn.load("wam7")
PACKAGE = Path(lwr_dyn.__file__).parent
EXTRAS_ARE_THERE = all(find_spec(name) for name in ("casadi", "llvmlite", "lark", "matplotlib", "sympy"))


def _registries():
    """Every registry at the top level of a module of the package."""
    for path in sorted(PACKAGE.rglob("*.py")):
        if " = Registry(\n" in path.read_text(encoding="utf-8"):
            try:
                module = import_module(".".join(("lwr_dyn", *path.relative_to(PACKAGE).with_suffix("").parts)))
            except ModuleNotFoundError:
                if EXTRAS_ARE_THERE:
                    raise
                continue
            yield from (value for value in vars(module).values() if isinstance(value, Registry))


REGISTRIES = {id(registry): registry for registry in _registries()}.values()
ROWS = [pytest.param(registry, name, id=f"{registry.kind} {name}") for registry in REGISTRIES for name in registry.rows]

ADDED = """
import numpy as np
from typing import Annotated
from lwr_dyn.dynamics.engines import ENGINES
from lwr_dyn.foundation.registry import Option, Quantity
from lwr_dyn.trajectory.references.joint_moves import hold


def spring(arm, dynamics, *, gain: Annotated[float, Option(float, "Stiffness, 1/s^2.")] = 100.0):
    def mine(t, q, dq, q_ref, dq_ref, ddq_ref):
        return dynamics.inverse_dynamics(q, dq, gain * (q_ref - q) - 20.0 * dq)

    mine.parameters = {"gain": gain}
    return mine


def my_engine(arm, rotors):
    return ENGINES.load("newton-euler")(arm, rotors)


number = 3


def still(arm, *, seconds: Annotated[float, Option(float, "Duration, s.")] = 0.02):
    return hold(arm, np.zeros(arm.n), seconds)


def broken(arm, dynamics, *, rate: Annotated[float, Option(float, "Taken by simulate itself.")] = 1.0):
    return spring(arm, dynamics)
"""
POINTS = """
[lwr_dyn.controller]
mine = added_rows:spring
gone = added_rows:nothing
number = added_rows:number
absent = no_such_module:make
sick = sick_module:make
[lwr_dyn.reference]
still = added_rows:still
[lwr_dyn.engine]
my-engine = added_rows:my_engine
[lwr_dyn.new]
pid = added_rows:spring
"""


@pytest.fixture
def distribution(tmp_path, monkeypatch):
    """A package with rows, installed as far as `importlib.metadata` can see."""
    (tmp_path / "added_rows.py").write_text(ADDED)
    (tmp_path / "sick_module.py").write_text("1 / 0\n")
    info = tmp_path / "added_rows-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: added-rows\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(POINTS)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path
    for name in ("added_rows", "sick_module"):
        sys.modules.pop(name, None)


@pytest.mark.parametrize(("registry", "name"), ROWS)
def test_every_row_can_be_loaded_and_has_a_line_of_help(registry, name):
    row = registry[name]
    assert row.about
    loaded = registry.load(name)
    assert callable(loaded) or registry is IK_SOLVERS or registry.kind == "kernel_form"


def test_the_registries_of_the_core_are_seen():
    kinds = {registry.kind for registry in REGISTRIES}
    assert {"controller", "reference", "motion_profile", "engine", "command", "new", "file_format"} <= kinds
    assert IK_SOLVERS in REGISTRIES


@pytest.mark.parametrize("registry", [CONTROLLERS, REFERENCES])
def test_options_of_rows_have_help_and_a_default_in_the_signature(registry):
    for name in registry.rows:
        options = options_of(registry.load(name))
        assert options
        assert all(option.help.endswith(".") for option in options.values())
    assert options_of(CONTROLLERS.load("pid"))["omega_n"].default == 50.0
    assert options_of(REFERENCES.load("hold"))["q"].default is REQUIRED


def test_the_front_door_makes_controllers_and_references():
    dynamics, ones = lwr_dyn.dynamics_of(ARM), np.ones(7)
    pid = lwr_dyn.controller("pid", ARM, ki=3.0, inertia=ones, engine="newton-euler")
    assert pid.parameters["Ki"] == [3.0] * 7
    assert lwr_dyn.controller("pd-gravity", ARM, engine=dynamics, inertia=ones, omega_n=10.0).Kp[0] == 100.0
    assert (lwr_dyn.controller("pd-gravity", WAM, own_gains=True).Kp == WAM.gains.Kp).all()
    assert lwr_dyn.reference("hold", ARM, q=np.zeros(7)).duration == 2.0
    assert lwr_dyn.reference("lspb", ARM, start=np.zeros(7), end=ones).duration == 7.0
    assert list(lwr_dyn.engines()) == ["pinocchio", "newton-euler", "kernels"]


BAD = {
    "controller": (lambda: lwr_dyn.controller("fuzzy", ARM), "no controller named 'fuzzy'"),
    "engine": (lambda: lwr_dyn.controller("pid", ARM, engine="none"), "no engine named 'none'"),
    "reference": (lambda: lwr_dyn.reference("dance", ARM), "no reference named 'dance'"),
    "unknown option": (
        lambda: lwr_dyn.controller("inverse-dynamics", ARM, ki=1.0),
        "ki: no option of controller inverse-dynamics; allowed: omega_n, xi, feedforward, gravity",
    ),
    "missing option": (
        lambda: lwr_dyn.reference("hold", ARM), "q: not given; allowed: a value, which reference hold needs"
    ),
    "no effect": (
        lambda: lwr_dyn.controller("pd-gravity", WAM, own_gains=True, omega_n=9.0),
        "omega_n: would do nothing here; allowed: without own_gains",
    ),
    "no gains": (lambda: lwr_dyn.controller("pd-gravity", ARM, own_gains=True), "controller gains not given"),
    "no arm": (lambda: lwr_dyn.controller("pid", "lwr4plus"), "arm: 'lwr4plus'; allowed: an arm"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_a_bad_choice_is_one_line(case):
    call, message = BAD[case]
    with pytest.raises(LwrDynError) as fault:
        call()
    assert message in str(fault.value)


def test_rows_of_another_package_come_after_our_own(distribution):
    assert CONTROLLERS.names[: len(CONTROLLERS.rows) + 1] == (*CONTROLLERS.rows, "mine")
    assert CONTROLLERS["mine"].about == "from added-rows"
    assert lwr_dyn.controller("mine", ARM, gain=4.0).parameters == {"gain": 4.0}
    assert lwr_dyn.reference("still", ARM).duration == 0.02
    assert "my-engine" in lwr_dyn.engines()
    assert Registry("controller", {"mine": Row("math:sin", "ours")}).load("mine").__name__ == "sin"  # ours stays
    for name, error, words in (
        ("gone", UnknownNameError, "no attribute of added_rows named 'nothing'"),
        ("number", OptionError, "factory: 3; allowed: a function"),
        ("absent", MissingPackageError, "no_such_module is not installed"),
        ("sick", OptionError, "from added-rows: sick_module: ZeroDivisionError"),
    ):
        with pytest.raises(error, match=words):
            lwr_dyn.controller(name, ARM)


def test_what_is_installed_is_read_once_for_a_path(monkeypatch, tmp_path):
    seen, read = [], importlib.metadata.entry_points
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda: seen.append(1) or read())
    monkeypatch.syspath_prepend(str(tmp_path))
    assert CONTROLLERS.names == CONTROLLERS.names
    assert REFERENCES.names
    assert len(seen) == 1
    monkeypatch.syspath_prepend(str(tmp_path / "more"))
    assert CONTROLLERS.names
    assert len(seen) == 2


@pytest.mark.slow
def test_the_command_takes_rows_of_another_package_with_their_options(distribution):
    def command(*arguments):
        code = f"import sys; sys.path.insert(0, {str(distribution)!r}); from lwr_dyn.cli.main import main; main()"
        simulate = ("simulate", "lwr4plus", "--task", "still", "--seconds", "0.01", "--engine", "my-engine")
        given = [sys.executable, "-c", code, *simulate, "--controller", *arguments]
        return subprocess.run(given, capture_output=True, text=True)

    done = command("mine", "--gain", "9")
    assert done.returncode == 0
    assert "mine, task still, 0.01 s, 11 samples" in done.stdout
    allowed = "lwr-dyn: --gain: would do nothing here; allowed: with --controller mine\n"
    assert command("pid", "--gain", "9").stderr == allowed
    done = command("sick")
    assert done.stderr.count("\n") == 1
    assert "sick_module: ZeroDivisionError" in done.stderr


def test_a_factory_of_any_keywords_takes_them_and_needs_its_own():
    def free(arm, *, size, **more): ...

    check_options("free", free, 1, {"size": 1, "any": 2})
    with pytest.raises(OptionError, match="size: not given; allowed: a value, which free needs"):
        check_options("free", free, 1, {"any": 2})


def test_options_come_from_annotations_of_functions_and_classes():
    class Spring:
        def __init__(self, arm, dynamics, *, lean: Annotated[float, Option(Quantity.ANGLE, "Lean.")] = 0.5): ...

    def factory(arm, *, digits: Annotated["Decimal", Option(float, "Digits.")] = 3): ...

    assert options_of(Spring)["lean"].default == 0.5
    with pytest.raises(OptionError, match="annotation: name 'Decimal' is not defined"):
        options_of(factory)
