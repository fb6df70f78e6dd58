"""What goes on beside a program: waits, triggers, interrupts, timers, signals, submits; one pass of an endless loop."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.krl.language.source import parse_text
from lwr_dyn.krl.project.program import program_of
from lwr_dyn.krl.running.cell import cell_of
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import ProgramError, check_program, run_program
from lwr_dyn.krl.running.running_program import ALIKE, EACH, PATIENCE, LoopWatch
from tests.krl.random_cells import faults_of
from tests.krl.short_programs import HOME, SPEEDS, cell, values_of
from tests.krl.short_programs import program_of as short_program

LIN, BACK = "LIN_REL {Y 400}", "LIN_REL {Y -400}"
"""0.2 m/s and 2.3 m/s^2: 2 s and a ramp of 0.2/2.3 s."""
RAMP = 0.2 / 2.3
SECONDS = 2 * (2 + RAMP)
ALARM = '[[reply]]\nafter_s = 1.0\nset = { "$IN[7]" = true }\n[inputs]\n7 = false'
ANSWER = '[[reply]]\nwhen = "$OUT[5]"\nafter_s = 0.4\nset = { "$IN[7]" = true }\n[inputs]\n7 = false'
ON_INPUT = ("INTERRUPT DECL 5 WHEN $IN[7] DO f( )", "INTERRUPT ON 5")
TIMER = ("$TIMER[1] = 0", "$TIMER_STOP[1] = FALSE")
DATA = "DEFDAT a\nDECL INT N=0\nENDDAT\n"


def run_of(arm, *lines, cell_text="", data=None):
    routine = "DEF f( )\n$OUT[9] = TRUE"
    return run_program(short_program(*SPEEDS, HOME, *lines, "END", routine, data=data), arm, cell=cell(cell_text))


def events(run):
    return [(x.kind, round(x.time, 6), x.text) for x in run.events]


@pytest.mark.parametrize(
    ("place", "time"),
    [
        ("DISTANCE = 0 DELAY = 20", 0.02),
        ("DISTANCE = 1 DELAY = -50", 2 + RAMP - 0.05),
        ("PATH = -100 DELAY = 0", 2 + RAMP - 0.5 - RAMP / 2),
        ("PATH = 100 ONSTART DELAY = 0", 0.5 + RAMP / 2),
    ],
)
def test_a_trigger_acts_at_its_place(arm, place, time):
    run = run_of(arm, f"TRIGGER WHEN {place} DO $OUT[4]=TRUE", LIN, "WAIT SEC 1")
    assert [x.kind for x in run.events] == ["trigger", "output"]
    assert [x.time for x in run.events] == pytest.approx([time] * 2, abs=2e-4)


def test_an_output_is_an_event_at_the_end_of_the_motion_before_and_a_trigger_stops_no_advance_run(arm):
    run = run_of(arm, LIN, "$OUT[3] = TRUE", "WAIT SEC 1")
    assert events(run) == [("output", round(2 + RAMP, 6), "$OUT[3] = TRUE")]
    lines, trigger = (
        ["LIN_REL {Y 200} C_DIS", "LIN_REL {Z 200}"],
        "TRIGGER WHEN DISTANCE = {} DELAY = 0 DO $OUT[4]=TRUE",
    )
    plain = run_of(arm, "$APO.CDIS = 50", *lines)
    run = run_of(arm, "$APO.CDIS = 50", trigger.format(1), *lines)
    assert run.cycle_time == pytest.approx(plain.cycle_time)
    # the end of a blended motion is the middle of its blend
    middle = plain.executed[1].end - 0.5 * plain.executed[2].overlap
    assert run.events[0].time == pytest.approx(middle, abs=1e-6)
    # found on public programs: on a motion to where the arm stands it waited for ever
    run = run_of(arm, HOME, trigger.format(0), HOME, "LIN_REL {X 50}", "LIN_REL {X -20}")
    (fired,) = [x for x in run.events if x.text == "$OUT[4] = TRUE"]
    assert fired.time == pytest.approx(run.executed[1].begin)


def test_an_answer_of_the_cell_ends_a_wait_and_without_one_the_run_stops_or_takes_it_as_met(arm):
    run = run_of(arm, LIN, "$OUT[5] = TRUE", "WAIT FOR $IN[7]", BACK, cell_text=ANSWER)
    kinds = [(x.kind, x.end - x.begin) for x in run.executed[2:]]
    assert kinds == [("WAIT FOR", pytest.approx(0.4)), ("LIN_REL", pytest.approx(2 + RAMP))]
    assert ("reply", round(2.4 + RAMP, 6), "$IN[7] = TRUE") in events(run)
    with pytest.raises(ProgramError, match="nothing here can change it"):
        run_of(arm, LIN, "WAIT FOR $IN[7]", cell_text="inputs.7 = false")
    # one whose condition holds from the start comes then, and not again
    at_once = ANSWER.replace("$OUT[5]", "NOT $OUT[5]")
    assert [x.time for x in run_of(arm, LIN, BACK, cell_text=at_once).events] == [0.4]
    for place, name in (("N", "N"), ("M.X", "M.X")):
        with pytest.raises(OptionError, match=rf"reply\[0\]\.set\.{name}: "):
            run_of(arm, LIN, cell_text=f"[[reply]]\nset = {{ '{place}' = true }}", data=DATA)
    # two that undo each other: within the program, and after its end
    toggle = "".join(
        f"[[reply]]\nwhen = '$OUT[8] AND {x}$FLAG[1]'\nset = {{ '$FLAG[1]' = {y} }}\n"
        for x, y in (("", "false"), ("NOT ", "true"))
    )
    for lines in (("$OUT[8] = TRUE", LIN), ("TRIGGER WHEN DISTANCE = 1 DELAY = 9 DO $OUT[8] = TRUE", LIN)):
        with pytest.raises(ProgramError, match="answers of the cell follow one another without end; an answer that"):
            run_of(arm, *lines, cell_text=toggle)
    run = run_of(arm, LIN, "WAIT FOR $IN[7]", cell_text="unmet_wait_s = 1.5\ninputs.7 = false")
    assert run.cycle_time == pytest.approx(3.5 + RAMP)
    assert [x.name for x in run.assumptions if "WAIT" in x.name] == ["WAIT FOR $IN[7]"]


def test_an_interrupt_comes_at_its_edge_once_and_resume_goes_back_to_where_it_was_declared(arm):
    run = run_of(arm, *ON_INPUT, LIN, BACK, cell_text=ALARM)
    found = [x for x in events(run) if x[0] in ("interrupt", "output")]
    assert found == [("interrupt", 1.0, "interrupt 5: $IN[7]"), ("output", 1.0, "$OUT[9] = TRUE")]
    for switch, count in (("OFF 5", 0), ("OFF", 0), ("DISABLE 5", 0), ("OFF 6", 1), ("ENABLE 5", 1)):
        run = run_of(arm, *ON_INPUT, f"INTERRUPT {switch}", LIN, BACK, cell_text=ALARM)
        assert len([x for x in events(run) if x[0] == "interrupt"]) == count
    # what its routine does after a wait comes at the end of that
    waits = (*ON_INPUT, LIN, "END", "DEF f( )", "WAIT SEC 0.5", "$OUT[9] = TRUE")
    late = run_program(short_program(*SPEEDS, HOME, *waits), arm, cell=cell(ALARM))
    assert events(late)[1:] == [found[0], ("output", round(2.5 + RAMP, 6), "$OUT[9] = TRUE")]
    main = ["INTERRUPT DECL 5 WHEN $FLAG[1] DO g( )", "INTERRUPT ON 5", "b( )", "N = N + 100", "END"]
    called = ["DEF b( )", "$FLAG[1] = TRUE", "N = N + 10", "END"]
    values, _ = values_of(arm, [*main, *called, "DEF g( )", "N = N + 1", "RESUME"], ["DECL INT N=0"])
    assert values["N"] == 101


STOPPING = "DEF h( )\nBRAKE\nWAIT SEC 3\nEND\nDEF k( )\nBRAKE\nRESUME\nEND\n"
STOPPING += "DEF l( )\nBRAKE\nLIN_REL {Z 9}\nEND\nDEF n( )\n$OUT[9] = TRUE\nEND\nDEF way( )\nLIN_REL {Y 400}\nEND\n"


def stopped_run(arm, name, word="", way=("way( )",)):
    """The tool's way on the timeline, and its executed motions: 1 s after the start the interrupt comes."""
    lines = [f"INTERRUPT {word} DECL 5 WHEN $IN[7] DO {name}( )", "INTERRUPT ON 5", *way, "WAIT SEC 1"]
    program = short_program(*SPEEDS, HOME, *lines, "END", STOPPING.removesuffix("END\n"))
    run = run_program(program, arm, cell=cell(ALARM))
    t = np.linspace(0.0, run.cycle_time, 400)
    motion = run.timeline.sample(t)
    return run, t, motion, lwr_dyn.forward_kinematics(arm, motion.q)[:, :3, 3]


