"""`--set`: what no input or variable can be is one line; a value that nothing reads is told."""

import pytest

SOURCE = "DEF a( )\nPTP {A1 0, A2 -90, A3 90, A4 0, A5 30, A6 0}\nPTP {A1 5}\nEND\n"


@pytest.fixture
def run(tmp_path, monkeypatch, lwr_dyn_command):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.src").write_text(SOURCE)
    return lambda *given: lwr_dyn_command("krl", "run", "a.src", *(x for text in given for x in ("--set", text)))


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
def test_what_cannot_be_given_is_one_line(run, text, allowed):
    code, out, err = run(text)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"allowed: {allowed}" in err


def test_what_nothing_reads_is_told(run):
    code, out, _ = run("foo=3", "$OV_PRO=50", "$IN[8192]=TRUE")
    assert code == 0
    told = [line for line in out.splitlines() if "nothing reads it" in line]
    assert told == [f"assumed: {name}: given, but nothing reads it" for name in ("FOO",)]


def test_a_dollar_name_that_the_program_has_can_be_given(run, tmp_path):
    (tmp_path / "a.src").write_text(SOURCE.replace("END\n", "IF $INN[1] THEN\nWAIT SEC 1\nENDIF\nEND\n"))
    code, out, err = run("$INN[1]=TRUE")
    assert (code, err) == (0, "")
    assert "WAIT" in out
    assert run("$IN[1]=TRUE", "$INN2[1]=TRUE")[0] == 2


def test_a_value_that_is_read_is_not_told(run, tmp_path):
    (tmp_path / "a.dat").write_text("DEFDAT a\nINT N=1\nENDDAT\n")
    (tmp_path / "a.src").write_text(SOURCE.replace("END\n", "WAIT SEC N\nEND\n"))
    out = run("N=3")[1]
    assert "assumed: N: given\n" in out
    assert "nothing reads" not in out
