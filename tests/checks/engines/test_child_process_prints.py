"""What C code prints is kept, in order, and the terminal is back afterwards."""

import os

from lwr_dyn.checks.engines.child_process import one_line, quiet


def test_prints_of_both_streams_are_kept(capfd):
    with quiet() as lines:
        os.write(2, b"Error:   no such joint\n")
        os.write(1, b"a banner\n")
    os.write(1, b"after\n")
    assert lines == ["Error:   no such joint", "a banner"]
    assert capfd.readouterr() == ("after\n", "")
    assert one_line(ValueError("refused\nby it"), lines) == "refused by it (Error:   no such joint)"
    assert one_line(KeyError(), []) == "KeyError"
    assert len(one_line(ValueError("x" * 999), [])) < 250
