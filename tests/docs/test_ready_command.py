"""A command that a ready process runs behaves as one that was started: streams, exit code, signals, surroundings."""

import signal
import subprocess
import sys

import pytest

from tests.docs.console import environment

pytestmark = pytest.mark.slow
OF_ITS_OWN = f'"{sys.executable}" -m lwr_dyn'
"""The command, started."""


@pytest.fixture(scope="module")
def variables(tmp_path_factory):
    return environment(tmp_path_factory.mktemp("programs"), "lwr-dyn")


def answer(script, variables, folder, **more):
    """Output, errors and exit code of a script."""
    words = ["bash", "-o", "pipefail", "-c", script]
    done = subprocess.run(
        words, env=variables | more, cwd=folder, capture_output=True, text=True, stdin=subprocess.DEVNULL
    )
    return done.stdout, done.stderr, done.returncode


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("lwr-dyn chek 'a  b'", 2),
        ("lwr-dyn list > x; lwr-dyn list >> x; cat x", 0),
        ("lwr-dyn krl check a.src", 1),
        ("lwr-dyn list | true", 141),
    ],
)
def test_it_answers_as_one_that_was_started(line, code, variables, tmp_path):
    (tmp_path / "a.src").write_text("DEF a( )\nX = 1\nEND\n", encoding="utf-8")
    found = answer(line, variables, tmp_path)
    assert found == answer(line.replace("lwr-dyn", OF_ITS_OWN), variables, tmp_path)
    assert found[2] == code


def test_it_has_the_variables_of_who_asks(variables, tmp_path):
    wide, narrow = (answer("lwr-dyn --help", variables, tmp_path, COLUMNS=width)[0] for width in ("100", "50"))
    assert max(map(len, narrow.splitlines())) <= 50 < max(map(len, wide.splitlines()))


CONTROLLER = """
import multiprocessing, os, signal, sys

def make(arm, dynamics):
    process = multiprocessing.get_context("spawn").Process(target=os._exit, args=(7,))
    process.start()
    process.join()
    print(process.exitcode, flush=True)
    WAY
"""


@pytest.mark.parametrize(
    ("way", "code"),
    [("os.kill(os.getpid(), signal.SIGKILL)", -signal.SIGKILL), ("os.kill(os.getpid(), signal.SIGINT)", 130)],
)
def test_it_ends_as_one_that_was_started(way, code, variables, tmp_path):
    """It also has processes of its own, which start as those of a command that was started."""
    (tmp_path / "mine.py").write_text(CONTROLLER.replace("WAY", way), encoding="utf-8")
    line = "lwr-dyn simulate lwr4plus --task hold --from-deg 0,30,0,-60,0,30,0 --controller mine.py"
    out, err, ended = answer(line, variables, tmp_path)
    assert (out, ended) == ("7\n", code), err
    assert (out, err, ended) == answer(line.replace("lwr-dyn", OF_ITS_OWN), variables, tmp_path)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, -signal.SIGTERM)])
def test_a_signal_reaches_it(number, code, variables, tmp_path):
    # not signal.pause(): a signal that comes just before it is lost, and the process then waits for ever
    waits = "import time\nprint('waits', flush=True)\nwhile True:\n    time.sleep(0.05)\n"
    (tmp_path / "mine.py").write_text(waits, encoding="utf-8")
    line = ["lwr-dyn", "simulate", "lwr4plus", "--controller", "mine.py"]
    process = subprocess.Popen(line, env=variables, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    with process:
        assert process.stdout.readline() == b"waits\n"
        process.send_signal(number)
        assert process.wait() == code
