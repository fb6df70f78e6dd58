"""Tests of packages that `[test]` does not bring: where one is not installed its tests are skipped with its name.

A test lacks a package when its error, or a cause of that, names it; or when it fails and this process looked for the
package in vain while it ran (a command prints its error and exits). Nothing is written into the tests for it: they
import what they need. In CI everything of `[dev]` is installed: there a test is skipped only where its error names a
package of `NOT_IN_CI`, and any other fails. (A plugin of pytest: see conftest.py.)
"""

import importlib
import os
import sys
from importlib.abc import MetaPathFinder
from importlib.util import find_spec
from pathlib import Path

import pytest

PACKAGES = {
    "PIL": "pillow", "axe_playwright_python": "axe-playwright-python", "casadi": "casadi", "clarabel": "clarabel",
    "control": "control", "cvxpy": "cvxpy", "dask": "dask", "distributed": "distributed", "docutils": "sphinx",
    "eaik": "EAIK", "fmpy": "fmpy", "ipykernel": "ipykernel", "jax": "jax",
    "jsonschema": "jsonschema",
    "lark": "lark", "libcosimpy": "libcosimpy", "llvmlite": "llvmlite", "lsprotocol": "pygls", "lxml": "lxml",
    "matplotlib": "matplotlib", "mcap": "mcap", "mcap_ros2": "mcap-ros2-support",
    "mpmath": "mpmath", "mujoco": "mujoco", "myst_nb": "myst-nb",
    "myst_parser": "myst-nb", "nbclient": "myst-nb", "nbformat": "myst-nb", "pandas": "pandas",
    "pyarrow": "pyarrow", "pybullet": "pybullet", "pydrake": "drake", "pygls": "pygls", "rosbags": "rosbags",
    "selenium": "selenium", "sphinx": "sphinx", "sympy": "sympy", "toppra": "toppra", "xacro": "xacro",
}  # fmt: skip
"""As it is imported -> as pip installs it."""

NOT_IN_CI = {
    "drake": "230 MB, and not for every Python; `lwr-dyn parity` and `scripts/soak.py parity` run it",
    "pybullet": "built from source on new Pythons; `scripts/soak.py parity` runs it",
    "jax": "380 MB for one page; its lines run where it is installed",
    "EAIK": "no wheel for Python 3.14; a stand-in of its module is tested",
}
"""Package -> why CI does not install it."""


class Lookout(MetaPathFinder):
    """Last on `sys.meta_path`: notes the packages that were looked for and not found, but for those of `NOT_IN_CI`:
    help and tables look for them too, and a fault beside them has to be seen."""

    def __init__(self) -> None:
        self.missing: set[str] = set()

    def find_spec(self, fullname, path=None, target=None):
        if fullname in PACKAGES and PACKAGES[fullname] not in NOT_IN_CI:
            self.missing.add(PACKAGES[fullname])


LOOKOUT = Lookout()


def pytest_configure() -> None:
    sys.meta_path.append(LOOKOUT)


def pytest_unconfigure() -> None:
    sys.meta_path.remove(LOOKOUT)


def missing_packages(fault: BaseException | None) -> set[str]:
    """Packages that were looked for in vain since the last question, and those that an error or its causes name."""
    found, LOOKOUT.missing = LOOKOUT.missing, set()
    while fault is not None:
        name = getattr(fault, "package", None) or (fault.name if isinstance(fault, ModuleNotFoundError) else None)
        found |= {PACKAGES[name]} if name in PACKAGES else set()
        fault = fault.__cause__ or fault.__context__
    return found


def skipped_for(missing: set[str]) -> str | None:
    """Why a test that lacks these packages is skipped; None where it has to fail."""
    if not missing or (os.environ.get("CI") and not missing <= NOT_IN_CI.keys()):
        return None
    names = sorted(missing)
    how = " ".join(names) if missing & NOT_IN_CI.keys() else "'.[dev]'"
    return f"Skipped: {' and '.join(names)} not installed: pip install {how}"


def need(package: str) -> None:
    """Skip the test that asks, where a package (as it is imported) is not installed; in CI as `skipped_for` says."""
    if find_spec(package) is None:
        raise ModuleNotFoundError(f"{package} is not installed", name=package)


def _as_skipped(report, fault: BaseException | None, path: Path, line: int) -> None:
    why = skipped_for(missing_packages(fault))
    if report.failed and why is not None:
        report.outcome, report.longrepr = "skipped", (str(path), line, why)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    report = (yield).get_result()
    path, line, _ = item.location
    _as_skipped(report, call.excinfo and call.excinfo.value, path, (line or 0) + 1)


@pytest.hookimpl(tryfirst=True)
def pytest_make_collect_report(collector):
    """That of a file that lacks a package; else pytest makes it, which would spend seconds on tracebacks here."""
    missing_packages(None)  # what others have looked for
    if not isinstance(collector, pytest.Module):
        return None
    try:
        importlib.import_module(".".join(collector.path.relative_to(collector.config.rootpath).with_suffix("").parts))
    except Exception as fault:
        _forget(collector.path)
        why = skipped_for(missing_packages(fault))
        return why and pytest.CollectReport(collector.nodeid, "skipped", (str(collector.path), 1, why), [])
    missing_packages(None)
    return None


def _forget(path: Path) -> None:
    """Takes out the half of a module that pytest leaves where its import fails: others then fail to import it too."""
    for name in [name for name, module in sys.modules.items() if getattr(module, "__file__", None) == str(path)]:
        del sys.modules[name]
