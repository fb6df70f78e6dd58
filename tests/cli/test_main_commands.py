"""The command as a user types it: what it prints, its exit code, and one line for bad input."""

import pytest

BAD = {
    "no such robot": (("check", "kuka"), "no robot named 'kuka'"),
    "no such reading": (("check", "lwr4plus", "--reading", "real"), "no reading of lwr4plus named 'real'"),
    "missing file": (("check", "none.toml"), "none.toml: no such file"),
    "missing urdf": (("check", "none.urdf"), "none.urdf"),
    "no such command": (("chekc",), "no command named 'chekc' (did you mean check?)"),
    "no such file to begin": (("new", "controler", "x.py"), "no command named 'controler' (did you mean controller?)"),
    "no such controller": (("simulate", "lwr4plus", "--controller", "pd-gravty"), "(did you mean pd-gravity?)"),
    "no such option": (("check", "lwr4", "--fast"), "No such option"),
    "too few joints": (("fk", "lwr4", "--q-deg", "-90,0"), "--q-deg: 2 numbers; allowed: 7 numbers: lwr4 has 7 joints"),
    "no number": (("fk", "lwr4", "--q-deg", "a,b"), "not a list of numbers"),
    "not finite": (("fk", "lwr4", "--q", "nan,0,0,0,0,0,0"), "--q: nan at index (0,); allowed: finite numbers"),
    "no q": (("fk", "lwr4"), "--q, --q-deg, --axes-deg: none or several given; allowed: one of them"),
    "point of two": (
        ("fk", "lwr4", "--q", "0,0,0,0,0,0,0", "--point", "1,2"),
        "--point: 2 numbers; allowed: 3 numbers",
    ),
    "gain not positive": (("simulate", "lwr4plus", "--omega-n", "-1"), "omega_n: -1.0; allowed: a number above 0"),
    "no masses": (("simulate", "lwr4"), "masses and inertias not given"),
    "new without .toml": (("new", "arm", "arm.yaml"), "ends in '.yaml'; allowed: a path that ends in .toml"),
    "new in no folder": (("new", "arm", "none/arm.toml"), "none/arm.toml: no directory none"),
    "new with odd joints": (("new", "arm", "arm.toml", "--joints", "RX"), "joints: 'RX'; allowed: R or P per joint"),
    "new in another convention": (
        ("new", "arm", "arm.toml", "--convention", "x"),
        "'--convention': 'x' is not one of 'standard', 'modified'",
    ),
    "urdf into a folder that is not there": (
        ("urdf", "lwr4", "--out", "none/x.urdf"),
        "x.urdf: no directory none",
    ),
    "lock without a value": (("check", "x.urdf", "--lock", "finger"), "--lock: 'finger'; allowed: JOINT=VALUE"),
    "tip of a named robot": (("check", "lwr4", "--tip", "x"), "only with a .urdf, "),
}


@pytest.mark.parametrize(("arguments", "message"), BAD.values(), ids=BAD)
def test_bad_input_gets_one_line_and_exit_code_2(arguments, message, refused, folder):
    assert message in refused(*arguments)
    assert list(folder.iterdir()) == []


def test_a_zero_has_no_sign(lwr_dyn_command):
    assert "-0.0000" not in lwr_dyn_command("fk", "kr30ha", "--axes-deg", "A2=-90,A3=90")[1]


@pytest.mark.parametrize("form", [("--q-deg", "-90,0,0,0,0,0,0"), ("--q-deg=-90,0,0,0,0,0,0",)])
def test_lists_that_begin_with_a_minus(recorded, form):
    assert recorded("fk", "lwr4", *form)["position"] == pytest.approx([0, 0, 0.79])


def test_the_exercise_from_the_command_line(recorded):
    record = recorded("fk", "lwr4", "--q-deg", "0,90,90,-90,0,90,0", "--point", "0,0.05,0.1")
    assert record["point_in_base"] == pytest.approx([-0.3, -0.39, -0.05])


def test_check_passes_and_a_fault_gives_exit_code_1(lwr_dyn_command, recorded, tmp_path):
    report = recorded("check", "lwr4plus")
    assert report["holds"]
    assert {"name", "value", "tolerance", "holds"} <= set(report["verdicts"][0])
    assert "1 check holds, 1 not judged. " in lwr_dyn_command("check", "lwr4")[1].splitlines()[-1]
    own = tmp_path / "own.toml"
    assert lwr_dyn_command("new", "arm", str(own), "--joints", "RR")[0] == 0
    text = own.read_text()
    own.write_text(
        text.replace("[[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.004]]", "[[-1, 0, 0], [0, 0.01, 0], [0, 0, 0.004]]", 1)
    )
    code, out, _ = lwr_dyn_command("check", str(own))
    assert code == 1
    assert "link_1: smallest principal moment" in out
    assert "FAILS" in out


def test_new_never_overwrites(refused, tmp_path):
    own = tmp_path / "own.toml"
    own.write_text("mine")
    assert "exists already; allowed: a new file" in refused("new", "arm", str(own))
    assert own.read_text() == "mine"
