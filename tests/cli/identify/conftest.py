"""The command with paths and numbers as arguments, and the logs of `tests.identification`."""

import pytest

from tests.identification.conftest import fourier, one_joint_at_a_time, wam

__all__ = ["fourier", "one_joint_at_a_time", "wam"]


@pytest.fixture
def lwr_dyn_command(lwr_dyn_command):
    return lambda *arguments: lwr_dyn_command(*map(str, arguments))
