"""The numbers of a run depend on nothing but the run: batch size, threads, place in the block, neighbours."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.rollouts.kernel import BLOCK
from tests.codegen.rollouts.test_rollouts import ARM, IST, OWN, perturbed

LAW = lwr_dyn.controller("inverse-dynamics", ARM, omega_n=50.0)
RUNS = BLOCK + 9
INERTIA = perturbed(RUNS, seed=1)
UNSTABLE = np.where(np.arange(OWN.size) % 10 == 0, OWN, -OWN)
"""An arm with negative moments of inertia, which accelerates away from its reference."""


def computed(rows, **options):
    given = {"inertia": INERTIA[rows], "Kp": np.linspace(1000.0, 3000.0, RUNS)[rows]}
    return lwr_dyn.rollouts(ARM, LAW, IST, parameters=given, duration=0.5, record=5, **options)


@pytest.fixture(scope="module")
def all_at_once():
    return computed(np.arange(RUNS))


def is_same(one, rows, all_runs):
    return all(
        np.array_equal(a, b[rows])
        for a, b in [
            *((one.metrics[name], all_runs.metrics[name]) for name in all_runs.metrics),
            (one.q, all_runs.q), (one.dq, all_runs.dq), (one.tau, all_runs.tau),
        ]
    )  # fmt: skip


@pytest.mark.parametrize("rows", [[0], [7], [70, 3, 41], [72, *range(10)], range(5, 70)])
def test_the_bits_are_the_same_for_any_batch_and_place(rows, all_at_once):
    rows = np.array(rows)
    assert is_same(computed(rows), rows, all_at_once)


@pytest.mark.parametrize("threads", [2, 5])
def test_the_bits_are_the_same_for_any_number_of_threads(threads, all_at_once):
    assert is_same(computed(np.arange(RUNS), threads=threads), np.arange(RUNS), all_at_once)


def test_a_run_that_turns_nan_leaves_its_neighbours_as_they_were(all_at_once):
    rows = np.arange(16)
    given = INERTIA[rows].copy()
    given[5] = UNSTABLE
    done = lwr_dyn.rollouts(
        ARM, LAW, IST, parameters={"inertia": given, "Kp": np.linspace(1000.0, 3000.0, RUNS)[rows]}, duration=0.5,
        record=5, hand_over=False, position_limits=False,
    )  # fmt: skip
    assert done.flags[5] == "not finite"
    assert all(np.isnan(values[5]).all() for values in done.metrics.values())
    assert np.isnan(done.q[5]).all()
    others = rows[rows != 5]
    for name, values in done.metrics.items():
        assert np.array_equal(values[others], all_at_once.metrics[name][others])
    assert np.array_equal(done.q[others], all_at_once.q[others])


def test_a_run_too_fast_to_be_followed_says_so():
    given = {"inertia": [UNSTABLE, OWN]}
    done = lwr_dyn.rollouts(
        ARM, LAW, IST, parameters=given, duration=0.1, hand_over=False, position_limits=False, quantiles=[0.5]
    )
    assert done.flags == ("out of range", "")
    assert np.isnan(done.metrics["tip_q50"][0])
    again = lwr_dyn.rollouts(ARM, LAW, IST, parameters=given, duration=0.1, position_limits=False)
    assert again.simulated.tolist() == [True, False]
    assert again.metrics["tip_max"][0] > 0.1  # simulate follows it
    longer = lwr_dyn.rollouts(ARM, LAW, IST, parameters=given, duration=0.2, position_limits=False)
    assert np.isnan(longer.metrics["tip_max"][0])  # it diverges in simulate too
