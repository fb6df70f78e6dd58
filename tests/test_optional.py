"""A test whose package is not installed is skipped with its name; in CI only those of the list."""

import subprocess
import sys

import pytest

from lwr_dyn.foundation.errors import MissingPackageError
from tests.custody.core_alone import ROOT
from tests.optional import NOT_IN_CI, PACKAGES, missing_packages, need, skipped_for

TESTS = """
import sys
import pytest

class Away:  # the package as if it were not installed
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "sympy":
            import tests.optional
            tests.optional.LOOKOUT.find_spec(name)
            raise ModuleNotFoundError(f"No module named {name}", name=name)

sys.modules = {name: module for name, module in sys.modules.items() if name.partition(".")[0] != "sympy"}
sys.meta_path.insert(0, Away())

@pytest.fixture(scope="module")
def symbols():
    import sympy

def test_imports_it():
    import sympy

def test_takes_it_from_a_fixture(symbols): ...
def test_takes_it_again(symbols): ...

def test_calls_what_hides_the_error():
    try:
        import sympy
    except ImportError:
        pass
    assert False

def test_fails_for_another_reason():
    assert False

def test_holds_without_it():
    try:
        import sympy
    except ImportError:
        pass
"""


def outcomes(folder, monkeypatch, ci):
    monkeypatch.setenv("CI", "true") if ci else monkeypatch.delenv("CI", raising=False)
    (folder / "test_made.py").write_text(TESTS, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-rs", "-p", "tests.optional", str(folder)]
    done = subprocess.run([*command, f"--rootdir={folder}"], cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout


@pytest.mark.slow
def test_what_lacks_a_package_is_skipped_with_its_name(tmp_path, monkeypatch):
    text = outcomes(tmp_path, monkeypatch, ci=False)
    assert text.startswith("ssssF.")
    assert text.count("sympy not installed: pip install '.[dev]'") == 4
    assert "test_fails_for_another_reason" in text


@pytest.mark.slow
def test_what_imports_from_such_a_module_is_skipped_too(tmp_path, monkeypatch):
    monkeypatch.delenv("CI", raising=False)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{ROOT}")
    lacks = "raise ModuleNotFoundError('no sympy', name='sympy')\nVALUE = 1\n"
    (tmp_path / "test_first.py").write_text(lacks, encoding="utf-8")
    (tmp_path / "test_second.py").write_text("from test_first import VALUE\n", encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-rs", "-p", "tests.optional", "--import-mode=importlib"]
    done = subprocess.run([*command, str(tmp_path), f"--rootdir={tmp_path}"], cwd=ROOT, capture_output=True, text=True)
    assert done.stdout.count("sympy not installed: pip install '.[dev]'") == 2, done.stdout
    assert "error" not in done.stdout.lower()


@pytest.mark.slow
def test_in_ci_it_fails(tmp_path, monkeypatch):
    assert outcomes(tmp_path, monkeypatch, ci=True).startswith("FEEFF.")


def test_only_packages_of_the_list_are_left_out_in_ci(monkeypatch):
    monkeypatch.setenv("CI", "true")
    assert skipped_for({"sympy"}) is skipped_for({"drake", "sympy"}) is skipped_for(set()) is None
    assert skipped_for({"drake"}) == "Skipped: drake not installed: pip install drake"
    assert set(NOT_IN_CI) <= set(PACKAGES.values())


def test_an_error_and_its_causes_name_packages():
    fault = ValueError("odd")
    fault.__cause__ = MissingPackageError("llvmlite", "batch")
    fault.__cause__.__context__ = ModuleNotFoundError("No module named 'pydrake'", name="pydrake")
    assert missing_packages(fault) == {"llvmlite", "drake"}
    assert missing_packages(ModuleNotFoundError("No module named 'elsewhere'", name="elsewhere")) == set()
    with pytest.raises(ModuleNotFoundError, match="no_such_package is not installed"):
        need("no_such_package")


def test_tests_skip_by_no_other_way():
    by_hand = [
        path for path in (ROOT / "tests").rglob("*.py") if "importor" + "skip" in path.read_text(encoding="utf-8")
    ]
    assert by_hand == []
