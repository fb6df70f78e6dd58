"""Approximate positioning: a blend stays within its distance, saves time, and ends at a look at the world."""

from itertools import pairwise

import numpy as np
import pytest

import lwr_dyn
from tests.krl.short_programs import HOME, run_of


@pytest.mark.parametrize("distance", [1.0, 10.0, 40.0])
def test_blends_stay_inside_their_distance_and_save_time(arm, distance):
    lines = [
        HOME,
        f"$APO.CDIS = {distance}",
        "LIN_REL {Y 150} C_DIS",
        "LIN_REL {Z -120} C_DIS",
        "LIN_REL {X -100, Z 50}",
    ]
    run, stops = run_of(arm, *lines), run_of(arm, *(x.replace(" C_DIS", "") for x in lines))
    assert run.cycle_time < stops.cycle_time
    corners = [lwr_dyn.forward_kinematics(arm, d.q)[:3, 3] for d in run.executed[1:-1]]
    t = np.linspace(0.0, run.cycle_time, 4001)
    p = lwr_dyn.forward_kinematics(arm, run.timeline.sample(t).q)[:, :3, 3]
    # off the polyline only within the distance of a corner, and off it everywhere else by nothing
    nodes = [lwr_dyn.forward_kinematics(arm, d.q)[:3, 3] for d in run.executed]
    off = np.min([_from_segment(p, a, b) for a, b in pairwise(nodes)], axis=0)
    near = np.min([np.linalg.norm(p - c, axis=1) for c in corners], axis=0)
    assert near[off > 1e-8].max() <= distance / 1e3 + 1e-9
    assert off.max() > 0.05 * distance / 1e3
    assert [d.overlap > 0 for d in run.executed] == [False, False, True, True]


def _from_segment(p, a, b):
    along = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(p - a - along[:, None] * (b - a), axis=1)


def test_ptp_into_lin_is_passed_within_the_distance(arm):
    run = run_of(arm, HOME, "$APO.CDIS = 15", "$APO.CPTP = 100", "PTP_REL {A1 30} C_PTP C_DIS", "LIN_REL {Z -100}")
    entry = run.timeline.items[2]
    assert entry.overlap > 0
    corner = lwr_dyn.forward_kinematics(arm, run.executed[1].q)[:3, 3]
    t = np.linspace(entry.begin, entry.begin + entry.overlap, 50)
    lin = np.linalg.norm(lwr_dyn.forward_kinematics(arm, entry.part.axes(t - entry.begin).q)[:, :3, 3] - corner, axis=1)
    assert lin.max() <= 0.015 + 1e-9


@pytest.mark.parametrize("between", ["WAIT SEC 0.5", "$OUT[1] = TRUE", "WAIT FOR $OUT[1]==FALSE"])
def test_a_look_at_the_world_ends_the_blend_unless_continue_stands_before(arm, between):
    head = (HOME, "$APO.CDIS = 20", "LIN_REL {Y 100} C_DIS")
    assert run_of(arm, *head, between, "LIN_REL {Z 50}").executed[-1].overlap == 0.0
    if "OUT" in between:
        assert run_of(arm, *head, "CONTINUE", between, "LIN_REL {Z 50}").executed[-1].overlap > 0.0
