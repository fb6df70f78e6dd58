"""Interrupts and answers on what moves: the times at which they are due, computed by hand."""

import math

import numpy as np
import pytest

import lwr_dyn
from tests.krl.running.test_background import ALARM, BACK, LIN, RAMP, TIMER, events, kinds_of, run_of

END = 2 + RAMP
"""[s] Of the motion of 400 mm."""
IN_RAMP = math.sqrt(2 * 0.001 / 2.3)
"""[s] Of the first and of the last millimetre."""


def at(mm):
    """[s] When the tool has gone so far, beyond the ramp and before the next."""
    return mm / 200 + RAMP / 2


def interrupts(arm, condition, *lines, before=(), action="f( )", cell_text=""):
    declared = (f"INTERRUPT DECL 5 WHEN {condition} DO {action}", *before, "INTERRUPT ON 5")
    run = run_of(arm, *declared, *lines, cell_text=cell_text)
    return [x.time for x in run.events if x.kind == "interrupt"], run


@pytest.mark.parametrize(
    ("condition", "lines", "times"),
    [
        ("$TIMER[1] >= 100", (LIN,), [0.1]),
        ("$TIMER[1] >= 700", (LIN,), [0.7]),
        ("$TIMER[1] > 700", (LIN,), [0.701]),
        ("700 <= $TIMER[1]", (LIN,), [0.7]),
        ("$TIMER[1] >= 2500", (LIN, "WAIT SEC 1"), [2.5]),
        ("$TIMER[1] >= 2500", (LIN, "WAIT SEC 0.2"), []),
        ("$TIMER[1] >= 300", (LIN, "$TIMER[1] = 0", BACK), [0.3, END + 0.3]),
        ("($TIMER[1] >= 300) AND ($TIMER[1] < 400)", (LIN,), [0.3]),
        ("$POS_ACT.Y > 1", (LIN,), [IN_RAMP]),
        ("$POS_ACT.Y > 100", (LIN,), [at(100)]),
        ("$POS_ACT.Y > 300", (LIN, BACK), [at(300)]),
        ("$POS_ACT.Y > 399", (LIN,), [END - IN_RAMP]),
        ("$POS_ACT.Y > 401", (LIN,), []),
        ("NOT ($POS_ACT.Y > 300)", (LIN, BACK), [END + at(100)]),
        ("$POS_ACT.Y > 100", (LIN, BACK, LIN), [at(100), 2 * END + at(100)]),
        ("$POS_ACT.Y > 100", ("$BASE = {X 0, Y 50, Z 0, A 0, B 0, C 0}", LIN), [at(150)]),
        ("$POS_ACT.Y > 100", (f"{LIN} C_DIS", "LIN_REL {X 100}"), [at(100)]),
        ("($POS_ACT.Y > 100) AND $IN[7]", (LIN,), [1.0]),
        ("($TIMER[1] >= 300) OR ($POS_ACT.Y > 200)", (LIN,), [0.3]),
        ("$POS_ACT.Y > 100", ("WAIT SEC 0.25", LIN), [0.25 + at(100)]),
    ],
)
def test_an_interrupt_comes_when_it_is_due(arm, condition, lines, times):
    found, _ = interrupts(arm, condition, *lines, before=TIMER, cell_text=ALARM)
    assert found == pytest.approx(times, abs=1e-6)


def test_an_interrupt_of_an_axis_of_a_timer_below_zero_and_of_none_before_it_is_switched_on(arm):
    speed = arm.velocity[0]  # which an axis has after 0.4 s
    (first,), _ = interrupts(arm, "$AXIS_ACT.A1 < -1", "PTP {A1 -30}")
    assert first == pytest.approx(math.sqrt(2 * np.radians(1) / (speed / 0.4)), abs=1e-6)
    (middle,), run = interrupts(arm, "$AXIS_ACT.A1 < -15", "PTP {A1 -30}")
    assert middle == pytest.approx(run.cycle_time / 2, abs=1e-6)
    found, _ = interrupts(arm, "$TIMER_FLAG[1]", LIN, before=("$TIMER[1] = -250", TIMER[1]))
    assert found == pytest.approx([0.25], abs=1e-6)
    # the motion before may still pass into the next one, so it is looked at later
    declared = "INTERRUPT DECL 5 WHEN $POS_ACT.Y > 100 DO f( )"
    assert run_of(arm, declared, f"{LIN} C_DIS", "INTERRUPT ON 5", "LIN_REL {X 100}").events == ()


def test_what_interrupts_sees_where_the_arm_is_and_brake_stops_it_there(arm):
    _, run = interrupts(arm, "$POS_ACT.Y > 100", LIN, action="$ANOUT[1] = $POS_ACT.Y / 1000")
    (text,) = [x.text for x in run.events if x.kind == "output"]
    assert float(text.removeprefix("$ANOUT[1] = ")) == pytest.approx(0.1, abs=1e-6)
    routine = "INTERRUPT WITH BRAKE DECL 5 WHEN $POS_ACT.Y > 100 DO f( )"
    run = run_of(arm, routine, "INTERRUPT ON 5", LIN, "WAIT SEC 1")
    assert kinds_of(run) == ["PTP (start)", "LIN_REL", "BRAKE", "LIN_REL", "WAIT"]
    assert run.executed[1].end == pytest.approx(at(100), abs=1e-6)
    start, there = lwr_dyn.forward_kinematics(arm, np.array([run.executed[0].q, run.executed[1].q]))[:, 1, 3]
    assert 1e3 * (there - start) == pytest.approx(100, abs=1e-3)


def test_an_answer_waits_for_the_arm_and_two_interrupts_come_in_their_order(arm):
    cell_text = '[[reply]]\nwhen = "$POS_ACT.Y > 50"\nafter_s = 0.1\nset = { "$IN[7]" = true }\n[inputs]\n7 = false'
    other = ("INTERRUPT DECL 4 WHEN $POS_ACT.Y > 200 DO f( )", "INTERRUPT ON 4")
    run = run_of(
        arm, "INTERRUPT DECL 5 WHEN $POS_ACT.Y > 100 DO f( )", "INTERRUPT ON 5", *other, LIN, cell_text=cell_text
    )
    found = [(kind, time) for kind, time, _ in events(run) if kind != "output"]
    expected = [("reply", at(50) + 0.1), ("interrupt", at(100)), ("interrupt", at(200))]
    assert [x[0] for x in found] == [x[0] for x in expected]
    assert [x[1] for x in found] == pytest.approx([x[1] for x in expected], abs=1e-6)