def kinds_of(run):
    return [x.kind for x in run.executed]


def test_brake_stops_on_the_path_and_goes_on_along_it(arm):
    run, t, motion, places = stopped_run(arm, "h")
    assert kinds_of(run) == ["PTP (start)", "LIN_REL", "BRAKE", "WAIT", "LIN_REL", "WAIT"]
    away = places - places[0]
    assert np.abs(away[:, [0, 2]]).max() < 1e-9
    assert away[-1, 1] == pytest.approx(0.4, abs=1e-9)
    assert (np.diff(away[:, 1]) > -1e-12).all()
    cut, brake, wait = run.executed[1:4]
    # the row of the motion that is cut shows where the arm is then, and the later one where it ends
    np.testing.assert_allclose(cut.q, run.timeline.sample(np.array([cut.end])).q[0], atol=1e-9)
    np.testing.assert_allclose(run.executed[4].q, motion.q[-1], atol=1e-9)
    assert np.abs(motion.dq[(t > wait.begin) & (t < wait.end)]).max() < 1e-12
    # each ramp of the stop takes half its length longer than the motion alone
    assert run.cycle_time == pytest.approx(2 + RAMP + 3 + 1 + brake.end - brake.begin, abs=1e-9)
    # the speed that is sampled is the slope of the place
    t = np.linspace(brake.begin - 0.01, brake.end + 0.01, 2001)
    motion = run.timeline.sample(t)
    slope = np.diff(motion.q, axis=0) / np.diff(t)[:, None]
    assert np.abs(slope - 0.5 * (motion.dq[1:] + motion.dq[:-1])).max() < 1e-3 * np.abs(motion.dq).max()


