"""Motions on the model: closed-form ramps, branches by Status and Turn, speeds, frames; every statement."""

import math

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.forward import jacobian
from lwr_dyn.kinematics.six_joints.spherical_wrist import all_branches
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.robot.kuka_pose import KukaPose, kuka_pose, status, turn
from lwr_dyn.krl.running.program_run import check_program, run_program
from lwr_dyn.krl.running.targets import absolute_point
from lwr_dyn.krl.running.values import ExecutionError, StructValue
from tests.krl.short_programs import HOME, codes_of, run_of

SECONDS = 1e-9
METRES = 1e-9
START = np.radians([0, -90, 90, 0, 30, 0])


def trapezoid_time(way, speed, ramp):
    return way / speed + speed / ramp if way * ramp >= speed**2 else 2 * math.sqrt(way / ramp)


@pytest.mark.parametrize(("axis", "step"), [(1, 60), (1, 5), (2, 40), (3, -70), (4, 170), (5, 20), (6, -300)])
@pytest.mark.parametrize("percent", [100, 30])
def test_ptp_is_synchronous_and_takes_the_time_of_its_slowest_axis(arm, axis, step, percent):
    run = run_of(arm, HOME, f"BAS(#VEL_PTP, {percent})", f"PTP_REL {{A{axis} {step}, A5 3}}")
    ways = np.zeros(6)
    ways[axis - 1], ways[4] = step, 3  # of A5 twice the second one counts
    rated = np.degrees(arm.velocity)
    # all axes share one profile: its speed and its ramp are those of the tightest axis
    speed, ramp = (
        min(x / abs(w) for x, w in zip(of, ways, strict=True) if w) for of in (rated * percent / 100, rated / 0.4)
    )
    assert run.executed[-1].end - run.executed[-1].begin == pytest.approx(trapezoid_time(1.0, speed, ramp), abs=SECONDS)
    parts = (run.timeline.sample(np.linspace(0.0, run.cycle_time, 50)).q - START)[:, ways != 0] / np.radians(
        ways[ways != 0]
    )
    assert np.abs(parts - parts[:, :1]).max() < 1e-12


@pytest.mark.parametrize(("millimetres", "speed"), [(200, 0.2), (20, 0.5), (300, 1.0)])
def test_lin_takes_the_time_of_its_ramps_and_is_straight(arm, millimetres, speed):
    run = run_of(arm, HOME, f"$VEL.CP = {speed}", f"LIN_REL {{Y {millimetres}}}")
    assert run.cycle_time == pytest.approx(trapezoid_time(millimetres / 1e3, speed, 2.3), abs=SECONDS)
    t = np.linspace(0.0, run.cycle_time, 101)
    m = run.timeline.sample(t)
    T = lwr_dyn.forward_kinematics(arm, m.q)
    away = T[:, :3, 3] - T[0, :3, 3]
    assert np.abs(away[:, [0, 2]]).max() < METRES
    assert np.abs(T[:, :3, :3] - T[0, :3, :3]).max() < 1e-9
    v = np.einsum("kij,kj->ki", jacobian(arm.chain, m.q), m.dq)
    assert v[:, 1].max() == pytest.approx(min(speed, math.sqrt(2.3 * millimetres / 1e3)), rel=1e-6)
    turn_only = run_of(arm, HOME, f"$VEL.ORI1 = {450 * speed}", "LIN_REL {C 20}")
    assert turn_only.cycle_time == pytest.approx(trapezoid_time(20, 450 * speed, 500), abs=SECONDS)


def test_circ_stays_on_its_circle_and_ca_turns_on(arm):
    for line, angle in (
        ("CIRC_REL {Y 100, Z 100}, {Z 200}", math.pi),
        ("CIRC_REL {Y 100, Z 100}, {Z 200}, CA 270", 1.5 * math.pi),
    ):
        run = run_of(arm, HOME, line)
        m = run.timeline.sample(np.linspace(0.0, run.cycle_time, 80))
        p = lwr_dyn.forward_kinematics(arm, m.q)[:, :3, 3]
        centre = p[0] + np.array([0, 0, 0.1])
        assert np.abs(np.linalg.norm(p - centre, axis=1) - 0.1).max() < METRES
        assert run.cycle_time == pytest.approx(trapezoid_time(0.1 * angle, 0.2, 2.3), abs=SECONDS)


def test_rates_are_derivatives_also_in_blends(arm):
    run = run_of(arm, HOME, "$APO.CDIS = 30", "$APO.CPTP = 50", "PTP_REL {A1 20} C_PTP C_DIS",
               "LIN_REL {Y 100, B 15} C_DIS",
               "LIN_REL {Z 80, A 20} C_DIS", "CIRC_REL {Y 50, Z 50}, {Z 100} C_DIS", "PTP_REL {A6 40}")  # fmt: skip
    h = 1e-5
    marks = np.concatenate([item.begin + np.asarray(item.part.profile.knots) for item in run.timeline.items[1:]])
    t = np.linspace(h, run.cycle_time - h, 400)
    t = t[np.abs(t[:, None] - marks).min(axis=1) > 3 * h]
    t = t[np.array([min(abs(x - e.begin - e.overlap) for e in run.timeline.items) > 3 * h for x in t])]
    a, b, c = (run.timeline.sample(x) for x in (t - h, t, t + h))
    assert np.abs((c.q - a.q) / (2 * h) - b.dq).max() < 1e-6
    assert np.abs((c.dq - a.dq) / (2 * h) - b.ddq).max() < 1e-4


