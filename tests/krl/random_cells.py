"""Random programs with what goes on beside them: triggers, interrupts with BRAKE and RESUME, answers, waits, loops."""

import random
from itertools import pairwise

import numpy as np

from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.background import LONGEST_TAIL
from lwr_dyn.krl.running.cell import cell_of
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import ProgramError, run_program
from tests.krl.short_programs import HOME

MACHINE = MachineData(seconds=60.0, motions=80, steps=4000)
FAULTS = {
    "interrupted-motion",
    "endless",
    "waits-forever",
    "axis-speed",
    "singularity",
    "out-of-reach",
    "outside-limits",
}
"""Errors that such a program may rightly end with."""


def program_text(rng: random.Random) -> str:
    """A program of motions within reach, with statements that look at inputs and flags."""
    lines = ["DEF a( )", "BAS(#VEL_PTP, 60)", "$VEL.CP = 0.4", "$APO.CDIS = 20", "$APO.CPTP = 30"]
    lines += [f"INTERRUPT DECL {i} WHEN {rng.choice(['$IN[7]', '$FLAG[2]', '$OUT[3]'])} DO i{i}( )" for i in (1, 2)]
    lines += [f"INTERRUPT ON {rng.choice(['', '1', '2'])}", HOME, rng.choice(["way( )", "LOOP", "FOR N = 1 TO 3"])]
    end = {"LOOP": "ENDLOOP", "FOR N = 1 TO 3": "ENDFOR"}.get(lines[-1], "")
    lines += [statement(rng) for _ in range(rng.randint(2, 9))] + [end, "END"]
    for i in (1, 2):
        body = [
            rng.choice(["BRAKE", "BRAKE F", ""]),
            "$OUT[9] = TRUE",
            rng.choice(["WAIT SEC 0.2", "$FLAG[2] = FALSE"]),
        ]
        lines += [f"DEF i{i}( )", *body, rng.choice(["RESUME", "", ""]), "END"]
    lines += ["DEF way( )", *(statement(rng) for _ in range(3)), "END", ""]
    return "\n".join(lines)


def statement(rng: random.Random) -> str:
    """One statement."""
    blend, n, place = rng.choice(["", " C_DIS"]), rng.randint(2, 3), rng.choice(["DISTANCE = 0", "DISTANCE = 1"])
    return rng.choice([
        f"LIN_REL {{Y {rng.randint(-150, 150)}, Z {rng.randint(-60, 60)}}}{blend}",
        f"PTP_REL {{A1 {rng.randint(-20, 20)}, A5 {rng.randint(-5, 5)}}}" + (" C_PTP" if blend else ""),
        f"TRIGGER WHEN {place} DELAY = {rng.randint(-100, 100)} DO $OUT[{n}] = {rng.choice(['TRUE', 'FALSE'])}",
        f"TRIGGER WHEN PATH = {rng.randint(-80, 80)} DELAY = 0 DO $FLAG[2] = TRUE",
        f"$OUT[{n}] = {rng.choice(['TRUE', 'FALSE'])}", f"WAIT SEC {rng.choice([0.0, 0.1, 0.7])}",
        "WAIT FOR $IN[7] OR $FLAG[2]", "$FLAG[2] = NOT $FLAG[2]", "CONTINUE", "HALT",
    ])  # fmt: skip


def cell_table(rng: random.Random) -> dict:
    """A cell that answers."""
    table = {"inputs": {"others": False, "7": rng.random() < 0.3}, "unmet_wait_s": rng.choice([0.0, 0.5])}
    when = rng.choice(["$OUT[2]", "$OUT[3] OR $FLAG[2]", None])
    reply = {"after_s": rng.choice([0.0, 0.3, 1.1]), "set": {"$IN[7]": rng.random() < 0.7, "$FLAG[2]": True}}
    return {**table, "reply": [reply if when is None else {**reply, "when": when}]}


def faults_of(arm, seed: int) -> list[str]:
    """What is wrong with the run of one random program: nothing, unless it is not as the laws say."""
    rng = random.Random(seed)
    text, cell = program_text(rng), cell_of(cell_table(rng))
    try:
        run = run_program(parse_program(text, "DEFDAT a\nDECL INT N=0\nENDDAT\n", name="a"), arm, MACHINE, cell=cell)
    except ProgramError as fault:
        return [] if fault.code in FAULTS else [f"seed {seed}: {fault.code}: {fault}"]
    wrong = []
    if len(run.motion.t) < 2:
        return []
    step = np.abs(np.diff(run.motion.q, axis=0)) / np.diff(run.motion.t)[:, None]
    if (step > 1.5 * arm.velocity).any():
        wrong.append("the axes jump")
    times = [x.time for x in run.events]
    if times != sorted(times) or any(not 0.0 <= t <= run.timeline.duration + LONGEST_TAIL for t in times):
        wrong.append("events out of time")
    ends = [(x.begin, x.end) for x in run.executed]
    if any(b < a - 1e-9 for a, b in ends) or any(b < a - 1e-9 for (a, _), (b, _) in pairwise(ends)):
        wrong.append("motions out of order")
    again = run_program(parse_program(text, "DEFDAT a\nDECL INT N=0\nENDDAT\n", name="a"), arm, MACHINE, cell=cell)
    if [str(x) for x in again.events] != [str(x) for x in run.events] or again.cycle_time != run.cycle_time:
        wrong.append("another run differs")
    return [f"seed {seed}: {x}" for x in wrong]
