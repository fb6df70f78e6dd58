"""An engine's own prints kept off the terminal: C++ code writes to the file descriptors, past Python's streams."""

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet() -> Iterator[list[str]]:
    """Nothing reaches stdout and stderr inside; the list holds the printed lines afterwards."""
    lines: list[str] = []
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [(number, os.dup(number)) for number in (1, 2)]
    with tempfile.TemporaryFile() as file:
        try:
            for number, _ in kept:
                os.dup2(file.fileno(), number)
            yield lines
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for number, old in kept:
                os.dup2(old, number)
                os.close(old)
            file.seek(0)
            lines += [line.strip() for line in file.read().decode("utf-8", "replace").splitlines() if line.strip()]


def one_line(fault: BaseException, printed: list[str]) -> str:
    """An engine's reason in one line: its own words, and the error that it printed if there is one."""
    said = " ".join(str(fault).split()) or type(fault).__name__
    errors = [line for line in printed if "error" in line.lower()]
    said = said if not errors or errors[0] in said else f"{said} ({errors[0]})"
    return said if len(said) <= _LONGEST else f"{said[:_LONGEST]} ..."


_LONGEST = 220
