"""SPLINE and PTP_SPLINE: planned whole, through their points, twice differentiable, inside their bounds."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.forward import jacobian, joint_axes, velocity_product_at
from lwr_dyn.krl.motion.splines import orientation_through
from lwr_dyn.model.spatial import rot_z
from tests.krl.short_programs import HOME, codes_of, run_of

V, A = 0.5, 2.0
SPEEDS = (f"$VEL.CP = {V}", f"$ACC.CP = {A}")
ROUNDING = 2e-3
"""Bounds hold at the nodes; between two of them they may be exceeded by this share."""


def block(arm, *lines, head=(), tail="ENDSPLINE"):
    return run_of(arm, HOME, *SPEEDS, *head, "SPLINE", *lines, tail)


def motion_of_tool(arm, m):
    """Position, velocity and acceleration of the flange (k, 3), and its angular velocity."""
    T = lwr_dyn.forward_kinematics(arm, m.q)
    J = jacobian(arm.chain, m.q)
    rest = velocity_product_at(joint_axes(arm.chain, m.q), T[:, :3, 3], m.dq)
    rate, second = (np.einsum("kij,kj->ki", J, x) for x in (m.dq, m.ddq))
    return T[:, :3, 3], rate[:, :3], (second + rest)[:, :3], rate[:, 3:]


def spiral(count):
    """Points of a slow spiral, each relative to the one before it [mm, deg]."""
    u = np.linspace(0.0, 3.0 * np.pi, count + 1)
    p = np.stack([30 * u, 60 * np.sin(u), 20 * np.cos(u)], axis=1)
    return [
        "SPL_REL {" + ", ".join(f"{n} {x:.4f}" for n, x in zip("XYZ", step, strict=True)) + ", A 0.4}"
        for step in np.diff(p, axis=0)
    ]


@pytest.mark.parametrize("line", ["CONST_VEL START = 5", "TIME_BLOCK START", "STOP WHEN PATH = 0 IF $FLAG[1]"])
def test_what_is_not_carried_out_within_a_block_is_noted(arm, line):
    lines = [line, "SLIN_REL {Y 20}", *(["TIME_BLOCK END = 9"] if "TIME" in line else [])]
    run, plain = block(arm, *lines), block(arm, "SLIN_REL {Y 20}")
    notes = [d for d in run.diagnostics if d.code == "not-modelled"]
    assert [d.severity for d in notes] == ["note"] * (len(lines) - 1)
    assert notes[0].message.startswith(line.split(" =")[0].rsplit(" ", 1)[0] + " is not carried out")
    assert run.duration == plain.duration


def test_200_slin_of_1_mm_take_the_time_of_one_of_200_mm_and_a_corner_of_two_is_a_stop(arm):
    many, one = block(arm, *["SLIN_REL {Y 1}"] * 200), block(arm, "SLIN_REL {Y 200}")
    assert one.cycle_time == pytest.approx(0.2 / V + V / A, rel=1e-4)
    assert many.cycle_time == pytest.approx(one.cycle_time, rel=0.001)  # the goal is 3 %
    assert len(many.executed) == 201
    run = block(arm, "SLIN_REL {Y 200}", "SLIN_REL {Z 200}")
    assert run.cycle_time == pytest.approx(2 * (0.2 / V + V / A), rel=1e-4)
    assert np.abs(run.timeline.sample([run.executed[1].end]).dq).max() < 1e-6
    # so is a turn in place, beside curves too
    run = block(arm, "SPL_REL {Y 50}", "SPL_REL {C 10}", "SPL_REL {Z 50}")
    assert np.abs(run.timeline.sample([x.end for x in run.executed[1:3]]).dq).max() < 1e-6


def test_a_spline_through_50_points_is_smooth_and_inside_its_bounds(arm):
    run = block(arm, *spiral(50))
    (item,) = run.timeline.items[1:]
    t = np.linspace(0.0, run.cycle_time, 4001)
    m = run.timeline.sample(t)
    _, v, a, w = motion_of_tool(arm, m)
    speed = np.linalg.norm(v, axis=1)
    along = np.einsum("ki,ki->k", v, a) / np.maximum(speed, 1e-9)
    across = np.sqrt(np.maximum(np.sum(a**2, axis=1) - along**2, 0.0))
    moving = speed > 1e-3
    shares = speed.max() / V, np.abs(along[moving]).max() / A, across.max() / A
    turned = np.linalg.norm(w, axis=1).max() / np.radians(200), (np.abs(m.dq) / arm.velocity).max()
    assert 0.99 < max(shares) <= max(*shares, *turned) < 1 + ROUNDING
    # no step in the curve's first two derivatives, at points or between them
    s = np.linspace(0.0, item.part.profile.length, 20001)
    place = item.part.path.segment.at(s)
    for x, change in ((place.dp, place.ddp), (place.ddp, np.gradient(place.ddp, s, axis=0))):
        assert np.abs(np.diff(x, axis=0)).max() < 1.5 * np.abs(change).max() * (s[1] - s[0])


def test_the_points_of_a_block_are_met_at_the_end_of_their_motions(arm):
    steps = ["SLIN_REL {Y 100}", "SPL_REL {Y 50, Z 20, C 5}", "SPL_REL {Y 50, Z 50}", "SLIN_REL {Z 60, C -5}",
             "SCIRC_REL {Y 50, Z 50}, {Z 100}"]  # fmt: skip
    after = "LIN_REL {X -30}"
    run = block(arm, *steps, tail=f"ENDSPLINE\n{after}")
    plain = run_of(arm, HOME, *(x.replace("SPL_REL", "LIN_REL") for x in steps), after)
    for a, b in zip(run.executed, plain.executed, strict=True):
        assert np.abs(a.q - b.q).max() < 1e-9
        assert np.abs(run.timeline.sample([a.end]).q - a.q).max() < 1e-9
    assert [x.position.line for x in run.executed[1:]] == [8, 9, 10, 11, 12, 14]
    assert all(a.end == b.begin for a, b in zip(run.executed[1:], run.executed[2:], strict=False))


def test_a_curve_takes_the_direction_and_curvature_of_the_line_or_arc_beside_it(arm):
    def both_sides(end, *lines):
        path = block(arm, *lines).timeline.items[1].part.path.segment
        a, b = (path.at(np.array([end + x])) for x in (-1e-9, 1e-9))
        assert np.abs(a.dp - b.dp).max() < 1e-6
        assert np.abs(a.ddp - b.ddp).max() < 1e-4
        return a

    for end in np.cumsum([0.1, float(np.hypot(50, 40)) / 1e3]):
        both_sides(end, "SLIN_REL {Y 100}", "SPL_REL {Y 50, Z 40}", "SLIN_REL {Z 60}")
    arc = both_sides(np.pi * 0.05, "SCIRC_REL {Y 50, Z 50}, {Z 100}", "SPL_REL {Y -60, Z -10}")
    assert np.linalg.norm(arc.ddp) == pytest.approx(20.0)


def test_rates_are_derivatives(arm):
    run = block(arm, "SLIN_REL {Y 100}", "SPL_REL {Y 50, Z 40, A 10}", "SPL_REL {Z 60, B -10}")
    h = 1e-5
    knots = np.concatenate([item.begin + item.part.profile.knots for item in run.timeline.items[1:]])
    t = 0.5 * (knots[1:] + knots[:-1])
    t = t[np.diff(knots) > 4 * h]
    a, b, c = (run.timeline.sample(x) for x in (t - h, t, t + h))
    assert np.abs((c.q - a.q) / (2 * h) - b.dq).max() < 1e-6
    assert np.abs((c.dq - a.dq) / (2 * h) - b.ddq).max() < 1e-3


def test_a_motion_of_a_block_keeps_its_own_speed_and_settings_of_a_block_end_with_it(arm):
    run = block(arm, "SLIN_REL {Y 100}", "SLIN_REL {Y 100} WITH $VEL.CP = 0.1", "SLIN_REL {Y 100}")
    slow = run.executed[2]
    assert slow.end - slow.begin == pytest.approx(1.0, rel=0.03)
    assert run.cycle_time == pytest.approx(1.0 + 0.2 / V + (V + (V - 0.1) ** 2 / V) / A, rel=0.03)
    run = run_of(arm, HOME, "SPLINE WITH $VEL.CP = 0.05", "SLIN_REL {Y 20}", "ENDSPLINE", "LIN_REL {Y 20}")
    slow, plain = (x.end - x.begin for x in run.executed[1:])
    assert slow == pytest.approx(0.02 / 0.05 + 0.05 / 2.3, rel=1e-3)
    assert plain == pytest.approx(0.02 / 0.2 + 0.2 / 2.3, rel=1e-9)


def test_c_spl_passes_into_the_next_block(arm):
    head, tail = "$APO.CDIS = 20", ("SPLINE", "SLIN_REL {Z 100}", "ENDSPLINE")
    lines = ("SPLINE", "SLIN_REL {Y 100}")
    passed = run_of(arm, HOME, head, *lines, "ENDSPLINE C_SPL", *tail)
    stops = run_of(arm, HOME, head, *lines, "ENDSPLINE", *tail)
    assert passed.executed[-1].overlap > 0.0
    assert stops.cycle_time - passed.cycle_time == pytest.approx(passed.executed[-1].overlap, rel=1e-6)
    # within 20 mm of the end, or in the ramp
    assert passed.executed[-1].overlap == pytest.approx(min(0.2 / 2.3, np.sqrt(2 * 0.02 / 2.3)), rel=0.03)


@pytest.mark.parametrize(("first", "second", "passed"), [
    ("SLIN_REL {Y 50} C_SPL", "SLIN_REL {Z 50}", True),
    ("SPTP_REL {A1 5} C_SPL", "SLIN_REL {Z 50}", True),
    ("SLIN_REL {Y 50} C_SPL", "LIN_REL {Z 50}", False),
    ("LIN_REL {Y 50} C_DIS", "SLIN_REL {Z 50}", False),
    ("PTP_REL {A1 5} C_DIS", "LIN_REL {Z 50}", True),
])  # fmt: skip
def test_the_two_planners_do_not_pass_into_one_another(arm, first, second, passed):
    assert (run_of(arm, HOME, "$APO.CDIS = 20", first, second).executed[-1].overlap > 0.0) == passed


def test_ptp_spline_goes_through_its_points_inside_the_bounds_of_its_axes(arm):
    lines = ("SPTP_REL {A1 20}", "SPTP_REL {A1 10, A2 10, A4 30}", "SPTP_REL {A1 20, A2 -20, A5 20}")
    run = run_of(arm, HOME, "PTP_SPLINE", *lines, "ENDSPLINE")
    stops = run_of(arm, HOME, *lines)
    for a, b in zip(run.executed, stops.executed, strict=True):
        assert np.abs(a.q - b.q).max() < 1e-9
    assert run.cycle_time < stops.cycle_time
    m = run.timeline.sample(np.linspace(0.0, run.cycle_time, 2001))
    use = np.abs(m.dq) / arm.velocity, np.abs(m.ddq) * 0.4 / arm.velocity
    assert all(x.max() < 1 + ROUNDING for x in use)
    assert max(x.max() for x in use) > 0.99


def test_the_speed_of_axes_and_of_the_orientation_bound_a_block(arm):
    run = run_of(arm, HOME, "PTP_SPLINE", "SPTP_REL {A1 80}", "SPTP_REL {A1 80}", "ENDSPLINE")
    assert np.abs(run.timeline.sample(np.linspace(0, run.cycle_time, 999)).dq[:, 0]).max() / arm.velocity[0] < 1.001
    assert run.cycle_time == pytest.approx(160 / 140 + 0.4, rel=1e-3)
    slow = block(arm, "SLIN_REL {Y 50, C 15}", "SPL_REL {Y 50, C 15}", head=("$VEL.ORI1 = 10",))
    assert slow.cycle_time == pytest.approx(30 / 10, rel=0.05)


def test_the_orientation_takes_the_short_way_through_many_turns():
    """Quaternions of rotations by 20 to 340 deg change their sign on the way."""
    angles = np.radians(np.arange(20.0, 341.0, 20.0))
    R = np.array([rot_z(x) for x in angles])
    curve = orientation_through(angles, R)
    s = np.linspace(angles[0], angles[-1], 500)
    sample = curve.at(s)
    assert np.abs(sample.R - np.array([rot_z(x) for x in s])).max() < 1e-3
    assert np.abs(sample.rate - [0, 0, 1]).max() < 0.03


def blocked(kind, *lines):
    return [kind, *lines, "ENDSPLINE"]


SWINGS = ["SPTP_REL {A1 184}", "SPTP_REL {A1 0.5, A6 100}", "SPTP_REL {A1 -100}"]
TOLD = {
    "a kind of PTP_SPLINE": ([HOME, *blocked("SPLINE", "SPTP_REL {A1 10}")], ["in-spline", "spline"]),
    "a kind of SPLINE": ([HOME, *blocked("PTP_SPLINE", "SLIN_REL {X 10}")], ["in-spline", "spline"]),
    "axes in space": ([HOME, *blocked("SPLINE", "SLIN {A1 10}")], ["type"]),
    "a faulty point: the block is not planned": (
        [HOME, *blocked("SPLINE", "SLIN {A1 10}", "SPL_REL {X 3000}")], ["type"]),
    "out of reach": ([HOME, *blocked("SPLINE", "SPL_REL {X 3000}")], ["out-of-reach"]),
    "half a turn": ([HOME, *blocked("SPLINE", "SLIN_REL {C 179.9999999}")], ["half-turn"]),
    "outside limits": ([HOME, *blocked("PTP_SPLINE", "SPTP_REL {A1 400}")], ["outside-limits"]),
    "each by itself holds": ([HOME, *SWINGS], []),
    "a curve that swings past a limit": ([HOME, *blocked("PTP_SPLINE", *SWINGS)], ["outside-limits"]),
    "a first motion": (blocked("SPLINE", "SPL {X 1000, Y 0, Z 900, A 0, B 90, C 0}"), ["first-motion"]),
}  # fmt: skip


@pytest.mark.parametrize(("lines", "expected"), TOLD.values(), ids=TOLD)
def test_faults_of_a_block_are_diagnosed(arm, lines, expected):
    assert [code for _, code in codes_of(arm, *lines)] == expected