def test_an_interrupt_with_brake_stops_by_itself_and_resume_gives_the_stopped_motion_up(arm):
    assert kinds_of(stopped_run(arm, "n", "WITH BRAKE")[0]) == ["PTP (start)", "LIN_REL", "BRAKE", "LIN_REL", "WAIT"]
    run, _, _, places = stopped_run(arm, "k")
    assert kinds_of(run) == ["PTP (start)", "LIN_REL", "BRAKE", "WAIT"]
    assert 0.18 < places[-1, 1] - places[0, 1] < 0.25
    with pytest.raises(ProgramError, match="the arm has left the path of the interrupted motion; RESUME, or a motion"):
        stopped_run(arm, "l")
    # where the arm stands there is nothing to stop, and the trigger keeps its motion
    way = ("WAIT SEC 2", "TRIGGER WHEN DISTANCE = 0 DELAY = 0 DO $OUT[4]=TRUE", LIN)
    run, *_ = stopped_run(arm, "h", way=way)
    assert kinds_of(run) == ["PTP (start)", "WAIT", "WAIT", "LIN_REL", "WAIT"]
    assert [x.time for x in run.events if x.kind == "trigger"] == [run.executed[3].begin]


def slow(*values):
    return [pytest.param(x, marks=pytest.mark.slow) for x in values]


@pytest.mark.parametrize("left", [207, 205, *slow(250, 150, 1)])
def test_a_trigger_acts_at_its_place_on_the_path_that_is_braked(arm, left):
    """BRAKE comes 191 mm along and stops the tool 3 mm later: before, while it stops, while it goes on, after."""
    way = (f"TRIGGER WHEN PATH = -{left} DELAY = 0 DO $OUT[4]=TRUE", "LIN_REL {Y 400}")
    run, _, _, places = stopped_run(arm, "h", way=way)
    (fired,) = [x for x in run.events if x.kind == "trigger"]
    q = run.timeline.sample(np.array([fired.time])).q[0]
    place = lwr_dyn.forward_kinematics(arm, q)[:3, 3]
    assert 1e3 * (place - places[0])[1] == pytest.approx(400 - left, abs=0.01)
    stop = next(x for x in run.executed if x.kind == "BRAKE")
    assert (fired.time > stop.end + 3) == (left < 206)


