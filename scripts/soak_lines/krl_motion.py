"""Timing and splines of KRL programs."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def krl_splines() -> tuple[str, bool]:
    """500 random spline blocks and 500 random chains inside their bounds."""
    environment = os.environ | {"LWR_DYN_KRL_SPLINES": "500"}
    chosen = ["-m", "slow or not slow", "tests/krl/motion/test_splines_random.py"]
    command = [sys.executable, "-m", "pytest", "-q", *chosen]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    return done.stdout.strip().splitlines()[-1], done.returncode == 0
