"""The global search: never beaten by brute force, and it reports its steps."""

from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.inertia.worst_case import (
    FOLLOWED,
    SEED,
    JointInertia,
    _refine,
    _starts,
    diagonal,
    diagonal_along,
    first_joint,
    with_joint_values,
    worst_case_inertia,
    worst_case_inertias,
)
from lwr_dyn.dynamics.newton_euler import Recursion, newton_euler_dynamics
from lwr_dyn.model.arm import JointLimits
from tests.random_arms import random_arm


@pytest.fixture(scope="module")
def found(arm):
    return worst_case_inertias(arm)


def test_diagonal_is_that_of_the_mass_matrix(arm):
    q = np.random.default_rng(0).uniform(-1, 1, (20, 7))
    for rotors in ("armature", "full", "none"):
        B = newton_euler_dynamics(arm.chain, rotors).mass_matrix(q)
        recursion = Recursion.of(arm.chain, rotors)
        for i in range(7):
            assert np.abs(diagonal(recursion, i, q) - B[:, i, i]).max() < 1e-13
            along = [diagonal_along(recursion, i, q, j, q[:3, j]) for j in range(i + 1, 7)]
            one_by_one = [diagonal(recursion, i, with_joint_values(q, j, q[:3, j])) for j in range(i + 1, 7)]
            np.testing.assert_allclose(along, one_by_one, rtol=1e-12)


def test_brute_force_never_beats_the_search_and_the_maximiser_gives_the_value_inside_the_limits(arm, found):
    q, B = np.random.default_rng(1).uniform(arm.lower, arm.upper, (100_000, 7)), lwr_dyn.dynamics_of(arm).mass_matrix
    for i, w in enumerate(found):
        values = diagonal(Recursion.of(arm.chain), i, q)
        assert w.joint == i
        assert 0.97 * w.value < values.max() <= w.value * (1 + 1e-12)  # it comes near: no artefact
        assert B(w.q)[i, i] == pytest.approx(w.value, rel=2e-5)  # free joints at their middle
        assert ((w.q >= arm.lower) & (w.q <= arm.upper)).all()
        assert w.free[: i + 1] == (True,) * (i + 1)
    places = np.random.default_rng(3).uniform(-4.0, 4.0, (20, 7))  # outside the box too
    for w, many, distinct in zip(found, (256, 256, 209, 155, 137, 131, 129), (2, 1, 2, 1, 1, 1, 1), strict=True):
        climbed = worst_case_inertia(arm, w.joint, starts=places)  # not a lattice, on which the best ones nearly lie
        assert climbed.value == pytest.approx(w.value, rel=1e-12)
        assert (climbed.starts, climbed.share, w.share, w.starts) == (20, 1.0, 1.0, many)
        assert w.distinct == len(w.maximisers) == distinct
    for share, runner_up, rest in (
        (1.0, None, "no other local maximum was met"),
        (0.4, None, f"the best {FOLLOWED} of the rest, followed on, did too"),
        (0.4, 2.5, "of the rest, followed on, one in another maximum, 2.5"),
    ):  # fmt: skip
        words = replace(found[0], starts=256, share=share, runner_up=runner_up).statement()
        assert words == (
            f"256 climbs with exact line maxima over the joint box (90 deg lattice and random, seed {SEED}); "
            f"{share:.0%} ended here, {rest}"
        )


