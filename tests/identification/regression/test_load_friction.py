"""Friction that grows with the torque carried: found with bodies in turn, inside its errors; what cannot be found."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.foundation.errors import LogError
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.load_friction import load_indices, with_load_friction, with_moving_loads
from lwr_dyn.identification.regression.stribeck import stribeck_search
from lwr_dyn.identification.regression.torque_columns import JointColumns
from lwr_dyn.model.friction import Direction, JointFriction, friction_torque
from lwr_dyn.model.transmission import Transmission
from tests.identification.gain_study import load_misses, load_plant, load_samples
from tests.identification.plants import inside, rms


@pytest.fixture(scope="module")
def plant():
    return load_plant("ur10", 0)


@pytest.fixture(scope="module")
def samples():
    return load_samples("ur10", 0, 8.0)[1]


@pytest.fixture(scope="module")
def plain(plant):
    """The columns without the term."""
    return replace(plant.columns, carried=None)


def unused(samples, joint, rows=slice(None)):
    """Samples without the equations of a joint, from 0, at some instants."""
    used = samples.used.copy()
    used[rows, joint] = False
    return replace(samples, used=used)


def test_a_column_is_the_size_of_the_rigid_torque_along_the_motion(plant, samples):
    part, columns = samples.select(slice(0, 50)), plant.columns
    bodies_and_rotors = np.zeros(columns.count)
    bodies_and_rotors[columns.table_indices] = plant.parameters[columns.table_indices]
    Y = columns(part.q, part.dq, part.ddq)
    rigid, loads = Y @ bodies_and_rotors, load_indices(columns)
    for j, k in enumerate(loads):
        assert Y[:, j, k] == pytest.approx(np.abs(rigid[:, j]) * np.sign(part.dq[:, j]), abs=1e-10)
        assert columns.of_joint(j).start < k < columns.of_joint(j).stop
        assert not Y[:, np.arange(6) != j, k].any()
    assert np.isin(loads, columns.friction_indices).all()
    assert load_indices(replace(columns, carried=None)).size == 0
    assert columns.torques(part.q, part.dq, part.ddq, plant.parameters) == pytest.approx(Y @ plant.parameters, abs=1e-9)


@pytest.mark.parametrize("form", ["directions", "symmetric"])
def test_base_parameters_are_the_plain_ones_and_a_share_a_joint(plant, form):
    columns = replace(plant.columns, friction=form, stribeck_velocity=np.full(6, 0.1))
    bare, whole = replace(columns, carried=None).base(), columns.base()
    names = [f"load_{j}" for j in range(1, 7)]
    assert set(whole.statements()) == {*bare.statements(), *names}
    assert [whole.names[k] for k in load_indices(columns)] == names
    values = np.random.default_rng(0).normal(size=columns.count)
    others = values[~np.isin(columns.names, names)]
    shown = ~np.isin(whole.statements(), names)
    assert whole.of(values)[shown] == pytest.approx(bare.of(others))
    assert whole.of(values)[~shown] == pytest.approx(values[load_indices(columns)])


def test_without_noise_the_truth_is_where_columns_and_parameters_settle(plant, plain, samples):
    exact = replace(samples, tau=plant.columns.torques(samples.q, samples.dq, samples.ddq, plant.parameters))
    found = information_of(exact, with_load_friction(exact, plain))
    assert found.values == pytest.approx(plant.base, abs=2e-3)
    once = information_of(exact, plain)
    others = np.delete(plant.parameters, load_indices(plant.columns))
    assert np.abs(once.values - plain.base().of(others)).max() > 0.1


@pytest.mark.parametrize("arm", [pytest.param("panda", marks=pytest.mark.slow), "ur10"])
def test_parameters_lie_within_three_sigma(arm):
    z = load_misses(arm, range(2), 8.0)
    assert inside(z) > 0.97
    assert 0.75 < rms(z) < 1.25


@pytest.mark.slow
@pytest.mark.parametrize("arm", ["panda", "ur10"])
def test_parameters_of_twenty_logs_lie_within_three_sigma(arm):
    z = load_misses(arm, range(20))
    assert inside(z) > 0.99
    assert 0.9 < rms(z) < 1.1


@pytest.mark.parametrize("form", ["directions", "symmetric"])
def test_the_share_stands_between_levels_and_stribeck_drops(form):
    joint, side = JointColumns(form, (0.1,), load=True), Direction(0.5, 0.2, 0.8, 0.1)
    model, dq, load = JointFriction(side, side, 0.0), np.linspace(-1.0, 1.0, 41), np.linspace(5.0, -5.0, 41)
    values = np.array(joint.values_of(model, 0.0))
    at = joint.names.index("load")
    assert values[at] == 0.0
    values[at] = 0.07
    grows = replace(model, load=0.07)
    assert joint.friction_of(values) == grows
    assert joint.values_of(grows, 0.0) == values.tolist()
    wanted = friction_torque((grows,), dq[:, None], load[:, None])[:, 0]
    assert wanted == pytest.approx(model.torque(dq) + 0.07 * np.abs(load) * np.sign(dq), abs=1e-12)
    assert joint(dq, np.zeros(41), load) @ values == pytest.approx(wanted, abs=1e-12)
    for noisy, written in ((-0.01, 0.0), (1.2, 0.99)):
        values[at] = noisy
        assert joint.friction_of(values).load == written


def test_stribeck_speeds_are_found_beside_it(plant, plain, samples):
    speeds = np.full(6, 0.2)
    columns = replace(plant.columns, stribeck_velocity=speeds)
    parameters = np.zeros(columns.count)
    drops = np.array([name.startswith("stribeck") for name in columns.names])
    parameters[~drops], parameters[drops] = plant.parameters, 4.0
    noise = np.random.default_rng(3).normal(0.0, 0.02, samples.tau.shape)
    tau = columns.torques(samples.q, samples.dq, samples.ddq, parameters) + noise
    log = replace(samples, tau=tau)
    search = stribeck_search(log, with_load_friction(log, plain))
    assert search.speeds == pytest.approx(speeds, rel=0.1)
    found = with_load_friction(log, search.columns)
    information = with_moving_loads(log, information_of(log, found))
    values, sigma = shares(information)
    assert (np.abs(values - parameters[load_indices(columns)]) < 4.0 * sigma).all()


def shares(information):
    """Of the load, as base parameters: values and errors."""
    at = np.searchsorted(information.base.kept, load_indices(information.columns))
    return information.values[at], information.sigma[at]


def test_a_motor_behind_a_gear_has_the_share_of_its_joint(plain, samples):
    geared = replace(plain, transmission=Transmission(np.diag([-100.0, 50.0, 80.0, -60.0, 30.0, 40.0])))
    joints, motors = (shares(information_of(samples, with_load_friction(samples, x)))[0] for x in (plain, geared))
    assert joints == pytest.approx(motors, abs=1e-4)


def test_a_joint_that_turns_one_way_alone_is_named(plain, samples):
    with pytest.raises(LogError, match="q3: joint 3 turns one way alone"):
        with_load_friction(unused(samples, 2, samples.dq[:, 2] < 0.0), plain)


def test_a_joint_without_equations_has_a_share_that_no_motion_shows(plain, samples):
    five = unused(samples, 5)
    found = with_moving_loads(five, information_of(five, with_load_friction(five, plain)))
    assert np.isinf(shares(found)[1]).tolist() == [False] * 5 + [True]


def test_friction_that_is_no_small_share_is_refused(plant, plain, samples):
    columns, parameters = plant.columns, plant.parameters.copy()
    parameters[load_indices(columns)] = 3.0
    tau = columns.torques(samples.q, samples.dq, samples.ddq, parameters)
    with pytest.raises(LogError, match="friction with the load: moves by"):
        with_load_friction(replace(samples, tau=tau), plain)
