"""Progress of long work: one line on a terminal, a bar in a notebook, nothing in a pipe; and whether it is to end."""

import shutil
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread
from time import monotonic

Report = Callable[[float | str], None]
"""Called with the share that is done, from 0 to 1, or with the name of the step that begins."""
AFTER = 1.0
"""[s] Work that ends sooner shows nothing."""
EVERY = 0.2
"""[s] Between two states of the line."""
CLEAR = "\r\x1b[K"


@contextmanager
def progress(title: str, terminal: bool = True) -> Iterator[Report]:
    """A function that long work calls; what it reports is shown until the block ends.

    On a terminal (stderr) it is one line, which is cleared at the end; without `terminal`, in pipes and files there is
    none. In a notebook it is a bar of tqdm, if that can be imported.

    >>> with progress("adding") as report:
    ...     report(0.5)
    """
    if in_notebook():
        with _bar(title) as report:
            yield report
    elif terminal and sys.stderr.isatty():
        with _line(title) as report:
            yield report
    else:
        yield lambda _: None


@contextmanager
def stop_asked(on_stop: Callable[[], None] = lambda: None) -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C was pressed in the block: the work in it asks, and ends with what it has.

    The second Ctrl-C does what the first one did before the block. Where Ctrl-C is ignored, and outside of the main
    thread, nothing changes. `on_stop` is called at the first one.

    >>> with stop_asked() as stop:
    ...     stop()
    False
    """
    asked = Event()
    before = signal.getsignal(signal.SIGINT)
    if before is signal.SIG_IGN or threading.current_thread() is not threading.main_thread():
        yield asked.is_set
        return

    def ask(_: int, __: object) -> None:
        asked.set()
        signal.signal(signal.SIGINT, before)
        on_stop()

    signal.signal(signal.SIGINT, ask)
    try:
        yield asked.is_set
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _line(title: str) -> Iterator[Report]:
    """A thread draws the line, so that its clock goes on where a step is long."""
    state, begin, done = {"share": "", "step": ""}, monotonic(), Event()

    def report(found: float | str) -> None:
        state.update(step=found) if isinstance(found, str) else state.update(share=f"{found:.0%}")

    def draw() -> None:
        while not done.wait(EVERY if monotonic() - begin > AFTER else AFTER):
            words = (f"{title} ...", state["step"], state["share"], f"{monotonic() - begin:.0f} s")
            line = "  ".join(filter(None, words))
            print(f"{CLEAR}{line[: shutil.get_terminal_size().columns - 1]}", end="", file=sys.stderr, flush=True)

    thread = Thread(target=draw, daemon=True)
    thread.start()
    try:
        yield report
    finally:
        done.set()
        thread.join()
        if monotonic() - begin > AFTER:
            print(CLEAR, end="", file=sys.stderr, flush=True)


@contextmanager
def _bar(title: str) -> Iterator[Report]:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        yield lambda _: None
        return
    with tqdm(desc=title, total=100, delay=AFTER, leave=False, bar_format="{desc} {percentage:3.0f}% {bar}") as bar:

        def report(found: float | str) -> None:
            bar.set_description_str(f"{title}: {found}") if isinstance(found, str) else bar.update(100 * found - bar.n)

        yield report


def in_notebook() -> bool:
    """Whether a kernel of Jupyter runs this process."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return hasattr(shell, "kernel")
