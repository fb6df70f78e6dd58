"""Ctrl-C ends a command with one line and 130, whenever it comes; names are printed on any terminal."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from lwr_dyn.cli import main
from lwr_dyn.cli.main import interruptible
from tests.arms.urdf.small_files import LINK, joint, robot, written

COMMAND = [sys.executable, "-m", "lwr_dyn"]
HOOK = """
import builtins, os, signal, sys
signal.signal(signal.SIGINT, signal.{at_start})
real = builtins.__import__
def importing(name, *more, **options):
    if name == {name!r}:
        builtins.__import__ = real
        os.kill(os.getpid(), signal.SIGINT)
    return real(name, *more, **options)
builtins.__import__ = importing
sys.argv = ["lwr-dyn", *{words!r}]
from lwr_dyn.__main__ import main
main()
"""


MODULES = ("click", "lwr_dyn.foundation.errors", "numpy", "pinocchio")


def interrupted_at(name, words, at_start="default_int_handler"):
    """The command, with Ctrl-C at the moment when that module is first asked for."""
    code = HOOK.format(name=name, words=words, at_start=at_start)
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)


@pytest.fixture
def heard():
    """Ctrl-C is heard: a shell that runs the tests in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.slow
@pytest.mark.parametrize("name", MODULES)
def test_ctrl_c_while_a_module_is_loaded(name):
    done = interrupted_at(name, ["check", "lwr4plus"])
    assert (done.returncode, done.stdout, done.stderr.strip()) == (130, "", "lwr-dyn: stopped")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lwr_dyn.foundation.errors", "lwr_dyn.arms.papers.catalog"])
def test_where_the_shell_ignores_ctrl_c_it_stays_ignored(name):
    """Before the command begins, and inside it."""
    done = interrupted_at(name, ["list"], at_start="SIG_IGN")
    assert (done.returncode, done.stderr) == (0, "")
    assert "lwr4plus" in done.stdout


@pytest.mark.usefixtures("heard")
def test_an_error_that_a_library_makes_of_ctrl_c_is_no_traceback(lwr_dyn_command, monkeypatch):
    def interrupted(**_):
        try:
            os.kill(os.getpid(), signal.SIGINT)
            threading.Event().wait(5)
        except KeyboardInterrupt:
            raise ImportError("numpy.core.multiarray failed to import") from None

    monkeypatch.setattr(main.group, "main", interrupted)
    assert lwr_dyn_command("list") == (130, "", "lwr-dyn: stopped\n")


@pytest.mark.usefixtures("heard")
def test_ctrl_c_that_is_swallowed_comes_again(capfd):
    class Noisy:
        def __del__(self):
            os.kill(os.getpid(), signal.SIGINT)
            sum(range(100_000))

    def swallowed():
        with interruptible() as signals:
            Noisy()
            threading.Event().wait(5)
        return signals

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        swallowed()
    assert capfd.readouterr() == ("", "")
    assert signal.getsignal(signal.SIGINT) is before
    assert sys.unraisablehook is not None


@pytest.mark.slow
def test_a_name_that_the_terminal_cannot_show_is_escaped(tmp_path):
    path = written(tmp_path, robot(joint("j", "a", "b"), a="", b=LINK).replace('name="r"', 'name="空"'))
    environment = os.environ | {"PYTHONIOENCODING": "latin-1"}
    done = subprocess.run([*COMMAND, "fk", str(path), "--q", "0.1"], env=environment, capture_output=True)
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.startswith(b"\\u7a7a, reading urdf")
