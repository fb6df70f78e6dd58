"""Chains of motions as one path with rounded corners."""

import numpy as np
import pytest

from lwr_dyn.krl.motion.cycle_times import chains_of, limits_of_chain
from lwr_dyn.krl.motion.pose_paths import fastest_speeds, times_along
from tests.krl.short_programs import HOME, run_of


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


def test_the_orientation_bounds_a_chain(arm):
    lines = ("$APO.CDIS = 30", "LIN_REL {Y 60, C 20} C_DIS", "LIN_REL {Y 60, C 20}")
    quick = seconds(limits_of_chain(chain_of(arm, *lines))[0])
    slow = seconds(limits_of_chain(chain_of(arm, "$VEL.ORI1 = 20", *lines))[0])
    assert quick < 1.0
    assert slow == pytest.approx(40 / 20 + 20 / 500, rel=0.02)


def test_a_change_of_the_turn_bounds_the_corner(arm):
    lines = ("$APO.CDIS = 10", "$VEL.CP = 1", "LIN_REL {Y 60, C 10} C_DIS", "LIN_REL {Y 60, C -10}")
    soft, hard = (limits_of_chain(chain_of(arm, f"$ACC.ORI1 = {a}", *lines))[0] for a in (20, 2000))
    # at the corner the turn changes from +w to -w over 20 mm: x 2 w / 20 mm <= a
    w = np.radians(10) / 0.06
    assert soft.fastest.min() == pytest.approx(np.radians(20) / (2 * w / 0.02), rel=1e-3)
    assert hard.fastest.min() > 10 * soft.fastest.min()


def test_a_small_arc_bounds_the_speed_by_its_curvature(arm):
    arcs = ("$VEL.CP = 1", "$ACC.CP = 2", "$APO.CDIS = 5", "CIRC_REL {Y 20, Z 20}, {Z 40} C_DIS", "LIN_REL {Y -50}")
    limits, _ = limits_of_chain(chain_of(arm, *arcs))
    assert np.median(limits.fastest[: len(limits.s) // 3]) == pytest.approx(2 * 0.02)  # v^2 = a r


def test_another_tool_ends_a_chain(arm):
    lines = ("$APO.CDIS = 20", "LIN_REL {Y 50} C_DIS", "$TOOL = {X 0, Y 0, Z 50, A 0, B 0, C 0}", "LIN_REL {Z 50}")
    items = run_of(arm, HOME, *lines).timeline.items
    assert items[-1].overlap > 0.0
    assert list(chains_of(items)) == []
