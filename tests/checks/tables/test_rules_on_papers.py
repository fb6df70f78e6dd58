"""Faults of the LWR 4+ paper, found in its tables as printed, without a model."""

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
    assert finding.confidence == "certain"
    assert finding.numbers["ratio"] == pytest.approx(25.0, rel=1e-3)


def test_gains_put_right_are_clean():
    right = TABLE_VI.replace("13.5,4.4", "13.5,0.5392").replace("7,0.5392", "7,4.39")
    assert not found(right)


def test_means_of_absolute_values_are_no_fault():
    rows = [line.rsplit(",", 3)[0] for line in TABLE_VIII.replace("(mm)", "(mrad)").splitlines() if line[0] != "#"]
    (note,) = found("\n".join(rows))
    assert (note.rule, note.severity) == ("mean-kind", "note")


def test_the_velocity_block_is_in_another_order_and_a_row_too_low():
    rules = {f.rule: f for f in found(TABLE_VIII)}
    order = rules["column-order"]
    assert order.numbers["rows"] == [2, 3, 4, 5, 6]
    assert order.numbers["orders"] == [["max", "min", "mean"]]
    assert rules["rows-shifted"].confidence == "possible"
    assert rules["rows-shifted"].numbers["shift"] == -1


def test_joint_errors_in_millimetres():
    units = [f for f in found(TABLE_VIII) if f.rule == "unit"]
    assert [(f.printed, f.suspected) for f in units] == [("mm", "mrad"), ("mm/s", "mrad/s")]
    assert not [f for f in found(TABLE_VIII.replace("mm", "mrad")) if f.rule == "unit"]
    sliding = TABLE_VIII.replace("revolute", "prismatic")
    assert not [f for f in found(sliding) if f.rule == "unit"]


def test_the_rotor_is_off_by_two_powers_of_ten():
    (finding,) = found(ROTOR)
    assert (finding.rule, finding.place) == ("power-of-ten", "t, row 1, I_m")
    assert "1e2" in finding.sentence


@pytest.fixture(scope="module")
def data_room():
    from importlib import resources

    folder = resources.files("lwr_dyn.arms.papers")
    names = ("lwr4", "lwr4plus", "wam7", "kr30ha")
    return {name: lint(sheet_of_file(str(folder.joinpath(f"{name}.toml")))) for name in names}


def test_the_copied_centre_of_mass(data_room):
    (copied,) = [f for f in data_room["lwr4plus"] if f.rule == "copied"]
    assert copied.cells == ("inertial, row 5, com.z", "inertial, row 6, com.z")
    assert copied.numbers["shared_digits"] == 6
    assert copied.known == ("table2-c5z",)


def test_the_shifted_rows_of_table_ii(data_room):
    (shifted,) = [f for f in data_room["lwr4plus"] if f.rule == "rows-shifted"]
    assert set(shifted.cells) == {"dh.d", "frames.origin"}
    assert shifted.known == ("table2-rows",)


def test_a_sentence_with_wrong_arithmetic(data_room):
    (rotor,) = [f for f in data_room["lwr4plus"] if f.rule == "power-of-ten"]
    assert rotor.place == "erratum rotor-inertia-power, printed"
    assert [f.known for f in data_room["kr30ha"] if f.rule == "sign"] == [("theta2-home",)]


def test_mirror_image_links_repeat_and_a_digit_is_off(data_room):
    (digit,) = [f for f in data_room["lwr4plus"] if f.rule == "one-digit"]
    assert digit.cells == ("inertial, row 1, inertia.xx", "inertial, row 3, inertia.xx")


def test_the_other_data_files_are_clean(data_room):
    assert not data_room["wam7"]
    assert not data_room["lwr4"]
