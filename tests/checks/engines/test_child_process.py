"""An engine that crashes, aborts, hangs or refuses costs one line, which keeps what its C code prints in order."""

import os
import subprocess
import sys

import numpy as np
import pytest

from lwr_dyn.checks.engines.child_process import Job, TriedStates, load_all, one_line, quiet
from lwr_dyn.checks.engines.engine import ArmInFile
from tests.checks.engines.small_files import TWO

STATES = TriedStates(*np.zeros((3, 1, 2)))
SCOPE = ArmInFile(("j1", "j2"), "tool", (0.0, 0.0, -9.81))
WRAPPER = """
import os, time
import numpy as np
from lwr_dyn.checks.engines import child_process
def load_here(engine, job, states):
    print("chatter on stdout", flush=True)
    os.write(1, b"more chatter")
    if job.options.get("abort"):
        os.abort()
    if job.options.get("hang"):
        time.sleep(60)
    return child_process.Loaded(1.0, np.eye(4)[None], {}, ())
child_process.load_here = load_here
child_process.main("pinocchio")
"""


@pytest.fixture
def faulty(monkeypatch, tmp_path):
    """The child as a script whose engine does what the options say."""
    script, run = tmp_path / "child.py", subprocess.run
    script.write_text(WRAPPER, encoding="utf-8")
    monkeypatch.setattr(
        "lwr_dyn.checks.engines.child_process.subprocess.run",
        lambda command, **options: run([command[0], str(script)], **options),
    )


def test_a_crash_costs_its_own_file_only(two, faulty):
    jobs = [Job(two, SCOPE), Job(two, SCOPE, {"abort": True}), Job(two, SCOPE)]
    first, second, third = load_all("pinocchio", jobs, STATES)
    assert (first.mass, third.mass, second[:16]) == (1.0, 1.0, "ended by SIGABRT")


@pytest.mark.slow
def test_a_file_that_hangs_ends_the_engine(two, faulty):
    jobs = [Job(two, SCOPE), Job(two, SCOPE, {"hang": True}), Job(two, SCOPE)]
    first, second, third = load_all("pinocchio", jobs, STATES, seconds=5.0)
    assert (first.mass, second, third) == (1.0, "no answer within 5 s", "no answer within 5 s")


def test_a_refusal_is_one_line_with_the_parser_s_own_words(two, tmp_path):
    bad = tmp_path / "bad.urdf"
    bad.write_text(TWO.replace('link="upper"', 'link="uper"', 1), encoding="utf-8")
    good, refusal = load_all("pinocchio", [Job(two, SCOPE), Job(bad, SCOPE)], STATES)
    assert good.mass == pytest.approx(3.0)
    assert ("\n" in refusal, "does not contain a valid URDF model" in refusal, "uper" in refusal) == (False, True, True)


def test_prints_of_both_streams_are_kept(capfd, monkeypatch):
    for number, name in ((1, "stdout"), (2, "stderr")):  # both keep what is printed until they are flushed
        monkeypatch.setattr(f"sys.{name}", os.fdopen(number, "w", closefd=False))
        print(f"before on {name}", end="", file=getattr(sys, name))
    opened = os.listdir("/proc/self/fd")
    with quiet() as lines:
        os.write(2, b"Error:   no such joint\n")
        os.write(1, b"a banner\n")
        print("kept back by stdout")
        print("kept back by stderr", end="", file=sys.stderr)
    os.write(1, b", after\n")
    assert lines == ["Error:   no such joint", "a banner", "kept back by stdout", "kept back by stderr"]
    assert os.listdir("/proc/self/fd") == opened
    assert capfd.readouterr() == ("before on stdout, after\n", "before on stderr")
    assert one_line(ValueError("refused\nby it"), lines) == "refused by it (Error:   no such joint)"
    assert one_line(KeyError(), []) == "KeyError"
    assert len(one_line(ValueError("x" * 999), [])) < 250
