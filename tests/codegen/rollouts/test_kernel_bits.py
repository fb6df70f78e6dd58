"""The numbers of a run depend on nothing but the run: batch size, threads, place in the block, neighbours."""

import ctypes
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.kernel import address
from lwr_dyn.codegen.rollouts.kernel import BLOCK, RolloutKernel, Task
from tests.codegen.rollouts.test_result import SLOTS
from tests.codegen.rollouts.test_rollouts import ARM, IST, OWN, perturbed, same

LAW = lwr_dyn.controller("inverse-dynamics", ARM, omega_n=50.0)
RUNS = BLOCK + 9
INERTIA = perturbed(RUNS, seed=1)
UNSTABLE = np.where(np.arange(OWN.size) % 10 == 0, OWN, -OWN)
"""An arm with negative moments of inertia, which accelerates away from its reference."""


def computed(rows, inertia=INERTIA, **options):
    given = {"inertia": inertia[rows], "Kp": np.linspace(1000.0, 3000.0, RUNS)[rows]}
    return lwr_dyn.rollouts(ARM, LAW, IST, parameters=given, duration=0.5, record=5, **options)


@pytest.fixture(scope="module")
def all_at_once():
    return computed(np.arange(RUNS))


@pytest.mark.parametrize("rows", [[0], [7], [70, 3, 41], [72, *range(10)], range(5, 70)])
def test_the_bits_are_the_same_for_any_batch_and_place(rows, all_at_once):
    assert same(computed(np.array(rows)), all_at_once, np.array(rows))


@pytest.mark.parametrize("threads", [2, 5])
def test_the_bits_are_the_same_for_any_number_of_threads(threads, all_at_once):
    assert same(computed(np.arange(RUNS), threads=threads), all_at_once)


def test_a_run_that_turns_nan_leaves_its_neighbours_as_they_were(all_at_once):
    inertia = INERTIA.copy()
    inertia[5] = UNSTABLE
    done = computed(np.arange(16), inertia, hand_over=False, position_limits=False)
    assert done.flags[5] == "not finite"
    assert all(np.isnan(values[5]).all() for values in (*done.metrics.values(), done.q))
    others = np.delete(np.arange(16), 5)
    for one, other in ((done.q, all_at_once.q), *((x, all_at_once.metrics[name]) for name, x in done.metrics.items())):
        assert np.array_equal(one[others], other[others])


def test_a_run_too_fast_to_be_followed_says_so():
    def rolled(duration, **options):
        given = {"inertia": [UNSTABLE, OWN]}
        return lwr_dyn.rollouts(
            ARM, LAW, IST, parameters=given, duration=duration, position_limits=False, quantiles=[0.5], **options
        )

    done = rolled(0.1, hand_over=False)
    assert done.flags == ("out of range", "")
    assert np.isnan(done.metrics["tip_q50"]).tolist() == [True, False]
    again = rolled(0.1)
    assert again.simulated.tolist() == [True, False]
    assert again.metrics["tip_max"][0] > 0.1  # simulate follows it
    assert np.isnan(rolled(0.2).metrics["tip_max"][0])  # it diverges in simulate too


def test_blocks_of_runs_are_handed_to_the_code_with_room_for_their_results():
    """By code that notes what it is given, and traces squares of errors."""
    calls, runs = [], BLOCK + 6
    squares = np.random.default_rng(0).uniform(0.0, 4.0, (runs, 7))

    def call(*given):
        calls.append(given)
        first, last = given[-2:]
        trace = np.ctypeslib.as_array(ctypes.cast(given[12], ctypes.POINTER(ctypes.c_double)), (BLOCK, 7))
        trace[: last - first] = squares[first:last]

    common, places, which = np.zeros(SLOTS.size), np.arange(5.0), np.zeros(runs)
    rows, reference = np.zeros((runs, 5)), np.zeros((2, 7, 9))
    task = Task(common, rows, places, reference, which, seed=3, first_run=11, stride=3, quantiles=(0.25, 0.9))
    out = RolloutKernel(SLOTS, 4, 2, "digest", SimpleNamespace(call=call)).run(task)
    assert [given[-2:] for given in calls] == [(0, BLOCK), (BLOCK, runs)]
    assert out.record.shape == (runs, 3, 6)
    assert out.figures.shape == (runs, SLOTS.size - 3)
    assert np.array_equal(out.quantiles, np.quantile(np.sqrt(squares), (0.25, 0.9), axis=1).T)
    arrays = [common, rows, places, reference, which, out.record]
    for given in calls:
        assert list(given[:12:2]) == [address(x) for x in arrays]
        assert given[14] == 3
        assert list(given[1:16:2]) == [1, 5, 7, 2, 3, 3, 0, 11]
        assert given[16] == address(out.figures)
        assert given[17] % 64 == 0
    calls.clear()
    plain = RolloutKernel(SLOTS, 4, 2, "digest", SimpleNamespace(call=lambda *given: calls.append(given)))
    out = plain.run(Task(common, rows[:9], places, reference, which))
    assert (out.record, out.quantiles.shape) == (None, (9, 0))
    assert [(given[1], given[9], given[11], *given[-2:]) for given in calls] == [(0, 1, 0, 0, 9)]
