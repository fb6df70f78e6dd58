"""Progress of long work: one line on a terminal, a bar in a notebook, nothing in a pipe."""

import shutil
import sys
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
