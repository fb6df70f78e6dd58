"""Ctrl-C inside a command."""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def interruptible() -> Iterator[list[int]]:
    """Ctrl-C raises `KeyboardInterrupt`, again where a library has swallowed it; gives the signals so far."""
    signals: list[int] = []

    def interrupt(number: int, _: object) -> None:
        signals.append(number)
        raise KeyboardInterrupt

    def unraisable(found: Any) -> None:
        if signals:
            threading.Timer(0.01, signal.raise_signal, [signal.SIGINT]).start()
        else:
            shown(found)

    if threading.current_thread() is not threading.main_thread():
        yield signals
        return
    before, shown = signal.signal(signal.SIGINT, interrupt), sys.unraisablehook
    sys.unraisablehook = unraisable
    try:
        yield signals
    finally:
        sys.unraisablehook = shown
        signal.signal(signal.SIGINT, before)
