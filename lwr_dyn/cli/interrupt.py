"""Ctrl-C inside a command."""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any


@contextmanager
def interruptible() -> Iterator[list[int]]:
    """Ctrl-C raises `KeyboardInterrupt`, again where a library has swallowed it; gives the signals so far.

    Where it is ignored, it stays ignored.
    """
    signals: list[int] = []

    def interrupt(number: int, _: object) -> None:
        signals.append(number)
        raise KeyboardInterrupt

    def unraisable(found: Any) -> None:
        if signals:
            threading.Timer(0.01, again).start()
        else:
            shown(found)

    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    if ignored or threading.current_thread() is not threading.main_thread():
        yield signals
        return
    again = partial(signal.raise_signal, signal.SIGINT)
    if hasattr(signal, "pthread_kill"):  # it also wakes this thread where it waits
        again = partial(signal.pthread_kill, threading.get_ident(), signal.SIGINT)
    before, shown = signal.signal(signal.SIGINT, interrupt), sys.unraisablehook
    sys.unraisablehook = unraisable
    try:
        yield signals
    finally:
        sys.unraisablehook = shown
        signal.signal(signal.SIGINT, before)
