"""Progress: one line on a terminal, a bar in a notebook, nothing in a pipe."""

import contextlib
import io
import os
import signal
import sys
import threading
import time
from types import SimpleNamespace

import pytest

from lwr_dyn.foundation import progress as module
from lwr_dyn.foundation.progress import CLEAR, progress, stop_asked


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Bar:
    """What is used of tqdm."""

    def __init__(self, **options):
        self.options, self.n, self.said, self.closed = options, 0.0, [], False

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.closed = True

    def update(self, step):
        self.n += step

    def set_description_str(self, text):
        self.said.append(text)


def shown(monkeypatch, stream, after=0.0, *, work=0.2, **options):
    monkeypatch.setattr(module, "AFTER", after)
    monkeypatch.setattr(module, "EVERY", 0.01)
    monkeypatch.setattr(sys, "stderr", stream)
    with progress("adding", **options) as report:
        report("thirds")
        report(0.5)
        time.sleep(work)
    return stream.getvalue()


def test_a_terminal_has_one_line_that_is_cleared(monkeypatch):
    text = shown(monkeypatch, Terminal())
    assert "\n" not in text
    assert f"{CLEAR}adding ...  thirds  50%  0 s" in text
    assert text.endswith(CLEAR)


def test_a_line_is_no_wider_than_the_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "20")
    assert max(map(len, shown(monkeypatch, Terminal()).split(CLEAR))) == 19


@pytest.mark.parametrize(
    ("stream", "options"),
    [(io.StringIO(), {}), (Terminal(), {"terminal": False}), (Terminal(), {"after": 60.0, "work": 0.0})],
)
def test_pipes_and_short_work_show_nothing(monkeypatch, stream, options):
    assert shown(monkeypatch, stream, **options) == ""


def test_the_line_is_cleared_when_the_work_fails(monkeypatch):
    monkeypatch.setattr(module, "AFTER", 0.0)
    monkeypatch.setattr(sys, "stderr", Terminal())
    with contextlib.suppress(ZeroDivisionError), progress("dividing"):
        time.sleep(0.05)
        raise ZeroDivisionError
    assert sys.stderr.getvalue().endswith(CLEAR)


def in_a_notebook(monkeypatch, auto):
    """Shown there, where the package tqdm is this one, or none."""
    kernel = SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=True))
    package = auto and SimpleNamespace(auto=auto)
    for name, there in (("IPython", kernel), ("tqdm", package), ("tqdm.auto", auto)):
        monkeypatch.setitem(sys.modules, name, there)
    return shown(monkeypatch, Terminal(), work=0.0)


def test_a_notebook_has_a_bar_and_without_tqdm_nothing(monkeypatch):
    bars = []
    auto = SimpleNamespace(tqdm=lambda **options: bars.append(Bar(**options)) or bars[-1])
    assert [in_a_notebook(monkeypatch, each) for each in (auto, None)] == ["", ""]
    (bar,) = bars
    assert (bar.n, bar.said, bar.closed) == (50.0, ["adding: thirds"], True)
    form = "{desc} {percentage:3.0f}% {bar}"
    assert bar.options == {"desc": "adding", "total": 100, "delay": 0.0, "leave": False, "bar_format": form}


def test_the_first_ctrl_c_asks_and_the_second_one_stops():
    before, called = signal.getsignal(signal.SIGINT), []
    with pytest.raises(KeyboardInterrupt), stop_asked(lambda: called.append(1)) as stop:  # noqa: PT012
        assert not stop()
        os.kill(os.getpid(), signal.SIGINT)
        assert stop()
        assert called == [1]
        signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before
    with stop_asked():
        assert signal.getsignal(signal.SIGINT) is not before
    assert signal.getsignal(signal.SIGINT) is before


def test_an_ignored_ctrl_c_stays_ignored_and_another_thread_is_left_alone():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with stop_asked() as stop:
            signal.raise_signal(signal.SIGINT)
            assert not stop()
    finally:
        signal.signal(signal.SIGINT, before)
    said = []

    def work():
        with stop_asked() as stop:
            said.append((stop(), signal.getsignal(signal.SIGINT) is before))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert said == [(False, True)]
