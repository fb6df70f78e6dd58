"""The search: its buffers, its clock, what it hands over where it must end, and what is wrong with a motion."""

from dataclasses import replace

import numpy as np
import pytest

from lwr_dyn.identification.excitation import motion_design
from lwr_dyn.identification.excitation import watch as clock_of_search
from lwr_dyn.identification.excitation.motion_design import COARSE, FINE, MotionDesign, SearchedMotion, best_motion
from lwr_dyn.identification.excitation.motion_limits import MotionLimits, clearance_of
from lwr_dyn.identification.excitation.room import drawn_poses
from lwr_dyn.identification.excitation.watch import FOR_STARTS, SearchWatch
from lwr_dyn.identification.regression.torque_columns import TorqueColumns


def design_of(arm, watch=None, kept=0.05, torque_share=0.8, duration=5.0, harmonics=2):
    limits = MotionLimits.of(arm, torque_share=torque_share)
    columns, clearance = TorqueColumns(arm.chain), clearance_of(arm, kept)
    noise, watch = np.full(arm.n, 0.1), watch or SearchWatch()
    return MotionDesign(arm, duration, harmonics, "d", noise, columns, limits, clearance, watch)


@pytest.mark.slow
def test_a_buffer_is_at_most_a_share_of_what_a_pair_can_have(iiwa):
    design = design_of(iiwa)
    names = design.clearance.names
    widest = design.clearance.of(drawn_poses(design.limits)).max(axis=0)
    for buffer in (0.02, 0.1):
        buffers = design._space(COARSE, buffer).buffer
        assert (buffers <= 0.3 * widest).all()
        assert buffers.max() == buffer
        tight = names.index("link_5 and link_3")
        assert 0.0 < buffers[tight] < 0.3 * 0.004
    X = np.zeros((design.check.count, iiwa.n))
    X[0] = drawn_poses(design.limits)[np.argmax(design.clearance.of(drawn_poses(design.limits)).min(axis=1))]
    assert design._space(COARSE).slack(X.ravel()).min() > 0.0, "no motion would be inside, whatever the search does"


def test_a_search_that_must_end_hands_over_its_best(lwr):
    """At once it is where it began."""
    rounds, most = [], [15]
    design = design_of(lwr, SearchWatch(stop=lambda: len(rounds) > most[0]))
    space = design._space(COARSE)
    start = motion_design.random_start(space, np.random.default_rng(0)).ravel()
    objective = space.objective
    object.__setattr__(space, "objective", lambda x: (rounds.append(x), objective(x))[1])
    x = space.solve(start, 60, 2e-4, watch=design.watch)
    assert len(rounds) == 16, "the search went on, or ended by itself"
    assert space.slack(x).min() > -motion_design.OUTSIDE
    inside = [objective(y)[0] for y in rounds if space.slack(y).min() > -motion_design.OUTSIDE]
    assert objective(x)[0] <= np.median(inside)
    assert design.watch.ended == "stopped"
    most[0] = -1
    assert np.array_equal(space.solve(start, 60, 2e-4, watch=design.watch), start)


def test_what_is_far_is_left_out_of_the_last_search_and_its_rows_are_those_of_the_whole(lwr):
    design = design_of(lwr)
    space = design._space(FINE)
    x = motion_design.random_start(space, np.random.default_rng(0)).ravel()
    near = space._within(x, FINE.reach)
    assert 0 < near.sum() < 0.7 * len(near)
    assert np.array_equal(near, space._curved(x) < FINE.reach)
    gradient, h = space._curved_gradient(x, near), 1e-6
    for i in np.random.default_rng(1).permutation(x.size)[:5]:
        e = h * np.eye(x.size)[i]
        difference = (space._curved(x + e) - space._curved(x - e))[near] / (2 * h)
        assert np.abs(difference - gradient[:, i]).max() < 1e-6 * max(1.0, np.abs(gradient).max())


def test_faults_name_the_pair_the_moment_and_the_joint(lwr):
    design = design_of(lwr, torque_share=0.02)
    down = np.radians([0, 90, 0, -60, 0, 0, 0])
    X = np.zeros((design.check.count, 7))
    X[0] = down
    near = -design.clearance.of(down[None]).min()
    said = design.faults(X)
    assert said[0] == f"the flange and the floor are {near:.3g} m too near at 0.00 s: 0.05 m is to be kept"
    assert said[1].startswith("joint_2 needs ")
    assert said[1].endswith(" times the torque that it may use")
    assert design_of(lwr).faults(np.zeros_like(X)) == ()