def test_no_axis_is_faster_than_its_rating_without_a_word(arm):
    passed = ("PTP_REL {A1 30, A4 20} C_PTP", "PTP_REL {A1 -50, A6 90} C_PTP") * 3
    run = run_of(arm, HOME, "$APO.CPTP = 100", *passed, "PTP_REL {A2 9}")
    assert (run.peak_speeds <= arm.velocity * (1 + 1e-9)).all()
    assert run.diagnostics == ()


POSE = "PTP {X 91, Y -1139, Z 1392, A 0, B 0, C 0, S 4, T 52}"
TOLD = {
    "a LIN near A5 = 0 at full speed": (
        ["PTP {A1 0, A2 -90, A3 90, A4 20, A5 4, A6 0}", "$VEL.CP = 2", "LIN_REL {Y -400}"], (3, "axis-speed")),
    "B turns from one side of the forearm's direction to the other": ([HOME, "LIN_REL {B 60}"], (2, "singularity")),
    "B turns away from it": ([HOME, "LIN_REL {B -60}"], None),
    "A5 comes down to 1.13 deg": ([HOME, "LIN_REL {B 24.2}"], None),
    "A5 comes down to 0.77 deg": ([HOME, "LIN_REL {B 24.5}"], (2, "singularity")),
    "a wrist that turns over in a PTP": (
        [HOME, POSE, "PTP {X 91, Y -1117, Z 1447, A 0, B 0, C 0, S 0, T 12}"], (3, "wrist-flip")),
    "a first LIN that is out of reach": (["LIN {X 9000, Y 0, Z 1000, A 0, B 90, C 0}"], (1, "out-of-reach")),
    "an external axis": ([HOME, "PTP {A1 5, E1 0, E2 3}"], (2, "external-axes")),
    "none": ([HOME, "PTP {A1 5, E1 0, E2 0.0}"], None),
    "after a point that is not whole nothing is known": (["PTP {A1 0, A2 -90}", "LIN_REL {Y 1}"], (2, "first-motion")),
    "the Status of the target of a LIN": (
        [POSE, "LIN {X 91, Y -1117, Z 1447, A 0, B 0, C 0, S 0, T 4}"], (2, "status-turn")),
}  # fmt: skip


@pytest.mark.parametrize(("lines", "expected"), TOLD.values(), ids=TOLD)
def test_what_the_wrist_cannot_do_is_told(arm, lines, expected):
    found = codes_of(arm, *lines)
    assert expected in found if expected else found == []


NOW = StructValue("E6POS", {"X": 100.0, "Y": 20, "Z": 3.0, "A": 90.0, "B": 0.0, "C": 0.0, "S": 2, "T": 2})
AXES = StructValue("E6AXIS", {f"A{i}": 10.0 * i for i in range(1, 7)})


@pytest.mark.parametrize(
    ("step", "frame", "expected"),
    [
        ({"X": 1.0, "C": 5}, None, [101.0, 20, 3.0, 90.0, 0.0, 5.0]),
        ({"X": 1.0, "C": 5}, "BASE", [101.0, 20, 3.0, 90.0, 0.0, 5.0]),
        ({"X": 1.0, "Z": 2.0}, "tool", [100.0, 21.0, 5.0, 90.0, 0.0, 0.0]),  # X of the tool is Y
    ],
)
def test_a_relative_motion_ends_at_a_pose_without_status_or_at_axes(step, frame, expected):
    found = absolute_point(StructValue("FRAME", step), NOW, frame)
    assert (found.type, list(found.parts), list(found.parts.values())) == (
        "FRAME",
        list("XYZABC"),
        pytest.approx(expected),
    )
    found = absolute_point(StructValue("E6AXIS", {"A2": -5}), AXES, frame)
    assert (found.type, list(found.parts.values())) == ("E6AXIS", [10.0, 15.0, 30.0, 40.0, 50.0, 60.0])
    with pytest.raises(ExecutionError, match="what is no structure"):
        absolute_point(3, NOW, frame)


