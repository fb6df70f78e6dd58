"""Objectives of a motion: their values by another way, their gradients by differences."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import MissingPackageError, OptionError
from lwr_dyn.identification.excitation import objectives
from lwr_dyn.identification.excitation.design import rows_of
from lwr_dyn.identification.regression import torque_columns
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import exact_samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.transmission import Transmission
from tests.public_arms import public_arm


@pytest.fixture(scope="module")
def columns(wam):
    return TorqueColumns(wam.chain)


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"friction": "directions"}, "friction 'directions'; allowed: symmetric"),
        ({"stribeck_velocity": np.array([0.1, *[np.nan] * 6])}, "Stribeck columns"),
        ({"transmission": Transmission(2.0 * np.eye(7))}, "a transmission"),
    ],
)
def test_columns_of_another_kind_are_refused(wam, motion, other, words):
    with pytest.raises(OptionError, match=words):
        objectives.MotionObjective(TorqueColumns(wam.chain, **other), motion[0], np.ones(7))


NOISE = np.array([0.4, 0.5, 0.3, 0.3, 0.1, 0.1, 0.05])


def test_the_sigma_of_the_score_is_that_of_a_fit_and_its_half_axes_are_shorter(columns, motion, wam):
    m = rows_of(motion[0].motion(motion[1]))
    score = objectives.motion_score(columns, m, NOISE)
    tau = columns(m.q, m.dq, m.ddq) @ columns.own(wam)
    fit = information_of(exact_samples(m.t, m.q, m.dq, m.ddq, tau), columns, noise=NOISE)
    assert np.abs(score.sigma / fit.sigma - 1.0).max() < 1e-6
    assert score.condition == pytest.approx(fit.condition, rel=1e-6)
    assert score.names == tuple(columns.names[k] for k in columns.base().kept)
    assert score.mean_sigma == pytest.approx(np.prod(score.sigma ** (1.0 / len(score.sigma))))
    assert score.d == pytest.approx(-np.linalg.slogdet(fit.precision / len(m.t))[1] / len(score.sigma))
    assert np.exp(score.d / 2.0) / np.sqrt(len(m.t)) < 0.95 * score.mean_sigma


def test_parameters_that_only_a_sum_shows_are_named(columns, motion):
    """Axes of the file are at right angles to 4e-6 only; else Izz_2 and the rotor would be one parameter."""
    rows, noise = rows_of(motion[0].motion(motion[1])), np.full(7, 0.1)
    rounded = objectives.motion_score(TorqueColumns(public_arm("xarm7").chain), rows, noise)
    clean = objectives.motion_score(columns, rows, noise)
    assert (rounded.together, clean.together) == (("Izz_2", "armature_2"), ())
    assert (clean.alone <= clean.sigma * (1 + 1e-12)).all()


@pytest.mark.parametrize("name", objectives.OBJECTIVES)
def test_gradients_are_those_of_the_objectives(columns, motion, name):
    basis, X = motion
    objective = objectives.MotionObjective(columns, basis, NOISE, name)
    x, h = X.ravel(), 1e-5
    _, gradient = objective(x)
    for i in np.random.default_rng(0).permutation(x.size)[:20]:
        e = h * np.eye(x.size)[i]
        difference = (objective(x + e)[0] - objective(x - e)[0]) / (2 * h)
        assert abs(difference - gradient[i]) < 1e-6 * np.abs(gradient).max()


@pytest.mark.parametrize("name", ["wam7", "lwr4plus"])
def test_values_are_those_of_the_columns_themselves(name, motion):
    basis, X = motion
    columns = TorqueColumns(lwr_dyn.load(name).chain)  # the LWR's base tells the orders of a tensor's entries apart
    states = [part @ X for part in (basis.position, basis.speed, basis.acceleration)]
    W = columns(*states)
    for j in range(columns.n):
        W[:, j, columns.of_joint(j)][:, 1] = np.tanh(states[1][:, j] / 0.05)
    rows = (W / NOISE[:, None])[:, :, columns.base().kept].reshape(-1, columns.base().count)
    _, logarithm = np.linalg.slogdet(rows.T @ rows / len(states[0]))
    condition = np.linalg.cond(rows / np.linalg.norm(rows, axis=0))
    found = [objectives.MotionObjective(columns, basis, NOISE, name)(X.ravel())[0] for name in objectives.OBJECTIVES]
    assert found == pytest.approx([-logarithm / columns.base().count, np.log(condition)], rel=1e-9)


def test_a_motion_that_shows_nothing_has_a_large_value_and_no_slope(columns, motion):
    basis, X = motion
    for name in objectives.OBJECTIVES:
        value, gradient = objectives.MotionObjective(columns, basis, NOISE, name)(np.zeros(X.size))
        assert (value, gradient.any()) == (objectives.LARGE, False)
    score = objectives.motion_score(columns, rows_of(basis.motion(0.0 * X)), NOISE)
    assert (score.d, np.isnan(score.sigma).all()) == (objectives.LARGE, True)


def test_without_compiled_columns_the_error_names_the_extra(motion, monkeypatch, wam):
    monkeypatch.setattr(torque_columns, "_kernel_of", lambda _: None)
    with pytest.raises(MissingPackageError) as missing:
        objectives.MotionObjective(TorqueColumns(wam.chain), motion[0], NOISE)
    assert missing.value.extra == "batch"


T, H, N = 7.0, 4, 3


@pytest.fixture
def series():
    basis = objectives.fourier_basis(T, H, 30)
    return basis, np.random.default_rng(0).normal(size=(basis.count, N))


def test_it_is_at_rest_at_both_ends_and_outside(series):
    basis, X = series
    motion = basis.motion(X)
    ends = motion.sample([-1.0, 0.0, T, T + 1.0])
    assert np.abs(ends.dq).max() < 1e-13
    assert np.abs(ends.ddq).max() < 1e-12
    assert np.ptp(ends.q, axis=0).max() < 1e-13
    assert np.abs(motion.sample([0.3]).dq).min() > 1e-3


def test_every_motion_at_rest_at_its_ends_is_one_of_the_basis():
    basis = objectives.fourier_basis(T, H, 30)
    assert basis.count == 2 * H - 1
    assert np.allclose(basis.free[1:].T @ basis.free[1:], np.diag([0.0, *[1.0] * (2 * H - 2)]), atol=1e-14)


def test_speeds_and_accelerations_are_derivatives(series):
    basis, X = series
    t, h = np.linspace(0.5, 6.5, 50), 1e-5
    low, middle, high = (basis.motion(X).sample(t + d) for d in (-h, 0.0, h))
    assert np.abs((high.q - low.q) / (2 * h) - middle.dq).max() < 1e-8
    assert np.abs((high.dq - low.dq) / (2 * h) - middle.ddq).max() < 1e-8


def test_the_basis_is_the_motion_at_its_instants(series):
    basis, X = series
    found = basis.motion(X).sample(np.arange(30) * T / 30)
    for matrix, values in ((basis.position, found.q), (basis.speed, found.dq), (basis.acceleration, found.ddq)):
        assert np.abs(matrix @ X - values).max() < 1e-12


@pytest.mark.parametrize(
    "numbers", [(0.0, 5), (np.nan, 5), (-1.0, 5), (10.0, 1), (10.0, objectives.MOST_HARMONICS + 1)]
)
def test_numbers_that_make_no_series_are_refused(numbers):
    with pytest.raises(OptionError):
        objectives.fourier_basis(*numbers, 10)
