"""Distances of capsules: against a dense search, against differences, and at poses where they are known."""

import dataclasses

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.urdf.geometry import link_radii
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.identification.excitation import motion_limits
from lwr_dyn.identification.excitation.objectives import fourier_basis
from lwr_dyn.kinematics.forward import joint_axes
from lwr_dyn.model.friction import friction_torque
from tests.codegen.rollouts.beside import first_joints


def _sampled_distance(a, b, c, d):
    s = np.linspace(0.0, 1.0, 201)
    x, y = ((1 - s[:, None]) * p + s[:, None] * r for p, r in ((a, b), (c, d)))
    return np.linalg.norm(x[:, None] - y[None], axis=2).min()


@pytest.mark.parametrize("kind", ["apart", "parallel", "crossing", "a point"])
def test_closest_parts_are_the_closest(kind):
    rng = np.random.default_rng(3)
    for _ in range(30):
        a, b, c, d = rng.normal(size=(4, 3))
        if kind == "parallel":
            d = c + 0.7 * (b - a)
        elif kind == "crossing":
            c, d = (a + b) / 2 + (d - c), (a + b) / 2 - (d - c)
        elif kind == "a point":
            d = c
        x, y = (float(share[0]) for share in motion_limits.closest_parts(a[None], b[None], c[None], d[None]))
        assert 0.0 <= min(x, y) <= max(x, y) <= 1.0
        found = np.linalg.norm(a + x * (b - a) - c - y * (d - c))
        dense = _sampled_distance(a, b, c, d)
        assert dense - 0.03 < found < dense + 1e-9


@pytest.mark.parametrize("name", ["lwr4plus", "wam7", "kr30ha"])
def test_gradients_are_those_of_the_distances(name):
    arm = lwr_dyn.load(name)
    space, h = motion_limits.clearance_of(arm), 1e-6
    q = motion_limits.random_positions(arm, 40, np.random.default_rng(1))
    values, gradient = space.with_gradient(q)
    assert np.array_equal(values, space.of(q))
    differences = [(space.of(q + h * e) - space.of(q - h * e)) / (2 * h) for e in np.eye(arm.n)]
    assert np.abs(np.stack(differences, axis=-1) - gradient).max() < 1e-7
    assert np.abs(gradient).max() > 0.1


def test_distances_are_those_of_the_capsules(lwr):
    space = motion_limits.clearance_of(lwr, kept=0.0)
    q = motion_limits.random_positions(lwr, 20, np.random.default_rng(2))
    points = np.concatenate([(axes := joint_axes(lwr.chain, q)).p, axes.flange[:, None, :3, 3]], axis=1)
    column = list(space.names).index("link_7 and link_3")
    radii = link_radii(lwr)
    for i, values in enumerate(space.of(q)):
        dense = _sampled_distance(points[i, 2], points[i, 3], points[i, 6], points[i, 7])
        assert dense - 0.01 < values[column] + radii[2] + radii[6] < dense + 1e-9


def test_floor_column_and_own_links_are_met_where_they_are(lwr):
    space = motion_limits.clearance_of(lwr)
    names = space.names
    down, under = np.radians([[0, 90, 0, -60, 0, 0, 0], [0, 105, 0, -115, 0, 0, 0]])
    met = [{name for name, x in zip(names, space.of(q[None])[0], strict=True) if x < 0.0} for q in (down, under)]
    low = {"joint_6 and the floor", "the flange and the floor"}
    assert met == [low, {*low, "link_5 and the column", "link_7 and the column"}]
    assert space.of(np.zeros((1, 7))).min() > 0.15
    assert space.floor == -0.3105
    assert motion_limits.clearance_of(lwr, floor=-2.0).of(down[None]).min() > 0.0
    assert not any("column" in name for name in motion_limits.clearance_of(lwr, column=0.0).names)


def test_more_is_kept_and_a_wider_column_is_nearer(lwr):
    q = motion_limits.random_positions(lwr, 50, np.random.default_rng(4))
    assert np.allclose(motion_limits.clearance_of(lwr, 0.02).of(q) - motion_limits.clearance_of(lwr, 0.05).of(q), 0.03)
    narrow, wide = motion_limits.clearance_of(lwr, column=0.1), motion_limits.clearance_of(lwr, column=0.15)
    difference = narrow.of(q) - wide.of(q)
    columns = [i for i, name in enumerate(narrow.names) if "column" in name]
    assert narrow.names == wide.names
    assert np.allclose(difference[:, columns], 0.05)


def test_an_arm_on_the_ceiling_keeps_clear_of_the_floor_below_it():
    arm = lwr_dyn.load("lwr4plus", mount={"on": "ceiling", "xyz": (0.0, 0.0, 2.5)})
    space = motion_limits.clearance_of(arm)
    assert space.floor == 0.0
    distances = dict(zip(space.names, space.of(np.zeros((1, 7)))[0], strict=True))
    radius = link_radii(arm.uninstalled())[-1]
    assert distances["the flange and the floor"] == pytest.approx(2.5 - 0.868 - radius - 0.05)
    assert distances["the flange and the ceiling"] == pytest.approx(0.868 + 0.3105 - radius - 0.05)


