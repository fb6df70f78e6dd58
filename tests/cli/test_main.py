"""The command as a whole: its subcommands by rows, errors as one line with an exit code, and what it imports."""

import io
import os
import subprocess
import sys
import warnings

import pytest

from lwr_dyn.cli import main
from lwr_dyn.foundation.errors import RatingWarning


def test_every_command_has_help(printed):
    for command in main.COMMANDS.names:
        out = printed(command, "--help")
        assert out.startswith("Usage: lwr-dyn ")


def test_the_front_door_is_light():
    heavy = {"pinocchio", "yourdfpy", "scipy", "sympy", "matplotlib", "meshcat", "mujoco", "casadi"}
    code = f"import sys, lwr_dyn; lwr_dyn.robots; lwr_dyn.cli; print(sorted({heavy} & set(sys.modules)))"
    code = code.replace("lwr_dyn.cli; ", "import lwr_dyn.cli.main; ")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("command", "heavy"),
    [
        ("--version", {"numpy", "importlib.metadata"}),
        ("--help", {"numpy"}),
        ("check lwr4plus", {"scipy", "yourdfpy", "lwr_dyn.checks.urdf.lint", "lwr_dyn.simulation"}),
    ],
)
def test_a_command_loads_what_it_needs(command, heavy):
    code = (
        "import sys\nfrom lwr_dyn.cli import main\n"
        f"try: main.main({command.split()})\nexcept SystemExit: pass\n"
        f"print(sorted({heavy} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.slow
@pytest.mark.parametrize(("given", "used"), [({}, "1"), ({"OMP_NUM_THREADS": "3"}, "3")])
def test_blas_has_one_thread_unless_told_otherwise(given, used):
    code = (
        "import os, sys, lwr_dyn.__main__ as m\n"
        "assert 'numpy' not in sys.modules\n"
        "sys.argv = ['lwr-dyn', '--version']\n"
        "try: m.main()\nfinally: print(os.environ['OMP_NUM_THREADS'])"
    )
    environment = {name: value for name, value in os.environ.items() if name != "OMP_NUM_THREADS"} | given
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.splitlines()[-1] == used


@pytest.mark.parametrize(
    ("fault", "code", "line"),
    [
        (OSError(28, "No space left on device"), 2, "lwr-dyn: stdout: no space left on device; allowed: an output"),
        (SystemExit(3), 3, ""),
    ],
)  # fmt: skip
def test_what_ends_a_command_has_its_exit_code(lwr_dyn_command, monkeypatch, fault, code, line):
    def failing(**_):
        raise fault

    monkeypatch.setattr(main.group, "main", failing)
    result, out, err = lwr_dyn_command("list")
    assert (result, out) == (code, "")
    assert err.startswith(line)
    assert err.count("\n") == (1 if line else 0)


def test_a_warning_is_one_line_and_printed_once(lwr_dyn_command, monkeypatch):
    def warning(**_):
        for _ in range(2):
            warnings.warn("over\nthe rating", RatingWarning, stacklevel=1)

    monkeypatch.setattr(main.group, "main", warning)
    assert lwr_dyn_command("list") == (0, "", "lwr-dyn: warning: over the rating\n")


def test_a_name_that_the_terminal_cannot_show_is_written_by_its_code(monkeypatch):
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(io.BytesIO(), encoding="ascii"))
    monkeypatch.setattr(main.group, "main", lambda **_: print("\u7a7a"))
    with pytest.raises(SystemExit):
        main.main([])
    sys.stdout.flush()
    assert sys.stdout.buffer.getvalue() == b"\\u7a7a\n"


def test_an_error_message_becomes_one_line(capsys):
    assert main.print_error("two\n  lines", 2) == 2
    assert capsys.readouterr().err == "lwr-dyn: two lines\n"
