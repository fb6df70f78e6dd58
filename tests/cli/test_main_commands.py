"""The command as a user types it: its exit codes, and one line for bad input."""

import pytest

from lwr_dyn.arms.papers.catalog import template

BAD = {
    "no such robot": (("check", "kuka"), "no robot named 'kuka'"),
    "no such reading": (("check", "lwr4plus", "--reading", "real"), "no reading of lwr4plus named 'real'"),
    "missing file": (("check", "none.toml"), "none.toml: no such file"),
    "missing urdf": (("check", "none.urdf"), "none.urdf"),
    "no such command": (("chekc",), "no command named 'chekc' (did you mean check?)"),
    "no such file to begin": (("new", "controler", "x.py"), "no command named 'controler' (did you mean controller?)"),
    "no such controller": (("simulate", "lwr4plus", "--controller", "pd-gravty"), "(did you mean pd-gravity?)"),
    "no such option": (("check", "lwr4", "--fast"), "No such option"),
    "no masses": (("simulate", "lwr4"), "masses and inertias not given"),
    "new without .toml": (("new", "arm", "arm.yaml"), "ends in '.yaml'; allowed: a path that ends in .toml"),
    "new in no folder": (("new", "arm", "none/arm.toml"), "none/arm.toml: no directory none"),
    "new with odd joints": (("new", "arm", "arm.toml", "--joints", "RX"), "joints: 'RX'; allowed: R or P per joint"),
    "new in a convention": (
        ("new", "arm", "arm.toml", "--convention", "x"),
        "'--convention': 'x' is not one of 'standard', 'modified'",
    ),
    "urdf into no folder": (("urdf", "lwr4", "--out", "none/x.urdf"), "x.urdf: no directory none"),
    "lock without a value": (("check", "x.urdf", "--lock", "finger"), "--lock: 'finger'; allowed: JOINT=VALUE"),
    "tip of a named robot": (("check", "lwr4", "--tip", "x"), "only with a .urdf, "),
}


@pytest.mark.parametrize(("arguments", "message"), BAD.values(), ids=BAD)
def test_bad_input_gets_one_line_and_exit_code_2(arguments, message, refused, folder):
    assert message in refused(*arguments)
    assert list(folder.iterdir()) == []


def test_check_passes_and_a_fault_gives_exit_code_1(lwr_dyn_command, recorded, printed, folder):
    report = recorded("check", "lwr4plus")
    assert report["holds"]
    assert {"name", "value", "tolerance", "holds"} <= set(report["verdicts"][0])
    assert "1 check holds, 1 not judged. " in printed("check", "lwr4").splitlines()[-1]
    text = template("own.toml", "own", "RR").replace("[[0.01, 0, 0]", "[[-1, 0, 0]", 1)
    (folder / "own.toml").write_text(text, encoding="utf-8")
    code, out, _ = lwr_dyn_command("check", "own.toml")
    assert (code, "link_1: smallest principal moment" in out, "FAILS" in out) == (1, True, True)


def test_new_never_overwrites(refused, folder):
    (folder / "own.toml").write_text("mine")
    assert "exists already; allowed: a new file" in refused("new", "arm", "own.toml")
    assert (folder / "own.toml").read_text() == "mine"
