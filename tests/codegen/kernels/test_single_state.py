"""Functions of single states at C level: what they read, what goes to the function behind, what they leave behind."""

import gc
import math
import pickle
import platform
import sys
import tracemalloc

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import single_state
from lwr_dyn.codegen.kernels.scalar_code import scalar_function
from lwr_dyn.codegen.kernels.single_state import Signature, closed_because, single_call
from lwr_dyn.codegen.kernels.straight_line import Node, StraightLineCode, Value
from lwr_dyn.dynamics.protocol import FUNCTIONS
from lwr_dyn.foundation.errors import ShapeError
from tests.codegen.kernels.wrong_arrays import BAD, GOOD, references, refused_or_right
from tests.codegen.rollouts.beside import first_joints

ARM = lwr_dyn.load("lwr4plus")
ENGINE = lwr_dyn.dynamics_of(ARM, "kernels")
TWO = first_joints(2)
open_here = pytest.mark.skipif(bool(closed_because()), reason=closed_because() or "open")


def doubled(behind, doc=""):
    """x -> 2 x of three numbers."""
    nodes = [Node("in", 0, j) for j in range(3)] + [Node("+", j, j) for j in range(3)] + [Node("const", 0.0)]
    code = StraightLineCode(tuple(nodes), tuple(Value(1, 3 + j) for j in range(3)), Value(1, 6))
    body = lambda: scalar_function("body", code, 1)  # noqa: E731
    return single_call("doubled", Signature(((3,),), (3,)), ["doubled"], body, behind, doc)


@open_here
def test_what_the_code_does_not_take_goes_to_the_function_behind():
    call = doubled(lambda *given: ("behind", given), "doubled(x, /)\n--\n\nTwice x.")
    x = np.arange(3.0)
    assert np.array_equal(call(x), 2 * x)
    assert (call.__name__, call.__doc__) == ("doubled", "Twice x.")
    for other in (
        x.tolist(), x[:2], x.astype("f4"), x.astype(">f8"), x[::-1], np.zeros((3, 1)), None, x.view(np.matrix),
    ):  # fmt: skip
        assert call(other)[0] == "behind"
        assert call(other)[1][0] is other
    assert call() == ("behind", ())
    assert call(x, x)[0] == "behind"
    with pytest.raises(TypeError, match="keyword"):
        call(x=x)

    def behind(*given):
        raise LookupError("no such thing")

    with pytest.raises(LookupError, match="no such thing"):
        doubled(behind)([1, 2, 3])


SCALED = """
define internal double @scale(double %x, double %y) {
  %p = fmul double %x, %y
  ret double %p
}
define double @body(ptr %x, double %factor, ptr %out) {
  %first = load double, ptr %x
  %p = call double @scale(double %first, double %factor)
  store double %p, ptr %out
  ret double 0.0
}
"""


@open_here
@pytest.mark.parametrize("optimised", [True, False])
def test_floats_and_arrays_of_any_length(optimised):
    """A float of Python alone is read as one, and the first axis may have any length where the others are right."""
    signature = Signature(((None, 2), ()), (1,))
    call = single_call(
        "scaled", signature, [SCALED, str(optimised)], lambda: SCALED, lambda *given: "behind", optimised=optimised
    )
    for length in (1, 2, 7):
        assert call(np.full((length, 2), 3.0), 0.5).tolist() == [1.5]
    assert math.isnan(call(np.ones((1, 2)), math.nan)[0])
    x = np.ones((3, 2))
    for other in (
        (x, 1), (x, np.float64(1.0)), (x, True), (x, None), (x[:, :1], 0.5), (x[:, 0], 0.5), (x[::2], 0.5),
        (np.asfortranarray(x), 0.5), (x[None], 0.5), (0.5, x), (x,), (x, 0.5, 0.5),
    ):  # fmt: skip
        assert call(*other) == "behind"


@open_here
@pytest.mark.parametrize("function", FUNCTIONS)
def test_every_function_is_one_call_at_c_level(function):
    for of in (ENGINE, ENGINE.ungated):
        call = getattr(of, function)
        # a number is made one of NumPy around the call
        assert type(getattr(call, "__wrapped__", call)).__name__ == "builtin_function_or_method"
        assert hasattr(call, "__wrapped__") == (function == "potential_energy" and of is ENGINE)
        assert call.__name__ == function
        assert call.__doc__.endswith(".")


@pytest.mark.parametrize("function", FUNCTIONS)
def test_random_arrays_are_refused_or_right(function):
    refused, answered = refused_or_right(getattr(ENGINE, function), len(FUNCTIONS[function][0]), ARM.n, 900, seed=7)
    assert min(refused, answered) > 20


