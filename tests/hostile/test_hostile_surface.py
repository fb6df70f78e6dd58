"""What a stranger's file or name did to a command and its log: one clear line, exit 2, and no command of GitHub."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import FileAccessError, UrdfError
from lwr_dyn.krl.project.program import parse_program
from lwr_dyn.krl.running.cell import read_cell, with_cell
from lwr_dyn.krl.running.program_run import check_program
from lwr_dyn.model.run import Run
from tests.hostile.readers import GOOD, ROOT

URDF = """<robot name="x"><link name="base"/><link name="{name}"><inertial><mass value="-1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="a" type="revolute"><parent link="base"/><child link="{name}"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="5" velocity="1"/></joint></robot>"""
DIGITS = "9" * 400


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    "line",
    [f"A = {DIGITS} + 1.0", f"A = SQRT({DIGITS})", f"A = B + 'H{DIGITS}'", f"FOR B = 1 TO {DIGITS}\nENDFOR",
     f"DECL CHAR C[{DIGITS}]\nA = {'9' * 5000}"],
)  # fmt: skip
def test_an_integer_of_400_digits(tmp_path, lwr_dyn_command, line):
    (tmp_path / "x.src").write_text(f"DEF x( )\nDECL REAL A\nDECL INT B\n{line}\nEND\n")
    code, out, err = lwr_dyn_command("krl", "check", "x.src", "--no-motion")
    assert code == 1
    assert f"{'5000' if 'CHAR' in line else 'number-range: 400'} digits are no INT" in out + err


@pytest.fixture
def standing_run(tmp_path):
    """A run file whose times are all equal, as another hand may write it."""
    arm = lwr_dyn.load("lwr4plus")
    hold = lwr_dyn.reference("hold", arm, q=np.zeros(7))
    lwr_dyn.simulate(arm, lwr_dyn.controller("pd-gravity", arm), hold, duration=0.05).save(tmp_path / "x.npz")
    with np.load(tmp_path / "x.npz") as stored:
        arrays = dict(stored)
    np.savez(tmp_path / "x.npz", **(arrays | {"t": np.ones_like(arrays["t"])}))
    return "x.npz"


def test_a_run_whose_times_are_all_equal(standing_run, lwr_dyn_command):
    for words in (("identify", "motion", "lwr4plus"), ("identify", "friction"), ("krl", "write", "--out", "x.src")):
        code, _, err = lwr_dyn_command(*words, standing_run)
        assert (code, "times that do not rise" in err) == (2, True), words
    with pytest.raises(FileAccessError, match="times that do not rise"):
        Run.load(standing_run)


@pytest.mark.parametrize(
    ("words", "says"),
    [(("simulate", "lwr4plus", "--controller", "c.py"), "a null character"),
     *((("identify", "friction", "x.csv", "--plot", where), "is a directory") for where in (".", "..", "/"))],
)  # fmt: skip
def test_a_null_byte_and_a_plot_that_is_a_folder_are_one_line(tmp_path, words, says, lwr_dyn_command):
    (tmp_path / "c.py").write_bytes(b"def controller(t, q, dq, q_ref, dq_ref, ddq_ref):\n    return 0 * q\n\0")
    (tmp_path / "x.csv").write_text("time,q1,tau1\n0,0,0\n")
    code, _, err = lwr_dyn_command(*words)
    assert (code, err.startswith("lwr-dyn: "), len(err.splitlines()), says in err) == (2, True, 1, True)


@pytest.mark.parametrize("number", ["S 1e999, T 2", "S 2, T 1e999"])
def test_a_status_or_turn_of_a_cell_that_no_number_is(tmp_path, number):
    """Found by the fuzz: an OverflowError."""
    good = (ROOT / GOOD / "cell.toml").read_text(encoding="utf-8")
    (tmp_path / "x.toml").write_text(good.replace("S 2, T 10", number), encoding="utf-8")
    cell = replace(read_cell(tmp_path / "x.toml"), submits=())
    program = with_cell(parse_program("DEF a( )\nPTP P[2]\nEND", name="a"), cell)
    found = check_program(program, lwr_dyn.load("kr30ha"), cell=cell)
    assert any("inf" in d.message for d in found if d.severity == "error")


COMMAND = re.compile(r"^\s*::|##\[", re.MULTILINE)
"""What GitHub's runner takes for a command: at the start of a line, or anywhere in the older form."""


@pytest.mark.parametrize("name", ["x\n::error::y.urdf", "::error::y.urdf", "a##[error]y.urdf", "\x1b[2Jy.urdf"])
@pytest.mark.parametrize("option", [(), ("--github",)])
def test_file_names_are_no_commands_of_a_log(tmp_path, lwr_dyn_command, name, option):
    (tmp_path / name).write_text(URDF.format(name="arm"), encoding="utf-8")
    for given in (name, "."):
        code, out, _ = lwr_dyn_command("lint", given, *option)
        text = "\n".join(line for line in out.splitlines() if not line.startswith("::error file="))
        assert (code, bool(text), COMMAND.search(text), "\x1b" in text) == (1, True, None, False)


@pytest.mark.parametrize("name", ["x&#10;::error::y", "x&#13;::error::y", "x##[error]", "x&#x85;y"])
def test_names_of_xml_are_no_commands_of_a_log(tmp_path, lwr_dyn_command, name):
    (tmp_path / "x.urdf").write_text(URDF.format(name=name), encoding="utf-8")
    code, out, _ = lwr_dyn_command("lint", "x.urdf")
    assert (code, COMMAND.search(out)) == (1, None)
    out = lwr_dyn_command("lint", "x.urdf", "--github")[1]
    starts = ("::error file=x.urdf", "::warning file=x.urdf", "::notice file=x.urdf", "x.urdf: ")
    assert all(line.startswith(starts) for line in out.split("\n") if line)
    assert json.loads(lwr_dyn_command("lint", "x.urdf", "--json")[1])["findings"]


def test_a_name_with_control_characters_is_refused_by_the_reader(tmp_path):
    good = URDF.replace('value="-1"', 'value="1"')
    for text in (good.format(name="x&#10;y"), good.format(name="y").replace('name="x"', 'name="x&#x9b;2J"')):
        (tmp_path / "x.urdf").write_text(text, encoding="utf-8")
        with pytest.raises(UrdfError, match="letters that can be printed in a line"):
            lwr_dyn.load(tmp_path / "x.urdf")
