"""Broken programs end in a diagnosis or a program, never in another exception, never in a hang."""

import os
import random
import time

import lwr_dyn
from lwr_dyn.krl.diagnostics import Diagnostic
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import check_program
from tests.krl.mutations import SOURCES, mutated

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