def test_triggers_of_a_stopped_motion_keep_their_delay_from_its_end_and_act_not_where_resume_gives_it_up(arm):
    way = [f"TRIGGER WHEN DISTANCE = 1 DELAY = {x} DO $OUT[{i}]=TRUE" for i, x in ((1, -80), (2, 0), (3, 70))]
    run, *_ = stopped_run(arm, "h", way=(*way, LIN))
    end = [x for x in run.executed if x.kind == "LIN_REL"][-1].end
    assert [x.time - end for x in run.events if x.kind == "trigger"] == pytest.approx([-0.08, 0.0, 0.07], abs=1e-9)
    way = [f"TRIGGER WHEN {x} DELAY = 0 DO $OUT[4]=TRUE" for x in ("PATH = -300", "PATH = -100", "DISTANCE = 1")]
    run, *_ = stopped_run(arm, "k", way=(*way, LIN))
    assert [x.text for x in run.events if x.kind == "trigger"] == ["TRIGGER PATH = -300, 0 ms"]


TWICE = [
    *SPEEDS, HOME, "INTERRUPT DECL 5 WHEN $IN[7] DO h( )", "INTERRUPT ON 5",
    "TRIGGER WHEN PATH = -120 DELAY = 0 DO $OUT[4]=TRUE", LIN, "WAIT SEC 1", "END", "DEF h( )", "BRAKE", "WAIT SEC 0.5",
]  # fmt: skip


@pytest.mark.parametrize("second", [1.53, 1.56, 1.8, 2.4])
def test_brake_stops_a_motion_that_goes_on_after_brake(arm, second):
    """The first one at 1 s; the second one while the arm gets up to speed, and later."""
    times = ((1.0, True), (1.1, False), (second, True), (second + 0.1, False))
    replies = [{"after_s": t, "set": {"$IN[7]": on}} for t, on in times]
    run = run_program(short_program(*TWICE), arm, cell=cell_of({"inputs": {"7": False}, "reply": replies}))
    stop = ["LIN_REL", "BRAKE", "WAIT"]
    assert kinds_of(run) == ["PTP (start)", *stop, *stop, "LIN_REL", "WAIT"]
    t = np.linspace(0.0, run.duration, 3000)
    motion = run.timeline.sample(t)
    start = lwr_dyn.forward_kinematics(arm, run.motion.q[0])[:3, 3]
    away = lwr_dyn.forward_kinematics(arm, motion.q)[:, :3, 3] - start
    assert np.abs(away[:, [0, 2]]).max() < 1e-9
    assert (np.diff(away[:, 1]) > -1e-12).all()
    assert away[-1, 1] == pytest.approx(0.4, abs=1e-9)
    for x in (x for x in run.executed if x.kind == "WAIT"):
        assert np.abs(motion.dq[(t > x.begin) & (t < x.end)]).max() < 1e-12
    slope = np.diff(motion.q, axis=0) / np.diff(t)[:, None]
    assert np.abs(slope - 0.5 * (motion.dq[1:] + motion.dq[:-1])).max() < 0.05 * np.abs(motion.dq).max()
    (fired,) = [x for x in run.events if x.kind == "trigger"]
    place = lwr_dyn.forward_kinematics(arm, run.timeline.sample(np.array([fired.time])).q[0])[:3, 3]
    assert 1e3 * (place - start)[1] == pytest.approx(280, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 5, 8, 22, 27, 33, 1211])
def test_random_programs_keep_the_laws(arm, seed):
    """scripts/soak.py krl_cells tries more."""
    assert faults_of(arm, seed) == []


def test_timers_count_the_time_of_the_model_and_signals_are_inputs_and_outputs(arm):
    run = run_of(arm, *TIMER, LIN, "N = $TIMER[1]", "WAIT SEC N / 1000.0", data=DATA)
    assert run.cycle_time == pytest.approx(2 * (2 + RAMP), abs=1e-3)
    names = ["SIGNAL GRIP $OUT[3]", "SIGNAL READY $IN[8]", "SIGNAL CODE $OUT[11] TO $OUT[14]"]
    lines = ["GRIP = TRUE", "A = $OUT[3]", "B = READY", "CODE = 5", "N = CODE"]
    lines.append("A = A AND $OUT[11] AND NOT $OUT[12] AND $OUT[13]")
    values, _ = values_of(arm, lines, [*names, "DECL BOOL A,B", "DECL INT N"], cell("inputs.8 = true"))
    assert (values["A"], values["B"], values["N"]) == (True, True, 5)