def test_climbs_start_from_the_best_corners_of_a_lattice_and_from_random_places(arm):
    """Two turns either way are 9^6 corners of quarter turns: too many, so each joint keeps its half turns."""
    free = replace(arm, limits=tuple(replace(x, lower=-2 * np.pi, upper=2 * np.pi) for x in arm.limits))
    for one, turns in ((arm, np.array([-1, 0, 1]) / 4), (free, np.array([-2, -1, 0, 1, 2]) / 2)):
        inertia = first_joint(one, {})
        starts, lattice = _starts(inertia), np.array(list(product([0.0], *[2 * np.pi * turns] * 6)))
        best, every = inertia.at(starts[:128]), np.sort(inertia.at(lattice))[::-1]
        np.testing.assert_allclose(best, every[:128], rtol=1e-12)
        assert len(np.unique(starts[:128].round(9), axis=0)) == 128 == len(starts) - 128
        drawn = (starts[128:, 1:] - one.lower[1:]) / (one.upper - one.lower)[1:]
        assert ((drawn >= 0.0) & (drawn <= 1.0)).all()
        np.testing.assert_allclose([drawn.min(axis=0), drawn.max(axis=0)], [[0.0] * 6, [1.0] * 6], atol=0.06)


def test_joints_that_change_nothing_stand_at_the_middle_of_their_limits(arm):
    lower, upper = arm.lower + 0.4, arm.upper - 0.1
    narrowed = [replace(x, lower=float(a), upper=float(b)) for x, a, b in zip(arm.limits, lower, upper, strict=True)]
    maximum = worst_case_inertia(replace(arm, limits=tuple(narrowed)), 3, {5: 0.3})
    free = np.array(maximum.free)
    assert free[:4].all()
    assert maximum.q[5] == 0.3
    free[5] = False
    assert maximum.q[free] == pytest.approx(((lower + upper) / 2)[free], abs=1e-15)
    assert maximum.value == pytest.approx(diagonal(Recursion.of(arm.chain), 3, maximum.q[None])[0], rel=2e-5)


@pytest.mark.slow
def test_another_maximum_is_called_one_only_after_it_was_followed_to_its_end():
    arm, rng = lwr_dyn.load("wam7"), np.random.default_rng(3)
    found, recursion, step = worst_case_inertia(arm, 2), Recursion.of(arm.chain), 1e-5
    kinds = tuple(link.kind for link in arm.chain.links)
    inertia = JointInertia(recursion, kinds, 2, arm.lower, arm.upper)
    assert "another maximum" in found.statement()
    assert found.runner_up < found.value
    for start in rng.uniform(arm.lower, arm.upper, (10, 7)):
        q, value = inertia.local_maximum(start)
        assert diagonal(recursion, 2, start) <= value <= found.value * (1 + 1e-12)
        up, down = (diagonal(recursion, 2, q + sign * step * np.eye(7)) for sign in (1, -1))
        slope = (up - down) / (2 * step)
        inside = (q > arm.lower + step) & (q < arm.upper - step)
        assert np.abs(slope[inside]).max(initial=0.0) < 1e-6


@pytest.mark.parametrize(
    ("ends", "values", "places"), [(2.5, [2.5, 3.0, 2.5], [5.0, 1.0, 7.0]), (3.0, [3.0] * 3, [1.0] * 3)]
)
def test_climbs_that_ended_lower_are_followed_to_their_end_and_may_meet_the_best(ends, values, places):
    q, value = np.array([[0.0], [1.0], [2.0]]), np.array([1.0, 3.0, 2.0])
    followed = SimpleNamespace(local_maximum=lambda at: (at + 5.0, ends))
    assert _refine(followed, q, value) == [3.0, ends, ends]
    assert (value.tolist(), q.ravel().tolist()) == (values, places)


def test_along_one_joint_the_largest_value_is_found_to_its_last_digits(arm):
    """The value is a trigonometric polynomial: its slope, by a Fourier transform of 16 samples, is 0 there."""
    kinds, rng = tuple(link.kind for link in arm.chain.links), np.random.default_rng(5)
    inertia = JointInertia(Recursion.of(arm.chain), kinds, 0, np.full(7, -4.0), np.full(7, 4.0))
    q, turns = rng.uniform(arm.lower, arm.upper, (20, 7)), np.arange(16) * np.pi / 8
    for j in (1, 3, 5):
        waves = np.fft.rfft(inertia.at(with_joint_values(q, j, turns)), axis=1) / 8
        best, orders = inertia.line_maximum(q, j), np.arange(9)
        phase = np.exp(1j * np.outer(best, orders))
        slope = (1j * orders * waves * phase).real.sum(axis=1)
        inside = np.abs(best) < 4.0
        assert inside.sum() > 10
        assert np.abs(slope[inside]).max() < 1e-12 * np.abs(waves).max()


