"""Memory of large results is used again, but never while a view of it is alive."""

import gc
import threading

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import result_form as module
from lwr_dyn.codegen.kernels.result_form import ALIGNMENT, LEAST, kept_bytes, result_memory
from tests.codegen.kernels.evaluate import states

SHAPE = (LEAST // 64, 8)


@pytest.fixture(autouse=True)
def _nothing_kept():
    module._kept.clear()
    yield
    module._kept.clear()


def place(array):
    return array.__array_interface__["data"][0]


def test_the_next_array_of_that_size_takes_the_memory():
    first = result_memory(SHAPE, "float64")
    at = place(first)
    assert at % ALIGNMENT == 0
    assert first.shape == SHAPE
    assert first.flags.writeable
    del first
    assert kept_bytes() == LEAST + ALIGNMENT
    assert place(result_memory((8, SHAPE[0]), "float64")) == at
    other = result_memory(SHAPE, "float64")
    assert place(result_memory((SHAPE[0], 9), "float64")) != place(other)


@pytest.mark.parametrize("view", [lambda x: x[5:6], lambda x: x.T, np.asarray, lambda x: memoryview(x)])
def test_a_view_keeps_the_memory(view):
    array = result_memory(SHAPE, "float64")
    array[:] = 7.0
    part = view(array)
    del array
    gc.collect()
    assert kept_bytes() == 0
    result_memory(SHAPE, "float64")[:] = 1.0
    assert np.all(np.asarray(part) == 7.0)


def test_little_memory_and_too_much_are_not_kept(monkeypatch):
    result_memory((100,), "float64")
    assert kept_bytes() == 0
    monkeypatch.setattr(module, "MOST", 3 * LEAST)
    arrays = [result_memory(SHAPE, "float64") for _ in range(7)]
    del arrays
    assert 0 < kept_bytes() <= 3 * LEAST
    result_memory((8, *SHAPE), "float64")
    assert kept_bytes() <= 3 * LEAST


def test_the_results_of_a_batch_and_of_the_engine_stay_what_they_were():
    arm = lwr_dyn.load("lwr4plus")
    q, batch, engine = states(7, 5000)[0], lwr_dyn.batch_dynamics(arm), lwr_dyn.dynamics_of(arm, "kernels")
    first = engine.mass_matrix(q)
    copy = first.copy()
    for values in (batch.mass_matrix(-q), engine.mass_matrix(2.0 * q), batch.mass_matrix(3.0 * q)):
        assert place(values) != place(first)
    assert np.array_equal(first, copy)


def test_threads_never_share_a_memory():
    wrong = []

    def work(number):
        for _ in range(50):
            array = result_memory(SHAPE, "float64")
            array[::64] = number
            if not (array[::64] == number).all():
                wrong.append(number)

    threads = [threading.Thread(target=work, args=(float(i),)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong
