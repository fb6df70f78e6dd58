"""Cycle times of motions that pass into one another: each law against its closed form; a chain is one rounded path."""

import math

import numpy as np
import pytest

from lwr_dyn.krl.motion.cycle_times import chains_of, limits_of_chain
from lwr_dyn.krl.motion.pose_paths import fastest_speeds, times_along
from tests.krl.short_programs import HOME, run_of

A, V = 2.0, 0.5
SPEEDS = (f"$VEL.CP = {V}", f"$ACC.CP = {A}")


def chain(arm, count, millimetres, advance=3):
    lines = [*SPEEDS, f"$ADVANCE = {advance}", "$APO.CDIS = 100"]
    return run_of(arm, HOME, *lines, *[f"LIN_REL {{Y {millimetres}}} C_DIS"] * count)


@pytest.mark.slow
@pytest.mark.parametrize(("count", "millimetres"), [(60, 1), (40, 2), (12, 10)])
def test_short_lines_with_c_dis_run_at_the_root_of_a_l(arm, count, millimetres):
    length = millimetres / 1e3
    executed = chain(arm, count, millimetres).executed
    middle = [x for x in executed if 0.25 * count < x.position.line - 9 < 0.75 * count]
    speed = (len(middle) - 1) * length / (middle[-1].end - middle[0].end)
    assert speed == pytest.approx(math.sqrt(A * length), rel=0.001)


@pytest.mark.slow
@pytest.mark.parametrize("count", [20, 200])
def test_all_known_short_lines_take_the_time_of_one_long_line(arm, count):
    times = chain(arm, count, 200 / count).times()
    assert times.known == pytest.approx(0.2 / V + V / A, rel=1e-3)
    assert times.chained == count


@pytest.mark.slow
def test_the_advance_bounds_the_speed_by_the_way_that_is_known(arm):
    """Speed at the end of each motion: sqrt(2 a N L), at most."""
    stop, one, three, five = (chain(arm, 60, 1, advance).times() for advance in (0, 1, 3, 5))
    assert stop.chained == 0
    assert stop.advance == pytest.approx(60 * 2 * math.sqrt(1e-3 / A), rel=1e-9)
    assert stop.advance > one.overlap > one.advance > three.advance > five.advance > five.known
    for n, times in ((1, one), (3, three), (5, five)):
        slow, fast = (math.sqrt(2 * A * k * 1e-3) for k in (n, n + 0.5))
        assert 0.06 / fast < times.advance < 0.06 / slow + 2 * slow / A


def test_a_right_angle_by_each_law_and_a_half_turn_back_that_stops_by_all_known(arm):
    def times(distance, blend, back="{Z -200}"):
        lines = (f"$APO.CDIS = {distance}", f"LIN_REL {{Y 200}}{blend}", f"LIN_REL {back}")
        return run_of(arm, HOME, *SPEEDS, *lines).times()

    stops, saved = times(5, ""), []
    for d in (5, 20, 50):
        passed = times(d, " C_DIS")
        assert stops.overlap - passed.overlap == pytest.approx(math.sqrt(2 * d / 1e3 / A), rel=1e-6)
        saved.append(stops.known - passed.known)
        assert passed.advance == pytest.approx(passed.known, abs=1e-9)
    # prototypes of the same law, written apart: 0.058, 0.119, 0.1945 s
    assert saved == pytest.approx([0.058, 0.119, 0.1945], abs=0.001)
    there_and_back = 2 * ((0.2 - 0.05) / V + V / A)
    assert there_and_back * 0.9 < times(50, " C_DIS", "{Y -200}").known < 2 * (0.2 / V + V / A)


def test_ptp_in_one_direction_is_one_ptp_when_all_is_known(arm):
    one = run_of(arm, HOME, "PTP_REL {A1 60, A4 30}").times()
    two = run_of(arm, HOME, "$APO.CPTP = 100", "PTP_REL {A1 30, A4 15} C_PTP", "PTP_REL {A1 30, A4 15}").times()
    assert two.known == pytest.approx(one.known, rel=2e-3)
    assert two.overlap > one.overlap * 1.03


@pytest.mark.parametrize(
    "lines",
    [
        ("LIN_REL {Y 50}", "WAIT SEC 1", "PTP_REL {A1 10}"),
        # PTP and LIN are two planners: their blend stays the overlap of ramps
        ("$APO.CDIS = 20", "$APO.CPTP = 50", "PTP_REL {A1 20} C_PTP C_DIS", "LIN_REL {Z -80}"),
    ],
)
def test_what_is_not_passed_by_one_planner_counts_as_planned(arm, lines):
    times = run_of(arm, HOME, *lines).times()
    assert times.overlap == times.advance == times.known
    assert (times.chained, times.lines()) == (0, ())
    assert "no KUKA figure" in chain(arm, 3, 10).times().lines()[0]


SQUARE = ("LIN_REL {Y 63} C_DIS", "LIN_REL {Z -47} C_DIS", "LIN_REL {Y -63} C_DIS", "LIN_REL {Z 47} C_DIS")
TURNS = [i * math.pi / 12 for i in range(24)]
ROUND = [f"LIN_REL {{Y {2 * math.cos(x):.9f}, Z {2 * math.sin(x):.9f}}} C_DIS" for x in TURNS]


@pytest.mark.parametrize(("square", "advance"), [(SQUARE, 3), pytest.param(ROUND, 1, marks=pytest.mark.slow)])
def test_a_pass_by_each_law_is_what_one_more_repetition_takes(arm, square, advance):
    """A loop that never stops, against the same passes written one after another: four of them less three."""
    lines = [*SPEEDS, "$APO.CDIS = 20", f"$ADVANCE = {advance}"]
    run = run_of(arm, HOME, *lines, "LOOP", *square, "ENDLOOP")
    three, four = (run_of(arm, HOME, *lines, *[*square] * n).times() for n in (3, 4))
    times = run.pass_times()
    assert run.passes.period == 1
    assert times.chained == len(square)
    assert times.overlap == pytest.approx(run.passes.cycle_time, rel=1e-12)
    for law in ("overlap", "advance", "known"):
        assert getattr(times, law) == pytest.approx(getattr(four, law) - getattr(three, law), rel=1e-6)
    if square is ROUND:
        assert times.known < times.advance < times.overlap


def test_a_pass_that_stops_at_its_end_takes_its_own_time_by_each_law(arm):
    lines = [*SPEEDS, "$APO.CDIS = 20"]
    run = run_of(arm, HOME, *lines, "LOOP", *SQUARE, "WAIT SEC 1", "ENDLOOP")
    once = run_of(arm, HOME, *lines, *SQUARE, "WAIT SEC 1").times()
    times = run.pass_times()
    assert (times.overlap, times.advance, times.known) == pytest.approx((once.overlap, once.advance, once.known))
    assert run_of(arm, HOME, *lines, *SQUARE).pass_times() is None


def chain_of(arm, *lines):
    (chain,) = chains_of(run_of(arm, HOME, *lines).timeline.items)
    return chain


def seconds(limits):
    return times_along(limits.s, fastest_speeds(limits))[-1]


@pytest.mark.parametrize("lines", [
    ("$APO.CPTP = 60", "PTP_REL {A1 30, A4 10} C_PTP", "PTP_REL {A1 -20, A2 15} C_PTP", "PTP_REL {A5 20}"),
    ("$APO.CDIS = 30", "LIN_REL {Y 100, C 20} C_DIS", "LIN_REL {Z -80, A 10} C_DIS", "LIN_REL {Y 50}"),
])  # fmt: skip
def test_rates_along_a_chain_are_those_of_its_motions(arm, lines):
    """Over the whole chain they add up to the motions, and in a corner one goes over into the other."""
    chain = chain_of(arm, *lines)
    limits, ends = limits_of_chain(chain)
    way = np.trapezoid(limits.first, limits.s, axis=0)
    if lines[0].startswith("$APO.CPTP"):
        assert way == pytest.approx(chain[-1].part.end - chain[0].part.start, abs=1e-9)
    else:
        turns = sum(x.part.path.orientation.at(np.zeros(1)).rate[0] * x.part.path.length for x in chain)
        assert way[1:] == pytest.approx(turns, rel=0.02)  # the parabola is a little shorter than its tangents
    h = np.diff(limits.s)
    slope = np.diff(limits.first, axis=0) / h[:, None]
    either = np.minimum(np.abs(slope - limits.second[:-1]), np.abs(slope - limits.second[1:]))
    assert either.max() < 0.2 * np.abs(limits.second).max()
    assert len(ends) == 3
    assert (np.diff([0, *ends]) > 0).all()
    assert ends[-1] == len(limits.s) - 1


def test_the_turn_and_its_change_and_the_curvature_bound_a_chain(arm):
    turned = ("$APO.CDIS = 30", "LIN_REL {Y 60, C 20} C_DIS", "LIN_REL {Y 60, C 20}")
    quick, slow = (seconds(limits_of_chain(chain_of(arm, *x, *turned))[0]) for x in ((), ("$VEL.ORI1 = 20",)))
    assert quick < 1.0
    assert slow == pytest.approx(40 / 20 + 20 / 500, rel=0.02)
    lines = ("$APO.CDIS = 10", "$VEL.CP = 1", "LIN_REL {Y 60, C 10} C_DIS", "LIN_REL {Y 60, C -10}")
    soft, hard = (limits_of_chain(chain_of(arm, f"$ACC.ORI1 = {a}", *lines))[0] for a in (20, 2000))
    # at the corner the turn changes from +w to -w over 20 mm: x 2 w / 20 mm <= a
    w = np.radians(10) / 0.06
    assert soft.fastest.min() == pytest.approx(np.radians(20) / (2 * w / 0.02), rel=1e-3)
    assert hard.fastest.min() > 10 * soft.fastest.min()
    arcs = ("$VEL.CP = 1", "$ACC.CP = 2", "$APO.CDIS = 5", "CIRC_REL {Y 20, Z 20}, {Z 40} C_DIS", "LIN_REL {Y -50}")
    limits, _ = limits_of_chain(chain_of(arm, *arcs))
    assert np.median(limits.fastest[: len(limits.s) // 3]) == pytest.approx(2 * 0.02)  # v^2 = a r


def test_another_tool_ends_a_chain(arm):
    lines = ("$APO.CDIS = 20", "LIN_REL {Y 50} C_DIS", "$TOOL = {X 0, Y 0, Z 50, A 0, B 0, C 0}", "LIN_REL {Z 50}")
    items = run_of(arm, HOME, *lines).timeline.items
    assert (items[-1].overlap > 0.0, list(chains_of(items))) == (True, [])
