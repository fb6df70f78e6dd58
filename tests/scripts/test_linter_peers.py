"""What other programs say of a file: each is asked in a process of its own, which may abort."""

import os
import signal
import sys
from pathlib import Path

import pytest

from scripts.linter_peers import apart, lines_of

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no fork")
PATH = Path("arm.urdf")


def test_lines_are_compared_without_numbers_and_a_program_that_aborts_or_raises_says_so():
    def aborts(text, path):
        os.kill(os.getpid(), signal.SIGKILL)

    def raises(text, path):
        raise ValueError(text)

    assert apart(lambda text, path: frozenset({text, path.name}), "a", PATH) == {"a", "arm.urdf"}
    assert apart(aborts, "a", PATH) == {"aborted, -9"}
    assert apart(raises, "a", PATH) == {"aborted, 1"}
    assert apart(lambda text, path: frozenset(), "a", PATH) == frozenset()
    assert lines_of("mass 0.5 of link_3\n\n  mass 7e-3 of link_3 ") == {"mass # of link_#"}
