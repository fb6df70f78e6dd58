"""Functions of the S-R-S arm's text, in Python, against NumPy: where balls align or the arm is straight too."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics import srs_margins
from lwr_dyn.kinematics.arm_geometry import require_srs
from lwr_dyn.kinematics.closed_forms.arm_numbers import numbers_of_srs
from lwr_dyn.kinematics.closed_forms.python_text import python_text
from lwr_dyn.kinematics.closed_forms.runners import python_names, text_tree, whole_numbers
from lwr_dyn.kinematics.solution import BRANCHES, TURN, joint_ranges, wrap
from lwr_dyn.kinematics.srs import arm_triangle, ball_forms, closed_form, elbow_angle
from lwr_dyn.model.arm import JointLimits
from tests.kinematics.srs_arms import fk, random_srs_arm

CLOSE = 1e-9
ENTRIES = (
    "inverse_kinematics", "inverse_kinematics_arm_angle", "inverse_kinematics_intervals", "inverse_kinematics_near",
    "ball_cuts", "moving_margins", "joined", "sort_cuts", "nearest_arm_angle", "nearest_turn", "smallest_margin",
)  # fmt: skip
LEVELS = (0.0, 0.2, -0.6, srs_margins.NO_LIMIT)


@cache
def _code(wholes):
    """With arrays that are NaN until they are written: in machine code they hold anything."""
    known = {name: x for name, x in python_names({}).items() if isinstance(x, float)}
    text = python_text(text_tree(("shared", "srs", "srs_intervals"), wholes, *ENTRIES), known)
    assert text.count("= [0.0] * ") > 20
    return compile(text.replace("= [0.0] * ", "= [float('nan')] * "), "srs", "exec")


class Case:
    """An arm whose ranges have these half widths, the functions of its text, and its special poses."""

    def __init__(self, arm, reference, halves=None):
        if halves is not None:
            middles = np.random.default_rng(3).uniform(-0.4, 0.4, 7)
            limits = (JointLimits(float(m - h), float(m + h)) for m, h in zip(middles, halves, strict=True))
            arm = replace(arm, limits=tuple(limits))
        self.arm, self.ranges = arm, joint_ranges(arm)
        self.geometry = g = require_srs(arm).with_reference(reference)
        numbers = numbers_of_srs(arm, g)
        self.text = python_names(numbers)
        exec(_code(whole_numbers(numbers)), self.text)
        q = np.random.default_rng(1).uniform(-2.0, 2.0, (14, 7))
        straight, first, last = slice(8, 13), [2, 4, 6, 9, 11], [3, 4, 7, 10, 11]
        q[straight, 3], q[first, 1], q[last, 5] = g.straight, -g.first.offset, -g.last.offset
        q[5, 3] = g.straight + 0.5
        q[[6, 12], 1], q[[7, 12], 5] = np.pi - g.first.offset, np.pi - g.last.offset
        self.T = T = fk(arm, q)
        to_wrist = T[:, :3, 3] + T[:, :3, :3] @ g.wrist_in_flange - g.shoulder
        T[straight, :3, 3] += 1e-12 * to_wrist[straight]  # within the slack: straight to the last bit
        T[13, :3, 3] -= to_wrist[13]  # the wrist at the shoulder: out of reach

    def problem(self, k):
        """Of pose k on each branch."""
        return srs_margins.margin_problem(self.geometry, self.ranges, self.rows(k), np.array(BRANCHES))

    def rows(self, k):
        return np.tile(self.T[k], (8, 1, 1))

    def forms(self, k, elbow):
        F = [0.0] * 55
        return self.text["forms"](self.T[k].ravel().tolist(), elbow, F), F


WIDE, NARROW = (4.0, 3.5, 7.0, 3.0, 9.0, 4.0, 3.3), (1.7, 1.6, 1.3, 2.9, 1.5, 1.7, 1.3)
MAKE = {
    "tilted reference": lambda: Case(lwr_dyn.load("lwr4plus"), (0.4, -0.7, 0.5), NARROW),
    "wide": lambda: Case(random_srs_arm(5), None, WIDE),
    "offsets": lambda: Case(random_srs_arm(11), None),
}


@pytest.fixture(scope="module", params=MAKE)
def case(request):
    return MAKE[request.param]()


def test_forms_cuts_and_margins(case):
    """At the alignments and cuts too; the sum of margins, which only decides between equals, with a weight of 1/2."""
    g, aligned = case.geometry, 0
    for k in range(len(case.T)):
        triangle, problem = arm_triangle(g, case.T[[k]]), case.problem(k)
        for b, signs in enumerate(BRANCHES):
            excess, F = case.forms(k, signs[1])
            elbow = np.array([signs[1]])
            assert excess == pytest.approx(triangle.reach_excess[0], abs=1e-15)
            assert F[54] == pytest.approx(elbow_angle(g, triangle, elbow)[0], abs=1e-7)
            assert np.abs(np.array(F[:54]) - ball_forms(g, case.T[[k]], triangle, elbow).ravel()).max() < 1e-7
            row = problem.rows(np.array([b]))
            G, cuts, level, forms = [0.0] * 42, [-np.pi] * 29, LEVELS[(k + b) % 4], row.forms[0, :, :7].ravel()
            case.text["ball_cuts"](F, 0, signs[0], 0, level, G, cuts, 0)
            case.text["ball_cuts"](F, 27, signs[2], 4, level, G, cuts, 1)
            assert np.abs(np.array(G) - forms).max() < 1e-7
            wanted = [srs_margins._crossings(row, np.array([level])), srs_margins._alignments(row.forms)]
            assert np.abs(wrap(np.array(cuts[1:]) - np.hstack(wanted)[0])).max() < 1e-5
            psi = np.array([*cuts[25:], *np.linspace(-3.0, 3.0, 12)])
            margins = srs_margins.margins(row, psi[None])[0]
            moving, out = np.delete(margins, 3, axis=1), [0.0] * 16
            case.text["moving_margins"](forms.tolist(), psi.tolist(), signs[0], signs[2], 0.5, out)
            assert np.abs(out - (moving.min(axis=1) + 0.5 * moving.sum(axis=1))).max() < 1e-6
            aligned += (np.array(cuts[25:]) > -np.pi).sum()
    assert aligned > 40


def test_intervals(case):
    several = 0
    for k in range(len(case.T)):
        for level in LEVELS[k % 2 :: 2]:
            out, counts = [0.0] * 256, [9] * 8
            excess = case.text["inverse_kinematics_intervals"](case.T[k].ravel().tolist(), level, out, counts)
            wanted = srs_margins.intervals_at_level(case.problem(k), level)
            for b in range(8):
                found = np.reshape(out[32 * b :][: 2 * counts[b]], (-1, 2))
                pairs = np.reshape(wanted.of(b) if excess == 0.0 else (), (-1, 2))
                # where a ball aligns at a limit, rounding decides about intervals of one point
                found, pairs = (x[np.ptp(x, axis=1) > 1e-6] for x in (found, pairs))
                assert found.shape == pairs.shape
                assert np.abs(found - pairs).max(initial=0.0) < 1e-5
                several += len(pairs) > 1
    assert several > 5


def test_pieces_are_joined_round_the_circle_but_not_where_a_ball_aligns(case):
    rng = np.random.default_rng(0)
    for share in (0.1, 0.5, 0.8, 0.97, 1.0) * 40:
        angles, inside = rng.uniform(-np.pi, np.pi, 29), rng.random(29) < share
        angles[0], angles[rng.integers(1, 29, 5)] = -np.pi, -np.pi
        cuts, hard = angles.tolist(), [0.0] * 29
        case.text["sort_cuts"](cuts, hard)
        order = np.argsort(angles, kind="stable")
        is_hard = (order >= 25) & (angles[order] > -np.pi)
        assert (cuts, hard) == (angles[order].tolist(), is_hard.tolist())
        if share == 1.0 and rng.random() < 0.5:
            is_hard[:] = False
        out = [0.0] * 40
        count = case.text["joined"](cuts, (is_hard * 1.0).tolist(), (inside * 1.0).tolist(), out, 2)
        ends = np.array([*cuts[1:], np.pi])
        wanted = srs_margins._joined(np.array([cuts]), ends[None], inside[None], is_hard[None]).of(0)
        assert out[2 : 2 + 2 * count] == [x for pair in wanted for x in pair]


def test_branches_at_an_arm_angle_and_back(case):
    for k, T in enumerate(case.T):
        problem = case.problem(k)
        for psi in (*srs_margins._alignments(problem.forms[[0, 2]]).ravel(), 0.7, -2.0):
            out = [0.0] * 56
            excess = case.text["inverse_kinematics"](T.ravel().tolist(), float(psi), out)
            if excess > 0.0:
                assert np.isnan(out).all()
                continue
            angles, signs = np.full(8, psi), np.array(BRANCHES)
            wanted = closed_form(case.geometry, case.ranges, case.rows(k), angles, signs)
            assert np.abs(wrap(np.reshape(out, (8, 7)) - wanted)).max() < 1e-6
            assert np.abs(np.reshape(out, (8, 7)) - case.ranges.middle).max() < np.pi + CLOSE
            away = k < 8 and psi in (0.7, -2.0)  # from alignments, where the branches meet
            for q, sign in zip(wanted if away else (), BRANCHES, strict=False):
                found = [0.0] * 4
                case.text["inverse_kinematics_arm_angle"](q.tolist(), found)
                assert tuple(found[1:]) == tuple(sign)
                assert abs(wrap(found[0] - psi)) < CLOSE


def nearest(case, q, near):
    """By whole turns, tried one by one."""
    turned = q + TURN * np.arange(-9, 10)[:, None]
    inside = np.abs(turned - case.ranges.middle) <= case.ranges.half + 1e-12
    best = np.where(inside, np.abs(turned - near), np.inf).argmin(axis=0)
    return np.where(inside.any(axis=0), turned[best, np.arange(7)], q)


def test_the_nearest_position(case):
    rng, statuses = np.random.default_rng(2), []
    for k in (*range(14), *range(6), *range(8)):
        T = case.T[k]
        near, psi, out, best = rng.uniform(-9.0, 9.0, 7), float(rng.uniform(-3.0, 3.0)), [9.0] * 7, (np.inf, 2, 9.0)
        status = case.text["inverse_kinematics_near"](T.ravel().tolist(), psi, near.tolist(), out)
        statuses.append(status)
        if k == 13:
            assert (status, out) == (3, [9.0] * 7)
            continue
        intervals = srs_margins.intervals_at_level(case.problem(k), 0.0)
        for b, branch in enumerate(BRANCHES):
            pairs = intervals.of(b)
            free = [max(0.0, abs(wrap(psi - (x + y) / 2.0)) - (y - x) / 2.0) for x, y in pairs]
            if not pairs:
                continue
            x, y = pairs[int(np.argmin(free))]
            at = (x + y) / 2.0 + np.clip(wrap(psi - (x + y) / 2.0), (x - y) / 2.0, (y - x) / 2.0)
            q = closed_form(case.geometry, case.ranges, T[None], np.array([at]), branch)[0]
            q = nearest(case, q, near)
            best = min(best, (float(np.sum((q - near) ** 2)), int(min(free) > 0.0), q), key=lambda x: x[0])
        assert status == best[1]
        assert np.abs(np.array(out) - best[2]).max() < 1e-5
    assert len(set(statuses)) > 1


def test_turns_margins_and_arm_angles_that_are_nearest(case):
    rng, ranges = np.random.default_rng(6), case.ranges
    for k in range(40):
        near, q = rng.uniform(-12.0, 12.0, 7), ranges.middle + rng.uniform(-np.pi, np.pi, 7)
        if k % 4 == 0:  # at a limit, and a little more than rounding outside
            q = ranges.middle + (ranges.half + (0.0, 9e-13, 2e-12, 1e-9)[k // 4 % 4]) * rng.choice([-1.0, 1.0], 7)
        turned = [case.text["nearest_turn"](q.tolist()[i], near.tolist()[i], i) for i in range(7)]
        assert turned == pytest.approx(nearest(case, q, near), abs=1e-14)
        margin = (ranges.half - np.abs(q - ranges.middle)).min()
        assert case.text["smallest_margin"]([5.0, *q.tolist()], 1) == pytest.approx(margin, abs=1e-14)
        starts = rng.uniform(-np.pi, np.pi, 3)
        pairs = np.stack([starts, starts + rng.uniform(0.0, 0.9, 3)], axis=1)
        psi = float(rng.uniform(-np.pi, np.pi))
        found = case.text["nearest_arm_angle"](pairs.ravel().tolist(), 3, psi)
        grid = np.linspace(pairs[:, 0], pairs[:, 1], 2001)
        assert abs(wrap(found - psi)) <= np.abs(wrap(grid - psi)).min() + CLOSE
        assert any(x - CLOSE <= found <= y + CLOSE for x, y in pairs)
        assert case.text["nearest_arm_angle"]([], 0, psi) == psi


def test_what_is_at_a_bound_to_the_last_bit_touches_it():
    arm = lwr_dyn.load("lwr4plus")
    numbers = numbers_of_srs(arm, require_srs(arm)) | {"LENGTHS": np.array([0.5, 0.25]), "REACH_SLACK": 2.0**-40}
    text = python_names(numbers)
    exec(_code(whole_numbers(numbers)), text)
    for distance, sign in ((0.75 + 2.0**-40, 1.0), (0.25 - 2.0**-40, -1.0)):
        assert text["reach_excess"](distance) == 0.0
        assert text["reach_excess"](distance + sign * 2.0**-45) == 2.0**-40 + 2.0**-45
    cuts = [9.0, 9.0]
    for sign in (1.0, -1.0):
        for value, root in ((1.0 + 1e-12, sign * np.pi / 2.0), (np.nextafter(1.0 + 1e-12, 2.0), -np.pi)):
            text["roots"](0.0, 1.0, -sign * float(value), cuts, 0)
            assert cuts == pytest.approx([root, root], abs=1e-15)
    for place, extreme in enumerate((1.0 - 1e-14, -1.0 + 1e-14)):
        for value, touches in ((extreme, True), (np.nextafter(extreme, 0.0), False)):
            text["alignment_cuts"]([0.5, 0.0, float(value) - np.copysign(0.5, extreme)], 0, cuts, 0)
            assert cuts == [-np.pi if not touches or k != place else k * np.pi for k in range(2)]
    F, cuts, found = [0.0] * 54, [0.0] * 29, [0.0] * 4
    F[2], F[4], F[10] = 1e-13, 0.6, 0.8  # rolls that hardly turn about one line: not as if they did
    for tilt, count in ((1e-13, 0), (float(np.nextafter(1e-13, 0.0)), 8)):
        F[2] = tilt
        text["ball_cuts"](F, 0, 1.0, 0, 2.0, [0.0] * 42, cuts, 0)
        assert sum(x > -np.pi for x in cuts[1:9]) == count
    g = require_srs(arm)
    text["inverse_kinematics_arm_angle"]([0.3, -g.first.offset, 0.1, g.straight, 0.2, -g.last.offset, 0.4], found)
    assert found[1:] == [1.0, 1.0, 1.0]
    assert text["nearest_arm_angle"]([-1.5, -0.5, 0.5, 1.5], 2, 0.0) == -0.5
