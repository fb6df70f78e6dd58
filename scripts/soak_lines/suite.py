"""Counts that pytest makes, in full."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def properties() -> tuple[str, bool]:
    """Every hypothesis property, 2000 examples each."""
    environment = os.environ | {"LWR_DYN_HYPOTHESIS": "soak"}
    command = [sys.executable, "-m", "pytest", "-q", "-m", "hypothesis", "tests"]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    return done.stdout.strip().splitlines()[-1], done.returncode == 0


def krl() -> tuple[str, bool]:
    """100 000 mutated KRL programs end in a diagnosis or a program."""
    environment = os.environ | {"LWR_DYN_KRL_FUZZ": "100000"}
    command = [sys.executable, "-m", "pytest", "-q", "-m", "slow or not slow", "tests/krl/running/test_program_run.py"]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    return done.stdout.strip().splitlines()[-1], done.returncode == 0


def shares() -> tuple[str, bool]:
    """Every case of the tests of which CI runs a share (`tests/share.py`): pages, robots, examples."""
    environment = {name: value for name, value in os.environ.items() if name != "LWR_DYN_SHARE"}
    command = [sys.executable, "-m", "pytest", "-q", "-n", "auto", "-m", "share", "tests"]
    done = subprocess.run(command, cwd=ROOT, env=environment | {"CI": "true"}, capture_output=True, text=True)
    return done.stdout.strip().splitlines()[-1], done.returncode == 0


def core() -> tuple[str, bool]:
    """All tests of the core in an environment of its own, from a built wheel without extras."""
    from tests.custody.core_alone import EVERYTHING, FOLDERS, installed_core, run_tests

    with tempfile.TemporaryDirectory() as folder:
        process = run_tests(installed_core(Path(folder), EVERYTHING), Path(folder), FOLDERS, "slow or not slow")
    return process.stdout.strip().splitlines()[-1], process.returncode == 0
