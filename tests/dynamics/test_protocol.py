"""The shape gate of all engines: batches, lists, and one clear error for anything else."""

import copy
import pickle
from importlib.util import find_spec

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.engines import ENGINES
from lwr_dyn.dynamics.newton_euler import Recursion
from lwr_dyn.dynamics.protocol import FUNCTIONS, Dynamics, Gated, mass_and_bias, mechanical_energy, singular_joint
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError, UnknownNameError
from lwr_dyn.foundation.registry import Registry, Row
from tests.random_arms import random_arm

METHODS = {name: len(arguments) for name, (arguments, _) in FUNCTIONS.items()}
LWR = lwr_dyn.load("lwr4plus")


@pytest.fixture(scope="module", params=[name for name in ENGINES.names if name != "kernels" or find_spec("llvmlite")])
def engine(request):
    return lwr_dyn.dynamics_of(LWR, request.param)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("batch", [(), (5,), (2, 3), (0,), (1,)])
def test_a_batch_is_its_states_one_by_one(engine, method, batch):
    x = np.random.default_rng(0).uniform(-1, 1, (3, *batch, 7))[: METHODS[method]]
    call = getattr(engine, method)
    out, shape = call(*x), (7,) * FUNCTIONS[method][1]
    assert (out.shape, out.dtype) == ((*batch, *shape), np.float64)
    rows = [call(*map(list, state)) for state in zip(*(a.reshape(-1, 7) for a in x), strict=True)]
    assert np.abs(out.reshape(-1, *shape) - np.array(rows).reshape(-1, *shape)).max(initial=0.0) < 1e-13


def assert_mass_and_bias(engine, q, dq):
    B, bias = mass_and_bias(engine, q, dq)
    assert B.shape == (*q.shape, q.shape[-1])
    assert np.array_equal(B, engine.mass_matrix(q))
    assert np.array_equal(bias, engine.bias_torque(q, dq))


def test_mass_matrix_and_bias_together_are_those_of_two_calls(engine):
    q, dq = np.random.default_rng(0).uniform(-1, 1, (2, 4, 7))
    assert_mass_and_bias(engine, q, dq)
    for bad in ((np.where(q == q[1, 2], np.inf, q), dq), (q, np.where(dq == dq[3, 0], np.nan, dq))):
        with pytest.raises(ShapeError):
            mass_and_bias(engine, *bad)


@pytest.mark.parametrize("rotors", ["armature", "full", "none"])
@pytest.mark.parametrize("joints", ["P", "R", "PP", None])
def test_so_are_those_of_any_joints(joints, rotors):
    arm = random_arm(5, joints)
    x = np.random.default_rng(0).uniform(-1, 1, (2, 3, arm.n))
    assert_mass_and_bias(lwr_dyn.dynamics_of(arm, "newton-euler", rotors=rotors), *x)


def test_leading_axes_broadcast(engine):
    q, dq = np.zeros((3, 1, 7)), np.ones((1, 4, 7))
    assert engine.bias_torque(q, dq).shape == (3, 4, 7)
    with pytest.raises(ShapeError, match="broadcast"):
        engine.bias_torque(np.zeros((3, 7)), np.zeros((4, 7)))


def assert_refused_everywhere(engine, method, bad):
    """In every argument, at every joint."""
    for argument, joint in np.ndindex(METHODS[method], engine.n):
        x = np.full((3, engine.n), 0.3)
        x[argument, joint] = bad
        words = f"{FUNCTIONS[method][0][argument]}: {bad} at index \\({joint},\\); allowed: finite"
        with pytest.raises(ShapeError, match=words):
            getattr(engine, method)(*x[: METHODS[method]])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_no_value_that_is_not_finite_passes(engine, method, bad):
    assert_refused_everywhere(engine, method, bad)


@pytest.mark.parametrize("seed", range(12))
def test_no_value_that_is_not_finite_passes_for_any_joints(seed):
    """Sliding joints hide more: B_11 of a sliding first joint is the mass of the arm at every q."""
    engine = lwr_dyn.dynamics_of(random_arm(seed))
    for method in METHODS:
        assert_refused_everywhere(engine, method, np.nan)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("shape", [(6,), (7, 1), (8,), ()])
def test_a_wrong_number_of_joints_is_refused(engine, method, shape):
    with pytest.raises(ShapeError, match=r"one per joint"):
        getattr(engine, method)(*[np.zeros(shape)] * METHODS[method])


@pytest.mark.parametrize("junk", ["abc", [[1, 2], [3]], None, object()])
def test_what_is_no_array_of_numbers_is_refused(engine, junk):
    with pytest.raises(ShapeError):
        engine.gravity_vector(junk)


def test_a_mass_matrix_is_singular_from_a_rounding_a_joint_on():
    """Of a batch the joint of the matrix that has no inverse; a diagonal of ones says nothing of sizes."""
    whole = np.diag([1.0, 1e6])
    for off, found in ((8e-16, None), (2e-16, 0)):
        B = np.array([whole, [[1.0, 1e3 * (1.0 - off)], [1e3 * (1.0 - off), 1e6]]])
        assert (singular_joint(B) is None) == (found is None)
    for bad, joint in (([[1.0, 0.0], [0.0, 0.0]], 1), ([[-1.0, 0.0], [0.0, 1.0]], 0), ([[1.0, np.inf], [0.0, 1.0]], 0)):
        assert singular_joint(np.array([whole, bad])) == joint