def sliding(seed):
    """A random arm whose third and fifth joint slide, in a box."""
    loose = random_arm(seed, "RRPRP")
    return replace(loose, limits=(JointLimits(lower=-0.6, upper=0.9),) * loose.n)


def test_along_a_sliding_joint_an_end_or_the_vertex_of_the_parabola_is_best():
    arm, grid = sliding(0), np.linspace(-0.6, 0.9, 3001)
    recursion, kinds = Recursion.of(arm.chain), tuple(link.kind for link in arm.chain.links)
    q, ends = np.random.default_rng(4).uniform(-0.6, 0.9, (20, 5)), set()
    for sign, joint in product((1.0, -1.0), (2, 4)):
        inertia = JointInertia(recursion, kinds, 0, arm.lower, arm.upper, sign)
        best, values = inertia.line_maximum(q, joint), inertia.at(with_joint_values(q, joint, grid))
        found = np.array([inertia.at(with_joint_values(q[[k]], joint, best[[k]]))[0, 0] for k in range(20)])
        np.testing.assert_allclose(found, values.max(axis=1), rtol=1e-6, atol=1e-9)
        assert (found >= values.max(axis=1) - 1e-12).all()
        ends |= set(np.isclose(np.abs(best - 0.15), 0.75).tolist())
    assert ends == {True, False}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_sliding_joints_are_searched_to_their_ends_and_to_their_vertex(seed):
    arm, q = sliding(seed), np.random.default_rng(seed).uniform(-0.6, 0.9, (50_000, 5))
    values = diagonal(Recursion.of(arm.chain), 0, q)
    most, least = (worst_case_inertia(arm, 0, smallest=s).value for s in (False, True))
    assert least * (1 - 1e-12) <= values.min() < 1.2 * least
    assert 0.8 * most < values.max() <= most * (1 + 1e-12)


def test_maxima_are_kept_by_the_content_of_the_arm(monkeypatch):
    first = worst_case_inertias(lwr_dyn.load("lwr4plus"))
    again = worst_case_inertias(lwr_dyn.load("lwr4plus"))
    assert all(a is b for a, b in zip(again, first, strict=True))
    assert worst_case_inertia(lwr_dyn.load("lwr4plus"), 3) is first[3]
    assert worst_case_inertia(lwr_dyn.load("lwr4plus"), 3, {4: 0.1}) is not first[3]
    assert worst_case_inertia(lwr_dyn.load("lwr4plus"), 3, smallest=True).value < first[3].value
    assert not first[0].q.flags.writeable
    other = worst_case_inertias(lwr_dyn.load("lwr4plus", reading="computed"))
    assert other[0].value != first[0].value
    arm = lwr_dyn.load("lwr4plus")
    narrow = replace(arm, limits=tuple(replace(limit, lower=-0.1, upper=0.1) for limit in arm.limits))
    assert worst_case_inertias(narrow)[0].value < 0.9 * first[0].value  # whatever the rounding of the search
    monkeypatch.setattr("lwr_dyn.control.inertia.worst_case.KEPT", 1)
    monkeypatch.setattr("lwr_dyn.control.inertia.worst_case._found", {})
    held = [lwr_dyn.load("lwr4plus", lock={f"joint_{j}": q for j in (3, 4, 5, 6, 7)}) for q in (0.1, 0.2)]
    one, _ = map(worst_case_inertias, held)
    assert worst_case_inertias(held[0])[0] is not one[0]
