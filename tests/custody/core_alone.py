"""The core in an environment of its own: a built wheel with its plain dependencies, no extra."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CORE = (
    "foundation", "model", "arms/papers", "arms/urdf", "arms/*", "dynamics/*", "kinematics/*", "control/*",
    "trajectory/*", "trajectory/references", "simulation/*", "checks/arm", "pages/replay",
)  # fmt: skip
"""Packages of the core; `/*` is the package without its sub-packages."""
READY = Path(os.environ["LWR_DYN_WHEEL_ENVIRONMENT"]) if "LWR_DYN_WHEEL_ENVIRONMENT" in os.environ else None
"""An environment with the wheel of this checkout alone, its plain dependencies and the file `complete`: `.ci/run`."""
NEEDED = ("pytest", "hypothesis")
"""What tests of the core need beside it; `EVERYTHING` of them needs more."""
EVERYTHING = (*NEEDED, "mujoco", "example-robot-data", "casadi", "matplotlib", "selenium", "axe-playwright-python")
FOLDERS = ("agreement", "laws", "test_*.py", *CORE)
"""Tests of the core."""


def core_files(root: Path, name: str, pattern: str) -> list[Path]:
    """The files of one entry of `CORE` below a folder."""
    if name.endswith("/*"):
        return sorted((root / name[:-2]).glob(pattern))
    return sorted(root.glob(name)) if name.endswith(".py") else sorted((root / name).rglob(pattern))


def run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """A command in a folder without this checkout on its path, not as in CI; what it compiles is kept."""
    left_out = ("CI", "PYTHONPATH", "PYTHONDONTWRITEBYTECODE")
    environment = {name: value for name, value in os.environ.items() if name not in left_out}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


def installed_core(folder: Path, packages: tuple[str, ...] = NEEDED) -> Path:
    """The Python of a new environment with the wheel, its plain dependencies and `packages`; raises `RuntimeError`.

    `folder` also gets the tests and the committed models, but no source: what is imported comes from the wheel.
    """
    python = folder / "environment" / "bin" / "python"
    if READY is not None and (READY / "complete").is_file():
        half_written = shutil.ignore_patterns("*.pyc.*")  # its own trial may be running
        shutil.copytree(READY, folder / "environment", symlinks=True, ignore=half_written, copy_function=_linked)
        wheel = ()
    else:
        wheel = (str(_built(folder, python)),)
    install = ("install", "-q", "--no-compile", *wheel, *packages)
    _succeed([sys.executable, "-m", "pip", "--python", str(python), *install], folder)
    shutil.copytree(ROOT / "tests", folder / "tests", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "models", folder / "models")
    shutil.copy(ROOT / "pyproject.toml", folder / "pyproject.toml")
    return python


def _linked(source: str, target: str) -> str:
    """A file in both places without its bytes twice; a copy where the places are on two disks."""
    try:
        os.link(source, target)
    except OSError:
        shutil.copy2(source, target)
    return target


def _built(folder: Path, python: Path) -> Path:
    """The wheel of this checkout; also makes the environment of `python`, empty."""
    source = folder / "source"
    shutil.copytree(ROOT / "lwr_dyn", source / "lwr_dyn", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source / name)
    steps = (
        [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", str(folder), str(source)],
        [sys.executable, "-m", "venv", "--without-pip", str(python.parents[1])],
    )
    for step in steps:
        _succeed(step, folder)
    shutil.rmtree(source)
    return next(folder.glob("*.whl"))


def run_tests(
    python: Path, folder: Path, names: tuple[str, ...], marked: str = "not slow"
) -> subprocess.CompletedProcess[str]:
    """The tests of these folders in the environment; what is skipped stands at the end with its reason."""
    places = [str(path) for name in names for path in core_files(folder / "tests", name, "test_*.py")]
    return run([str(python), "-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider", "-m", marked, *places], folder)


def _succeed(command: list[str], folder: Path) -> None:
    process = run(command, folder)
    if process.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {process.stderr[-2000:]}")
