"""Broken programs end in a diagnosis or a program, never in another exception, never in a hang."""

import os
import random
import time

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.krl.diagnostics import Diagnostic, SourcePosition
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.motions import ExecutedMotion
from lwr_dyn.krl.running.program_run import ProgramError, check_program, overspeed, run_program
from lwr_dyn.model.run import Motion
from tests.krl.mutations import SOURCES, mutated
from tests.krl.short_programs import HOME, program_of

COUNT = int(os.environ.get("LWR_DYN_KRL_FUZZ", "400"))
"""The full 100 000 are in scripts/soak.py."""
PATIENCE = 20.0
"""[s] A hang is longer than this; the bounds below end a program long before."""
BOUNDS = MachineData(steps=2000, motions=25)


def test_the_bounds_that_are_given_are_those_of_the_check():
    program = parse_program("DEF a( )\nDECL INT n\nFOR n = 1 TO 3000\nENDFOR\nEND\n", name="a")
    arm = lwr_dyn.load("kr30ha")
    assert check_program(program, arm) == ()
    (found,) = check_program(program, arm, BOUNDS)
    assert "2000" in str(found)


def test_a_motion_in_which_an_axis_is_over_its_speed_is_an_error_at_its_line(arm):
    t, dq = np.arange(5.0), np.zeros((5, 6))
    dq[1, 2], dq[3, 4], dq[4, 4] = -1.5 * arm.velocity[2], (1 + 9e-7) * arm.velocity[4], (1 + 2e-6) * arm.velocity[4]
    spans = ((0.0, 0.5), (0.6, 0.9), (1.0, 1.0), (2.0, 3.0), (3.5, 4.0))
    executed = [
        ExecutedMotion(SourcePosition("a.src", i), "LIN", *span, dq[0], np.eye(4)) for i, span in enumerate(spans, 1)
    ]
    found = overspeed(arm, Motion(t, 0 * dq, dq, 0 * dq), executed)
    assert [str(d).partition(" (")[0] for d in found] == [
        "a.src:3:1: error axis-speed: A3 turns at 150 % of its speed",
        "a.src:5:1: error axis-speed: A5 turns at 100 % of its speed",
    ]


def test_a_program_that_moves_nothing_is_refused_and_one_that_waits_too_long_at_its_end_is_cut(arm):
    with pytest.raises(ProgramError, match=r"^a\.src:2:1: the program moves nothing; a program with a PTP") as fault:
        run_program(program_of("WAIT SEC 1"), arm)
    assert fault.value.code == "no-motion"
    for seconds, cut in ((4.9, ["stopped here after 4.9 s of simulated time"]), (5.0, [])):
        run = run_program(program_of("BAS(#VEL_PTP, 1)", HOME, "WAIT SEC 5"), arm, MachineData(seconds=seconds))
        assert ([d.message for d in run.diagnostics], run.cycle_time) == (cut, None if cut else 5.0)
        assert (run.duration, str(run.cut or "")[:13]) == (seconds, "a.src:4:1: no" if cut else "")


def test_a_subprogram_that_is_not_modelled_is_noted_once(arm):
    lines = ("BAS(#VEL_PTP, 1)", HOME, "ERR_RAISE($ERR)", "IR_STOPM()", "ERR_RAISE($ERR)")
    found = [d for d in run_program(program_of(*lines), arm).diagnostics if d.code == "not-modelled"]
    assert [str(d) for d in found] == ["a.src:4:1: note not-modelled: ERR_RAISE is not carried out"]


def test_mutated_programs_are_diagnosed(arm):
    rng = random.Random(20240521)
    seeds = [
        (path.read_bytes(), dat.read_bytes() if (dat := path.with_suffix(".dat")).exists() else None)
        for path in SOURCES
    ]
    faulty = 0
    for i in range(COUNT):
        source, data = seeds[i % len(seeds)]
        if data is not None and rng.random() < 0.3:
            data = mutated(data, rng)
        source = mutated(source, rng)
        start = time.perf_counter()
        try:
            program = parse_program(source, data, "fuzz")
            assert program.source.to_bytes() == source
            # every fifth is also moved
            diagnostics = check_program(program, arm if i % 5 == 0 else None, BOUNDS, {"$IN[1]": True})
        except Exception as fault:
            raise AssertionError(f"input {i}: {source!r}, {data!r}") from fault
        assert time.perf_counter() - start < PATIENCE, source
        assert all(isinstance(d, Diagnostic) and d.message and d.position.line >= 1 for d in diagnostics)
        faulty += bool(diagnostics)
    assert faulty > COUNT / 2