@pytest.mark.parametrize("kind", [*GOOD, "pickled"])
def test_each_kind_of_good_array_is_read(kind):
    x = np.random.default_rng(3).uniform(-3.0, 3.0, ARM.n)
    given = pickle.loads(pickle.dumps(x)) if kind == "pickled" else GOOD[kind](x, np.random.default_rng(0))
    assert np.array_equal(ENGINE.mass_matrix(given), ENGINE.mass_matrix(x))


@pytest.mark.parametrize("kind", BAD)
def test_each_kind_of_bad_array_is_refused(kind):
    x, rng = np.random.default_rng(3).uniform(-3.0, 3.0, (3, ARM.n)), np.random.default_rng(0)
    for place in range(3):
        rows = list(x)
        rows[place] = BAD[kind](x[place], rng)
        with pytest.raises((ValueError, TypeError)):
            ENGINE.inverse_dynamics(*rows)


def test_results_are_new_arrays():
    q = np.full(ARM.n, 0.3)
    first, second = ENGINE.mass_matrix(q), ENGINE.mass_matrix(q)
    assert not np.shares_memory(first, second)
    assert (first.flags.owndata, first.flags.writeable, first.flags.c_contiguous) == (True,) * 3


def test_calls_leave_nothing_behind():
    q, calls = np.full(ARM.n, 0.3), (ENGINE.mass_matrix, ENGINE.gravity_vector, ENGINE.potential_energy)
    bad = np.zeros(3)

    def all_ways(times):
        for call in calls * times:
            call(q)
            with pytest.raises(ShapeError):
                call(bad)
        gc.collect()

    all_ways(20)
    held = [references(x) for x in (q, bad, np.float64, None)]
    tracemalloc.start()
    all_ways(20)
    before = tracemalloc.get_traced_memory()[0]
    for call in calls * 3000:
        call(q)
    all_ways(20)
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert grown < 20_000  # one array a call would be a megabyte
    more = np.subtract([references(x) for x in (q, bad, np.float64, None)], held)
    assert more[:2].tolist() == [0, 0]
    assert np.abs(more[2:]).max() < 500


@open_here
def test_the_code_lives_as_long_as_the_function():
    call = doubled(lambda x: x)
    single_state._engines.clear()
    gc.collect()
    assert np.array_equal(call(np.ones(3)), np.full(3, 2.0))


@pytest.fixture
def judged_again():
    """What is found out about this Python is found out anew, here and by later tests."""
    single_state.closed_because.cache_clear()
    yield
    single_state.closed_because.cache_clear()


@pytest.mark.parametrize(
    ("of", "name", "value", "why"),
    [
        (platform, "machine", lambda: "aarch64", "not tried on linux on aarch64"),
        (single_state, "_layout_holds", lambda x: False, "in another way"),
    ],
)
@pytest.mark.slow
@pytest.mark.usefixtures("judged_again")
def test_where_the_road_is_closed_the_function_behind_serves(monkeypatch, of, name, value, why):
    monkeypatch.setattr(sys, "platform", "linux")
    open_engine = lwr_dyn.dynamics_of(TWO, "kernels")
    for function in FUNCTIONS:
        getattr(open_engine, function)
    monkeypatch.setattr(of, name, value)
    single_state.closed_because.cache_clear()
    assert why in closed_because()
    behind = lambda x: x  # noqa: E731
    assert doubled(behind) is behind
    plain, states = lwr_dyn.dynamics_of(TWO, "kernels"), np.random.default_rng(1).uniform(-2.0, 2.0, (3, 2))
    for function, (arguments, _) in FUNCTIONS.items():
        rows = states[: len(arguments)]
        assert np.array_equal(getattr(plain, function)(*rows), getattr(open_engine, function)(*rows))
        assert type(getattr(plain, function)).__name__ == "function"
    assert plain.ungated.held_step(1e-3, 1, np.zeros((2, 2, 2))) is None
    with pytest.raises(ShapeError):
        plain.mass_matrix(np.zeros(3))


@pytest.mark.usefixtures("judged_again")
def test_an_object_of_another_size_has_no_lock_or_another_width(monkeypatch):
    # a free-threaded Python has a larger head, so that all offsets are others
    monkeypatch.setattr(single_state, "object", type("Wide", (), {"__basicsize__": 32}), raising=False)
    assert "lock" in closed_because()
    behind = lambda x: x  # noqa: E731
    assert doubled(behind) is behind


@open_here
def test_the_layout_is_looked_at():
    assert single_state._layout_holds(np.arange(3.0))
    assert not single_state._layout_holds(np.arange(3.0).astype(">f8"))
    assert not single_state._layout_holds(np.arange(6.0)[::2])