@pytest.mark.parametrize(
    ("motions", "best"),
    [
        ([(1.0, 0.01, 0.5), (0.5, -0.01, 0.5), (2.0, 0.3, 0.5)], 0),
        ([(1.0, -0.02, 0.5), (5.0, -0.01, 0.5)], 1),
        ([(1.0, 0.1, 1.5), (5.0, -0.01, 0.5)], 1),
    ],
)
def test_the_best_motion_may_be_run_or_is_the_nearest_to_it(motions, best):
    found = [SearchedMotion(np.zeros((1, 1)), *one) for one in motions]
    assert best_motion(found) is found[best]


@pytest.mark.parametrize(
    ("duration", "harmonics", "instants"), [(5.0, 2, 5000), (0.05, 5, 100), (0.05, 2, 50), (250.0, 2, 200_000)]
)
def test_a_check_has_a_thousand_instants_a_second_twenty_a_harmonic_and_no_more_than_it_can(
    lwr, duration, harmonics, instants
):
    design = design_of(lwr, duration=duration, harmonics=harmonics)
    assert (len(design.check.position), design.check_rate) == (instants, pytest.approx(instants / duration))


def searched(value, clear, torque=0.5):
    return SearchedMotion(np.zeros((1, 1)), value, clear, torque)


def test_starts_are_refined_from_the_best_on_until_two_are_good(lwr, monkeypatch):
    said, asked = [], []

    def refined(_, one):
        asked.append(one.value)
        return replace(one, value=one.value - 0.1)

    monkeypatch.setattr(MotionDesign, "refined", refined)
    found = [searched(*one) for one in ((3.0, 0.1), (1.0, -0.1), (2.0, 0.1), (0.0, -0.11), (4.0, 0.1))]
    best = design_of(lwr, SearchWatch(report=said.append, steps=4)).best_of(found)
    assert (asked, best.value) == ([1.0, 2.0, 3.0], 1.9)  # 0.11 m too near is hopeless
    steps = [text for text in said if isinstance(text, str)]
    assert steps == ["best starts, 1 of 2", "best starts, 1 of 2", "best starts, 2 of 2"]
    assert [share for share in said if not isinstance(share, str)] == [0.25, 0.5, 0.75, 1.0]
    ended = SearchWatch(stop=lambda: True)
    assert design_of(lwr, ended).best_of(found[1:3]) is found[2]


@pytest.mark.parametrize(
    ("start", "came_to", "asked", "best"),
    [
        (0.5, [(-0.03, 1.2), (0.01, 1.1), (0.02, 0.9)],
         [(0.02, np.inf), (0.055, 1 / 1.21), (0.06, 1 / 1.21 / 1.11)], 2),
        (1.1, [(-0.01, 0.9), (-0.02, 0.9), (-0.005, 0.9), (-0.03, 0.9)],
         [(0.02, 1.0), (0.035, 1.0), (0.06, 1.0), (0.07, 1.0)], 2),
        (0.5, [(-0.11, 0.9)], [(0.02, np.inf)], 0),
    ],
)  # fmt: skip
def test_what_a_check_finds_missing_is_asked_for_in_the_next_search(lwr, monkeypatch, start, came_to, asked, best):
    spaces, results = [], [searched(float(k), *one) for k, one in enumerate(came_to)]
    left = iter(results)
    monkeypatch.setattr(MotionDesign, "_space", lambda _, size, *given: spaces.append((size, *given)))
    monkeypatch.setattr(MotionDesign, "_solved", lambda _, space, X, size: X)
    monkeypatch.setattr(MotionDesign, "_judged", lambda _, X: next(left))
    assert design_of(lwr).refined(searched(9.0, 0.1, start)) is results[best]
    assert [size for size, *_ in spaces] == [FINE] * len(asked)
    np.testing.assert_allclose([given for _, *given in spaces], asked)


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    found = Clock()
    monkeypatch.setattr(clock_of_search, "perf_counter", found)
    return found


def test_starts_end_before_the_best_of_them(clock):
    watch, said = SearchWatch(10.0, begin=0.0), []
    for clock.now in (5.99, 6.0, 9.69, 9.7):
        said.append((watch.is_over(FOR_STARTS), watch.is_over(), watch.ended))
    assert said == [(False, False, "searched"), *[(True, False, "seconds")] * 2, (True, True, "seconds")]


def test_a_wish_to_stop_ends_every_stage_and_is_kept():
    asked = []
    watch = SearchWatch(stop=lambda: bool(asked))
    assert not watch.is_over()
    asked.append(1)
    assert watch.is_over(FOR_STARTS)
    asked.clear()
    assert (watch.is_over(), watch.ended) == (True, "stopped")


def test_progress_names_the_step_and_rises_to_the_end(clock):
    said = []
    watch = SearchWatch(100.0, report=said.append, steps=2, begin=0.0)
    watch.step("start 1 of 1")
    for share in (0.5, 2.0):
        watch.inside(share)
    watch.step_done()
    clock.now = 90.0
    watch.inside(0.1)
    watch.step_done()
    assert said == ["start 1 of 1", 0.25, 0.5, 0.5, 0.9, 1.0]
