"""`--set`: what no input or variable can be is one line; a value that nothing reads is told."""

import json

import numpy as np
import pytest

SOURCE = "DEF a( )\nPTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}\nPTP {A1 5}\nEND\n"


@pytest.fixture
def program(folder):
    (folder / "a.src").write_text(SOURCE)
    return folder


def run_with(*given):
    return ("krl", "run", "a.src", *(x for text in given for x in ("--set", text)))


def peaks(printed, *words):
    record = json.loads(printed("krl", "run", "a.src", "--json", *words))
    return record["motions"], np.array(record["peak_static_torque"])


@pytest.mark.usefixtures("program")
def test_a_robot_of_a_program_is_loaded_as_elsewhere(printed):
    """Frames of the program stand on base and flange: of a tool the mass counts, of a mount the gravity."""
    motions, static = peaks(printed)
    with_tool, heavier = peaks(printed, "--tool", "xyz=0,0,0.2", "--tool", "mass=50", "--tool", "com=0,0,0.1")
    hanging, reversed_ = peaks(printed, "--mount", "ceiling")
    assert with_tool == hanging == motions
    assert (heavier[1:3] > 1.1 * static[1:3]).all()
    np.testing.assert_allclose(reversed_, static, rtol=1e-12, atol=1e-9)
    _, level = peaks(printed, "--mount", "wall")
    assert level[0] > 100.0 > static[0]
    _, rotors = peaks(printed, "--rotor", "A1=1e3")
    np.testing.assert_array_equal(rotors, static)


def test_the_same_options_stand_in_krl_write(folder, refused):
    (folder / "axes.csv").write_text("A1,A2,A3,A4,A5,A6\n0,-90,90,0,30,0\n5,-90,90,0,30,0\n")
    assert "no joint of kr30ha named 'A9'" in refused("krl", "write", "axes.csv", "--rotor", "A9=1")


@pytest.mark.parametrize(
    ("text", "allowed"),
    [
        ("$IN[0]=TRUE", "$IN[1] to $IN[8192]"),
        ("$IN[99999]=TRUE", "$IN[1] to $IN[8192]"),
        ("$IN=TRUE", "$IN[1] to $IN[8192]"),
        ("$IN[1]=5", "TRUE or FALSE"),
        ('$IN[1]="x y"', "TRUE or FALSE"),
        ("$ANIN[33]=1.0", "$ANIN[1] to $ANIN[32]"),
        ("$ANIN[1]=TRUE", "a number"),
        ("$T1[1]=TRUE", "$T1 without an index"),
        ("$OV_PRO=TRUE", "a number"),
        ("$OV_PRO=0", "more than 0, at most 100"),
        ("$VEL.CP=0", "more than 0, at most 100"),
        ("$VEL_AXIS[1]=101", "more than 0, at most 100"),
        ("$INN[1]=TRUE", "a $ variable of KUKA's, or one that a file names (did you mean $IN?)"),
    ],
)
@pytest.mark.usefixtures("program")
def test_what_cannot_be_given_is_one_line(refused, text, allowed):
    assert f"allowed: {allowed}" in refused(*run_with(text))


@pytest.mark.usefixtures("program")
def test_what_nothing_reads_is_told(printed):
    out = printed(*run_with("foo=3", "$OV_PRO=50", "$IN[8192]=TRUE"))
    told = [line for line in out.splitlines() if "nothing reads it" in line]
    assert told == ["assumed: FOO: given, but nothing reads it"]


def test_a_dollar_name_that_the_program_has_can_be_given(program, printed, refused):
    (program / "a.src").write_text(SOURCE.replace("END\n", "IF $INN[1] THEN\nWAIT SEC 1\nENDIF\nEND\n"))
    assert "WAIT" in printed(*run_with("$INN[1]=TRUE"))
    refused(*run_with("$IN[1]=TRUE", "$INN2[1]=TRUE"))


def test_a_value_that_is_read_is_not_told(program, printed):
    (program / "a.dat").write_text("DEFDAT a\nINT N=1\nENDDAT\n")
    (program / "a.src").write_text(SOURCE.replace("END\n", "WAIT SEC N\nEND\n"))
    out = printed(*run_with("N=3"))
    assert "assumed: N: given\n" in out
    assert "nothing reads" not in out


@pytest.mark.parametrize("target", ["a.src", "."])
def test_names_that_an_option_brings_are_known_to_a_program_and_to_a_folder(folder, lwr_dyn_command, target):
    (folder / "a.src").write_text("DEF a( )\nWELD( )\nEND\n")
    (folder / "names.toml").write_text('[[group]]\nfunctions = ["WELD()"]\n')
    assert [lwr_dyn_command("krl", "check", target, *x)[0] for x in ((), ("--names", "names.toml"))] == [1, 0]
