"""Faults of the LWR 4+ paper, found in its tables as printed, without a model."""

from importlib import resources

import pytest

from lwr_dyn.checks.tables.rules import lint, sheet_of_file
from lwr_dyn.checks.tables.sheet import sheet_of_csv

TABLE_VI = """Joint,K_P,K_D
1,7310,292.4
2,7270,290.8
3,1225.7,49.03
4,1185.5,47.42
5,28.2,1.127
6,13.5,4.4
7,0.5392,0.1756
"""
TABLE_VIII = """# title: position and velocity errors for decentralized control
# joints: revolute
Joint,Avg. Pos. Error (mm),Max. Pos. Error (mm),Min. Pos. Error (mm),\
Avg. Vel. Error (mm/s),Max. Vel. Error (mm/s),Min. Vel. Error (mm/s)
1,0.4,0.3,-1.8,1.8,36.2,-10.0
2,9.6,10.5,0.0,5.1,-25.6,2.8
3,1.9,6.5,-3.2,148.3,-7.9,3.2
4,11.4,15.0,0.0,118.9,-21.0,5.7
5,5.2,0.0,-7.0,214.7,-14.7,2.0
6,1.5,3.2,-0.3,1.7,-100.4,1.8
7,0.2,0.5,-0.3,2.0,8.1,-6.5
"""
ROTOR = """# formula: I_m = 1/2 * m * r^2
motor,m [kg],r [m],I_m [kg m^2]
1,0.0106,0.05,1.325e-7
2,0.0106,0.05,1.325e-5
"""


def found(text):
    return lint(sheet_of_csv(text, "table.csv", "t"))


def test_the_exchanged_gains_are_found_by_the_ratio_alone():
    (finding,) = found(TABLE_VI)
    assert (finding.rule, set(finding.cells)) == ("swapped", {"t, row 6, K_D", "t, row 7, K_P"})
    assert (finding.confidence, finding.numbers["ratio"]) == ("certain", pytest.approx(25.0, rel=1e-3))
    assert not found(TABLE_VI.replace("13.5,4.4", "13.5,0.5392").replace("7,0.5392", "7,4.39"))


def test_means_of_absolute_values_are_no_fault():
    rows = [line.rsplit(",", 3)[0] for line in TABLE_VIII.replace("(mm)", "(mrad)").splitlines() if line[0] != "#"]
    (note,) = found("\n".join(rows))
    assert (note.rule, note.severity) == ("mean-kind", "note")


def test_the_velocity_block_is_in_another_order_and_a_row_too_low_and_joints_turn_by_no_millimetres():
    rules = {f.rule: f for f in found(TABLE_VIII)}
    order, shifted = rules["column-order"].numbers, rules["rows-shifted"]
    assert (order["rows"], order["orders"]) == ([2, 3, 4, 5, 6], [["max", "min", "mean"]])
    assert (shifted.confidence, shifted.numbers["shift"]) == ("possible", -1)
    units = [[(f.printed, f.suspected) for f in found(text) if f.rule == "unit"] for text in (
        TABLE_VIII, TABLE_VIII.replace("mm", "mrad"), TABLE_VIII.replace("revolute", "prismatic"))]  # fmt: skip
    assert units == [[("mm", "mrad"), ("mm/s", "mrad/s")], [], []]


def test_the_rotor_is_off_by_two_powers_of_ten():
    (finding,) = found(ROTOR)
    assert (finding.rule, finding.place, "1e2" in finding.sentence) == ("power-of-ten", "t, row 1, I_m", True)


def test_the_faults_of_the_data_files():
    """The copied centre, the shifted rows, the rotor's arithmetic, mirror images with a digit off; two are clean."""
    folder = resources.files("lwr_dyn.arms.papers")
    names = ("lwr4", "lwr4plus", "wam7", "kr30ha")
    data = {name: lint(sheet_of_file(str(folder.joinpath(f"{name}.toml")))) for name in names}
    rules = ("copied", "rows-shifted", "power-of-ten", "one-digit")
    (copied,), (shifted,), (rotor,), (digit,) = ([f for f in data["lwr4plus"] if f.rule == rule] for rule in rules)
    assert (copied.cells, copied.known) == (("inertial, row 5, com.z", "inertial, row 6, com.z"), ("table2-c5z",))
    assert copied.numbers["shared_digits"] == 6
    assert (set(shifted.cells), shifted.known) == ({"dh.d", "frames.origin"}, ("table2-rows",))
    assert rotor.place == "erratum rotor-inertia-power, printed"
    assert digit.cells == ("inertial, row 1, inertia.xx", "inertial, row 3, inertia.xx")
    assert [f.known for f in data["kr30ha"] if f.rule == "sign"] == [("theta2-home",)]
    assert (data["wam7"], data["lwr4"]) == ((), ())
