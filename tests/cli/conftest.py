"""The command as a function: arguments in, exit code, stdout and stderr out."""

import pytest

from lwr_dyn.cli.main import main


@pytest.fixture
def lwr_dyn_command(capsys):
    def run(*arguments):
        with pytest.raises(SystemExit) as stop:
            main(list(arguments))
        out, err = capsys.readouterr()
        return stop.value.code, out, err

    return run