@pytest.mark.slow
def test_pose_status_turn_to_axes_and_back_for_all_branches(arm):
    rng = np.random.default_rng(3)
    seen, worst = set(), 0.0
    for _ in range(60):
        q0 = rng.uniform(arm.lower, arm.upper)
        for q in all_branches(arm, lwr_dyn.forward_kinematics(arm, q0)[None]).q[0]:
            if np.isnan(q).any() or (q < arm.lower).any() or (q > arm.upper).any():
                continue
            pose = kuka_pose(arm, q)
            seen.add(pose.s)
            six = (pose.x_mm, pose.y_mm, pose.z_mm, pose.a_deg, pose.b_deg, pose.c_deg)
            place = ", ".join(f"{n} {v!r}" for n, v in zip("XYZABC", six, strict=True))
            run = run_of(arm, f"PTP {{{place}, S {pose.s}, T {pose.t}}}")
            back = run.executed[0].q
            worst = max(worst, np.abs(back - q).max())
            assert (status(arm, back), turn(back)) == (pose.s, pose.t)
            assert np.abs(kuka_pose(arm, back).matrix() - pose.matrix()).max() < METRES
    assert seen == set(range(8))
    assert worst < 1e-9


def test_base_and_tool_are_frames(arm):
    run = run_of(arm, "$TOOL = {X 10, Y 20, Z 150, A 0, B 90, C 0}", "$BASE = {X 700, Y -200, Z 900, A 30, B 0, C 0}",
               HOME, "PTP {X 300, Y 100, Z 400, A 20, B 100, C 10}")  # fmt: skip
    base, tool = KukaPose(700, -200, 900, 30, 0, 0).matrix(), KukaPose(10, 20, 150, 0, 90, 0).matrix()
    target = KukaPose(300, 100, 400, 20, 100, 10).matrix()
    T = lwr_dyn.forward_kinematics(arm, run.executed[-1].q)
    assert np.abs(T @ tool - base @ target).max() < METRES


def test_static_and_dynamic_torque_are_the_models(arm):
    run = run_of(arm, HOME, "PTP_REL {A2 30}", "WAIT SEC 1")
    model = lwr_dyn.dynamics_of(arm, engine="newton-euler")
    assert np.abs(run.static_torque - model.gravity_vector(run.motion.q)).max() < 1e-8
    tau = model.inverse_dynamics(run.motion.q, run.motion.dq, run.motion.ddq)
    assert np.abs(run.torque - tau).max() < 1e-8
    rest = run.motion.t > run.cycle_time - 0.9
    assert np.abs(run.torque[rest] - run.static_torque[rest]).max() < 1e-9


def test_every_statement_has_its_effect(arm):
    lines = ["INT i, n, t[3]", "REAL x", "DECL FRAME f", "BOOL b", HOME, "n = 0",
             "FOR i = 1 TO 9 STEP 3", "n = n + i", "ENDFOR",  # 12
             "WHILE n > 9", "n = n - 1", "ENDWHILE",  # 9
             "REPEAT", "n = n - 2", "UNTIL n < 4",  # 3
             "LOOP", "n = n + 1", "IF n >= 6 THEN", "EXIT", "ENDIF", "ENDLOOP",  # 6
             "SWITCH n", "CASE 1, 2", "n = 0", "CASE 6", "n = 7", "DEFAULT", "n = 0", "ENDSWITCH",  # 7
             "t[2] = 7 / 2", "x = -7 / 2", "n = n + t[2]", "n = n + x",  # 7 + 3 - 3
             "f = {X 10, Y 0, Z 0, A 90, B 0, C 0} : {X 5, Y 0, Z 0, A 0, B 0, C 0}", "n = n + f.Y",  # 12
             "b = (n == 12) AND NOT FALSE", "IF b THEN", "n = half(n)", "GOTO onward", "ENDIF", "n = 99",
             "onward:",  # 6
             "PTP_REL {A1 n}"]  # fmt: skip
    text = "\n".join(["DEF a( )", *lines[:4], "BAS(#VEL_PTP, 100)", *lines[4:], "END",
                      "DEFFCT INT half(x:IN)", "INT x", "RETURN x / 2", "ENDFCT", ""])  # fmt: skip
    program = parse_program(text, name="a")
    assert check_program(program, arm) == ()
    run = run_program(program, arm)
    assert np.degrees(run.executed[-1].q - START)[0] == pytest.approx(6.0, abs=1e-9)


def test_a_first_motion_to_where_the_arm_stands_starts_at_mastering_and_a_parameter_by_reference_comes_back(arm):
    run = run_of(arm, "PTP $AXIS_ACT", "PTP_REL {A1 10}")
    assert np.degrees(run.executed[0].q) == pytest.approx([0, -90, 90, 0, 0, 0], abs=1e-12)
    text = "DEF a( )\nINT n\nBAS(#VEL_PTP, 100)\n" + HOME + "\nn = 1\nb(n, n)\nPTP_REL {A1 n}\nEND\n"
    for mode, expected in (("OUT", 5.0), ("IN", 1.0)):
        run = run_program(parse_program(text + f"DEF b(k:{mode}, m:IN)\nINT k, m\nk = m + 4\nEND\n", name="a"), arm)
        assert np.degrees(run.executed[-1].q)[0] == pytest.approx(expected, abs=1e-9)
