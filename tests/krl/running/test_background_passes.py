"""Endless loops: one pass is found where the state comes back; a loop that only watches is named."""

import pytest

from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import ProgramError, check_program, run_program
from tests.krl.short_programs import HOME

PASS = ["LIN_REL {Y 400}", "LIN_REL {Y -400}"]
SECONDS = 2 * (2 + 0.2 / 2.3)


def program(*lines, data=("DECL INT N=0",)):
    source = "\n".join(["DEF a( )", "BAS(#VEL_PTP, 100)", "$VEL.CP = 0.2", HOME, *lines, "END", ""])
    return parse_program(source, "\n".join(["DEFDAT a", *data, "ENDDAT", ""]), name="a")


@pytest.mark.parametrize(
    "loop",
    [
        ["LOOP", *PASS, "ENDLOOP"],
        ["WHILE TRUE", *PASS, "ENDWHILE"],
        ["REPEAT", *PASS, "UNTIL FALSE"],
        ["X:", *PASS, "GOTO X"],
    ],
)
def test_one_pass_is_found_and_the_run_ends(arm, loop):
    run = run_program(program("PTP_REL {A1 10}", *loop), arm)
    assert run.passes.period == 1
    assert run.passes.cycle_time == pytest.approx(SECONDS)
    assert [d.code for d in run.diagnostics] == ["endless"]
    assert len(run.executed) < 10


def test_passes_that_take_turns_are_found(arm):
    loop = ["LOOP", "N = 1 - N", "IF N == 1 THEN", *PASS, "ENDIF", "WAIT SEC 1", "ENDLOOP"]
    run = run_program(program(*loop), arm)
    assert run.passes.period == 2
    assert run.passes.cycle_time == pytest.approx(SECONDS / 2 + 1)


@pytest.mark.slow
def test_a_counter_does_not_hide_that_passes_are_alike(arm):
    run = run_program(program("LOOP", "N = N + 1", *PASS, "ENDLOOP"), arm)
    assert (run.passes.period, len(run.passes.seconds)) == (0, 65)
    assert run.passes.cycle_time == pytest.approx(SECONDS)
    assert "later passes may differ" in str(run.passes)


@pytest.mark.parametrize("places", [4, 20, 32])
def test_a_pallet_is_counted_to_its_end(arm, places):
    """The last place takes 10 s longer: three like passes before it are not the cycle."""
    loop = ["LOOP", "N = N + 1", "WAIT SEC 1", f"IF N == {places} THEN", "N = 0", "WAIT SEC 10", "ENDIF", "ENDLOOP"]
    run = run_program(program(*loop), arm)
    assert run.passes.period == places
    assert run.passes.cycle_time == pytest.approx(1 + 10 / places)


def test_a_loop_with_a_way_out_runs_to_its_end(arm):
    run = run_program(program("LOOP", "N = N + 1", *PASS, "IF N == 6 THEN", "EXIT", "ENDIF", "ENDLOOP"), arm)
    assert run.passes is None
    assert run.cycle_time == pytest.approx(6 * SECONDS)


def test_passes_that_differ_are_counted_up_to_the_bound(arm):
    run = run_program(program("LOOP", "N = N + 1", "WAIT SEC N", "ENDLOOP"), arm, MachineData(passes=12))
    assert len(run.passes.seconds) == 12
    assert "from 2.000 to 13.000 s" in str(run.passes)


def test_a_loop_that_only_watches_is_named_and_ends_the_run(arm):
    loop = ["LOOP", "IF $FLAG[3] THEN", *PASS, "ENDIF", "ENDLOOP"]
    run = run_program(program("PTP_REL {A1 10}", *loop), arm)
    assert [(d.severity, d.code) for d in run.diagnostics] == [("warning", "endless")]
    empty = parse_program("DEF a( )\nLOOP\nENDLOOP\nEND\n", name="a")
    with pytest.raises(ProgramError, match="goes round without motion") as fault:
        run_program(empty, arm)
    assert fault.value.code == "endless"
    assert [d.code for d in check_program(empty, arm)] == ["endless"]


def test_a_loop_that_watches_a_timer_ends_with_it(arm):
    lines = ["$TIMER[1] = 0", "$TIMER_STOP[1] = FALSE", "REPEAT", "N = 1", "UNTIL $TIMER[1] > 500", "PTP_REL {A1 10}"]
    run = run_program(program(*lines), arm)
    assert run.passes is None
    assert run.executed[-2].kind == "watching loop"
    assert run.executed[-1].begin == pytest.approx(0.5, abs=0.03)


def test_a_timer_that_decides_is_part_of_the_state(arm):
    """A pass of 1 s, and 2 s more each time 2.5 s have gone by: three passes in turn, of 5 s."""
    watch = ["IF $TIMER[1] > 2500 THEN", "WAIT SEC 2", "$TIMER[1] = 0", "ENDIF"]
    start = ["$TIMER[1] = 0", "$TIMER_STOP[1] = FALSE"]
    run = run_program(program(*start, "LOOP", "WAIT SEC 1", *watch, "ENDLOOP"), arm)
    assert (run.passes.period, run.passes.cycle_time) == (3, pytest.approx(5 / 3))
    run = run_program(program(*start, "LOOP", "WAIT SEC 1", "N = $TIMER[1]", "ENDLOOP"), arm)
    assert run.passes.period == 0


def test_a_wait_before_the_arm_stands_anywhere_counts(arm):
    endless = parse_program("DEF a( )\nREPEAT\nWAIT SEC 1\n$FILTER = $FILTER + 1\nUNTIL FALSE\nEND\n", name="a")
    notes = check_program(endless, arm, MachineData(seconds=20.0))
    assert [d.message for d in notes] == ["stopped here after 20 s of simulated time"]


def test_a_long_computation_is_not_taken_for_an_endless_loop(arm):
    lines = [
        "FOR N = 1 TO 3000",
        "$FILTER = N / 2",
        "ENDFOR",
        "WHILE N > 5",
        "N = N - 5",
        "ENDWHILE",
        "PTP_REL {A1 10}",
    ]
    assert run_program(program(*lines), arm).executed[-1].kind == "PTP_REL"


def test_the_command_prints_the_pass(printed, recorded, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.src").write_text(
        "\n".join(["DEF a( )", HOME, "LOOP", *PASS, "$OUT[1] = TRUE", "ENDLOOP", "END", ""])
    )
    record = recorded("krl", "run", "a.src")
    assert record["passes"]["period"] == 1
    assert record["events"][0]["text"] == "$OUT[1] = TRUE"
    assert "s a pass, for ever" in printed("krl", "run", "a.src")
