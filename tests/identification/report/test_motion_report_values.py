"""From a fit to what the page shows: predictions, friction dots, full parameters, ellipsoids of links."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.dynamics.regressor import body_parameters
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import Samples, exact_samples
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.identification.report import motion_report
from lwr_dyn.identification.report.charts import central_moments, link_ellipsoid
from lwr_dyn.model.chain import Body
from lwr_dyn.model.spatial import from_rpy
from lwr_dyn.model.transmission import Transmission
from tests.identification.plants import perturbed_plant, random_motion, simulated_samples

NOISE = 0.05


def spread(values):
    """Standard deviation about 0 of what is known."""
    return np.sqrt(np.nanmean(np.square(values)))


@pytest.fixture(scope="module")
def columns(lwr):
    return TorqueColumns(lwr.chain, "directions")


@pytest.fixture(scope="module")
def plant(columns, lwr):
    return perturbed_plant(columns, lwr, np.random.default_rng(3))


@pytest.fixture(scope="module")
def samples(plant, lwr):
    rng = np.random.default_rng(4)
    return simulated_samples(plant, random_motion(lwr, 20.0, rng), NOISE, rng, slowest=0.05)


def joined(parts, sources):
    """Samples as one, each a recording of its own."""
    whole = [np.concatenate([getattr(p, name) for p in parts]) for name in ("t", "q", "dq", "ddq", "tau", "used")]
    return Samples(*whole, np.repeat(np.arange(len(parts)), [len(p) for p in parts]), tuple(sources))


def test_the_truth_predicts_its_torques_and_leaves_its_friction(plant, columns, samples):
    drawn = motion_report.drawn_fit(samples, columns, plant.parameters)
    (one,) = drawn.recordings
    left = np.where(one.used, one.measured - one.predicted, np.nan)
    assert spread(left) == pytest.approx(NOISE, rel=0.05)
    assert one.t[0] == 0.0
    assert spread(drawn.torque - of_models(columns, plant.parameters, drawn)) == pytest.approx(NOISE, rel=0.05)
    np.testing.assert_array_equal(np.isnan(drawn.torque), ~samples.used)


def test_full_parameters_have_the_fitted_base_values_and_stay_near_the_table(columns, samples, lwr):
    information = information_of(samples, columns)
    full = motion_report.full_parameters(information, lwr)
    np.testing.assert_allclose(information.base.of(full), information.values, rtol=1e-9, atol=1e-9)
    own = columns.own(lwr)
    alone = information.base.grouping.any(axis=0)
    np.testing.assert_array_equal(full[~alone], own[~alone])  # what no motion shows stays the table's
    own_information = replace(information, values=information.base.of(own))
    np.testing.assert_allclose(motion_report.full_parameters(own_information, lwr), own, rtol=1e-9, atol=1e-12)
    assert motion_report.link_parameters(columns, full).shape == (7, 10)


def test_recordings_of_a_file_are_numbered_and_the_many_and_long_ones_are_counted(columns, plant, samples, monkeypatch):
    few = samples.select(slice(0, 30))
    drawn = motion_report.drawn_fit(joined([few] * 3, ("a.csv", "b.csv", "a.csv")), columns, plant.parameters)
    assert [one.source for one in drawn.recordings] == ["a.csv (1)", "b.csv", "a.csv (2)"]
    many = motion_report.drawn_fit(joined([few] * 10, ["a.csv"] * 10), columns, plant.parameters)
    assert len(many.recordings) == motion_report.MOST_RECORDINGS
    assert (many.left_out, many.every) == (10 - motion_report.MOST_RECORDINGS, 1)
    monkeypatch.setattr(motion_report, "MOST_ROWS", 14)
    long = motion_report.drawn_fit(joined([few, samples.select(slice(0, 28))], "ab"), columns, plant.parameters)
    assert long.every == 3
    for one, step in zip(long.recordings, (3, 2), strict=True):
        np.testing.assert_array_equal(one.q, samples.q[: len(one.q) * step : step])
    assert [len(one.q) for one in long.recordings] == [10, 14]


def test_torques_that_were_cut_out_are_not_drawn(columns, plant, samples):
    tau, used = samples.tau.copy(), samples.used.copy()
    tau[100:150, 2], used[100:150, 2] = 0.0, False
    drawn = motion_report.drawn_fit(replace(samples, tau=tau, used=used), columns, plant.parameters)
    assert np.isnan(drawn.recordings[0].measured[100:150, 2]).all()
    assert np.isfinite(drawn.recordings[0].measured[:, 3]).all()


def of_models(columns, parameters, drawn):
    """Friction by the models of parameters, at the speeds drawn."""
    return np.column_stack([m.torque(drawn.speed[:, j]) for j, m in enumerate(columns.friction_of(parameters))])


def test_friction_behind_a_coupling_is_that_of_the_motors(lwr):
    matrix = np.diag([2.0, 3.0, 1.5, 1.0, 1.0, 1.0, 1.0])
    matrix[1, 2] = 0.5
    columns = TorqueColumns(lwr.chain, transmission=Transmission(matrix))
    parameters = columns.own(lwr)
    for j in range(7):
        parameters[columns.of_joint(j)] = (0.01, 2.0 + j, 1.0, 0.1)
    m = random_motion(lwr, 5.0, np.random.default_rng(5))
    samples = exact_samples(m.t, m.q, m.dq, m.ddq, columns(m.q, m.dq, m.ddq) @ parameters)
    drawn = motion_report.drawn_fit(replace(samples, used=np.ones_like(samples.used)), columns, parameters)
    np.testing.assert_allclose(drawn.speed, m.dq @ matrix.T)
    np.testing.assert_allclose(drawn.torque, of_models(columns, parameters, drawn), atol=1e-9)


SIZES = st.tuples(*[st.floats(0.01, 0.5)] * 3)
PLACES = st.tuples(*[st.floats(-0.5, 0.5)] * 3)


@given(st.floats(0.1, 20.0), SIZES, PLACES, PLACES)
def test_the_ellipsoid_of_a_solid_one_comes_back_with_its_moments(mass, sizes, rpy, com):
    """I_1 = m (b^2 + c^2) / 5 about its own axes."""
    squares, R = np.square(sizes), from_rpy(rpy)
    tensor = R @ np.diag(mass / 5.0 * (squares.sum() - squares)) @ R.T
    parameters = body_parameters(Body(mass, np.array(com), tensor))
    found = link_ellipsoid(parameters)
    np.testing.assert_allclose(found.semi_axes, np.sort(sizes)[::-1], rtol=1e-6, atol=1e-9)
    assert np.linalg.det(found.axes) == pytest.approx(1.0)
    matrix = found.image.matrix()
    np.testing.assert_allclose(matrix[:3, 3], com, atol=1e-12)
    np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, R @ np.diag(squares) @ R.T, atol=1e-9)
    own, centre, moments = central_moments(parameters)
    assert own == mass
    np.testing.assert_allclose(centre, com, atol=1e-12)
    np.testing.assert_allclose(np.trace(moments) * np.eye(3) - moments, tensor, atol=1e-12)


PLATE = np.array([2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 2.0])


@pytest.mark.parametrize(
    ("place", "value"), [(0, -1.0), (0, 0.0), (4, 5.0), (9, np.nan)], ids=["mass below 0", "no mass", "triangle", "nan"]
)
def test_a_plate_is_a_body_and_what_no_body_can_be_has_no_ellipsoid(place, value):
    assert link_ellipsoid(PLATE).semi_axes[2] == 0.0
    assert link_ellipsoid(np.where(np.arange(10) == place, value, PLATE)) is None