def test_a_submit_program_answers_an_output(arm):
    """A pass in each interpolation cycle, through what it calls, up to a WAIT, after which the next pass goes on."""
    source = parse_text(f"DEF a( )\n{HOME}\n$OUT[1] = TRUE\nWAIT FOR $FLAG[2]\nPTP {{A1 5}}\nEND\n", "a.src")[0]
    answer = "IF $OUT[1] THEN\n$FLAG[2] = TRUE\nENDIF"

    def program(lines):
        text = f"DEF sps( )\nLOOP\nhelper( )\n{lines}\nENDLOOP\nEND\nDEF helper( )\nHALT\nEND\n"
        return program_of(source, None, [parse_text(text, "sps.sub")[0]])

    for lines, passes in ((answer, 1), (f"WAIT SEC 9\n{answer}", 2), ("WAIT FOR $OUT[1]\n$FLAG[2] = TRUE", 2)):
        last = run_program(program(lines), arm, cell=cell('submits = ["sps.sub"]')).executed[-1]
        assert (last.kind, last.begin) == ("PTP", pytest.approx(passes * 0.012))
    with pytest.raises(ProgramError, match="nothing here can change it"):
        run_program(program(answer), arm)
    with pytest.raises(OptionError, match=r"submits of the cell: other\.sub is not among the files"):
        run_program(program(answer), arm, cell=cell('submits = ["here/other.sub"]'))
    faults = {"PTP {A1 5}": "a submit program moves the robot", "WAIT FOR $IN[7]": "the input $IN[7] has no value"}
    for line, words in faults.items():
        with pytest.raises(ProgramError) as fault:
            run_program(program(answer.replace("$FLAG[2] = TRUE", line)), arm, cell=cell('submits = ["sps.sub"]'))
        assert str(fault.value).startswith(f"sps.sub:5:1: {words}; ")


def program(*lines):
    return short_program(*SPEEDS, HOME, *lines, data=DATA)


def turn(*lines):
    return ["LOOP", *lines, "ENDLOOP"]


def pallet(places):
    """The last place takes 10 s longer: three like passes before it are not the cycle."""
    return turn("N = N + 1", "WAIT SEC 1", f"IF N == {places} THEN", "N = 0", "WAIT SEC 10", "ENDIF")


WATCH = ("IF $TIMER[1] > 2500 THEN", "WAIT SEC 2", "$TIMER[1] = 0", "ENDIF")
PASSES = {
    "loop": (turn(LIN, BACK), 1, SECONDS),
    "while": (["WHILE TRUE", LIN, BACK, "ENDWHILE"], 1, SECONDS),
    "repeat": (["REPEAT", LIN, BACK, "UNTIL FALSE"], 1, SECONDS),
    "goto": (["X:", LIN, BACK, "GOTO X"], 1, SECONDS),
    "turns": (turn("N = 1 - N", "IF N == 1 THEN", LIN, BACK, "ENDIF", "WAIT SEC 1"), 2, SECONDS / 2 + 1),
    **{f"pallet of {n}": (pallet(n), n, 1 + 10 / n) for n in (4, 20, 32)},
    "a timer decides: 1 s, and 2 s more each 2.5 s": ([*TIMER, *turn("WAIT SEC 1", *WATCH)], 3, 5 / 3),
    "a timer is read": ([*TIMER, *turn("WAIT SEC 1", "N = $TIMER[1]")], 0, 1.0),
}


@pytest.mark.parametrize(("loop", "period", "seconds"), PASSES.values(), ids=PASSES)
def test_one_pass_of_an_endless_loop_is_found_and_the_run_ends(arm, loop, period, seconds):
    run = run_program(program("PTP_REL {A1 10}", *loop), arm)
    assert (run.passes.period, run.passes.cycle_time) == (period, pytest.approx(seconds))
    assert [d.code for d in run.diagnostics] == ["endless"]
    assert period != 1 or len(run.executed) < 10


@pytest.mark.slow
def test_a_counter_does_not_hide_that_passes_are_alike(arm):
    passes = run_program(program(*turn("N = N + 1", LIN, BACK)), arm).passes
    assert (passes.period, len(passes.seconds), passes.cycle_time) == (0, 65, pytest.approx(SECONDS))
    assert "later passes may differ" in str(passes)


