"""The clock of a search: its stages, a wish to stop, and what progress shows."""

import pytest

from lwr_dyn.identification.excitation import watch as module
from lwr_dyn.identification.excitation.watch import FOR_STARTS, SearchWatch


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    found = Clock()
    monkeypatch.setattr(module, "perf_counter", found)
    return found


def test_starts_end_before_the_best_of_them(clock):
    watch = SearchWatch(10.0, begin=0.0)
    clock.now = 5.9
    assert not watch.is_over(FOR_STARTS)
    assert watch.ended == "searched"
    clock.now = 6.1
    assert watch.is_over(FOR_STARTS)
    assert not watch.is_over()
    assert watch.ended == "seconds"
    clock.now = 9.8
    assert watch.is_over()


def test_a_wish_to_stop_ends_every_stage_and_is_kept():
    asked = []
    watch = SearchWatch(stop=lambda: bool(asked))
    assert not watch.is_over()
    asked.append(1)
    assert watch.is_over(FOR_STARTS)
    asked.clear()
    assert watch.is_over()
    assert watch.ended == "stopped"


def test_progress_names_the_step_and_rises_to_the_end(clock):
    said = []
    watch = SearchWatch(100.0, report=said.append, steps=2, begin=0.0)
    watch.step("start 1 of 1")
    for share in (0.5, 2.0):
        watch.inside(share)
    watch.step_done()
    clock.now = 90.0
    watch.inside(0.1)
    watch.step_done()
    assert said == ["start 1 of 1", 0.25, 0.5, 0.5, 0.9, 1.0]
