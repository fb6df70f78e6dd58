"""Programs of a few lines on a given arm."""

from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.cell import RobotCell, with_cell
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import check_program, interpreted, run_program

HOME = "PTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}"


def run_of(arm, *lines, **settings):
    text = "\n".join(["DEF a( )", "BAS(#VEL_PTP, 100)", "$VEL.CP = 0.2", *lines, "END", ""])
    return run_program(parse_program(text, name="a"), arm, MachineData(**settings))


def codes_of(arm, *lines):
    text = "\n".join(["DEF a( )", "BAS(#VEL_PTP, 100)", "$VEL.CP = 0.2", *lines, "END", ""])
    return [(d.position.line - 3, d.code) for d in check_program(parse_program(text, name="a"), arm)]


def values_of(arm, lines, data=(), cell=None):
    """The values of the variables of `a.dat` after a run of the lines, and the assumptions as text."""
    source = "\n".join(["DEF a( )", *lines, "END", ""])
    program = parse_program(source, "\n".join(["DEFDAT a", *data, "ENDDAT", ""]), name="a")
    m = interpreted(with_cell(program, cell or RobotCell()), arm, MachineData(), cell)
    faults = [str(d) for d in m.log.diagnostics if d.severity == "error"]
    assert not faults, faults
    values = {name: variable.value for name, variable in m.files["a.dat"].items()}
    return values, [str(x) for x in m.controller.assumptions.values()]
