"""The command with paths and numbers as arguments, and the logs of `tests.identification`."""

import pytest

from lwr_dyn.cli.main import main
from tests.identification.conftest import fourier, one_joint_at_a_time, wam

__all__ = ["fourier", "one_joint_at_a_time", "wam"]


@pytest.fixture
def lwr_dyn_command(capsys):
    def run(*arguments):
        with pytest.raises(SystemExit) as stop:
            main([str(a) for a in arguments])
        out, err = capsys.readouterr()
        return stop.value.code, out, err

    return run