def test_energy_is_kinetic_and_potential(engine):
    q, dq = np.random.default_rng(0).uniform(-1, 1, (2, 4, 7))
    kinetic = [dq[k] @ engine.mass_matrix(q[k]) @ dq[k] / 2 for k in range(4)]
    np.testing.assert_allclose(mechanical_energy(engine, q, dq), kinetic + engine.potential_energy(q), rtol=1e-13)


def test_results_are_the_callers_own(engine):
    q = np.full(7, 0.2)
    B = engine.mass_matrix(q)
    kept = B.copy()
    engine.mass_matrix(-q)
    assert np.array_equal(B, kept)


def test_a_missing_argument_is_named(engine):
    with pytest.raises(TypeError, match="dq"):
        engine.coriolis_matrix(np.zeros(7))


def test_an_engine_has_the_words_of_the_protocol(engine):
    assert isinstance(engine, Dynamics)
    assert engine.mass_matrix.__doc__ == Dynamics.mass_matrix.__doc__


@pytest.mark.parametrize(
    ("robot", "given", "error", "words"),
    [
        ("lwr4plus", {"engine": "mujoco"}, UnknownNameError, "pinocchio, newton-euler, kernels"),
        ("lwr4plus", {"engine": "newton-euler", "rotors": "half"}, OptionError, "armature, full, none"),
        ("lwr4plus", {"rotors": "full"}, OptionError, "rotors: 'full' with engine pinocchio; allowed: armature"),
        ("lwr4", {}, MissingDataError, "masses and inertias not given"),
    ],
)
def test_names_and_options_that_do_not_exist(robot, given, error, words):
    with pytest.raises(error, match=words):
        lwr_dyn.dynamics_of(lwr_dyn.load(robot), **given)


class Constant:
    """An engine of two joints whose results are what is given; `batched` broadcasts less than a batch."""

    def __init__(self, **results):
        for name, (_, axes) in FUNCTIONS.items():
            value = results.get(name, np.ones((2,) * axes))
            setattr(self, name, lambda *state, value=value: value)


@pytest.mark.parametrize("batched", [None, Constant()])
def test_a_constant_result_gets_the_axes_of_its_batch(batched):
    gated = Gated("constant", 2, Constant(), batched)
    for name, (arguments, axes) in FUNCTIONS.items():
        states = [np.zeros((3, 2))] * len(arguments)
        assert getattr(gated, name)(*states).shape == (3, *(2,) * axes)
        assert getattr(gated, name).__doc__ == getattr(Dynamics, name).__doc__
    assert repr(gated) == "<engine constant, 2 joints>"


def test_functions_that_may_hide_a_value_check_their_arguments_first():
    hidden = np.array([np.nan, 0.0])
    assert Gated("constant", 2, Constant()).gravity_vector(hidden).tolist() == [1.0, 1.0]  # does not pass the value on
    with pytest.raises(ShapeError, match=r"q: nan at index \(0,\)"):
        Gated("constant", 2, Constant(), slow=("gravity_vector",)).gravity_vector(hidden)


@pytest.mark.parametrize("again", [lambda x: pickle.loads(pickle.dumps(x)), copy.deepcopy], ids=["pickle", "deepcopy"])
def test_a_copy_of_an_engine_gives_the_same_bits(engine, again):
    there, x = again(engine), np.random.default_rng(3).uniform(-2, 2, (3, 20, 7))
    assert there is not engine
    assert (there.name, there.n, repr(there)) == (engine.name, 7, f"<engine {engine.name}, 7 joints>")
    for method, count in METHODS.items():
        for states in (x[:count], x[:count, 0]):
            assert np.array_equal(getattr(engine, method)(*states), getattr(there, method)(*states)), method


def test_what_holds_an_engine_can_be_pickled(engine):
    law = lwr_dyn.controller("inverse-dynamics", LWR, engine=engine)
    q, dq = np.full(7, 0.1), np.full(7, 0.2)
    assert np.array_equal(pickle.loads(pickle.dumps(law))(0, q, dq, dq, q, q), law(0, q, dq, dq, q, q))
    run = lwr_dyn.simulate(LWR, law, lwr_dyn.reference("hold", LWR, q=q, duration=0.003), engine=engine)
    there = pickle.loads(pickle.dumps(run))
    assert np.array_equal(there.q, run.q)
    assert there.setup.arm.digest == LWR.digest


def test_an_engine_of_another_package_is_made_again_by_its_name(monkeypatch):
    row = Row(f"{__name__}:other_engine", "of another package")
    monkeypatch.setattr(lwr_dyn.dynamics.engines, "ENGINES", Registry("engine", {**ENGINES.rows, "other": row}))
    arm, q = lwr_dyn.load("wam7"), np.full(7, 0.3)
    made = lwr_dyn.dynamics_of(arm, "other")
    there = pickle.loads(pickle.dumps(made))
    assert there.name == "other"
    assert np.array_equal(there.mass_matrix(q), made.mass_matrix(q))
    with pytest.raises(pickle.PicklingError, match="engine other does not say how it is made"):
        pickle.dumps(other_engine(arm, "armature"))


def other_engine(arm, rotors):
    return Gated("other", arm.n, Recursion.of(arm.chain, rotors))