@pytest.mark.parametrize(
    ("count", "first", "place", "alike"),
    [(PATIENCE, 1.0, "a", True), (PATIENCE - 1, 1.0, "a", False), (PATIENCE, 2.0, "b", PATIENCE > ALIKE)],
)
def test_passes_are_alike_where_the_last_ones_are(count, first, place, alike):
    watch = LoopWatch(0.0, None)
    watch.seconds, watch.places = [*[1.0] * 9, first, *[1.0] * (count - 10)], [*"a" * 9, place, *"a" * (count - 10)]
    assert watch.alike() is alike
    for changed in ([*watch.seconds[:-1], 2.0], watch.places), (watch.seconds, [*watch.places[:-1], "c"]):
        other = LoopWatch(0.0, None)
        other.seconds, other.places = changed
        assert not other.alike()
    ended = LoopWatch(0.0, None)
    for now, where in ((1.5, "a"), (1.5, "b"), (4.0, "c")):
        ended.end_pass(now, where)
    assert (ended.count, ended.seconds, ended.places, ended.began) == (3, [1.5, 2.5], ["a", "c"], 4.0)
    compared = [n for n in range(1, 100) if replace(ended, count=n).compares]
    assert compared == [*range(1, EACH), *(n for n in range(EACH, 100) if n % 16 == 0)]
    assert [n for n in range(1, 100) if replace(ended, count=n).keeps] == [1, 2, 4, 8, 16, 32, 64]


def test_passes_that_differ_are_counted_up_to_the_bound_and_a_loop_with_a_way_out_to_its_end(arm):
    run = run_program(program(*turn("N = N + 1", "WAIT SEC N")), arm, MachineData(passes=12))
    assert (len(run.passes.seconds), "from 2.000 to 13.000 s" in str(run.passes)) == (12, True)
    run = run_program(program(*turn("N = N + 1", LIN, BACK, "IF N == 6 THEN", "EXIT", "ENDIF")), arm)
    assert (run.passes, run.cycle_time) == (None, pytest.approx(6 * SECONDS))


def test_a_loop_that_only_watches_is_named_and_ends_the_run(arm):
    run = run_program(program("PTP_REL {A1 10}", *turn("IF $FLAG[3] THEN", LIN, BACK, "ENDIF")), arm)
    assert [(d.severity, d.code) for d in run.diagnostics] == [("warning", "endless")]
    empty = short_program(*turn())
    with pytest.raises(ProgramError, match="goes round without motion") as fault:
        run_program(empty, arm)
    assert [fault.value.code, *(d.code for d in check_program(empty, arm))] == ["endless", "endless"]
    # one that watches a timer ends with it, and a long computation is none
    run = run_program(program(*TIMER, "REPEAT", "N = 1", "UNTIL $TIMER[1] > 500", "PTP_REL {A1 10}"), arm)
    assert (run.passes, run.executed[-2].kind) == (None, "watching loop")
    assert run.executed[-1].begin == pytest.approx(0.5, abs=0.03)
    count = ["FOR N = 1 TO 3000", "$FILTER = N / 2", "ENDFOR", "WHILE N > 5", "N = N - 5", "ENDWHILE"]
    assert run_program(program(*count, "PTP_REL {A1 10}"), arm).executed[-1].kind == "PTP_REL"
    # a wait counts before the arm stands anywhere
    endless = short_program("REPEAT", "WAIT SEC 1", "$FILTER = $FILTER + 1", "UNTIL FALSE")
    notes = check_program(endless, arm, MachineData(seconds=20.0))
    assert [d.message for d in notes] == ["stopped here after 20 s of simulated time"]


def test_the_command_prints_the_pass(printed, recorded, folder):
    lines = ["DEF a( )", HOME, "LOOP", LIN, BACK, "$OUT[1] = TRUE", "ENDLOOP", "END", ""]
    (folder / "a.src").write_text("\n".join(lines))
    record = recorded("krl", "run", "a.src")
    assert (record["passes"]["period"], record["events"][0]["text"]) == (1, "$OUT[1] = TRUE")
    assert "s a pass, for ever" in printed("krl", "run", "a.src")


def test_a_fault_in_a_trigger_after_the_end_of_the_program_is_a_diagnosis(arm):
    late = short_program(*SPEEDS, HOME, "TRIGGER WHEN DISTANCE = 1 DELAY = 500 DO NONAME=TRUE", LIN)
    assert [(x.code, x.position.line) for x in check_program(late, arm)] == [("undeclared", 5)]
    with pytest.raises(ProgramError, match="NONAME is not declared"):
        run_program(late, arm)
