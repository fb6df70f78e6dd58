"""Programs of a few lines on a given arm."""

from lwr_dyn.foundation.fields import parse_toml
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.cell import RobotCell, cell_of, with_cell
from lwr_dyn.krl.running.controller import MachineData
from lwr_dyn.krl.running.program_run import check_program, interpreted, run_program

HOME = "PTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}"
SPEEDS = ("BAS(#VEL_PTP, 100)", "$VEL.CP = 0.2")


def program_of(*lines, data=None):
    return parse_program("\n".join(["DEF a( )", *lines, "END", ""]), data, "a")


def told(*lines, data=None):
    return [(d.position.line, d.severity, d.code) for d in check_program(program_of(*lines, data=data))]


def said(text, data=None, arm=None):
    """What the check says of lines with " | " between them, as "3 type": line and code, with ? for a warning."""
    found = check_program(program_of(*text.split(" | "), data=data), arm)
    return [f"{d.position.line} {d.code}{'?' * (d.severity == 'warning')}" for d in found]


def cell(text):
    return cell_of(parse_toml(text, "cell.toml"), "cell.toml")


def run_of(arm, *lines, **settings):
    return run_program(program_of(*SPEEDS, *lines), arm, MachineData(**settings))


def codes_of(arm, *lines):
    return [(d.position.line - 3, d.code) for d in check_program(program_of(*SPEEDS, *lines), arm)]


def values_of(arm, lines, data=(), cell=None):
    """The values of the variables of `a.dat` after a run of the lines, and the assumptions as text."""
    program = program_of(*lines, data="\n".join(["DEFDAT a", *data, "ENDDAT", ""]))
    m = interpreted(with_cell(program, cell or RobotCell()), arm, MachineData(), cell)
    faults = [str(d) for d in m.log.diagnostics if d.severity == "error"]
    assert not faults, faults
    values = {name: variable.value for name, variable in m.files["a.dat"].items()}
    return values, [str(x) for x in m.controller.assumptions.values()]
