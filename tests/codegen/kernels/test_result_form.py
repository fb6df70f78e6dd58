"""Where results of a batch lie: rows, padded rows, blocks of states; distinct values with the map to the matrix."""

import gc
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import result_form as module
from lwr_dyn.codegen.kernels.batch import NotFiniteWarning
from lwr_dyn.codegen.kernels.kernel import address as place
from lwr_dyn.codegen.kernels.kernel_source import generate
from lwr_dyn.codegen.kernels.kernel_spec import FUNCTIONS, kernel_spec
from lwr_dyn.codegen.kernels.result_form import ALIGNMENT, LEAST, kept_bytes, matrix_entries, result_memory
from lwr_dyn.foundation.errors import OptionError, ShapeError
from tests.codegen.kernels.evaluate import states
from tests.codegen.rollouts.beside import first_joints

ARM = lwr_dyn.load("lwr4plus")
DENSE = lwr_dyn.batch_dynamics(ARM)
COUNT = 43
X = states(7, COUNT)


SHORT = first_joints(3)
"""For results of hundreds of numbers, which compile slowly."""


def batch_of(layout, structure="dense", arm=ARM, **options):
    return lwr_dyn.batch_dynamics(arm, layout=layout, structure=structure, **options)


def read(batch, function, result, count=COUNT):
    values = batch.form(function).states_first(result, count)
    return batch.entries(function).dense(values) if batch.spec.structure == "compact" else values


FORMS = [
    *(("mass_matrix", layout, form) for layout in ("rows", "padded", "blocks") for form in ("dense", "compact")),
    *((function, "padded", "dense") for function in ("inverse_dynamics", "potential_energy")),
    *((function, "blocks", "compact") for function in ("torque_regressor", "inverse_dynamics")),
]


@pytest.mark.slow
@pytest.mark.parametrize(("function", "layout", "structure"), FORMS)
def test_the_values_are_those_of_dense_rows(function, layout, structure):
    arm = SHORT if function == "torque_regressor" else ARM
    arguments = X[: {"inverse_dynamics": 3, "torque_regressor": 3}.get(function, 1), :, : arm.n]
    dense, batch = batch_of("rows", arm=arm), batch_of(layout, structure, arm)
    expected = getattr(dense, function)(*arguments)
    result = getattr(batch, function)(*arguments)
    assert np.array_equal(read(batch, function, result), expected)
    for count in (1, 8, 17):
        part = getattr(batch, function)(*(x[:count] for x in arguments))
        assert np.array_equal(read(batch, function, part, count), expected[:count])


@pytest.mark.slow
def test_padded_rows_begin_on_whole_vectors_and_every_matrix_is_whole():
    batch = batch_of("padded")
    B, vector = batch.mass_matrix(X[0]), 8 * batch.kernel("mass_matrix").interface.lanes
    assert (B.shape, B[3].flags.c_contiguous) == ((COUNT, 7, 7), True)
    assert (B.strides[0] % vector, place(B) % vector) == (0, 0)


@pytest.mark.slow
@pytest.mark.parametrize("layout", ["padded", "blocks"])
def test_a_place_for_results_is_what_empty_gives(layout):
    batch = batch_of(layout)
    given = batch.form("mass_matrix").empty(COUNT)
    assert batch.mass_matrix(X[0], out=given) is given
    assert np.array_equal(read(batch, "mass_matrix", given), DENSE.mass_matrix(X[0]))
    other = np.empty(given.shape) if layout == "padded" else np.empty(given.shape[::-1]).T
    shifted = np.empty(given.nbytes * 2, dtype=np.uint8)[1:]
    begin = -place(shifted) % 64 + 8
    unaligned = np.lib.stride_tricks.as_strided(shifted[begin:][: 8 * 1].view(float), given.shape, given.strides)
    for refused, words in ((np.empty((COUNT, 49)), "allowed: an array"), (other, "empty"), (unaligned, "empty")):
        with pytest.raises(ShapeError, match=f"out: .*{words}"):
            batch.mass_matrix(X[0], out=refused)


@pytest.mark.slow
@pytest.mark.parametrize("layout", ["padded", "blocks"])
def test_states_that_are_not_finite_or_far_away(layout):
    batch, q = batch_of(layout), X[0].copy()
    q[11, 3], q[20, 5], q[42, 0] = np.nan, 1e9, np.inf
    with pytest.warns(NotFiniteWarning, match="index 11, 42"):
        result = read(batch, "mass_matrix", batch.mass_matrix(q))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert np.array_equal(result, DENSE.mass_matrix(q), equal_nan=True)
    assert np.isnan(result[[11, 42]]).all()
    assert np.isfinite(result[20]).all()


