"""KRL programs with numbers beyond all bounds."""

import pytest

import lwr_dyn
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import check_program, run_program

HOME = "PTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}"
HEAD = ["DEF a( )", "BAS(#VEL_PTP, 100)", "$VEL.CP = 0.3", HOME]
SLOW = (["WAIT SEC 5E4"], ["WAIT SEC 5E4", "WAIT SEC 1"], ["$VEL.CP = 1E-5", "LIN_REL {X 9}"])


@pytest.fixture(scope="module")
def arm():
    return lwr_dyn.load("kr30ha")


def program(*lines):
    return parse_program("\n".join([*HEAD, *lines, "END", ""]), name="a")


@pytest.mark.parametrize("lines", [*SLOW, ["WAIT SEC 2"]])
def test_a_run_is_cut_at_its_longest_time(arm, lines):
    run = run_program(program(*lines), arm, MachineData(seconds=10.0))
    bounds, cut = [d.message for d in run.diagnostics if d.code == "bound"], lines in SLOW
    assert bounds == ["stopped here after 10 s of simulated time"] * cut
    assert run.cycle_time == (None if cut else run.timeline.duration)
    assert (run.duration == run.motion.t[-1] == 10.0) == cut
    assert len(run.motion.t) < 1000


@pytest.mark.parametrize("far", ["1E300", "-1E300", "1E154", "1.7E308"])
@pytest.mark.parametrize("axis", "XYZ")
def test_a_point_out_of_all_bounds_is_diagnosed(arm, far, axis):
    near = {"X": "1200", "Y": "10", "Z": "1300", "A": "0", "B": "90", "C": "0"}
    place, end = (f"{{{', '.join(f'{x} {v}' for x, v in p.items())}}}" for p in (near | {axis: far}, near))
    for move in ("CIRC {0}, {1}", "CIRC {1}, {0}", "LIN {0}", "PTP {0}", f"LIN_REL {{{{{axis} {far}}}}}"):
        line = move.format(place, end)
        assert any(d.severity == "error" for d in check_program(program(line), arm)), line
