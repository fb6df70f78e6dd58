"""WITH: its assignments hold for one motion, and a value for axis 1 alone counts for all axes."""

import math

import pytest

from tests.krl.short_programs import HOME, run_of


def seconds(run):
    return [x.end - x.begin for x in run.executed[1:]]


def test_with_holds_for_its_motion_alone(arm):
    run = run_of(arm, HOME, "SLIN_REL {Y 100} WITH $VEL.CP = 0.1", "LIN_REL {Y -100}", "LIN_REL {Y 100}")
    slow, plain, again = seconds(run)
    assert slow == pytest.approx(0.1 / 0.1 + 0.1 / 2.3, abs=1e-9)
    assert [plain, again] == pytest.approx([0.1 / 0.2 + 0.2 / 2.3] * 2, abs=1e-9)


def test_a_blend_distance_after_with_is_that_of_its_motion(arm):
    lines = ("SLIN_REL {Y 100} WITH $APO.CDIS = 20 C_SPL", "SLIN_REL {Z 50} C_SPL", "SLIN_REL {Y 50}")
    run = run_of(arm, HOME, *lines)
    assert [x.overlap > 0.0 for x in run.executed[1:]] == [False, True, False]


def test_the_speed_of_axis_1_counts_for_all_axes_and_is_taken_back(arm):
    run = run_of(arm, HOME, "SPTP_REL {A6 90} WITH $VEL_AXIS[1] = 50", "PTP_REL {A6 -90}", "PTP_REL {A1 20, A6 90}")
    half, full, _ = seconds(run)
    rated = math.degrees(arm.velocity[5])
    assert half == pytest.approx(90 / (0.5 * rated) + 0.2, abs=1e-6)
    assert full == pytest.approx(2 * math.sqrt(90 * 0.4 / rated), abs=1e-6)


def test_with_of_one_motion_is_no_speed_for_the_next(arm):
    from lwr_dyn.krl.project.program import parse_program
    from lwr_dyn.krl.running.program_run import run_program

    text = "\n".join(["DEF a( )", HOME, "SLIN_REL {Y 50} WITH $VEL.CP = 0.1", "LIN_REL {Y 50}", "END", ""])
    run = run_program(parse_program(text, name="a"), arm)
    warned = [(d.position.line, d.code) for d in run.diagnostics if "before the first LIN" in d.message]
    assert warned == [(4, "no-velocity")]