def test_torques_are_those_of_the_arm_and_their_room_has_the_gradient_of_its_differences():
    """Of an arm with two joints and friction, whose first torque has no limit."""
    arm, basis = first_joints(2), fourier_basis(8.0, 5, 60)
    X = 0.3 * np.random.default_rng(5).normal(size=(basis.count, 2))
    use = motion_limits.TorqueUse.of(arm, np.array([np.inf, 40.0]))
    states = [part @ X for part in (basis.position, basis.speed, basis.acceleration)]
    tau = lwr_dyn.dynamics_of(arm).inverse_dynamics(*states) + friction_torque(arm.friction_models(), states[1])
    assert np.abs(use.torque(*states) - tau).max() < 1e-9
    assert use.share(*states) == pytest.approx(np.abs(tau).max(axis=0) / [np.inf, 40.0])
    gradient, h = use.room_gradient(basis, X), 1e-6
    assert gradient.shape == (2 * 60 * 1, X.size)
    for i in range(X.size):
        e = h * np.eye(X.size)[i].reshape(X.shape)
        difference = (use.room(basis, X + e) - use.room(basis, X - e)).ravel() / (2 * h)
        assert np.abs(difference - gradient[:, i]).max() < 2e-5 * np.abs(gradient).max()


def test_a_fitted_motion_is_inside_and_fills_what_it_may(wam):
    basis, limits = fourier_basis(6.0, 5, 200), motion_limits.MotionLimits.of(wam, 0.2, 0.5)
    X = 5.0 * np.random.default_rng(1).normal(size=(basis.count, 7))
    for fill, size in ((False, 1e-3), (False, 1.0), (True, 1e-3)):
        Y = limits.fitted(size * X, basis, fill)
        q, share = basis.position @ Y, np.abs(basis.speed @ Y).max(axis=0) / limits.speed
        assert ((q >= limits.lower - 1e-12) & (q <= limits.upper + 1e-12)).all()
        assert share.max() <= 1.0 + 1e-12
        filled = np.maximum(share, np.ptp(q, axis=0) / (limits.upper - limits.lower))
        assert (np.abs(filled - 1.0) < 1e-9).all() == (fill or size == 1.0)


BAD = {
    "clearance_of": [{"kept": -0.1}, {"kept": np.nan}, {"floor": np.inf}, {"column": -1.0}],
    "MotionLimits": [{"margin": -1.0}, {"margin": 3.0}, {"speed_share": 0.0}, {"speed_share": 1.1},
                     {"torque_share": np.nan}],
}  # fmt: skip


@pytest.mark.parametrize(("of", "bad"), [(of, bad) for of, every in BAD.items() for bad in every])
def test_distances_and_limits_that_cannot_be_are_refused(wam, of, bad):
    make = motion_limits.clearance_of if of == "clearance_of" else motion_limits.MotionLimits.of
    with pytest.raises(OptionError):
        make(wam, **bad)


def test_an_unknown_speed_limit_is_asked_for_and_an_unknown_travel_is_a_turn(wam):
    first = dataclasses.replace(wam.limits[0], velocity=None, lower=None, upper=None)
    bare = dataclasses.replace(wam, limits=(first, *wam.limits[1:]))
    with pytest.raises(OptionError, match=r"speed limit of .*unknown.*--joint-speed"):
        motion_limits.MotionLimits.of(bare)
    limits = motion_limits.MotionLimits.of(bare, 0.1, 0.5, unknown_speed=2.0)
    assert limits.speed[0] == 1.0
    assert (limits.lower[0], limits.upper[0]) == pytest.approx((-np.pi + 0.1, np.pi - 0.1))


def test_links_that_are_never_far_apart_keep_less_unless_a_distance_is_asked_for(iiwa):
    """0.3 of the largest distance that they have in drawn poses; all others keep 5 cm."""
    space, asked = motion_limits.clearance_of(iiwa), motion_limits.clearance_of(iiwa, 0.05)
    q, planes = motion_limits.random_positions(iiwa, 500, np.random.default_rng(0)), len(space.low)
    widest = (asked.of(q) + 0.05).max(axis=0)
    assert 0.045 < widest[space.names.index("link_5 and link_3")] < 0.054
    assert np.allclose(space.keeps[planes:], np.minimum(0.05, 0.3 * widest[planes:]), rtol=1e-12)
    assert set(space.keeps[:planes]) == set(asked.keeps) == {0.05}
    assert np.allclose(space.of(q) + space.keeps, asked.of(q) + 0.05, rtol=0, atol=1e-15)
