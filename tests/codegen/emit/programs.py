"""Programs that run emitted code: compilers, node, an emulator."""

import ctypes
import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

IN_CI = ("gcc", "clang", "node", "chromium")
"""What CI installs: where it is absent there, a test fails instead of being skipped."""


def program(name: str) -> str:
    """The path of a program; absent it skips the test, or fails it where CI should have it."""
    found = shutil.which(name)
    if found is None and os.environ.get("CI") and name in IN_CI:
        pytest.fail(f"{name} is not installed")
    if found is None:
        pytest.skip(f"{name} is not installed")
    return found


def output(command: list[str], folder: Path | None = None, seconds: float = 300.0) -> str:
    """What a command prints; raises `AssertionError` with its messages where it fails."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=seconds, check=False)
    assert done.returncode == 0, f"{command}\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    return done.stdout


def node(folder: Path, text: str, name: str = "run.js") -> Any:
    """What a script prints as JSON."""
    (folder / name).write_text(text)
    return json.loads(output([program("node"), name], folder))


def shared(folder: Path, files: list[str], *flags: str, to: str = "made.so") -> ctypes.CDLL:
    """C files of a folder as a library."""
    output([program("gcc"), *flags, "-shared", "-fPIC", *files, "-lm", "-o", to], folder)
    return ctypes.CDLL(str(folder / to))