def test_large_rows_may_begin_anywhere():
    q, memory = states(7, 9001)[0], np.full(9001 * 49 + 16, 77.0)
    few = np.concatenate([DENSE.mass_matrix(part) for part in np.array_split(q, 3)])  # through the caches
    assert np.array_equal(DENSE.mass_matrix(q), few)
    for start in range(1, 9):
        memory[:] = 77.0
        out = memory[start : start + 9001 * 49].reshape(9001, 7, 7)
        assert np.array_equal(DENSE.mass_matrix(q, out=out), few)
        assert memory[start - 1] == 77.0
        assert memory[start + 9001 * 49] == 77.0


@pytest.mark.parametrize("layout", ["padded", "blocks"])
def test_results_larger_than_the_cache_are_the_same(layout):
    q = states(7, 9001)[0]  # 3.5 MB, past the caches
    batch = batch_of(layout)
    assert np.array_equal(read(batch, "mass_matrix", batch.mass_matrix(q), 9001), DENSE.mass_matrix(q))


@pytest.mark.slow
@pytest.mark.parametrize(("function", "most"), [("mass_matrix", 28), ("torque_regressor", 248)])
def test_distinct_values_are_few(function, most):
    made = generate(kernel_spec(ARM, structure="compact"), function).interface
    entries = matrix_entries(made.entries, made.constants, FUNCTIONS[function].result(ARM.n))
    assert entries.count <= most
    assert set(np.unique(entries.index[entries.sign != 0])) == set(range(entries.count))


@pytest.mark.slow
@pytest.mark.parametrize("threads", [2, 3])
def test_threads_and_single_precision(threads):
    q = states(7, 10_001)[0]
    for layout, dtype in (("blocks", "float64"), ("padded", "float32")):
        several, one = (batch_of(layout, dtype=dtype, threads=k) for k in (threads, 1))
        pair = [read(b, "mass_matrix", b.mass_matrix(q.astype(dtype)), 10_001) for b in (several, one)]
        assert np.array_equal(*pair)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: batch_of("columns"), OptionError, "layout: 'columns'; allowed: rows, padded, blocks"),
        (lambda: batch_of("rows", "sparse"), OptionError, "structure: 'sparse'; allowed: dense, compact"),
        (
            lambda: batch_of("rows", "compact").inverse_dynamics_derivatives(*X), OptionError,
            "'compact' for inverse_dynamics_derivatives",
        ),
        (lambda: DENSE.entries("mass_matrix"), OptionError, "entries: of a dense batch"),
        (
            lambda: batch_of("rows", "compact").entries("mass_matrix").dense(np.zeros((3, 5))), ShapeError,
            r"values: shape \(3, 5\)",
        ),
    ],
)  # fmt: skip
def test_choices_that_do_not_exist_are_refused(call, error, words):
    with pytest.raises(error, match=words):
        call()


@pytest.mark.slow
def test_derivatives_have_the_layout_too():
    x = X[:, :9, : SHORT.n]
    padded, dense = (batch_of(layout, arm=SHORT).inverse_dynamics_derivatives(*x) for layout in ("padded", "rows"))
    assert np.array_equal(padded.by_q, dense.by_q)
    assert np.array_equal(padded.by_ddq, dense.by_ddq)


SHAPE = (LEAST // 64, 8)


@pytest.fixture(autouse=True)
def _nothing_kept():
    module._kept.clear()
    yield
    module._kept.clear()


def test_the_next_array_of_that_size_takes_the_memory():
    first = result_memory(SHAPE, "float64")
    at = place(first)
    assert (at % ALIGNMENT, first.shape, first.flags.writeable) == (0, SHAPE, True)
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
    q, engine = states(7, 5000)[0], lwr_dyn.dynamics_of(ARM, "kernels")
    first = engine.mass_matrix(q)
    copy = first.copy()
    for values in (DENSE.mass_matrix(-q), engine.mass_matrix(2.0 * q), DENSE.mass_matrix(3.0 * q)):
        assert place(values) != place(first)
    assert np.array_equal(first, copy)


def test_threads_never_share_a_memory():
    def is_mine(number):
        array = result_memory(SHAPE, "float64")
        array[::64] = number
        return (array[::64] == number).all()

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(is_mine, np.arange(200.0)))
